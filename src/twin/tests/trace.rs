//! HDDA on the GPU equals brute-force marching on the CPU.

use super::worlds::{floor_to_a_wall, noise, rays, shapes, window};
use crate::frame::Frame;
use crate::gpu::Location;
use crate::gpu::shared::{Frame as FrameUniform, NONE};
use crate::settings::HitModel;
use crate::twin::gpu::Gpu;
use crate::twin::random::Random;
use crate::twin::shared::{TestHit, TestRay};
use crate::twin::trace::{Hit, Ray, trace};
use crate::twin::world::{Packed, World};
use glam::{DVec3, IVec3};

const RAYS: usize = 50_000;
/// Rays that may fall on either side of a rule by rounding alone.
const BORDERLINE_MAX: f64 = 0.005;

fn trace_on_gpu(gpu: &mut Gpu, packed: &Packed, model: HitModel, rays: &[Ray]) -> Vec<TestHit> {
    let single = |v: DVec3| v.as_vec3().to_array();
    let list: Vec<TestRay> = rays
        .iter()
        .map(|r| TestRay {
            origin: single(r.origin),
            t_max: r.t_max as f32,
            direction: single(r.direction),
            normal: single(r.normal),
            start_error: r.start_error as f32,
            ..TestRay::default()
        })
        .collect();
    let mut frame = Frame::default();
    frame.upload.push("frame", &[FrameUniform { hit_model: model as u32, ..packed.frame }]);
    frame.upload.push("world_grid", &packed.grid);
    frame.upload.push("world_bricks", &packed.bricks);
    frame.upload.push("rays", &list);
    frame.dispatch("trace_rays", [(rays.len() as u32).div_ceil(64), 1, 1], [0u32; 0]);
    gpu.buffer("ray_hits", rays.len() * size_of::<TestHit>(), Location::Readback);
    gpu.run(&frame);
    gpu.read("ray_hits", rays.len())
}

/// Everything about a hit that is not a distance.
type Key = Option<(IVec3, usize, u32)>;

fn key(hit: Option<Hit>, packed: &Packed) -> Key {
    hit.map(|h| (h.cell, h.side, h.light.map_or(NONE, |lit| packed.lights[&lit])))
}

/// Whether the twin's own answer changes when the origin moves by a few roundings of a position in the window, or a
/// plane by a tenth of that.
fn is_borderline(world: &World, packed: &Packed, model: HitModel, ray: &Ray, expected: Key) -> bool {
    let step = 3e-5f64.max(f64::from(world.size().max_element()) * 4e-7);
    let nudge = |k: i32| DVec3::new(f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9)) - 1.0;
    (0..27 * 27).any(|k| {
        let (origin, error) = (ray.origin + nudge(k % 27) * step, nudge(k / 27) * step * 0.1);
        let nudged = Ray { origin, error, ..*ray };
        key(trace(world, model, &nudged), packed) != expected
    })
}

/// Rounding of a distance: that of a position, seen along the ray.
fn distance_error(world: &World, hit: &Hit, ray: &Ray) -> f64 {
    let normal = world.voxel(hit.cell).and_then(|v| v.plane(hit.side)).map_or(DVec3::X, |p| p.normal);
    let facing = normal.dot(ray.direction).abs().max(1e-4);
    5e-7 * (hit.t + f64::from(world.size().max_element())) / facing
}

fn agrees(gpu: &mut Gpu, name: &str, world: &World, model: HitModel, seed: u64) {
    let packed = world.pack();
    let rays = rays(&mut Random::new(seed), world, RAYS);
    let found = trace_on_gpu(gpu, &packed, model, &rays);
    let (mut borderline, mut hits, mut closed, mut black) = (0, 0, 0, 0);
    for (ray, gpu) in rays.iter().zip(&found) {
        let hit = trace(world, model, ray);
        let expected = key(hit, &packed);
        let got = (gpu.kind == 1).then(|| (IVec3::from(gpu.cell), gpu.side as usize, gpu.light));
        if got != expected {
            assert!(
                is_borderline(world, &packed, model, ray, expected),
                "{name}: {ray:?}: {gpu:?}, not {hit:?} {expected:?}"
            );
            borderline += 1;
            continue;
        }
        let Some(hit) = hit else { continue };
        hits += 1;
        closed += usize::from(hit.light.is_some_and(|l| l != (hit.cell, hit.side)));
        black += usize::from(hit.light.is_none());
        let error = (f64::from(gpu.t) - hit.t).abs();
        let most = if model == HitModel::Cube { 1e-4 + 1e-5 * hit.t } else { distance_error(world, &hit, ray) };
        assert!(error <= most, "{name}: {ray:?}: {gpu:?}, not {hit:?} (off by {error:e}, not {most:e})");
    }
    let share = borderline as f64 / RAYS as f64;
    println!(
        "{name}: {RAYS} rays, {hits} hit, {closed} by another face's light, {black} black, {borderline} borderline"
    );
    assert!(share < BORDERLINE_MAX, "{name}: {:.2} % of the rays are borderline", share * 100.0);
}

#[test]
fn hdda_hits_what_marching_through_every_voxel_hits() {
    let mut gpu = Gpu::new(&["trace_rays"]);
    let mut random = Random::new(1);

    let mut sparse = window([2, 1, 2], [0, 0, 0]);
    noise(&mut random, &mut sparse, 0.2, 0.02, 0.5, 0.3);
    agrees(&mut gpu, "sparse", &sparse, HitModel::Plane, 11);

    let mut dense = window([1, 1, 1], [5, -3, 7]);
    noise(&mut random, &mut dense, 0.8, 0.6, 0.5, 0.5);
    agrees(&mut gpu, "dense", &dense, HitModel::Plane, 12);
    agrees(&mut gpu, "dense, cube hits", &dense, HitModel::Cube, 13);

    let mut shifted = window([4, 2, 4], [-3, 5, 1_000_001]);
    noise(&mut random, &mut shifted, 0.1, 0.05, 0.5, 0.3);
    agrees(&mut gpu, "several groups, shifted", &shifted, HitModel::Plane, 14);

    let mut closed = window([1, 2, 1], [0, 1, 0]);
    noise(&mut random, &mut closed, 0.5, 0.3, 0.1, 0.9);
    agrees(&mut gpu, "closed faces", &closed, HitModel::Plane, 15);

    let mut solid = window([2, 2, 2], [-1, -1, -1]);
    shapes(&mut random, &mut solid);
    agrees(&mut gpu, "shapes", &solid, HitModel::Plane, 16);
    agrees(&mut gpu, "shapes, cube hits", &solid, HitModel::Cube, 17);
}

/// A ray just above a floor, through the blocks that hold it, visits every voxel of them: more than the steps that a
/// bound in bricks would allow.
#[test]
fn a_grazing_ray_reaches_the_far_end_of_the_window() {
    let mut gpu = Gpu::new(&["trace_rays"]);
    let mut world = window([32, 1, 32], [0, 0, 0]);
    floor_to_a_wall(&mut world);
    let origin = DVec3::new(1.5, 2.5, 1.25);
    let direction = DVec3::new(1.0, 0.0, 0.998).normalize().as_vec3().as_dvec3();
    let ray = Ray { origin, direction, normal: DVec3::ZERO, start_error: 0.25, t_max: 1e30, error: DVec3::ZERO };
    let expected = trace(&world, HitModel::Plane, &ray).expect("the wall");
    let found = trace_on_gpu(&mut gpu, &world.pack(), HitModel::Plane, &[ray])[0];
    assert_eq!((found.kind, IVec3::from(found.cell)), (1, expected.cell), "{found:?}, not {expected:?}");
}
