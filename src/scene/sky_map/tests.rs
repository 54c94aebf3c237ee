//! The reduced image keeps the image's light.

use super::*;
use crate::twin::pack::rgb9e5_decode;
use crate::twin::random::Random;

/// Texels of an image as RGBA in 32 bits.
fn image(layout: SkyLayout, width: u32, height: u32, texels: &[DVec3]) -> Vec<u32> {
    let rgba: Vec<[f32; 4]> = texels.iter().map(|t| t.as_vec3().extend(1.0).to_array()).collect();
    let texels = bytemuck::cast_slice(&rgba);
    SkyImage { layout, format: SkyFormat::Rgba32Float, width, height, texels }.reduce().expect("a valid image")
}

/// The texel that shaders/lib/sky.wgsl reads in a direction.
fn texel_of(direction: DVec3) -> usize {
    let place = place_of(direction).min(DVec2::splat(EDGE as f64 - 1.0));
    place.x as usize + EDGE * place.y as usize
}

/// Directions all over the sphere, with their solid angles and their texels.
type Field = Vec<(DVec3, f64, usize)>;

fn map_field() -> Field {
    let steps = EDGE * 8;
    let place = |i: usize| DVec2::new((i % steps) as f64 + 0.5, (i / steps) as f64 + 0.5) * 2.0 / steps as f64 - 1.0;
    let points = (0..steps * steps).map(|i| octahedron(place(i)));
    // The octahedron's sides stand 1 / sqrt 3 from the middle; both of a square's triangles have sqrt 3 / 2 of area.
    let angle = |p: DVec3| (2.0 / steps as f64).powi(2) / p.length().powi(3);
    points.map(|p| (p.normalize(), angle(p), texel_of(p))).collect()
}

fn lat_long_field(width: u32, height: u32) -> Field {
    let parts = 1200 / width;
    let (columns, rows) = (width * parts, height * parts);
    let row = |row: u32| {
        let [theta, low, high] = [0.5, 0.0, 1.0].map(|part| (f64::from(row) + part) / f64::from(rows) * PI);
        (0..columns).map(move |column| {
            let phi = ((f64::from(column) + 0.5) / f64::from(columns) - 0.5) * TAU;
            let direction = DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
            let texel = row / parts * width + column / parts;
            (direction, (low.cos() - high.cos()) * TAU / f64::from(columns), texel as usize)
        })
    };
    (0..rows).flat_map(row).collect()
}

/// The axes of a face: middle, s, t (Vulkan, Cube Map Face Selection).
const FACES: [[DVec3; 3]; 6] = [
    [DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y],
    [DVec3::NEG_X, DVec3::Z, DVec3::NEG_Y],
    [DVec3::Y, DVec3::X, DVec3::Z],
    [DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z],
    [DVec3::Z, DVec3::X, DVec3::NEG_Y],
    [DVec3::NEG_Z, DVec3::NEG_X, DVec3::NEG_Y],
];

fn cube_field(edge: u32) -> Field {
    let steps = edge * (480 / edge);
    let at = move |index: u32| (2.0 * f64::from(index) + 1.0) / f64::from(steps) - 1.0;
    let point = move |face: u32, i: u32| {
        let (column, row) = (i % steps, i / steps);
        let [middle, s, t] = FACES[face as usize];
        let p = middle + s * at(column) + t * at(row);
        let texel = column * edge / steps + edge * (row * edge / steps + edge * face);
        (p.normalize(), (2.0 / f64::from(steps)).powi(2) / p.length().powi(3), texel as usize)
    };
    (0..6).flat_map(move |face| (0..steps * steps).map(move |i| point(face, i))).collect()
}

/// The sum over the sphere, and that weighted with the cosine to a normal.
fn sums(field: &Field, normal: DVec3, radiance: impl Fn(usize) -> DVec3) -> [DVec3; 2] {
    field.iter().fold([DVec3::ZERO; 2], |[sum, irradiance], (direction, angle, texel)| {
        let light = radiance(*texel) * *angle;
        [sum + light, irradiance + light * direction.dot(normal).max(0.0)]
    })
}

