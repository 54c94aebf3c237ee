//! What lights bring to the faces of a floor, against closed forms.

use crate::scene::{InstanceDesc, Light, MeshUpdate};
use crate::settings::Settings;
use crate::twin::random::Random;
use crate::world::floor::{FLOOR, HALF, MOMENTS, SHIFTED, UP, cosine_over_square, lit_floor, live, quad};
use crate::world::histories::{Live, update};
use glam::{DVec3, IVec3};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_3, PI};

/// Mean of a field over a face of the floor.
fn over_face(live: &Live, cell: IVec3, field: impl Fn(DVec3) -> f64) -> f64 {
    let places = (0..64).map(|i| DVec3::new(f64::from(i % 8) + 0.5, 0.0, f64::from(i / 8) + 0.5) / 8.0);
    let grid = live.world.grid;
    let at = |place: DVec3| grid.to_world(cell.as_dvec3() + place).with_y(f64::from(FLOOR));
    places.map(|place| field(at(place))).sum::<f64>() / 64.0
}

/// A light's irradiance on the floor is the field, face by face, on a grid that lies askew to the floor.
fn assert_field(light: Light, field: impl Fn(DVec3) -> f64) {
    let settings = Settings { voxel_size: 0.5, grid_offset: SHIFTED, direct_samples: 4, ..Settings::default() };
    let mut live = live(settings, &[quad([-HALF, -HALF, HALF, HALF], FLOOR)]);
    let found = lit_floor(&mut live, &[light], MOMENTS);
    let inside = |cell: IVec3| {
        let [low, high] = [cell, cell + 1].map(|c| live.world.grid.to_world(c.as_dvec3()));
        low.x.min(low.z) > -f64::from(HALF) && high.x.max(high.z) < f64::from(HALF)
    };
    let cells = found.iter().map(|(cell, e)| (IVec3::from(*cell), *e)).filter(|(cell, _)| inside(*cell));
    let pairs: Vec<_> = cells.map(|(cell, e)| (e, over_face(&live, cell, &field))).collect();
    assert!(pairs.len() >= 225, "{} faces", pairs.len());
    let most = pairs.iter().map(|p| p.1).fold(0.0, f64::max);
    let [sum, truth] = [pairs.iter().map(|p| p.0).sum::<f64>(), pairs.iter().map(|p| p.1).sum()];
    let worst = pairs.iter().map(|p| (p.0 - p.1).abs() / (p.1 + 0.02 * most)).fold(0.0, f64::max);
    println!("{light:?}: flux {:+.3} %, worst face {:.2} %", 100.0 * (sum / truth - 1.0), 100.0 * worst);
    assert!((sum / truth - 1.0).abs() < 0.005, "flux {sum}, not {truth}");
    assert!(worst < 0.03, "a face is off by {worst}");
}

#[test]
fn the_sun_lights_the_floor_evenly() {
    let light = Light::Directional { direction: [3.0, -4.0, 0.0], irradiance: [5.0; 3] };
    assert_field(light, |_| 5.0 * 0.8);
}

#[test]
fn a_point_falls_off_with_the_square_of_its_distance() {
    let position = DVec3::new(0.7, 1.6, -0.4);
    let light = Light::Point { position: position.to_array(), intensity: [3.0; 3], range: 0.0 };
    assert_field(light, |p| 3.0 * cosine_over_square(position, p));
}

#[test]
fn a_point_ends_at_its_range() {
    let position = DVec3::new(0.7, 1.6, -0.4);
    let light = Light::Point { position: position.to_array(), intensity: [3.0; 3], range: 3.0 };
    assert_field(light, |p| {
        let window = (1.0 - (position.distance(p) / 3.0).powi(4)).max(0.0).powi(2);
        3.0 * window * cosine_over_square(position, p)
    });
}

#[test]
fn a_spot_falls_off_between_its_angles() {
    let (position, direction) = (DVec3::new(-1.0, 2.5, 0.5), DVec3::new(0.4, -1.0, 0.1));
    let light = Light::Spot {
        position: position.to_array(),
        direction: direction.as_vec3().to_array(),
        intensity: [3.0; 3],
        inner_angle: 0.3,
        outer_angle: 0.7,
        range: 0.0,
    };
    assert_field(light, |p| {
        let cosine = (p - position).normalize().dot(direction.normalize());
        let share = ((cosine - 0.7f64.cos()) / (0.3f64.cos() - 0.7f64.cos())).clamp(0.0, 1.0);
        3.0 * share * share * cosine_over_square(position, p)
    });
}

#[test]
fn a_sphere_is_a_point_with_its_solid_angle() {
    let position = DVec3::new(0.7, 1.1, -0.4);
    let light = Light::Sphere { position: position.to_array(), radius: 0.8, radiance: [2.0; 3] };
    assert_field(light, |p| 2.0 * PI * 0.8 * 0.8 * cosine_over_square(position, p));
}

