//! What simplification leaves, and what it leaves alone.

use super::*;
use crate::bricks::{BrickWindow, MAX_TRIANGLES, PrimitiveIndex, WorldGrid};
use crate::parallel::Workers;
use crate::scene::{InstanceDesc, MaterialDesc, MeshDesc, MeshUpdate};
use crate::twin::shapes::{Shape, bumpy_sphere, plate, terrain};
use glam::{DVec2, IVec3};
use std::time::Instant;

const TURNED: [[f32; 3]; 3] = [[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]];

fn scene(tolerance: f64) -> Scene {
    let mut scene = Scene::default();
    scene.tolerance = tolerance;
    let material = MaterialDesc { id: 1, base_color: [0.5; 3], ..MaterialDesc::default() };
    scene.apply(&MeshUpdate { materials: &[material], ..MeshUpdate::default() });
    scene
}

fn add(scene: &mut Scene, shape: &Shape, uvs: &[[f32; 2]]) {
    let mesh = MeshDesc { id: 1, positions: &shape.0, uvs, indices: &shape.1 };
    scene.apply(&MeshUpdate { meshes: &[mesh], ..MeshUpdate::default() });
}

fn instance(id: u64, scale: f32) -> InstanceDesc {
    let linear = TURNED.map(|c| c.map(|v| v * scale));
    InstanceDesc { id, mesh: 1, material: 1, linear, translation: [0.0; 3] }
}

fn place(scene: &mut Scene, id: u64, scale: f32) -> Vec<u64> {
    scene.apply(&MeshUpdate { instances: &[instance(id, scale)], ..MeshUpdate::default() })
}

/// The mesh for an instance of scale 1.
fn simplified(shape: &Shape, uvs: &[[f32; 2]], tolerance: f64) -> Mesh {
    let mut scene = scene(tolerance);
    add(&mut scene, shape, uvs);
    place(&mut scene, 1, 1.0);
    scene.meshes.remove(&1).expect("the mesh")
}

fn volume(mesh: &Mesh) -> f64 {
    let corners = mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize].as_dvec3()));
    corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// 2 000 000 triangles on 64 x 64 voxels.
#[test]
fn a_dense_mesh_costs_what_its_voxels_need() {
    let (voxel, cells) = (0.5, 1000);
    let shape = terrain(32.0, cells);
    let grid = WorldGrid { voxel_size: voxel, offset: DVec3::ZERO };
    let entered = |scene: &Scene| {
        let mut index = PrimitiveIndex::default();
        index.follow(BrickWindow { low: IVec3::splat(-16), size: IVec3::splat(32) }, scene, &grid, &Workers::default());
        let start = Instant::now();
        index.insert(&[1], scene, &grid, &Workers::default());
        let (time, lists) = (start.elapsed(), index.lists());
        let (listed, longest) = lists.values().fold((0, 0), |s, l| (s.0 + l.len(), s.1.max(l.len())));
        println!("entered in {time:.1?}: {} bricks of {}, {longest} at most", lists.len(), listed / lists.len());
        longest
    };
    let mut scene = scene(0.1 * voxel);
    let start = Instant::now();
    add(&mut scene, &shape, &[]);
    let added = start.elapsed();
    place(&mut scene, 1, 1.0);
    let simplified = start.elapsed() - added;
    let mesh = &scene.meshes[&1];
    println!("2 000 000 triangles added in {added:.1?}, simplified in {simplified:.1?} to {}", mesh.triangles.len());
    let longest = entered(&scene);
    assert_eq!(scene.triangles, Triangles { given: 2_000_000, kept: mesh.triangles.len() as u64 });
    assert!(mesh.triangles.len() < 4 * 64 * 64, "a few triangles a voxel, the border included");
    assert!(longest < MAX_TRIANGLES / 16, "{longest}");
    let mut whole = self::scene(0.0);
    add(&mut whole, &shape, &[]);
    place(&mut whole, 1, 1.0);
    assert!(entered(&whole) > MAX_TRIANGLES, "too many without");

    // Every vertex of the host's lies close to what is left.
    let at = |i: u32| DVec2::new(f64::from(i % (cells + 1)), f64::from(i / (cells + 1)));
    let place = |p: Vec3| DVec2::new(p.x.into(), p.z.into()) * (f64::from(cells) / 32.0) + f64::from(cells) / 2.0;
    let mut off = vec![f64::INFINITY; shape.0.len()];
    for t in &mesh.triangles {
        let corners = t.map(|i| mesh.positions[i as usize]);
        let [a, b, c] = corners.map(place);
        let area = (b - a).perp_dot(c - a);
        let (low, high) = (a.min(b).min(c).floor(), a.max(b).max(c).ceil());
        for (x, z) in (low.x as u32..=high.x as u32).flat_map(|x| (low.y as u32..=high.y as u32).map(move |z| (x, z))) {
            let index = z * (cells + 1) + x;
            if x > cells || z > cells {
                continue;
            }
            let p = at(index);
            let weights = [(c - b).perp_dot(p - b), (a - c).perp_dot(p - c), (b - a).perp_dot(p - a)].map(|w| w / area);
            if weights.iter().all(|w| *w > -1e-3) {
                let height: f64 = weights.iter().zip(corners).map(|(w, p)| w * f64::from(p.y)).sum();
                let off = &mut off[index as usize];
                *off = off.min((height - f64::from(shape.0[index as usize][1])).abs() / voxel);
            }
        }
    }
    let rms = (off.iter().map(|o| o * o).sum::<f64>() / off.len() as f64).sqrt();
    let most = off.iter().copied().fold(0.0, f64::max);
    println!("off by {rms:.3} voxels (root mean square), {most:.3} at most");
    assert!(rms < 0.1 && most < 0.4, "{rms} {most}");
}

