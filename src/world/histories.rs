//! A world that has come about in any way is the world that its scene makes at once.

use super::*;
use crate::bricks::BrickWindow;
use crate::gpu::{Bound, Buffer, Copies, Location, Player};
use crate::scene::{
    BufferAddress, BufferMeshDesc, IndexBuffer, IndexType, InstanceDesc, MaterialDesc, MeshDesc, MeshUpdate,
    VertexBuffer, VertexFormat,
};
use crate::twin::gpu::Gpu;
use crate::twin::layout::{Brick, decode, encode};
use crate::twin::pack::rgb9e5_decode;
use crate::twin::random::Random;
use crate::twin::world::find_brick;
use ash::vk;
use glam::{DMat3, DQuat, Vec3};
use std::collections::{BTreeMap, HashSet};

const FRAMES_IN_FLIGHT: usize = 3;
const MESHES: u32 = 3;
const MATERIALS: u32 = 3;
const INSTANCES: u32 = 12;

fn settings() -> Settings {
    Settings {
        voxel_size: 1.0,
        coverage_groups: [4, 2, 4],
        memory_budget: 16 << 20,
        light_faces_per_frame: 64,
        bounce_rays: 0,
        ..Settings::default()
    }
}

/// A box, a tetrahedron, an open sheet: about two units large.
fn meshes() -> [(Vec<[f32; 3]>, Vec<u32>); MESHES as usize] {
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32 * 2.0 - 1.0);
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = |quad: &[u32; 4]| [quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]];
    let tetrahedron = [0, 3, 5, 6].map(corner).to_vec();
    [
        ((0..8).map(corner).collect(), quads.iter().flat_map(triangles).collect()),
        (tetrahedron, vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]),
        ((0..4).map(corner).collect(), vec![0, 1, 3, 0, 3, 2]),
    ]
}

fn material(id: u64, random: &mut Random) -> MaterialDesc {
    let base_color = std::array::from_fn(|_| random.unit() as f32);
    let emission = if id == 2 { [3.0, 2.0, 1.0] } else { [0.0; 3] };
    MaterialDesc { id, base_color, emission, ..MaterialDesc::default() }
}

/// Anywhere about the middle of the world, turned, stretched and perhaps mirrored.
fn instance(id: u64, random: &mut Random) -> InstanceDesc {
    let scale = DVec3::from_array(std::array::from_fn(|_| {
        random.between(0.3, 8.0) * if random.chance(0.2) { -1.0 } else { 1.0 }
    }));
    let rotation = DMat3::from_quat(DQuat::from_axis_angle(random.direction(), random.between(0.0, 3.0)));
    let linear = rotation * DMat3::from_diagonal(scale);
    InstanceDesc {
        id,
        mesh: u64::from(random.below(MESHES)),
        material: u64::from(random.below(MATERIALS)),
        linear: [linear.x_axis, linear.y_axis, linear.z_axis].map(|c| c.as_vec3().to_array()),
        translation: ((random.point() - 0.5) * 30.0).to_array(),
    }
}

/// Applies a batch, as `Context::update_meshes` does.
pub(super) fn update(world: &mut World, scene: &mut Scene, update: &MeshUpdate) {
    scene.check(update).expect("a valid update");
    world.readback.update(update).expect("a valid update");
    let changed = scene.apply(update);
    world.instances_changed(&changed, scene);
}

/// Meshes and materials.
fn furnish(world: &mut World, scene: &mut Scene, random: &mut Random) {
    let shapes = meshes();
    let mesh = |id: usize| MeshDesc { id: id as u64, positions: &shapes[id].0, uvs: &[], indices: &shapes[id].1 };
    let meshes: Vec<MeshDesc> = (0..shapes.len()).map(mesh).collect();
    let materials: Vec<MaterialDesc> = (0..u64::from(MATERIALS)).map(|id| material(id, random)).collect();
    update(world, scene, &MeshUpdate { meshes: &meshes, materials: &materials, ..MeshUpdate::default() });
    // As if something had once been far away on every side: the window follows the camera.
    world.primitives.bounds = Some((DVec3::splat(-1e4), DVec3::splat(1e4)));
}