/// Irradiance of a polygon of radiance 1 on a level plane below it (Lambert 1760).
fn polygon(corners: &[DVec3], p: DVec3) -> f64 {
    let seen: Vec<DVec3> = corners.iter().map(|c| (c - p).normalize()).collect();
    let edge = |i: usize| {
        let (a, b) = (seen[i], seen[(i + 1) % seen.len()]);
        a.dot(b).acos() * a.cross(b).normalize().y
    };
    (0..seen.len()).map(edge).sum::<f64>().abs() / 2.0
}

fn rectangle(position: DVec3, half_u: DVec3, half_v: DVec3, two_sided: bool) -> Light {
    let [half_u, half_v] = [half_u, half_v].map(|axis| axis.as_vec3().to_array());
    Light::Rectangle { position: position.to_array(), half_u, half_v, radiance: [2.0; 3], two_sided }
}

/// Level and tilted, far and near.
#[test]
fn a_rectangle_is_lamberts_polygon() {
    let tilt = DVec3::new(FRAC_PI_3.cos(), FRAC_PI_3.sin(), 0.0);
    let cases = [
        (DVec3::new(0.3, 1.5, 0.2), DVec3::X * 0.6, DVec3::Z * 1.1),
        (DVec3::new(0.3, 0.4, 0.2), DVec3::X * 0.6, DVec3::Z * 1.1),
        (DVec3::new(-1.0, 1.4, 0.2), tilt * 0.9, DVec3::Z * 0.5),
    ];
    for (middle, u, v) in cases {
        let corners = [-u - v, u - v, u + v, v - u].map(|c| middle + c);
        // The tilted one's plane cuts the floor: what lies behind it sees nothing.
        let front = |p: DVec3| (p - middle).dot(u.cross(v)) > 0.0;
        assert_field(rectangle(middle, u, v, false), |p| if front(p) { 2.0 * polygon(&corners, p) } else { 0.0 });
    }
    let (middle, u, v) = cases[2];
    let corners = [-u - v, u - v, u + v, v - u].map(|c| middle + c);
    assert_field(rectangle(middle, v, u, true), |p| 2.0 * polygon(&corners, p));
}

#[test]
fn a_rectangle_is_dark_behind() {
    let light = rectangle(DVec3::Y * 1.5, DVec3::Z, DVec3::X, false);
    let mut live = live(Settings::default(), &[quad([-HALF, -HALF, HALF, HALF], FLOOR)]);
    assert!(lit_floor(&mut live, &[light], 1).values().all(|e| *e == 0.0));
}

/// Flux on the floor of a closed roof with an opening, over what the sun sends through it.
fn share_through(opening: [f32; 4], voxel_size: f32, grid_offset: [f32; 3]) -> f64 {
    let [x0, z0, x1, z1] = opening;
    let outer = [[-2.5, -2.5, 2.5, z0], [-2.5, z1, 2.5, 2.5], [-2.5, z0, x0, z1], [x1, z0, 2.5, z1]];
    let mut quads = outer.map(|edges| quad(edges, 1.53)).to_vec();
    // Small enough that no sun reaches it past the roof.
    quads.push(quad([-1.0, -1.0, 1.75, 1.75], FLOOR));
    // The sun reaches a few faces, and parts of those: many samples.
    let settings = Settings { voxel_size, grid_offset, direct_samples: 16, ..Settings::default() };
    let mut live = live(settings, &quads);
    let direction = DVec3::new(0.6, -1.0, 0.35);
    let sun = Light::Directional { direction: direction.as_vec3().to_array(), irradiance: [5.0; 3] };
    let found = lit_floor(&mut live, &[sun], MOMENTS);
    let sum: f64 = found.values().sum();
    let area = f64::from((x1 - x0) * (z1 - z0));
    let share = sum * f64::from(voxel_size).powi(2) / (5.0 * -direction.normalize().y * area);
    println!("{opening:?} of voxels of {voxel_size} m: {share:.4}");
    share
}

/// Smaller than a voxel, but of whole coverage cells: what is left is where the floor is sampled.
#[test]
fn the_sun_through_a_window_smaller_than_a_voxel_brings_its_flux() {
    let share = share_through([-0.5625, -0.4375, -0.375, -0.3125], 0.25, [0.0; 3]);
    assert!((share - 1.0).abs() < 0.02, "{share:.4} of the flux");
}

/// Cells that are covered by half or more count as covered: openings that lie askew to the voxels lose 1/32 voxel on
/// each side.
#[test]
fn the_sun_through_a_window_askew_to_the_voxels_brings_most_of_its_flux() {
    let share = share_through([-0.6, -0.43, 0.23, 0.64], 0.25, SHIFTED);
    assert!((share - 1.0).abs() < 0.05, "{share:.4} of the flux");
}