#[test]
fn a_solid_stays_closed_and_keeps_its_volume() {
    let shape = bumpy_sphere(8.0, 100, 200);
    let [before, after] = [0.0, 0.125].map(|tolerance| simplified(&shape, &[], tolerance));
    println!("{} of {} triangles", after.triangles.len(), before.triangles.len());
    assert!(after.triangles.len() * 8 < before.triangles.len());
    assert!(!after.two_sided.contains(&true));
    assert!(!sheets::two_sided(&after.positions, &after.triangles).contains(&true), "closed");
    assert!((volume(&after) / volume(&before) - 1.0).abs() < 0.02);
}

/// A tenth of the tolerance thick, sharp and round.
#[test]
fn a_thin_solid_keeps_its_thickness() {
    let plate = plate([160, 2, 120], 0.0125);
    let mut pillow = bumpy_sphere(1.0, 60, 120);
    pillow.0.iter_mut().for_each(|p| p[1] *= 0.0125);
    for (name, shape) in [("plate", plate), ("pillow", pillow)] {
        let [before, after] = [0.0, 0.25].map(|tolerance| simplified(&shape, &[], tolerance));
        println!("{name}: {} of {} triangles", after.triangles.len(), before.triangles.len());
        assert!(after.triangles.len() * 4 < before.triangles.len(), "{name}");
        let ratio = volume(&after) / volume(&before);
        assert!((ratio - 1.0).abs() < 0.05, "{name}: {ratio}");
    }
}

#[test]
fn borders_stay_where_they_are() {
    let cells = 60;
    let shape = terrain(8.0, cells);
    let mesh = simplified(&shape, &[], 0.25);
    assert!(mesh.triangles.len() * 4 < shape.1.len() / 3);
    assert!(!mesh.two_sided.contains(&false));
    let on_border = |p: &&Vec3| p.x.abs().max(p.z.abs()) > 3.999;
    assert_eq!(mesh.positions.iter().filter(on_border).count(), 4 * cells as usize);
}