/// An instance comes, moves or goes, or a material is repainted.
fn edit(world: &mut World, scene: &mut Scene, random: &mut Random) {
    let id = u64::from(random.below(INSTANCES));
    let none = MeshUpdate::default();
    match random.below(8) {
        0 => update(world, scene, &MeshUpdate { materials: &[material(id % u64::from(MATERIALS), random)], ..none }),
        1..4 if scene.instances.contains_key(&id) => {
            update(world, scene, &MeshUpdate { removed_instances: &[id], ..none });
        }
        _ => update(world, scene, &MeshUpdate { instances: &[instance(id, random)], ..none }),
    }
}

/// Nothing is ever voxelised here: what the window holds waits, neither more nor less.
#[test]
fn after_any_history_bricks_list_what_the_scene_holds() {
    let (mut random, mut scene) = (Random::new(1), Scene::default());
    let mut world = World::new(&settings(), FRAMES_IN_FLIGHT).expect("a world");
    furnish(&mut world, &mut scene, &mut random);
    let (mut moves, mut most) = (0, 0);
    for operation in 0..10_000 {
        if random.chance(0.1) {
            let window = world.table.window_bricks();
            world.follow([(random.point() - 0.5) * random.between(0.0, 300.0)].into_iter(), &scene);
            moves += u32::from(world.table.window_bricks() != window);
        } else {
            edit(&mut world, &mut scene, &mut random);
        }
        if operation % 4 > 0 {
            continue;
        }
        let Some(window) = world.table.window_bricks() else { continue };
        let mut fresh = PrimitiveIndex::default();
        fresh.follow(window, &scene, &world.grid, &Workers::default());
        let mut ids: Vec<u64> = scene.instances.keys().copied().collect();
        ids.sort_unstable();
        fresh.insert(&ids, &scene, &world.grid, &Workers::default());
        let lists = world.primitives.lists();
        assert!(lists == fresh.lists(), "operation {operation}");
        let waiting = world.table.next(usize::MAX, &Viewpoint::all_round(DVec3::ZERO));
        let waiting: HashSet<IVec3> = waiting.into_iter().map(|w| w.0).collect();
        assert!(waiting == lists.keys().copied().collect(), "operation {operation}");
        most = most.max(lists.len());
    }
    println!("the window moved {moves} times; {most} bricks at most");
    assert!(moves > 100 && most > 100);
}

/// A world on the GPU.
pub(super) struct Live {
    pub gpu: Gpu,
    slots: Vec<Slot>,
    settings: Settings,
    pub world: World,
    pub scene: Scene,
    eye: DVec3,
    frames: u32,
}

impl Live {
    pub fn new(settings: Settings) -> Self {
        let bricks =
            ["brick_compact", "light_carry", "brick_commit", "grid_update", "voxel_mark", "voxelize", "face_resolve"];
        let direct = ["light_direct", "light_direct_areas", "light_direct_maps"];
        let many = ["light_direct_many", "light_direct_many_areas", "light_direct_many_maps"];
        let bounce: &[&str] = if settings.bounce_rays > 0 { &[passes::light::bounce_pass(&settings)] } else { &[] };
        let lighting = [direct.as_slice(), &many, bounce, &["face_compact", "light_store"]].concat();
        let gpu = Gpu::new(&[bricks.as_slice(), &lighting].concat());
        let slots = (0..FRAMES_IN_FLIGHT).map(|_| Slot::new(&gpu.device).expect("a slot")).collect();
        let world = World::new(&settings, FRAMES_IN_FLIGHT).expect("a world");
        let scene = Scene::new(&settings);
        Self { gpu, slots, settings, world, scene, eye: DVec3::ZERO, frames: 0 }
    }

    /// As `Context::dispatch`, without a view.
    pub fn frame(&mut self) {
        let index = self.frames as usize % FRAMES_IN_FLIGHT;
        self.slots[index].recycle(&self.gpu.device);
        let mut scope =
            FrameScope::new(&self.gpu.device, &self.settings, &mut self.slots, index, self.frames, Frame::default());
        self.world.follow([self.eye].into_iter(), &self.scene);
        self.world.frame(&mut scope, &mut self.scene, self.eye, DMat4::IDENTITY).expect("a frame");
        let frame = scope.frame;
        let player = self.bind(index);
        self.gpu.play(&frame, player, &mut self.slots[index]);
        self.frames += 1;
    }

