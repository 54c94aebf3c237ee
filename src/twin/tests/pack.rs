//! The packers on the GPU equal their twins, and lose no more than they say.

use crate::frame::Frame;
use crate::gpu::Location;
use crate::twin::gpu::Gpu;
use crate::twin::pack::*;
use crate::twin::random::Random;
use crate::twin::shared::{PackInput, PackOutput};
use glam::{DVec3, Vec3};

const VALUES: usize = 100_000;

fn inputs() -> Vec<PackInput> {
    let mut random = Random::new(3);
    let single = |v: DVec3| v.as_vec3().to_array();
    (0..VALUES)
        .map(|index| {
            let side = random.below(6) as usize;
            let tilt = side_step(side).as_dvec3() + random.direction() * random.unit() * 0.99;
            let brightness = 2f64.powf(random.between(-20.0, 16.0));
            PackInput {
                color: match index % 64 {
                    0 => [0.0; 3],
                    // Brighter than what can be stored.
                    1 => [1e6, 65408.0, brightness as f32],
                    _ => single(random.point() * brightness),
                },
                side: side as u32,
                random: if index % 640 == 1 { [1.0 - f32::EPSILON / 2.0; 3] } else { single(random.point()) },
                albedo: single(random.point() * random.unit()),
                normal: single(if index % 8 == 0 { side_step(side).as_dvec3() } else { tilt.normalize() }),
                centroid: single(random.point()),
                ..PackInput::default()
            }
        })
        .collect()
}

fn on_gpu(inputs: &[PackInput]) -> Vec<PackOutput> {
    let mut gpu = Gpu::new(&["pack_values"]);
    let mut frame = Frame::default();
    frame.upload.push("pack_inputs", inputs);
    frame.dispatch("pack_values", [(inputs.len() as u32).div_ceil(64), 1, 1], [0u32; 0]);
    gpu.buffer("pack_outputs", inputs.len() * size_of::<PackOutput>(), Location::Readback);
    gpu.run(&frame);
    gpu.read("pack_outputs", inputs.len())
}