/// Noise, a bright band and a small sun, at none of the normals' horizons.
fn texels(count: usize, sun: usize, seed: u64) -> Vec<DVec3> {
    let mut random = Random::new(seed);
    let mut texels: Vec<DVec3> = (0..count).map(|i| random.point() * if i / 40 % 9 == 0 { 4.0 } else { 1.0 }).collect();
    texels[sun] = DVec3::new(30.0, 25.0, 20.0) * count as f64 / 60.0;
    texels
}

fn assert_sums(map: &[u32], field: &Field, texels: &[DVec3], what: &str) {
    let mut worst = [0.0f64; 2];
    for normal in [DVec3::X, DVec3::Y, -DVec3::Y, -DVec3::Z, DVec3::new(1.0, 2.0, -1.0).normalize()] {
        let found = sums(&map_field(), normal, |texel| rgb9e5_decode(map[texel]).as_dvec3());
        let truth = sums(field, normal, |texel| texels[texel]);
        for k in 0..2 {
            worst[k] = worst[k].max(((found[k] - truth[k]) / truth[k]).abs().max_element());
        }
    }
    println!("{what}: sum {:.3} %, irradiance {:.3} %", 100.0 * worst[0], 100.0 * worst[1]);
    assert!(worst.iter().all(|w| *w < 0.01), "{what}: {worst:?}");
}

#[test]
fn a_lat_long_image_keeps_its_sums() {
    for (width, height) in [(8, 3), (120, 60), (600, 300)] {
        let texels = texels((width * height) as usize, (height / 3 * width + width * 2 / 5) as usize, 1);
        let map = image(SkyLayout::LatLong, width, height, &texels);
        assert_sums(&map, &lat_long_field(width, height), &texels, &format!("{width} x {height}"));
    }
}

#[test]
fn a_cube_keeps_its_sums() {
    for edge in [2, 48, 160] {
        let texels = texels(6 * (edge * edge) as usize, 2 * (edge * edge) as usize, 2);
        let map = image(SkyLayout::Cube, edge, edge, &texels);
        assert_sums(&map, &cube_field(edge), &texels, &format!("cube of {edge}"));
    }
}

/// One texel: the map is the constant, to the rounding of nine bits.
#[test]
fn an_image_of_one_colour_is_a_constant() {
    let color = DVec3::new(0.7, 1.3, 2.9);
    for word in image(SkyLayout::LatLong, 1, 1, &[color]) {
        let error = (rgb9e5_decode(word).as_dvec3() - color).abs().max_element();
        // Half a step of nine bits below 4.
        assert!(error <= 0.5 * 4.0 / 512.0, "off by {error}");
    }
}

#[test]
fn every_format_is_read_as_its_value() {
    let color = [0.5f32, 3.0, 20.0];
    let half: Vec<u8> =
        [color[0], color[1], color[2], 9.0].iter().flat_map(|v| f16::from_f32(*v).to_le_bytes()).collect();
    let float: Vec<u8> = [color[0], color[1], color[2], 9.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let bits = color.map(|v| u32::from(f16::from_f32(v).to_bits()));
    let packed = (bits[0] >> 4 | bits[1] >> 4 << 11 | bits[2] >> 5 << 22).to_le_bytes().to_vec();
    let formats = [(SkyFormat::Rgba16Float, half), (SkyFormat::Rgba32Float, float), (SkyFormat::B10G11R11, packed)];
    for (format, texels) in formats {
        assert_eq!(format.decode(&texels), DVec3::new(0.5, 3.0, 20.0), "{format:?}");
    }
    let [nan, low, high] = [f32::NAN, -1.0, f32::INFINITY].map(f32::to_le_bytes);
    let odd = [nan, low, high, nan].concat();
    assert_eq!(SkyFormat::Rgba32Float.decode(&odd), DVec3::new(0.0, 0.0, 65504.0));
}

#[test]
fn texels_cover_the_sphere_once() {
    let all: f64 = (0..EDGE * EDGE).map(texel_angle).sum();
    assert!((all - 4.0 * PI).abs() < 1e-9, "{all}");
    let mut angles = vec![0.0; EDGE * EDGE];
    map_field().iter().for_each(|(_, angle, texel)| angles[*texel] += angle);
    for (index, angle) in angles.into_iter().enumerate() {
        let exact = texel_angle(index);
        assert!((angle - exact).abs() < 1e-3 * exact, "texel {index}: {angle}, not {exact}");
    }
}