    fn bind(&mut self, index: usize) -> Player {
        let mut player = Player::default();
        self.world.bind(index, &self.scene, &mut player);
        player
    }

    /// Frames until nothing has been voxelised for a while.
    pub fn settle(&mut self) {
        let mut quiet = 0;
        while quiet < 2 * FRAMES_IN_FLIGHT {
            self.frame();
            quiet = if self.world.table.busy() { 0 } else { quiet + 1 };
        }
        assert_eq!(self.world.table.missing(), 0);
    }

    /// A buffer of the GPU's own memory that holds these bytes.
    fn buffer(&mut self, bytes: &[u8]) -> Buffer {
        let [mut staging, buffer] = [Location::Upload, Location::Device]
            .map(|location| Buffer::new(&self.gpu.device, bytes.len() as u64, location).expect("a buffer"));
        staging.write(bytes);
        self.copy(staging.raw, buffer.raw, staging.size);
        staging.destroy(&self.gpu.device);
        buffer
    }

    fn copy(&mut self, from: vk::Buffer, to: vk::Buffer, size: u64) {
        let regions = vec![vk::BufferCopy { src_offset: 0, dst_offset: 0, size }];
        let mut player = Player::default();
        player.copies.insert("copy", vec![Copies { from, to, regions }]);
        let frame = Frame { commands: vec![Command::Copy("copy")], ..Frame::default() };
        self.gpu.play(&frame, player, &mut self.slots[0]);
    }

    fn read(&mut self, name: &str) -> Vec<u32> {
        let Bound::Buffer(from, _, size) = self.bind(0).bound[name] else { panic!("{name} is a buffer") };
        let mut new = Buffer::new(&self.gpu.device, size, Location::Readback).expect("a buffer");
        self.copy(from, new.raw, size);
        let words = new.read((size / 4) as usize);
        new.destroy(&self.gpu.device);
        words
    }

    /// Every brick that the GPU finds.
    pub fn bricks(&mut self) -> BTreeMap<[i32; 3], Brick> {
        self.packed_bricks().into_iter().map(|(place, words)| (place, decode(&words))).collect()
    }

    /// Every lit face: its voxel, its side, and the radiance that it sends out.
    pub fn radiance(&mut self) -> Vec<(IVec3, usize, Vec3)> {
        let lit = |(place, words): ([i32; 3], Vec<u32>)| {
            let (_, lights) = encode(&decode(&words));
            let face = |((cell, side), word): ((IVec3, usize), u32)| {
                (IVec3::from(place) * 8 + cell, side, rgb9e5_decode(words[word as usize]))
            };
            lights.into_iter().map(face).collect::<Vec<_>>()
        };
        self.packed_bricks().into_iter().flat_map(lit).collect()
    }

    /// Every brick that the GPU finds, and whatever lies behind it.
    fn packed_bricks(&mut self) -> BTreeMap<[i32; 3], Vec<u32>> {
        let (grid, words) = (self.read("world_grid"), self.read("world_bricks"));
        let BrickWindow { low, size } = self.world.table.window_bricks().expect("a window");
        let extent = (size / 4).as_uvec3();
        let places =
            (0..size.element_product()).map(|i| IVec3::new(i % size.x, i / size.x % size.y, i / (size.x * size.y)));
        let found = |place: IVec3| {
            let at = find_brick(&grid, extent, low, place.as_uvec3())?;
            Some(((low + place).to_array(), words[at as usize..].to_vec()))
        };
        places.filter_map(found).collect()
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.world.destroy(&self.gpu.device);
        self.slots.iter_mut().for_each(|s| s.destroy(&self.gpu.device));
    }
}

