//! Which bricks a change touches, and what the lists hold after any history.

use super::*;
use crate::parallel::tests::threads;
use crate::scene::{InstanceDesc, MaterialDesc, MeshDesc, MeshUpdate};
use crate::twin::shapes::terrain;

const GRID: WorldGrid = WorldGrid { voxel_size: 0.5, offset: DVec3::ZERO };
const WINDOW: BrickWindow = BrickWindow { low: IVec3::new(-64, -16, -64), size: IVec3::new(128, 32, 128) };

fn scene(positions: &[[f32; 3]], indices: &[u32]) -> Scene {
    let mut scene = Scene::default();
    let material = MaterialDesc { id: 1, base_color: [0.5; 3], ..MaterialDesc::default() };
    let mesh = MeshDesc { id: 1, positions, uvs: &[], indices };
    scene.apply(&MeshUpdate { materials: &[material], meshes: &[mesh], ..MeshUpdate::default() });
    scene
}

fn place_at(scene: &mut Scene, id: u64, translation: [f64; 3]) {
    let linear = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let instances = [InstanceDesc { id, mesh: 1, material: 1, linear, translation }];
    scene.apply(&MeshUpdate { instances: &instances, ..MeshUpdate::default() });
}

fn index(window: BrickWindow, scene: &Scene) -> PrimitiveIndex {
    let mut index = PrimitiveIndex { window: Some(window), ..PrimitiveIndex::default() };
    let mut ids: Vec<u64> = scene.instances.keys().copied().collect();
    ids.sort_unstable();
    index.insert(&ids, scene, &GRID, &Workers::default());
    index
}

/// A torus about the y axis, metres.
fn ring(radius: f32, tube: f32, around: u32, across: u32) -> (Vec<[f32; 3]>, Vec<u32>) {
    let corner = |i: u32| {
        let turn = |i: u32, n: u32| (i as f32 / n as f32 * std::f32::consts::TAU).sin_cos();
        let ((s, c), (up, out)) = (turn(i / across, around), turn(i % across, across));
        let distance = radius + tube * out;
        [distance * c, tube * up, distance * s]
    };
    let side = |i: u32| {
        let at = |u: u32, v: u32| (u % around) * across + v % across;
        let (u, v) = (i / across, i % across);
        [at(u, v), at(u, v + 1), at(u + 1, v), at(u + 1, v), at(u, v + 1), at(u + 1, v + 1)]
    };
    ((0..around * across).map(corner).collect(), (0..around * across).flat_map(side).collect())
}

/// A ring 200 m across redoes its own bricks, not those of its bounds: few more than its triangles pass through, for what
/// lies a voxel away from a triangle changes with it.
#[test]
fn a_large_ring_touches_its_own_bricks() {
    let (positions, indices) = ring(100.0, 1.0, 720, 12);
    let mut scene = scene(&positions, &indices);
    place_at(&mut scene, 1, [0.3, 1.7, 0.9]);
    let mut index = PrimitiveIndex { window: Some(WINDOW), ..PrimitiveIndex::default() };
    index.insert(&[1], &scene, &GRID, &Workers::default());
    let touched = index.touched(1).len();
    let mut passed = FxHashSet::default();
    for triangle in &scene.meshes[&1].triangles {
        let [a, b, c] = triangle.map(|i| place(scene.meshes[&1].positions[i as usize], &scene.instances[&1], &GRID));
        let steps = ((b - a).length().max((c - a).length()) * 8.0).ceil() as u32;
        for u in 0..=steps {
            for v in 0..=steps - u {
                let [u, v] = [u, v].map(|w| f64::from(w) / f64::from(steps));
                passed.insert(((a + (b - a) * u + (c - a) * v) / 8.0).floor().as_ivec3());
            }
        }
    }
    assert!(passed.iter().all(|b| index.holds(*b)));
    let ratio = touched as f64 / passed.len() as f64;
    assert!(ratio < 1.5, "{touched} bricks are touched, {} passed through: {ratio:.2}", passed.len());
    let placed = &index.placed[0];
    let in_bounds = (placed.last - placed.first + 1).element_product() as usize;
    println!("{touched} bricks touched, {} passed through, {in_bounds} in the bounds", passed.len());
    assert!(touched * 6 < in_bounds, "{touched} of the {in_bounds} bricks of its bounds");
}

