//! A world of level quads for tests of lights: what they bring to the lowest, the floor.

use super::histories::{Live, update};
use crate::scene::{InstanceDesc, Light, MaterialDesc, MeshDesc, MeshUpdate};
use crate::settings::Settings;
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::PI;

const ALBEDO: f32 = 0.5;
/// Half the floor's edge, metres.
pub const HALF: f32 = 4.0;
pub const FLOOR: f32 = 0.1;
/// The side of the floor's voxels that looks up.
pub const UP: usize = 3;
/// At which a face is looked at: the running average of one that sees much of a light from near is not quiet.
pub const MOMENTS: u32 = 12;
pub const SHIFTED: [f32; 3] = [0.37, 0.61, 0.23];

/// A level quad: x and z of two corners, and its height.
pub fn quad([x0, z0, x1, z1]: [f32; 4], y: f32) -> [[f32; 3]; 4] {
    [[x0, y, z0], [x1, y, z0], [x1, y, z1], [x0, y, z1]]
}

/// A world of level quads, loaded.
pub fn live(settings: Settings, quads: &[[[f32; 3]; 4]]) -> Live {
    let indices: Vec<u32> = (0..quads.len() as u32).flat_map(|q| [0, 2, 1, 0, 3, 2].map(|i| 4 * q + i)).collect();
    live_mesh(Settings { bounce_rays: 0, ..settings }, &quads.concat(), &indices)
}

/// The same of one mesh.
pub fn live_mesh(settings: Settings, positions: &[[f32; 3]], indices: &[u32]) -> Live {
    let settings = Settings { coverage_groups: [4, 2, 4], ..settings };
    let mut live = Live::new(settings);
    let linear = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    update(
        &mut live.world,
        &mut live.scene,
        &MeshUpdate {
            materials: &[MaterialDesc { id: 0, base_color: [ALBEDO; 3], ..MaterialDesc::default() }],
            meshes: &[MeshDesc { id: 0, positions, uvs: &[], indices }],
            instances: &[InstanceDesc { id: 0, mesh: 0, material: 0, linear, translation: [0.0; 3] }],
            ..MeshUpdate::default()
        },
    );
    live.settle();
    live
}

/// Irradiance that the floor's faces come to, with their voxels: the mean of so many moments.
pub fn lit_floor(live: &mut Live, lights: &[Light], moments: u32) -> BTreeMap<[i32; 3], f64> {
    lights.iter().for_each(|light| light.check().expect("a valid light"));
    live.scene.lights = lights.to_vec();
    live.world.lights_changed();
    let level = live.world.grid.to_voxels(DVec3::Y * f64::from(FLOOR)).y.floor() as i32;
    let mut floor = BTreeMap::new();
    (0..32).for_each(|_| live.frame());
    for _ in 0..moments {
        (0..8).for_each(|_| live.frame());
        for (cell, _, radiance) in live.radiance().iter().filter(|(cell, side, _)| *side == UP && cell.y == level) {
            *floor.entry(cell.to_array()).or_default() +=
                f64::from(radiance.y) * PI / f64::from(ALBEDO) / f64::from(moments);
        }
    }
    floor
}

/// cos / d^2 of a point above the floor.
pub fn cosine_over_square(position: DVec3, p: DVec3) -> f64 {
    let v = position - p;
    v.y / v.length().powi(3)
}