/// 60 operations, each of which has the GPU voxelise some dozen bricks; the camera leaves a part of them, or all, and
/// comes back.
#[test]
fn after_any_history_the_gpu_holds_what_the_scene_makes_at_once() {
    let (mut random, mut old) = (Random::new(2), Live::new(settings()));
    furnish(&mut old.world, &mut old.scene, &mut random);
    for _ in 0..60 {
        edit(&mut old.world, &mut old.scene, &mut random);
        let away = old.eye == DVec3::ZERO && random.chance(0.2);
        old.eye = if away { DVec3::X * if random.chance(0.5) { 64.0 } else { 2000.0 } } else { DVec3::ZERO };
        (0..random.below(3)).for_each(|_| old.frame());
    }
    old.eye = DVec3::ZERO;
    old.settle();
    let mut new = Live::new(settings());
    std::mem::swap(&mut new.scene, &mut old.scene);
    let mut all: Vec<u64> = new.scene.instances.keys().copied().collect();
    all.sort_unstable();
    new.world.instances_changed(&all, &new.scene);
    new.settle();
    assert_eq!(old.world.table.window_bricks(), new.world.table.window_bricks());
    let figures = |world: &World| (world.table.resident(), world.table.faces(), world.table.pages.used());
    println!("bricks, faces, pages: {:?} after {} frames", figures(&old.world), old.frames);
    assert_eq!(figures(&old.world), figures(&new.world));
    let (old, new) = (old.bricks(), new.bricks());
    assert!(old.keys().eq(new.keys()), "the same bricks");
    let differ = old.iter().filter(|(position, brick)| new[*position] != **brick).count();
    assert_eq!(differ, 0, "of {} bricks", old.len());
}

/// Halves with something between them and 16-bit indices, in the GPU's own memory; each mesh takes another's place.
#[test]
fn meshes_of_buffers_make_the_lists_and_bricks_of_those_in_memory() {
    let shapes = meshes();
    let replacing = |id: usize| &shapes[(id + 1) % shapes.len()];
    let mut found = Vec::new();
    for in_buffers in [false, true] {
        let (mut random, mut live) = (Random::new(3), Live::new(settings()));
        furnish(&mut live.world, &mut live.scene, &mut random);
        (0..20).for_each(|_| edit(&mut live.world, &mut live.scene, &mut random));
        live.frame();
        let (mut memory, mut descs, mut buffers) = (Vec::new(), Vec::new(), Vec::new());
        for (id, (positions, indices)) in (0..shapes.len()).map(|id| (id as u64, replacing(id))) {
            memory.push(MeshDesc { id, positions, uvs: &[], indices });
            let halves = |p: &[f32; 3]| [p[0], p[1], p[2], f32::NAN].map(half::f16::from_f32);
            let vertices: Vec<u8> = positions.iter().flat_map(halves).flat_map(half::f16::to_ne_bytes).collect();
            let indices16: Vec<u8> = indices.iter().flat_map(|i| (*i as u16).to_ne_bytes()).collect();
            let buffer = live.buffer(&[&[0xff; 6], &vertices[..], &indices16].concat());
            // SAFETY: destroyed once it has been read.
            let address = |offset: usize| unsafe { BufferAddress::new(buffer.raw, offset as u64) };
            descs.push(BufferMeshDesc {
                id,
                vertex_count: positions.len() as u32,
                index_count: indices.len() as u32,
                positions: VertexBuffer { address: address(6), stride: 8, format: VertexFormat::Float16 },
                uvs: None,
                indices: IndexBuffer { address: address(6 + vertices.len()), index_type: IndexType::Uint16 },
            });
            buffers.push(buffer);
        }
        let (memory, descs) = if in_buffers { (&[][..], &descs[..]) } else { (&memory[..], &[][..]) };
        let given = MeshUpdate { meshes: memory, buffer_meshes: descs, ..MeshUpdate::default() };
        update(&mut live.world, &mut live.scene, &given);
        assert_eq!(live.world.readback.pending() as usize, descs.len());
        live.settle();
        assert_eq!(live.world.readback.pending(), 0);
        buffers.iter_mut().for_each(|b| b.destroy(&live.gpu.device));
        let lists = live.world.primitives.lists();
        println!("{} bricks hold {} triangles", lists.len(), lists.values().map(Vec::len).sum::<usize>());
        found.push((lists, live.bricks()));
    }
    assert!(found[0].0 == found[1].0, "the lists");
    assert!(found[0].1 == found[1].1, "the bricks");
}