/// A roll whose texture goes round once, its seam given twice.
#[test]
fn texture_seams_stay_closed_and_the_texture_in_place() {
    let (around, along) = (240, 80);
    let (mut shape, mut uvs) = ((Vec::new(), Vec::new()), Vec::new());
    for (i, j) in (0..=along).flat_map(|j| (0..=around).map(move |i| (i, j))) {
        let turn = std::f32::consts::TAU * (i % around) as f32 / around as f32;
        shape.0.push([2.0 * turn.cos(), 4.0 * j as f32 / along as f32, 2.0 * turn.sin()]);
        uvs.push([i as f32 / around as f32, j as f32 / along as f32]);
    }
    for (i, j) in (0..along).flat_map(|j| (0..around).map(move |i| (i, j))) {
        let a = j * (around + 1) + i;
        shape.1.extend([a, a + around + 1, a + 1, a + 1, a + around + 1, a + around + 2]);
    }
    let mesh = simplified(&shape, &uvs, 0.1);
    println!("{} of {} triangles", mesh.triangles.len(), shape.1.len() / 3);
    assert!(mesh.triangles.len() * 4 < shape.1.len() / 3);
    let mut edges = FxHashMap::<_, i32>::default();
    let at = sheets::weld(&mesh.positions);
    for t in &mesh.triangles {
        let middle = t.iter().map(|i| mesh.positions[*i as usize]).sum::<Vec3>() / 3.0;
        let uv = t.iter().map(|i| mesh.uvs[*i as usize]).sum::<Vec2>() / 3.0;
        let turn = f64::from(middle.z).atan2(middle.x.into()).rem_euclid(std::f64::consts::TAU) / std::f64::consts::TAU;
        assert!((turn - f64::from(uv.x)).abs() < 0.02 && (middle.y / 4.0 - uv.y).abs() < 0.02, "{middle} {uv}");
        for k in 0..3 {
            let [from, to] = [t[k], t[(k + 1) % 3]].map(|i| at[i as usize]);
            *edges.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
        }
    }
    assert_eq!(edges.values().filter(|n| **n != 0).count(), 2 * around as usize, "open at its ends only");
}

/// Larger instances have finer meshes; what is no larger changes nothing.
#[test]
fn a_mesh_is_as_fine_as_its_largest_instance_needs() {
    let shape = bumpy_sphere(8.0, 100, 200);
    let mut scene = scene(0.125);
    add(&mut scene, &shape, &[]);
    let given = shape.1.len() as u64 / 3;
    assert_eq!(scene.triangles, Triangles { given, kept: given }, "without an instance nothing is known");
    assert_eq!(place(&mut scene, 1, 1.0), [1]);
    let first = scene.triangles.kept;
    assert_eq!(place(&mut scene, 2, 0.5), [2]);
    assert_eq!(place(&mut scene, 3, 1.0), [3]);
    assert_eq!(scene.triangles.kept, first);
    assert_eq!(place(&mut scene, 2, 1.1), [1, 2, 3], "all instances of a mesh that is another one now");
    let second = scene.triangles.kept;
    assert!(second > first);
    assert_eq!(place(&mut scene, 2, 1.9), [2], "it was done for twice the scale");
    // As large as this no triangle can be spared.
    assert_eq!(place(&mut scene, 1, 1e6), [1, 2, 3]);
    assert_eq!(scene.triangles, Triangles { given, kept: given });
    let mesh = &scene.meshes[&1];
    assert!(mesh.positions.iter().map(|p| p.to_array()).eq(shape.0.iter().copied()), "the host's own again");
    let none = MeshUpdate::default();
    scene.apply(&MeshUpdate { removed_instances: &[1, 2, 3], removed_meshes: &[1], ..none });
    assert_eq!(scene.triangles, Triangles::default());
}

/// As the largest floats make it: what it is worth is another matter.
#[test]
fn a_mesh_without_bounds_stays_as_it_is() {
    let mut shape = bumpy_sphere(8.0, 20, 40);
    (shape.0[0], shape.0[1]) = ([3e38; 3], [-3e38; 3]);
    let mesh = simplified(&shape, &[], 0.125);
    assert_eq!((mesh.triangles.len(), mesh.clusters.len()), (shape.1.len() / 3, 1));
}

#[test]
fn the_bound_of_a_scale_holds_and_is_exact_for_similarities() {
    let turned = DMat3::from_cols_array_2d(&TURNED.map(|c| c.map(f64::from)));
    assert!((largest_scale(&(turned * 3.0)) - 3.0).abs() < 1e-5);
    let sheared = turned * DMat3::from_diagonal(DVec3::new(1.0, 5.0, 0.1)) * DMat3::from_rotation_x(0.7);
    let exact = 5.0;
    assert!((exact * (1.0 - 1e-5)..exact * 3f64.sqrt()).contains(&largest_scale(&sheared)));
}
