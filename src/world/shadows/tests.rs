//! Shadow maps drawn by formula, of casters that no voxel knows: what they leave on the floor.

use super::gpu_layers;
use crate::bricks::WorldGrid;
use crate::gpu::shared::Light as GpuLight;
use crate::scene::{Camera, Light, ShadowLayer, ShadowMap, check_shadow_maps};
use crate::settings::Settings;
use crate::world::floor::{FLOOR, MOMENTS, SHIFTED, cosine_over_square, lit_floor, live, live_mesh, quad};
use crate::world::histories::Live;
use ash::vk;
use ash::vk::Handle;
use glam::{DMat3, DVec2, DVec3, DVec4, IVec3};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

const EDGE: u32 = 64;
/// Grazing, so that half a texel makes a difference of depth.
const SUN: Light = Light::Directional { direction: [0.0, -1.0, 1.2], irradiance: [5.0; 3] };
const RANGE: f32 = 9.0;

fn camera(position: DVec3, right: DVec3, forward: DVec3, projection: [[f32; 4]; 4]) -> Camera {
    let rotation = DMat3::from_cols(right, forward.cross(right), forward).transpose();
    Camera { position: position.to_array(), view_rotation: rotation.as_mat3().to_cols_array_2d(), projection }
}

/// Parallel, about the world's origin; so many metres to each side.
fn sun_camera(direction: DVec3, half: f32) -> Camera {
    let forward = direction.normalize();
    let [scale, depth] = [1.0 / half, 0.05];
    let projection = [[scale, 0.0, 0.0, 0.0], [0.0, scale, 0.0, 0.0], [0.0, 0.0, depth, 0.0], [0.0, 0.0, 0.0, 1.0]];
    camera(forward * -10.0, DVec3::X, forward, projection)
}

/// The six faces of a cube, from 0.05 to 20 m.
fn cube(position: DVec3) -> [Camera; 6] {
    let (near, far) = (0.05, 20.0);
    let scale = far / (far - near);
    let projection =
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, scale, 1.0], [0.0, 0.0, -near * scale, 0.0]];
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    [(z, x), (z, -x), (x, y), (x, -y), (x, z), (x, -z)].map(|(right, axis)| camera(position, right, axis, projection))
}

/// What a rasteriser leaves: at the centre of each texel `value` of depth and place of the nearest of the floor and a
/// caster, which is 1.4 m above it where its shadow is to fall.
fn draw(camera: &Camera, shadow: impl Fn(DVec3) -> bool, value: impl Fn(f64, DVec3) -> f64) -> Vec<f32> {
    let (clip, origin) = (camera.clip(), DVec3::from(camera.position));
    let texel = |index: u32| {
        let [x, y] = [index % EDGE, index / EDGE].map(|i| (f64::from(i) + 0.5) / f64::from(EDGE) * 2.0 - 1.0);
        let [near, far] = [0.0, 1.0].map(|depth| clip.inverse().project_point3(DVec3::new(x, y, depth)) + origin);
        let height = |y: f64| near + (far - near) * ((y - near.y) / (far.y - near.y));
        let floor = height(f64::from(FLOOR));
        let is_below = far.y < f64::from(FLOOR);
        let surface = if is_below && shadow(floor) { near.lerp(floor, 0.6) } else { floor };
        let depth = clip.project_point3(surface - origin).z;
        if is_below { value(depth, surface) as f32 } else { value(1.0, far) as f32 }
    };
    (0..EDGE * EDGE).map(texel).collect()
}

fn layer(layer: u32, camera: Camera) -> ShadowLayer {
    ShadowLayer { layer, rectangle: [0; 4], camera }
}

fn map(view: vk::ImageView, layers: Vec<ShadowLayer>) -> ShadowMap {
    let (depth_bias, normal_offset) = (0.0, 0.0);
    ShadowMap { light: 0, view, size: [EDGE; 2], layers, reversed: false, range: 0.0, depth_bias, normal_offset }
}

