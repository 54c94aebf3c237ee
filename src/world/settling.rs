//! How light settles, and stays.

use super::World;
use super::floor::{FLOOR, HALF as FLOOR_HALF, SHIFTED, UP, live, live_mesh, quad};
use super::histories::Live;
use crate::scene::Light;
use crate::settings::Settings;
use glam::{DVec3, IVec3};
use std::collections::BTreeMap;

/// Of what `live_mesh` makes.
const ALBEDO: f64 = 0.5;
/// Half the edges of a closed room, metres.
const HALF: [f32; 3] = [0.95, 0.65, 0.8];

/// A closed room with a lamp in it, its grid askew to the walls. Its faces are lit once a frame.
fn room(settings: Settings) -> Live {
    let corner = |i: u32| std::array::from_fn(|axis| if i >> axis & 1 == 1 { HALF[axis] } else { -HALF[axis] });
    let corners: Vec<[f32; 3]> = (0..8).map(corner).collect();
    // Towards the middle.
    let quads = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
    let triangles = |q: [u32; 4]| [q[0], q[1], q[2], q[0], q[2], q[3]];
    let indices: Vec<u32> = quads.into_iter().flat_map(triangles).collect();
    let mut live = live_mesh(Settings { grid_offset: SHIFTED, ..settings }, &corners, &indices);
    live.scene.lights = vec![Light::Point { position: [0.4, 0.3, -0.2], intensity: [3.0; 3], range: 0.0 }];
    live.world.lights_changed();
    live
}

/// Radiance of every face.
fn faces(live: &mut Live) -> BTreeMap<([i32; 3], usize), f64> {
    live.radiance().into_iter().map(|(cell, side, l)| ((IVec3::to_array(&cell), side), f64::from(l.y))).collect()
}

fn mean(faces: &BTreeMap<([i32; 3], usize), f64>) -> f64 {
    faces.values().sum::<f64>() / faces.len() as f64
}

/// Mean of the faces' mean radiance over `count` frames, every tenth of them looked at; before each frame, `change`.
fn mean_of(live: &mut Live, count: u32, change: impl Fn(&mut World, u32)) -> f64 {
    let moments = (0..count / 10).map(|moment| {
        for frame in 0..10 {
            change(&mut live.world, 10 * moment + frame);
            live.frame();
        }
        mean(&faces(live))
    });
    moments.sum::<f64>() / f64::from(count / 10)
}

/// 20 000 frames in which nothing may sleep: averages neither stick nor creep, but stay where updates of full weight, whose
/// noise no rounding can swallow, have their mean.
#[test]
fn light_neither_sticks_nor_creeps() {
    let settings = Settings { light_faces_per_frame: 256, direct_samples: 1, bounce_rays: 1, ..Settings::default() };
    let mut live = room(settings);
    let start_over = |world: &mut World, frame: u32| {
        if frame.is_multiple_of(16) {
            world.lights_changed();
        }
    };
    let converged = mean_of(&mut live, 4000, start_over);
    let rouse = |world: &mut World, _| world.table.rouse_lighting();
    mean_of(&mut live, 1000, rouse);
    let blocks: Vec<f64> = (0..4).map(|_| mean_of(&mut live, 5000, rouse)).collect();
    let worst = blocks.iter().map(|block| (block / converged - 1.0).abs()).fold(0.0, f64::max);
    println!("{converged:.5}; over 5 000 frames each {blocks:.5?}: {:.3} % off", 100.0 * worst);
    assert!(worst < 0.005, "{worst:.4}");
}

/// What has settled stays as it is, to the bit.
#[test]
fn settled_light_does_not_flicker() {
    let mut live = room(Settings { light_faces_per_frame: 1024, ..Settings::default() });
    let mut frames = 0;
    while live.world.table.convergence() < 1.0 {
        live.frame();
        frames += 1;
    }
    let settled = faces(&mut live);
    (0..20).for_each(|_| live.frame());
    println!("settled after {frames} frames");
    assert!((100..300).contains(&frames), "{frames}");
    assert!(settled == faces(&mut live));
}

/// In a closed room of one albedo each bounce brings as much to all of the walls as the one before times that. The direct
/// light is uneven, and faces that the corners cut, which it reaches least, count here as much as whole ones; all bounces
/// after it are even.
#[test]
fn bounces_are_none_one_or_all() {
    let means = [(0, false), (4, true), (4, false)].map(|(bounce_rays, single_bounce)| {
        let settings = Settings { light_faces_per_frame: 1024, bounce_rays, single_bounce, ..Settings::default() };
        let mut live = room(settings);
        (0..200).for_each(|_| live.frame());
        mean(&faces(&mut live))
    });
    let [first, all] = [means[1], means[2]].map(|mean| mean / means[0] - 1.0);
    println!("{means:.4?}: of the direct light the first bounce brings {first:.3}, all {all:.3}; albedo {ALBEDO}");
    assert!((first / ALBEDO - 1.0).abs() < 0.15, "{first:.3}");
    assert!((all / first * (1.0 - ALBEDO) - 1.0).abs() < 0.03, "{first:.3} {all:.3}");
}

/// The sun moves in every frame, and each of the bricks is lit but now and then: two voxels within the border of the shadow
/// no face of the floor is still bright, and two outside none is still dark.
#[test]
fn a_moving_sun_leaves_no_bright_faces_behind() {
    let (roof, height) = ([-1.6, -1.3, 1.4, 1.7], 2.1);
    let quads = [quad([-FLOOR_HALF, -FLOOR_HALF, FLOOR_HALF, FLOOR_HALF], FLOOR), quad(roof, height)];
    // Fewer than a brick has.
    let settings = Settings { light_faces_per_frame: 64, grid_offset: SHIFTED, ..Settings::default() };
    let mut live = live(settings, &quads);
    let level = live.world.grid.to_voxels(DVec3::Y * f64::from(FLOOR)).y.floor() as i32;
    let (mut dark, mut lit) = (0, 0);
    for frame in 0..160 {
        let angle = (-50.0 + 0.5 * f64::from(frame)).to_radians();
        let direction = DVec3::new(angle.sin(), -angle.cos(), 0.2).normalize();
        let irradiance = [std::f32::consts::PI / -direction.y as f32; 3];
        live.scene.lights = vec![Light::Directional { direction: direction.as_vec3().to_array(), irradiance }];
        live.world.lights_changed();
        live.frame();
        if frame < 60 || frame % 10 > 0 {
            continue;
        }
        let to_roof = direction * (f64::from(height - FLOOR) / direction.y);
        for (cell, side, radiance) in live.radiance() {
            let p = live.world.grid.to_world(cell.as_dvec3() + 0.5);
            if side != UP || cell.y != level || p.x.abs().max(p.z.abs()) > f64::from(FLOOR_HALF) - 0.5 {
                continue;
            }
            let above = p + to_roof;
            let [x0, z0, x1, z1] = roof.map(f64::from);
            let inside = (above.x - x0).min(x1 - above.x).min(above.z - z0).min(z1 - above.z);
            let share = f64::from(radiance.y) / ALBEDO;
            if inside > 1.0 {
                dark += 1;
                assert!(share < 0.05, "frame {frame}: {share:.3} of the sun, {inside:.2} m within its shadow");
            } else if inside < -1.0 {
                lit += 1;
                assert!(share > 0.95, "frame {frame}: {share:.3} of the sun, {inside:.2} m outside its shadow");
            }
        }
    }
    println!("{dark} faces in the shadow, {lit} in the sun");
    assert!(dark > 30 && lit > 500);
}