/// After any history of instances that come, move and go and of windows that move, the lists are those of a new index.
#[test]
fn lists_do_not_depend_on_history() {
    // Large enough to lie in several bricks, and to reach out of the window.
    let positions = [[-9.0, 0.0, 2.0], [8.0, 3.0, -4.0], [1.0, 6.0, 7.0], [0.0, -5.0, 0.0]];
    let mut scene = scene(&positions, &[0, 1, 2, 0, 3, 1, 1, 3, 2]);
    let mut window = BrickWindow { low: IVec3::new(-8, -4, -8), size: IVec3::new(16, 8, 16) };
    let mut churned = index(window, &scene);
    let mut random = 1u32;
    let mut next = |n: u32| {
        random = random.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (random >> 8) % n
    };
    for _ in 0..300 {
        let ids: Vec<u64> = (0..3).map(|_| u64::from(next(20))).collect();
        let before = churned.lists();
        let left = churned.remove(&ids);
        let touched = |list: &&Vec<(u64, u32)>| list.iter().any(|p| ids.contains(&p.0));
        assert_eq!(left.len(), before.values().filter(touched).count(), "the bricks that held them, each once");
        for id in ids {
            if next(3) == 0 {
                scene.instances.remove(&id);
            } else {
                place_at(&mut scene, id, [0; 3].map(|_| f64::from(next(120)) - 60.0));
            }
            // An id may have been drawn twice.
            churned.remove(&[id]);
            if scene.instances.contains_key(&id) {
                churned.insert(&[id], &scene, &GRID, &Workers::default());
            }
        }
        if next(4) == 0 {
            window.low += (IVec3::new(next(5) as i32, next(3) as i32, next(5) as i32) - IVec3::new(2, 1, 2)) * 4;
            churned.follow(window, &scene, &GRID, &Workers::default());
        }
        let fresh = index(window, &scene);
        assert_eq!(churned.lists(), fresh.lists());
        assert_eq!(churned.placed.iter().map(|p| p.bricks.len()).sum::<usize>(), {
            fresh.placed.iter().map(|p| p.bricks.len()).sum::<usize>()
        });
    }
    assert!(churned.placed.len() <= 20, "places are used again");
}

/// Clusters pass over what they do not reach, and nothing else.
#[test]
fn work_follows_the_triangles_that_a_window_reaches() {
    let (positions, indices) = terrain(200.0, 300);
    let mut scene = scene(&positions, &indices);
    let linear = [[0.6, 0.0, 0.8], [0.1, 1.2, 0.0], [-0.8, 0.0, 0.6]];
    let placed = InstanceDesc { id: 1, mesh: 1, material: 1, linear, translation: [3.0, 1.0, -2.0] };
    scene.apply(&MeshUpdate { instances: &[placed], ..MeshUpdate::default() });
    let count = scene.meshes[&1].triangles.len() as u64;
    assert_eq!(count, 180_000);
    let mut window = BrickWindow { low: IVec3::new(-4, -4, -4), size: IVec3::splat(8) };
    let mut clustered = index(window, &scene);
    println!("{} of {count} triangles tested in a window of 32 m", clustered.tested);
    assert!(clustered.tested * 15 < count, "of 200 m");
    for step in [IVec3::new(4, 0, 0), IVec3::new(0, 0, -4), IVec3::new(-8, 0, 4)] {
        let before = clustered.tested;
        window.low += step;
        clustered.follow(window, &scene, &GRID, &Workers::default());
        println!("{} when it moves by {step}", clustered.tested - before);
        assert!((clustered.tested - before) * 15 < count);
        // As if all were one cluster.
        let clusters = std::mem::take(&mut scene.meshes.get_mut(&1).expect("the mesh").clusters);
        let all = Cluster {
            triangles: 0..count as u32,
            low: clusters.iter().map(|c| c.low).fold(Vec3::INFINITY, Vec3::min),
            high: clusters.iter().map(|c| c.high).fold(Vec3::NEG_INFINITY, Vec3::max),
        };
        scene.meshes.get_mut(&1).expect("the mesh").clusters = vec![all];
        let whole = index(window, &scene);
        assert_eq!(whole.tested, count);
        assert!(clustered.lists() == whole.lists(), "the same lists");
        scene.meshes.get_mut(&1).expect("the mesh").clusters = clusters;
    }
}

/// However many threads there are: a terrain of many tasks, and more instances than one task holds.
#[test]
fn lists_do_not_depend_on_threads() {
    let (positions, indices) = terrain(30.0, 60);
    let mut scene = scene(&positions, &indices);
    let moved = |k: f64| [7.0 * k - 25.0, 0.3 * k, 4.0 * (k % 4.0)];
    (0..9).rev().for_each(|id| place_at(&mut scene, id, moved(id as f64)));
    let ids: Vec<u64> = (0..9).collect();
    let mut window = BrickWindow { low: IVec3::new(-8, -4, -8), size: IVec3::new(16, 8, 16) };
    let mut indices = [Workers::default(), threads(1), threads(4)].map(|workers| {
        let mut index = PrimitiveIndex { window: Some(window), ..PrimitiveIndex::default() };
        // Some come late.
        index.insert(&ids[5..], &scene, &GRID, &workers);
        index.insert(&ids[..5], &scene, &GRID, &workers);
        (index, workers)
    });
    for _ in 0..3 {
        let all = indices.each_ref().map(|(index, _)| index.lists());
        assert!(all[0].values().map(Vec::len).sum::<usize>() > 8 * TASK_TRIANGLES);
        assert!(all[0] == all[1] && all[0] == all[2]);
        let bricks =
            indices.each_ref().map(|(index, _)| ids.iter().map(|id| index.touched(*id).to_vec()).collect::<Vec<_>>());
        assert!(bricks[0] == bricks[1] && bricks[0] == bricks[2]);
        window.low += IVec3::new(4, 0, -4);
        indices.iter_mut().for_each(|(index, workers)| index.follow(window, &scene, &GRID, workers));
    }
}