/// Irradiance of the floor's faces, by their middles.
fn lit(live: &mut Live, lights: &[Light], maps: &[ShadowMap], moments: u32) -> Vec<(DVec3, f64)> {
    check_shadow_maps(maps, lights).expect("valid maps");
    live.scene.shadow_maps = maps.to_vec();
    let found: BTreeMap<[i32; 3], f64> = lit_floor(live, lights, moments);
    assert!(found.len() >= 256, "{} faces", found.len());
    let grid = live.world.grid;
    let middle = |cell: [i32; 3]| grid.to_world(IVec3::from(cell).as_dvec3() + 0.5).with_y(f64::from(FLOOR));
    found.into_iter().map(|(cell, e)| (middle(cell), e)).collect()
}

/// A floor, and small screens in the world of voxels above it.
fn floor(screens: &[[f32; 4]], direct_lights: u32) -> Live {
    let quads = [&[quad([-4.0, -4.0, 4.0, 4.0], FLOOR)], &*screens.iter().map(|s| quad(*s, 1.53)).collect::<Vec<_>>()];
    live(Settings { voxel_size: 0.5, direct_samples: 4, direct_lights, ..Settings::default() }, &quads.concat())
}

/// Faces are black where x is below 0, and have this irradiance, within a part of it, elsewhere.
fn assert_half(faces: &[(DVec3, f64)], lit: impl Fn(DVec3) -> f64, tolerance: f64) {
    let [dark, light] = [true, false].map(|side| faces.iter().filter(move |(p, _)| (p.x < 0.0) == side));
    assert_eq!(dark.clone().filter(|(_, e)| *e == 0.0).count(), faces.len() / 2);
    let off = light.map(|(p, e)| (e / lit(*p) - 1.0).abs()).fold(0.0, f64::max);
    println!("a lit face is off by {:.2} % at most", 100.0 * off);
    assert!(off < tolerance, "a lit face is off by {off}");
}

/// One map as it is, in reverse depth, in an atlas whose rest is black, and read where some lights are chosen of many.
#[test]
fn a_map_that_shadows_half_the_floor_makes_half_the_faces_dark() {
    let Light::Directional { direction, .. } = SUN else { unreachable!() };
    let direction = DVec3::from(direction.map(f64::from));
    let camera = sun_camera(direction, 6.0);
    let is_dark = |p: DVec3| p.x < 0.0;
    let irradiance = 5.0 * -direction.normalize().y;
    let depths = draw(&camera, is_dark, |depth, _| depth);
    let far_away = Light::Point { position: [0.0, 90.0, 0.0], intensity: [1.0; 3], range: 1.0 };
    for direct_lights in [4, 1] {
        let mut live = floor(&[], direct_lights);
        let plain = map(live.gpu.image([EDGE; 2], std::slice::from_ref(&depths)), vec![layer(0, camera)]);
        assert_half(&lit(&mut live, &[SUN, far_away], std::slice::from_ref(&plain), 1), |_| irradiance, 0.01);
        if direct_lights == 1 {
            continue;
        }
        let reversed = depths.iter().map(|depth| 1.0 - depth).collect();
        // Depth 1 - z: of the row that clip space's z is, w less it.
        let mut from_behind = camera;
        (from_behind.projection[2][2], from_behind.projection[3][2]) = (-0.05, 1.0);
        let view = live.gpu.image([EDGE; 2], &[vec![0.0; depths.len()], reversed]);
        let reversed = ShadowMap { reversed: true, ..map(view, vec![layer(1, from_behind)]) };
        assert_half(&lit(&mut live, &[far_away, SUN], &[ShadowMap { light: 1, ..reversed }], 1), |_| irradiance, 0.01);

        let (width, [left, top]) = (4 * EDGE, [2 * EDGE, EDGE / 2]);
        let mut atlas = vec![0.0; (width * 2 * EDGE) as usize];
        for (row, texels) in (top..).zip(depths.chunks_exact(EDGE as usize)) {
            atlas[(row * width + left) as usize..][..EDGE as usize].copy_from_slice(texels);
        }
        let size = [width, 2 * EDGE];
        let part = ShadowLayer { rectangle: [left, top, EDGE, EDGE], ..layer(0, camera) };
        let view = live.gpu.image(size, &[atlas]);
        assert_half(&lit(&mut live, &[SUN], &[ShadowMap { size, ..map(view, vec![part]) }], 1), |_| irradiance, 0.01);

        // Its light is now another one, which has an extent.
        live.scene.shadow_maps = vec![plain];
        let ball = Light::Sphere { position: [0.0, 3.0, 0.0], radius: 0.5, radiance: [4.0; 3] };
        assert!(lit_floor(&mut live, &[ball], 1).values().all(|e| *e > 0.0));
    }
}

