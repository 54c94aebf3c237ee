//! Voxels of a simplified mesh are those of the mesh.

use super::histories::{Live, update};
use super::*;
use crate::scene::{InstanceDesc, MaterialDesc, MeshDesc, MeshUpdate};
use crate::twin::layout::Voxel;
use crate::twin::pack::plane_decode;
use crate::twin::shapes::bumpy_sphere;
use std::collections::BTreeMap;

/// Occupied voxels by position.
fn voxels(simplify_voxels: f32) -> (BTreeMap<[i32; 3], Voxel>, u64) {
    let settings = Settings {
        voxel_size: 0.5,
        coverage_groups: [4, 4, 4],
        light_faces_per_frame: 64,
        bounce_rays: 0,
        simplify_voxels,
        ..Settings::default()
    };
    let mut live = Live::new(settings);
    let (positions, indices) = bumpy_sphere(8.0, 120, 240);
    let linear = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let given = MeshUpdate {
        materials: &[MaterialDesc { id: 0, base_color: [0.5; 3], ..MaterialDesc::default() }],
        meshes: &[MeshDesc { id: 0, positions: &positions, uvs: &[], indices: &indices }],
        instances: &[InstanceDesc { id: 0, mesh: 0, material: 0, linear, translation: [0.1, 0.2, 0.3] }],
        ..MeshUpdate::default()
    };
    update(&mut live.world, &mut live.scene, &given);
    live.settle();
    let place = |(brick, cell): ([i32; 3], IVec3)| (IVec3::from(brick) * 8 + cell).to_array();
    let bricks = live.bricks().into_iter();
    let voxels = bricks.flat_map(|(at, brick)| brick.into_iter().map(move |(cell, v)| (place((at, cell)), v)));
    (voxels.collect(), live.scene.triangles.kept)
}

#[test]
fn voxels_of_a_simplified_mesh_are_those_of_the_mesh() {
    let tolerance = 0.1;
    let ((before, given), (after, kept)) = (voxels(0.0), voxels(tolerance));
    let common: Vec<_> = before.iter().filter_map(|(at, v)| Some((v, after.get(at)?))).collect();
    let (mut offsets, mut angles, mut sides) = (0.0, 0.0, 0);
    for (a, b) in &common {
        for side in 0..6 {
            let (Some(a), Some(b)) = (a.faces[side], b.faces[side]) else { continue };
            // Faces of which next to nothing lies in the voxel say little.
            if a.mask.count_ones().min(b.mask.count_ones()) < 8 {
                continue;
            }
            let (a, b) = (plane_decode(side, a.plane), plane_decode(side, b.plane));
            let middle = DVec3::splat(0.5);
            offsets += (a.height(middle) - b.height(middle)).powi(2);
            angles += a.normal.dot(b.normal).clamp(-1.0, 1.0).acos().powi(2);
            sides += 1;
        }
    }
    let [offset, angle] = [offsets, angles].map(|sum: f64| (sum / f64::from(sides)).sqrt());
    let strangers = before.len() + after.len() - 2 * common.len();
    println!(
        "{kept} of {given} triangles; {} voxels, {strangers} in one of both only; planes off by {offset:.3} voxels \
         and {:.1} degrees (root mean square)",
        before.len(),
        angle.to_degrees()
    );
    assert!(kept * 8 < given);
    assert!(offset < f64::from(tolerance) && angle.to_degrees() < 6.0);
    assert!(strangers * 10 < before.len());
}
