//! A world that has come about in any way is the world that its scene makes at once.

use super::*;
use crate::bricks::BrickWindow;
use crate::gpu::{Buffer, Location};
use crate::scene::{InstanceDesc, MaterialDesc, MeshDesc, MeshUpdate};
use crate::twin::gpu::Gpu;
use crate::twin::layout::{Brick, decode};
use crate::twin::random::Random;
use crate::twin::world::find_brick;
use ash::vk;
use glam::{DMat3, DQuat};
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
    MaterialDesc { id, base_color, emission, base_color_texture: None }
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
            world.follow((random.point() - 0.5) * random.between(0.0, 300.0), &scene);
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
    gpu: Gpu,
    slots: Vec<Slot>,
    settings: Settings,
    pub world: World,
    pub scene: Scene,
    eye: DVec3,
    frames: u32,
}

impl Live {
    pub fn new(settings: Settings) -> Self {
        let bricks = ["brick_commit", "grid_update", "voxel_mark", "voxelize", "face_resolve"];
        let gpu = Gpu::new(&[bricks.as_slice(), &["face_compact", "light_direct", "light_store"]].concat());
        let slots = (0..FRAMES_IN_FLIGHT).map(|_| Slot::new(&gpu.device).expect("a slot")).collect();
        let world = World::new(&settings, FRAMES_IN_FLIGHT).expect("a world");
        let scene = Scene::new(&settings);
        Self { gpu, slots, settings, world, scene, eye: DVec3::ZERO, frames: 0 }
    }

    /// As `Context::dispatch`, without a view.
    fn frame(&mut self) {
        let index = self.frames as usize % FRAMES_IN_FLIGHT;
        self.slots[index].recycle(&self.gpu.device).expect("recycled");
        let mut scope =
            FrameScope::new(&self.gpu.device, &self.settings, &mut self.slots, index, self.frames, Frame::default());
        self.world.frame(&mut scope, &mut self.scene, self.eye, DMat4::IDENTITY).expect("a frame");
        let frame = scope.frame;
        let (bound, replaced) = (self.world.bindings(index), self.world.take_replaced());
        self.gpu.play(&frame, bound, replaced, &mut self.slots[index]);
        self.frames += 1;
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

    fn read(&mut self, name: &str) -> Vec<u32> {
        let Bound::Buffer(old, _, size) = self.world.bindings(0)[name] else { panic!("{name} is a buffer") };
        let mut new = Buffer::new(&self.gpu.device, size, Location::Readback).expect("a buffer");
        let kept = vec![vk::BufferCopy { src_offset: 0, dst_offset: 0, size }];
        let replaced = FxHashMap::from_iter([("copy", Replaced { old, new: new.raw, kept })]);
        let frame = Frame { commands: vec![Command::Move("copy")], ..Frame::default() };
        self.gpu.play(&frame, FxHashMap::default(), replaced, &mut self.slots[0]);
        let words = new.read((size / 4) as usize);
        new.destroy(&self.gpu.device);
        words
    }

    /// Every brick that the GPU finds.
    pub fn bricks(&mut self) -> BTreeMap<[i32; 3], Brick> {
        let (grid, words) = (self.read("world_grid"), self.read("world_bricks"));
        let BrickWindow { low, size } = self.world.table.window_bricks().expect("a window");
        let extent = (size / 4).as_uvec3();
        let places =
            (0..size.element_product()).map(|i| IVec3::new(i % size.x, i / size.x % size.y, i / (size.x * size.y)));
        let found = |place: IVec3| {
            let at = find_brick(&grid, extent, low, place.as_uvec3())?;
            Some(((low + place).to_array(), decode(&words[at as usize..])))
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