/// The fine cascade sees nothing, the coarse one something everywhere; a screen stands in the fine one, and one beyond both.
#[test]
fn the_finest_cascade_decides_and_rays_do_where_there_is_none() {
    let mut live = floor(&[[-1.0, -1.0, 0.0, 0.0], [3.0, 3.0, 4.0, 4.0]], 4);
    let cascades = [2.0, 3.0].map(|half| sun_camera(DVec3::NEG_Y, half));
    let view = live.gpu.image([EDGE; 2], &[1.0, 0.1].map(|depth| vec![depth; (EDGE * EDGE) as usize]));
    let sun = Light::Directional { direction: [0.0, -1.0, 0.0], irradiance: [5.0; 3] };
    let layers = vec![layer(0, cascades[0]), layer(1, cascades[1])];
    let faces = lit(&mut live, &[sun], &[map(view, layers)], 1);
    for (p, e) in &faces {
        let out = p.x.abs().max(p.z.abs());
        let is_lit = if out < 3.0 { out < 2.0 } else { p.x.min(p.z) < 3.0 };
        let truth = if is_lit { 5.0 } else { 0.0 };
        assert!((e - truth).abs() < 0.05, "at {p}: {e}, not {truth}");
    }
    let rays = lit(&mut live, &[sun], &[], 1);
    let dark = |faces: &[(DVec3, f64)]| faces.iter().filter(|(_, e)| *e == 0.0).count();
    assert_eq!([dark(&faces), dark(&rays)], [84, 8]);
}

/// A cube about a point, of depths and of distances.
#[test]
fn a_cube_shadows_half_the_floor_of_a_point() {
    let position = DVec3::new(0.0, 1.1, 0.0);
    let point = Light::Point { position: position.to_array(), intensity: [3.0; 3], range: 0.0 };
    let mut live = floor(&[], 4);
    let cameras = cube(position);
    for range in [0.0, RANGE] {
        let value = |depth: f64, p: DVec3| if range > 0.0 { p.distance(position) / f64::from(range) } else { depth };
        let images = cameras.map(|camera| draw(&camera, |p| p.x < 0.0, value));
        let layers = (0..).zip(cameras).map(|(index, camera)| layer(index, camera)).collect();
        let cube = ShadowMap { range, ..map(live.gpu.image([EDGE; 2], &images), layers) };
        let faces = lit(&mut live, &[point], &[cube], MOMENTS);
        let over_face = |p: DVec3| {
            let places = (0..64).map(|i| p + 0.5 * (DVec3::new(f64::from(i % 8), 3.5, f64::from(i / 8)) - 3.5) / 8.0);
            3.0 * places.map(|p| cosine_over_square(position, p)).sum::<f64>() / 64.0
        };
        assert_half(&faces, over_face, 0.03);
    }
}

