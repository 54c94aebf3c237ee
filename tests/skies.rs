//! Skies on a black floor, against closed forms and sums over their directions.

use brickgi::Settings;
use brickgi_host::image::luminance;
use brickgi_host::scene::{Instance, Material, Mesh, Sky, SkyLayout, SkyPicture};
use brickgi_host::{Host, HostOptions, Scene, SceneCamera};
use std::f64::consts::PI;

const BUDGET: u64 = 2 << 20;
const ROTATION: [[f32; 3]; 3] = [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];

/// A floor, or a wall that looks to +x, alone under a sky; `pixel_rays`: without probes.
fn host(wall: bool, sky: Sky, sky_picture: Option<SkyPicture>, pixel_rays: u32) -> Host {
    let corners = [[-4.0, -4.0], [4.0, -4.0], [-4.0, 4.0], [4.0, 4.0]];
    let positions = corners.map(|[a, b]: [f32; 2]| if wall { [0.0, a, b] } else { [b, 0.0, a] }).to_vec();
    let [position, up] = if wall { [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0]] } else { [[0.0, 2.0, 0.0], [0.0, 0.0, -1.0]] };
    let scene = Scene {
        name: "sheet".into(),
        meshes: vec![Mesh { positions, uvs: Vec::new(), indices: vec![0, 1, 2, 1, 3, 2] }],
        materials: vec![Material { base_color: [0.0; 3], emission: [0.0; 3], texture: None }],
        instances: vec![Instance::at(0, 0, [0.0; 3])],
        sky,
        sky_picture,
        cameras: vec![SceneCamera {
            name: "over".into(),
            position,
            target: [0.0; 3],
            up,
            vfov_deg: 60.0,
            near: 0.05,
            width: 32,
            height: 32,
        }],
        ..Scene::default()
    };
    let settings = Settings {
        voxel_size: 0.25,
        grid_offset: [0.37, 0.61, 0.23],
        bounce_rays: 0,
        pixel_rays,
        memory_budget: BUDGET,
        ..Settings::default()
    };
    Host::new(HostOptions { settings, validation: true, ..HostOptions::new(scene) }).expect("a device")
}

/// Mean irradiance of what the camera sees.
fn irradiance(host: &mut Host) -> f64 {
    (0..48).for_each(|_| host.frame().expect("a frame"));
    assert_eq!(host.validation_messages(), Vec::<String>::new());
    let image = host.read_indirect().expect("E_ind");
    image.pixels.iter().map(|p| luminance(*p)).sum::<f64>() / image.pixels.len() as f64
}

/// By probes, of which the camera has four, and by rays of the pixels' own.
fn assert_irradiance(wall: bool, sky: Sky, picture: Option<&SkyPicture>, expected: f64) {
    for (pixel_rays, tolerance) in [(0, 0.015), (4, 0.005)] {
        let found = irradiance(&mut host(wall, sky, picture.cloned(), pixel_rays));
        println!("{sky:?}, wall {wall}, {pixel_rays} rays: {found:.4}, {expected:.4} expected");
        assert!((found / expected - 1.0).abs() < tolerance, "{found}, not {expected}");
    }
}

#[test]
fn a_gradient_lights_floor_and_wall_as_its_integral() {
    let [zenith, horizon, ground] = [3.0, 1.0, 0.4];
    let sky = Sky::Gradient { zenith: [3.0; 3], horizon: [1.0; 3], ground: [0.4; 3], up: [0.0, 2.0, 0.0] };
    assert_irradiance(false, sky, None, PI * (horizon / 3.0 + 2.0 * zenith / 3.0));
    // Over the quarter sphere above, and that below, the mean of the height, weighted with the cosine, is 4 / (3 pi).
    let height = 4.0 / (3.0 * PI);
    let above = horizon + (zenith - horizon) * height;
    let below = horizon + (ground - horizon) * height;
    assert_irradiance(true, sky, None, PI / 2.0 * (above + below));
}