fn double(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

/// Whether two planes are a quantisation step apart at most: of the normal (which moves the offset about the voxel's
/// centre with it), or of the offset.
pub fn planes_agree(a: u32, b: u32) -> bool {
    let apart = |shift: u32, mask: u32| (a >> shift & mask).abs_diff(b >> shift & mask);
    let normal = apart(0, 1023).max(apart(10, 1023));
    normal <= 1 && apart(20, 4095) <= if normal == 0 { 1 } else { 6 }
}

#[test]
fn packers_equal_their_twins() {
    let inputs = inputs();
    let (mut albedo_off, mut plane_off, mut mask_off) = (0, 0, 0);
    for (i, o) in inputs.iter().zip(on_gpu(&inputs)) {
        let side = i.side as usize;
        let color = rgb9e5_encode(Vec3::from(i.color), Vec3::from(i.random));
        assert_eq!(o.color_word, color, "{i:?}");
        assert_eq!(Vec3::from(o.color), rgb9e5_decode(color), "{i:?}");

        let albedo = albedo_encode(double(i.albedo), double(i.random));
        let levels = |word: u16| albedo_levels(word).map(i32::from);
        let (a, b) = (levels(albedo), levels(o.albedo_word as u16));
        assert!((0..3).all(|k| (a[k] - b[k]).abs() <= 1), "{i:?}: {a:?} and {b:?}");
        albedo_off += usize::from(a != b);
        assert!(double(o.albedo).distance(albedo_decode(o.albedo_word as u16)) < 1e-6, "{i:?}");

        let fine = fine_albedo_levels(fine_albedo_encode(double(i.albedo)));
        let found = fine_albedo_levels(o.fine_albedo_word);
        assert!((0..3).all(|k| fine[k].abs_diff(found[k]) <= 1), "{i:?}: {fine:?} and {found:?}");
        albedo_off += usize::from(fine != found);
        assert!(double(o.fine_albedo).distance(fine_albedo_decode(o.fine_albedo_word)) < 1e-6, "{i:?}");
        assert!(double(o.fine_albedo).distance(double(i.albedo)) < 1.5e-3, "{i:?}");

        let plane = plane_encode(side, double(i.normal), double(i.centroid));
        assert!(planes_agree(plane, o.plane_word), "{i:?}: {plane:x} and {:x}", o.plane_word);
        plane_off += usize::from(plane != o.plane_word);
        let decoded = plane_decode(side, o.plane_word);
        assert!(decoded.normal.distance(double(o.normal)) < 1e-6, "{i:?}");
        assert!((decoded.offset - f64::from(o.offset)).abs() < 1e-6, "{i:?}");
        mask_off += usize::from(mask_bit(side >> 1, double(i.centroid)) != o.mask_bit);
    }
    println!("{VALUES} values: off by a step by rounding: {albedo_off} albedos, {plane_off} planes");
    assert_eq!(mask_off, 0, "mask bits");
    let most = VALUES / 500;
    assert!(albedo_off < most && plane_off < most, "{albedo_off} albedos, {plane_off} planes off by a step");
}

/// 10-bit odd grid: an axis is exact; elsewhere within a step. The plane passes the voxel where its surface does.
#[test]
fn planes_keep_their_place() {
    let (mut worst_angle, mut worst_height) = (0f64, 0f64);
    for i in inputs() {
        let side = i.side as usize;
        let (normal, centroid) = (double(i.normal), double(i.centroid));
        let plane = plane_decode(side, plane_encode(side, normal, centroid));
        if normal == side_step(side).as_dvec3() {
            assert_eq!(plane.normal, normal, "an axis is exact");
        }
        // Steeper ones are stored at the limit of what a side can face.
        if normal[side >> 1].abs() < 0.03 {
            continue;
        }
        worst_angle = worst_angle.max(plane.normal.distance(normal));
        worst_height = worst_height.max(plane.height(centroid).abs());
        let crossing = centroid[side >> 1] - plane.height(centroid) / plane.normal[side >> 1];
        assert!((0.0..=1.0).contains(&crossing), "{i:?}: the plane leaves the voxel at {crossing}");
    }
    println!("worst normal {worst_angle:.5}, worst height {worst_height:.5}");
    assert!(worst_angle < 0.0035, "normals are off by up to {worst_angle}");
    assert!(worst_height < 0.0015, "heights are off by up to {worst_height} voxel");
}

#[test]
fn the_mean_of_dithered_albedos_is_exact() {
    let mut random = Random::new(4);
    for _ in 0..50 {
        let albedo = random.point();
        let samples = 4000;
        let sum: DVec3 = (0..samples).map(|_| albedo_decode(albedo_encode(albedo, random.point()))).sum();
        let error = (sum / f64::from(samples) - albedo).abs().max_element();
        // Steps are up to 0.064 wide: five deviations of their mean.
        assert!(error < 0.032 * 5.0 / f64::from(samples).sqrt(), "{albedo}: off by {error}");
    }
}

#[test]
fn radiance_rounds_to_nine_bits() {
    for i in inputs() {
        let color = Vec3::from(i.color).min(Vec3::splat(65408.0));
        let error = (rgb9e5_decode(rgb9e5_encode(color, Vec3::splat(0.5))) - color).abs().max_element();
        // Half a step of a mantissa that starts at 256 and may carry; the smallest exponent bounds it below.
        assert!(error <= (color.max_element() / 256.0).max(2f32.powi(-24)) * 0.502, "{color}: off by {error}");
    }
}

/// Also just below a power of two, where rounding up changes the exponent.
#[test]
fn stochastic_rounding_of_radiance_is_exact_on_average() {
    let mut random = Random::new(5);
    for k in 0..100 {
        let color = if k % 2 == 0 { random.point() * 3.0 } else { DVec3::new(random.unit(), 511.3 / 512.0, 0.999) };
        let color = color.as_vec3();
        let samples = 4000;
        let one = |random: &mut Random| rgb9e5_decode(rgb9e5_encode(color, random.point().as_vec3())).as_dvec3();
        let mean = (0..samples).map(|_| one(&mut random)).sum::<DVec3>() / f64::from(samples);
        let error = (mean - color.as_dvec3()).abs().max_element();
        let step = f64::from(color.max_element()) / 256.0;
        assert!(error < step * 0.5 * 5.0 / f64::from(samples).sqrt(), "{color}: off by {error}");
    }
}

/// A running average of few bits neither sticks nor drifts: towards a steady value beyond a power of two.
#[test]
fn a_running_average_crosses_a_power_of_two() {
    let mut random = Random::new(6);
    let target = Vec3::new(1.03, 0.51, 2.06);
    let mut stored = rgb9e5_encode(target * 0.95, Vec3::splat(0.5));
    for _ in 0..1000 {
        let value = rgb9e5_decode(stored);
        stored = rgb9e5_encode(value + (target - value) / 43.0, random.point().as_vec3());
    }
    let error = ((rgb9e5_decode(stored) - target) / target).abs().max_element();
    assert!(error < 0.015, "{} instead of {target}", rgb9e5_decode(stored));
}