/// A ball's own map, so fine that texels are no matter: faces lie on mean planes, half of each behind the ball. (If they were
/// not moved off for that, the ball would take 23 % of its light; moved by .02 voxel .7 %, by .05 and more none.)
#[test]
fn a_ball_hardly_shadows_itself() {
    const BALL_EDGE: u32 = 512;
    let [columns, rows] = [64, 32];
    let place = |i: u32| {
        let [around, down] =
            [(i % columns, columns), (i / columns, columns)].map(|(k, n)| f64::from(k) / f64::from(n) * TAU);
        DVec3::new(down.sin() * around.cos(), down.cos(), down.sin() * around.sin()).as_vec3().to_array()
    };
    let positions: Vec<_> = (0..columns * (rows + 1)).map(place).collect();
    let quad = |i: u32| {
        let [left, right] = [i, i / columns * columns + (i + 1) % columns];
        [left, right, left + columns, right, right + columns, left + columns]
    };
    let indices: Vec<u32> = (0..columns * rows).flat_map(quad).collect();
    let settings = Settings { voxel_size: 0.25, grid_offset: SHIFTED, direct_samples: 4, ..Settings::default() };
    let mut live = live_mesh(settings, &positions, &indices);
    let direction = DVec3::new(0.0, -1.0, 0.5);
    let camera = sun_camera(direction, 1.2);
    // The facets' middles lie as far inside.
    let radius = (PI / f64::from(columns)).cos();
    let depth = |i: u32| {
        let at = |k: u32| 1.2 * ((f64::from(k) + 0.5) / f64::from(BALL_EDGE) * 2.0 - 1.0);
        let aside = DVec2::new(at(i % BALL_EDGE), at(i / BALL_EDGE)).length();
        if aside < radius { ((10.0 - (radius * radius - aside * aside).sqrt()) / 20.0) as f32 } else { 1.0 }
    };
    let depths: Vec<f32> = (0..BALL_EDGE * BALL_EDGE).map(depth).collect();
    let sun = Light::Directional { direction: direction.as_vec3().to_array(), irradiance: [5.0; 3] };
    let view = live.gpu.image([BALL_EDGE; 2], &[depths]);
    live.scene.lights = vec![sun];
    let own = ShadowMap { size: [BALL_EDGE; 2], ..map(view, vec![layer(0, camera)]) };
    let [rays, own] = [vec![], vec![own]].map(|maps| {
        live.scene.shadow_maps = maps;
        live.world.lights_changed();
        (0..64).for_each(|_| live.frame());
        live.radiance().iter().map(|(_, _, radiance)| f64::from(radiance.y)).sum::<f64>()
    });
    let lost = 1.0 - own / rays;
    println!("the ball takes {:+.2} % of the light that it has with rays", 100.0 * lost);
    assert!(own > 0.0 && lost.abs() < 0.005, "{own}, with rays {rays}");
}

/// Places far from the world's origin come to the texels that they would come to near it.
#[test]
fn maps_keep_their_precision_far_away() {
    for far in [0.0, 1e6] {
        let corner = DVec3::new(far, 0.0, -far);
        let mut camera = sun_camera(DVec3::new(0.4, -1.0, 0.7), 20.0);
        camera.position = (DVec3::from(camera.position) + corner).to_array();
        let grid = WorldGrid { voxel_size: 0.25, offset: DVec3::splat(0.37) };
        let window = grid.to_voxels(corner).floor() - 500.0;
        let maps = [map(vk::ImageView::from_raw(1), vec![layer(0, camera)])];
        let found = gpu_layers(&maps, &mut [GpuLight::default()], &grid, window)[0];
        let clip = glam::Mat4::from_cols_array_2d(&found.clip);
        for place in [DVec3::ZERO, DVec3::new(7.0, -3.0, 5.0)] {
            let in_grid = (grid.to_voxels(corner + place) - window).as_vec3();
            let truth: DVec4 = camera.clip() * (corner + place - DVec3::from(camera.position)).extend(1.0);
            let off = (clip * in_grid.extend(1.0)).as_dvec4() - truth;
            assert!(off.abs().max_element() < 1e-5, "{off}");
        }
    }
}
