//! What voxelisation tests, for each face that it makes.
//!
//! `BRICKGI_SCENE=city.glb BRICKGI_VOXEL=0.5 BRICKGI_SIMPLIFY=0 cargo test --release --lib tests_for_each_face --
//! --nocapture` counts another scene; nodes must not be transformed.

use super::histories::{Live, update};
use super::*;
use crate::bricks::CubeTest;
use crate::scene::{InstanceDesc, MaterialDesc, MeshDesc, MeshUpdate};

/// Triangle-voxel tests and what led to them.
#[derive(Default)]
struct Counts {
    bricks: u64,
    /// Triangles in the bricks' lists.
    listed: u64,
    most_listed: u64,
    /// Of `voxel_mark`: each triangle with the cells of its bounds.
    marked: u64,
    /// Of `voxelize`: each touched cell with all of the brick's triangles.
    gathered: u64,
    /// Of those, the ones that are cut against the cell's columns.
    cut: u64,
}

impl Counts {
    /// Counts a batch's last brick.
    fn add(&mut self, batch: &Batch) {
        let brick = batch.bricks.last().expect("a brick");
        let place = UVec3::new(brick.place & 3, brick.place >> 2 & 3, brick.place >> 4).as_dvec3() * 8.0;
        let mut touched = [0u64; 1000];
        let list = &batch.lists[brick.first_triangle as usize..][..brick.triangle_count as usize];
        for index in list {
            let t = batch.triangles[*index as usize].map(f64::from);
            let corners = [0, 4, 8].map(|k| DVec3::new(t[k], t[k + 1], t[k + 2]) - place);
            let (low, high) = corners.iter().fold((corners[0], corners[0]), |b, c| (b.0.min(*c), b.1.max(*c)));
            let first = low.floor().clamp(DVec3::splat(-1.0), DVec3::splat(9.0)).as_ivec3();
            let last = high.floor().clamp(DVec3::splat(-2.0), DVec3::splat(8.0)).as_ivec3();
            let test = CubeTest::new(corners, 0.5);
            for z in first.z..=last.z {
                for y in first.y..=last.y {
                    for x in first.x..=last.x {
                        self.marked += 1;
                        if test.meets(DVec3::new(x.into(), y.into(), z.into()) + 0.5) {
                            touched[(x + 1 + 10 * (y + 1 + 10 * (z + 1))) as usize] += 1;
                        }
                    }
                }
            }
        }
        self.bricks += 1;
        self.listed += list.len() as u64;
        self.most_listed = self.most_listed.max(list.len() as u64);
        self.gathered += touched.iter().filter(|n| **n > 0).count() as u64 * list.len() as u64;
        self.cut += touched.iter().sum::<u64>();
    }
}

/// Registers a glTF file, a material for all of it.
fn load(path: &str, world: &mut World, scene: &mut Scene) {
    let gltf::Gltf { document, blob } = gltf::Gltf::open(path).expect("a readable scene");
    let blob = blob.expect("a .glb with its one buffer inside");
    let material = MaterialDesc { id: 0, base_color: [0.5; 3], ..MaterialDesc::default() };
    update(world, scene, &MeshUpdate { materials: &[material], ..MeshUpdate::default() });
    for (id, primitive) in (0u64..).zip(document.meshes().flat_map(|m| m.primitives().collect::<Vec<_>>())) {
        let reader = primitive.reader(|_| Some(&blob[..]));
        let positions: Vec<[f32; 3]> = reader.read_positions().expect("positions").collect();
        let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
        let mesh = MeshDesc { id, positions: &positions, uvs: &[], indices: &indices };
        let linear = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let instance = InstanceDesc { id, mesh: id, material: 0, linear, translation: [0.0; 3] };
        update(world, scene, &MeshUpdate { meshes: &[mesh], instances: &[instance], ..MeshUpdate::default() });
    }
}

#[test]
fn tests_for_each_face() {
    let cornell = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/scenes/cornell/cornell.glb");
    let given = std::env::var("BRICKGI_SCENE").ok();
    let number = |name: &str, usual: f32| std::env::var(name).map_or(usual, |v| v.parse().expect("a number"));
    let settings = Settings {
        voxel_size: number("BRICKGI_VOXEL", 0.25),
        simplify_voxels: number("BRICKGI_SIMPLIFY", 0.0),
        memory_budget: 128 << 20,
        light_faces_per_frame: 64,
        bounce_rays: 0,
        ..Settings::default()
    };
    let mut live = Live::new(settings);
    load(given.as_deref().unwrap_or(cornell), &mut live.world, &mut live.scene);
    live.settle();
    let (world, mut counts, mut batch) = (&live.world, Counts::default(), Batch::default());
    for brick in world.primitives.bricks() {
        batch.clear();
        world.primitives.triangles(brick, None, &live.scene, &world.grid, &world.material_index, &mut batch);
        counts.add(&batch);
    }
    let (faces, Counts { bricks, listed, most_listed, marked, gathered, cut }) =
        (u64::from(world.table.faces()), counts);
    let each = |count: u64, of: u64| count as f64 / of as f64;
    println!(
        "{} of {} triangles; {faces} faces in {bricks} bricks of {:.0} triangles ({most_listed} at most); tests for each face: \
         {:.1} to mark, {:.1} to gather, {:.1} cut",
        live.scene.triangles.kept,
        live.scene.triangles.given,
        each(listed, bricks),
        each(marked, faces),
        each(gathered, faces),
        each(cut, faces)
    );
    assert!(given.is_some() || marked + gathered < 26 * faces, "few triangles: few tests");
}