/// Every texel another radiance; the mean of many directions.
fn picture() -> SkyPicture {
    let texel = |i: u32| [(i * 37 % 11) as f32 + if i % 64 < 24 { 12.0 } else { 0.0 }; 3];
    let rgba32 = (0..64 * 32).map(|i| [texel(i)[0], texel(i)[1], texel(i)[2], 0.0]).collect();
    SkyPicture { layout: SkyLayout::LatLong, width: 64, height: 32, rgba32 }
}

/// Irradiance of a surface that looks to `normal` in the image's own space.
fn integral(picture: &SkyPicture, normal: [f64; 3]) -> f64 {
    let (steps, mut sum) = (8, 0.0);
    let [columns, rows] = [picture.width, picture.height].map(|side| side * steps);
    for row in 0..rows {
        let theta = (f64::from(row) + 0.5) / f64::from(rows) * PI;
        for column in 0..columns {
            let phi = ((f64::from(column) + 0.5) / f64::from(columns) - 0.5) * 2.0 * PI;
            let direction = [theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos()];
            let cosine: f64 = (0..3).map(|k| direction[k] * normal[k]).sum();
            let texel = picture.rgba32[(row / steps * picture.width + column / steps) as usize][0];
            sum += f64::from(texel) * cosine.max(0.0) * theta.sin();
        }
    }
    sum * 2.0 * PI * PI / f64::from(columns) / f64::from(rows)
}

#[test]
fn an_image_lights_floor_and_wall_as_its_integral() {
    let (picture, intensity) = (picture(), [0.5; 3]);
    let none = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let floor = Sky::Image { intensity, rotation: none };
    assert_irradiance(false, floor, Some(&picture), 0.5 * integral(&picture, [0.0, 1.0, 0.0]));
    assert_irradiance(true, floor, Some(&picture), 0.5 * integral(&picture, [1.0, 0.0, 0.0]));
    // The rotation takes the image's +z to the world's +x.
    let turned = Sky::Image { intensity, rotation: ROTATION };
    assert_irradiance(true, turned, Some(&picture), 0.5 * integral(&picture, [0.0, 0.0, 1.0]));
}

/// An image takes 16 KiB for each frame in flight, in the budget, and none while the sky is a constant.
#[test]
fn an_image_counts_against_the_budget() {
    let uploads = [false, true].map(|used| {
        let sky = Sky::Image { intensity: [1.0; 3], rotation: ROTATION };
        let sky = if used { sky } else { Sky::default() };
        let mut host = host(false, sky, Some(picture()), 0);
        for _ in 0..16 {
            host.frame().expect("a frame");
            assert!(host.stats().world_bytes <= BUDGET, "{} bytes", host.stats().world_bytes);
        }
        let stats = host.stats();
        assert!(stats.bricks > 0 && stats.bricks_missing == 0, "{} bricks are missing", stats.bricks_missing);
        stats.resources.iter().find(|r| r.name == "upload").expect("uploads").bytes
    });
    // Uploads are a list made anew each frame, with an eighth to spare.
    let grown = uploads[1] - uploads[0];
    assert!((30 << 10..40 << 10).contains(&grown), "{uploads:?}");
}

/// Radiance 2 in every texel, of a lat-long image and of a cube.
#[test]
fn an_image_of_one_colour_is_a_constant_sky() {
    let constant = irradiance(&mut host(false, Sky::Constant { radiance: [2.0; 3] }, None, 0));
    for (layout, width, height, faces) in [(SkyLayout::LatLong, 8, 4, 1), (SkyLayout::Cube, 4, 4, 6)] {
        let rgba32 = vec![[2.0f32, 2.0, 2.0, 1.0]; (width * height * faces) as usize];
        let picture = SkyPicture { layout, width, height, rgba32 };
        let sky = Sky::Image { intensity: [1.0; 3], rotation: ROTATION };
        let found = irradiance(&mut host(false, sky, Some(picture), 0));
        assert!((found / constant - 1.0).abs() < 1e-4, "{layout:?}: {found}, not {constant}");
    }
}