/// Lights of all kinds above the floor: some far stronger than others, some that do not reach it.
fn many_lights(count: u32) -> Vec<Light> {
    let mut random = Random::new(7);
    let mut light = |index: u32| {
        let position = [random.between(-4.0, 4.0), random.between(0.6, 3.0), random.between(-4.0, 4.0)];
        let direction = random.direction();
        let strength = [random.between(0.0, 2.0).powi(4) as f32; 3];
        let range = random.between(0.5, 4.0) as f32;
        match index % 5 {
            0 => Light::Point { position, intensity: strength, range },
            1 => Light::Spot {
                position,
                direction: direction.as_vec3().to_array(),
                intensity: strength,
                inner_angle: 0.2,
                outer_angle: 0.8,
                range: 0.0,
            },
            2 => Light::Sphere { position, radius: 0.1 * range, radiance: strength },
            3 => {
                let u = direction.any_orthonormal_vector();
                rectangle(position.into(), u * 0.2, direction.cross(u) * 0.4, index.is_multiple_of(2))
            }
            _ => {
                Light::Directional { direction: [direction.x as f32, -1.0, direction.z as f32], irradiance: [0.03; 3] }
            }
        }
    };
    (0..count).map(&mut light).collect()
}

/// Those that are chosen stand for all: fewer than each brick can choose from, and more; beside a screen. (With all of
/// them in each sample, moments of the same world are 4.7 and 1.2 % apart.)
#[test]
fn some_of_many_lights_stand_for_all_of_them() {
    for (count, most) in [(40, 0.06), (300, 0.03)] {
        let lights = many_lights(count);
        let [all, some] = [(4096, 3), (4, MOMENTS)].map(|(direct_lights, moments)| {
            let settings = Settings { grid_offset: SHIFTED, direct_samples: 1, direct_lights, ..Settings::default() };
            let quads = [quad([-HALF, -HALF, HALF, HALF], FLOOR), quad([-1.2, -1.7, 1.3, 0.6], 0.8)];
            let mut live = live(settings, &quads);
            let found = lit_floor(&mut live, &lights, moments);
            assert!(found.len() >= 256, "{} faces", found.len());
            found
        });
        let [sum, truth] = [&some, &all].map(|faces| faces.values().sum::<f64>());
        let mean = truth / all.len() as f64;
        let square = all.iter().map(|(cell, e)| (some[cell] - e).powi(2)).sum::<f64>() / all.len() as f64;
        let (flux, error) = (sum / truth - 1.0, square.sqrt() / mean);
        println!("{count} lights: flux {:+.3} %, faces {:.2} %", 100.0 * flux, 100.0 * error);
        assert!(flux.abs() < 0.005 && error < most, "flux {flux:+.4}, faces {error:.4}");
    }
}

/// Something moves under the floor, frame by frame: the floor's faces above it keep their averages. (As if new, they are
/// 73 % apart from frame to frame.)
#[test]
fn where_something_moves_what_stays_keeps_its_light() {
    // In the half shadow of the screen.
    let quads = [quad([-HALF, -HALF, HALF, HALF], FLOOR), quad([-1.2, -1.7, 1.3, 0.6], 0.8)];
    let settings = Settings { grid_offset: SHIFTED, direct_samples: 1, ..Settings::default() };
    let mut live = live(settings, &quads);
    let light = Light::Sphere { position: [0.1, 2.0, -0.3], radius: 0.9, radiance: [1.0; 3] };
    lit_floor(&mut live, &[light], 6);
    let level = live.world.grid.to_voxels(DVec3::Y * f64::from(FLOOR)).y.floor() as i32;
    let linear = [[0.1, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.1]];
    let at = DVec3::new(0.8, -1.0, 0.8);
    let brick = live.world.grid.to_voxels(at).floor().as_ivec3() >> 3i32;
    let mut seen: BTreeMap<[i32; 3], Vec<f64>> = BTreeMap::new();
    for frame in 0..64 {
        let translation = (at + DVec3::X * 0.1 * f64::from(frame % 2)).to_array();
        let instances = &[InstanceDesc { id: 1, mesh: 0, material: 0, linear, translation }];
        update(&mut live.world, &mut live.scene, &MeshUpdate { instances, ..MeshUpdate::default() });
        live.frame();
        for (cell, _, radiance) in live.radiance().iter().filter(|(cell, side, _)| *side == UP && cell.y == level) {
            seen.entry(cell.to_array()).or_default().push(f64::from(radiance.y));
        }
    }
    let above =
        seen.iter().filter(|(cell, _)| IVec3::from(**cell) >> 3i32 == brick).map(|(_, radiance)| &radiance[16..]);
    let steps = |v: &[f64]| v.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / (v.len() - 1) as f64;
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (count, square, sum) = above.fold((0.0, 0.0, 0.0), |(n, s, m), v| (n + 1.0, s + steps(v), m + mean(v)));
    let moved = f64::sqrt(square / count) / (sum / count);
    println!("{count} faces, {:.2} % apart from frame to frame", 100.0 * moved);
    assert!(moved > 0.0 && moved < 0.3, "{moved:.3}");
}
