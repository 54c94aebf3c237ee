//! Voxelisation on the GPU equals its CPU twin.

use super::pack::planes_agree;
use super::solids::{self, Bodies};
use crate::bricks::{self, BrickWindow, Cells, Mask, PrimitiveIndex, WorldGrid};
use crate::frame::{Command, Frame};
use crate::gpu::Location;
use crate::gpu::shared::{BATCH_BRICKS, BrickResult, Material, NO_TEXTURE, NONE, RECORD_WORDS};
use crate::parallel::Workers;
use crate::passes;
use crate::scene::Scene;
use crate::settings::HitModel;
use crate::twin::gpu::Gpu;
use crate::twin::layout::{Brick, Face, Voxel, decode, encode};
use crate::twin::pack::{albedo_levels, fine_albedo_levels, rgb9e5_decode};
use crate::twin::random::{Errors, Random};
use crate::twin::resolve;
use crate::twin::shapes;
use crate::twin::triangle::Triangle;
use crate::twin::voxelize::{self, Source};
use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;
use std::collections::{BTreeSet, HashSet};

const PAYLOAD_WORDS: u32 = 1 << 20;
/// Runs of the twin with errors that decide whether a difference hangs on rounding.
const TRIES: u64 = 12;

/// A scene as the passes read it.
struct Batch {
    positions: Vec<IVec3>,
    masks: Vec<Option<Mask>>,
    queued: bricks::Batch,
    materials: Vec<Material>,
    texels: Vec<u32>,
    emission_max: f32,
}

impl Batch {
    fn new(scene: &Scene) -> Self {
        let grid = WorldGrid { voxel_size: 1.0, offset: DVec3::ZERO };
        let mut index = PrimitiveIndex::default();
        index.follow(
            BrickWindow { low: IVec3::splat(-64), size: IVec3::splat(128) },
            scene,
            &grid,
            &Workers::default(),
        );
        for id in 0..scene.instances.len() as u64 {
            index.insert(&[id], scene, &grid, &Workers::default());
        }
        let mut positions: Vec<IVec3> = index.bricks().collect();
        positions.sort_unstable_by_key(IVec3::to_array);
        let ids: FxHashMap<u64, u32> = scene.materials.keys().map(|id| (*id, *id as u32)).collect();
        let mut queued = bricks::Batch::default();
        let mut random = Random::new(24);
        let mut mask = || random.chance(0.5).then(|| Mask::default().map(|_| random.next() as u32));
        let masks: Vec<Option<Mask>> = positions.iter().map(|_| mask()).collect();
        for (position, mask) in positions.iter().zip(&masks) {
            index.triangles(*position, *mask, scene, &grid, &ids, &mut queued);
        }
        let texture = &scene.textures[&7];
        let materials: Vec<Material> = (0..scene.materials.len() as u64)
            .map(|id| {
                let m = &scene.materials[&id];
                Material {
                    base_color: m.base_color.to_array(),
                    texture: if m.texture.is_some() { 0 } else { NO_TEXTURE },
                    emission: m.emission.to_array(),
                    texture_size: texture.width | texture.height << 16,
                    opacity: m.opacity,
                    texture_alpha: m.texture_alpha.into(),
                    unused: [0; 2],
                }
            })
            .collect();
        let emission_max = materials.iter().flat_map(|m| m.emission).fold(1e-6, f32::max);
        Self { positions, masks, queued, materials, texels: texture.texels.clone(), emission_max }
    }

    fn source(&self, brick: usize) -> Source<'_> {
        let b = &self.queued.bricks[brick];
        let list = &self.queued.lists[b.first_triangle as usize..(b.first_triangle + b.triangle_count) as usize];
        let corner = (self.positions[brick] & 3i32).as_dvec3() * 8.0;
        let triangle = |index: &u32| Triangle::new(&self.queued.triangles[*index as usize]).moved(corner);
        Source {
            triangles: list.iter().map(triangle).collect(),
            materials: &self.materials,
            texels: &self.texels,
            emission_max: f64::from(self.emission_max),
            seed: b.seed,
            reach: self.masks[brick],
        }
    }

    /// Each brick's words; none: empty.
    fn on_gpu(&self, gpu: &mut Gpu, model: HitModel) -> Vec<(BrickResult, Vec<u32>)> {
        let wide = BATCH_BRICKS as usize;
        gpu.buffer("voxel_args", 16, Location::Device);
        gpu.buffer("voxel_items", wide * 4000, Location::Device);
        gpu.buffer("voxel_states", wide * 4000, Location::Device);
        gpu.buffer("voxel_records", wide * 512 * RECORD_WORDS as usize * 4, Location::Device);
        gpu.buffer("payload_used", 16, Location::Device);
        gpu.buffer("payload", PAYLOAD_WORDS as usize * 4, Location::Readback);
        gpu.buffer("brick_results", self.queued.bricks.len() * size_of::<BrickResult>(), Location::Readback);
        let mut frame = Frame::default();
        frame.upload.push("materials", &self.materials);
        frame.upload.push("texels", &self.texels);
        frame.commands.push(Command::Clear("voxel_args"));
        frame.commands.push(Command::Clear("payload_used"));
        let how = passes::bricks::Voxelization {
            batch: BATCH_BRICKS,
            payload_words: PAYLOAD_WORDS,
            emission_max: self.emission_max,
            hit_model: model,
        };
        passes::bricks::voxelize(&mut frame, &self.queued, &how);
        gpu.run(&frame);
        let payload: Vec<u32> = gpu.read("payload", PAYLOAD_WORDS as usize);
        let results: Vec<BrickResult> = gpu.read("brick_results", self.queued.bricks.len());
        let words = |r: &BrickResult| {
            assert_ne!(r.offset, NONE, "the payload is large enough");
            payload[r.offset as usize..(r.offset + r.words) as usize].to_vec()
        };
        results.iter().map(|r| (*r, words(r))).collect()
    }
}

/// Equal sides, coverage and lighting; planes, albedo and emission within a quantisation step.
fn agree(a: Option<&Voxel>, b: Option<&Voxel>) -> bool {
    let (Some(a), Some(b)) = (a, b) else { return a.is_none() && b.is_none() };
    let part = a.is_part_filled();
    part == b.is_part_filled()
        && a.faces.iter().zip(&b.faces).all(|(a, b)| match (a, b) {
            (Some(a), Some(b)) => faces_agree(a, b, part),
            (a, b) => a.is_none() && b.is_none(),
        })
}

fn faces_agree(a: &Face, b: &Face, part: bool) -> bool {
    let levels = |f: &Face| {
        if part { albedo_levels(f.albedo as u16).map(u32::from) } else { fine_albedo_levels(f.albedo) }
    };
    let albedo = levels(a).into_iter().zip(levels(b)).all(|(a, b)| a.abs_diff(b) <= 1);
    let (ea, eb) = (rgb9e5_decode(a.emission), rgb9e5_decode(b.emission));
    let emission = (ea - eb).abs().max_element() <= ea.max(eb).max_element() / 256.0;
    a.mask == b.mask && a.lit == b.lit && planes_agree(a.plane, b.plane) && albedo && emission
}

struct Tally {
    voxels: usize,
    lit: usize,
    part_filled: usize,
    unreached: usize,
    off_by_a_step: usize,
    borderline: usize,
}

fn compare(name: &str, gpu: &mut Gpu, bodies: &Bodies, model: HitModel) -> Tally {
    let batch = Batch::new(&bodies.scene());
    let mut tally = Tally { voxels: 0, lit: 0, part_filled: 0, unreached: 0, off_by_a_step: 0, borderline: 0 };
    for (index, (result, words)) in batch.on_gpu(gpu, model).into_iter().enumerate() {
        let source = batch.source(index);
        let expected = resolve::voxelize(&source, model, &Errors::none());
        let found = if words.is_empty() { Brick::new() } else { decode(&words) };
        if !found.is_empty() {
            assert_packed(&found, &words, &result);
        }
        let cells: BTreeSet<[i32; 3]> = expected.keys().chain(found.keys()).map(IVec3::to_array).collect();
        let different: Vec<IVec3> =
            cells.iter().map(|c| IVec3::from(*c)).filter(|c| !agree(expected.get(c), found.get(c))).collect();
        assert_borderline(
            &format!("{name}, brick {}", batch.positions[index]),
            &source,
            model,
            &expected,
            &found,
            &different,
        );
        let occupied: BTreeSet<[i32; 3]> =
            Cells::from_blocks(&result.occupied).iter().map(|p| p.as_ivec3().to_array()).collect();
        assert_eq!(occupied, found.keys().map(IVec3::to_array).collect());
        if different.is_empty() {
            let all = resolve::voxelize(&Source { reach: None, ..source }, model, &Errors::none());
            let lit = |brick: &Brick| brick.values().flat_map(|v| v.faces).flatten().filter(|f| f.lit).count();
            assert_eq!(result.unreached as usize, lit(&all) - lit(&expected));
            tally.unreached += lit(&all) - lit(&expected);
        }
        tally.voxels += cells.len();
        tally.borderline += different.len();
        let faces = expected.values().flat_map(|v| v.faces).flatten();
        faces.for_each(|f| {
            tally.lit += usize::from(f.lit);
            tally.part_filled += usize::from(f.mask != 0xffff);
        });
        tally.off_by_a_step +=
            cells.iter().map(|c| IVec3::from(*c)).filter(|c| expected.get(c) != found.get(c)).count();
    }
    let Tally { voxels, lit, part_filled, unreached, off_by_a_step, borderline } = tally;
    println!(
        "{name}: {} bricks, {voxels} voxels, {lit} lit faces, {part_filled} part-filled, {unreached} out of reach; not the same bits: \
         {off_by_a_step}, of which borderline: {borderline}",
        batch.positions.len()
    );
    tally
}

/// What the shader packed is what the encoder packs, word for word.
fn assert_packed(brick: &Brick, words: &[u32], result: &BrickResult) {
    let (packed, lights) = encode(brick);
    assert_eq!(packed, words);
    let surfaces: HashSet<_> = brick
        .iter()
        .map(|(cell, v)| ((*cell >> 2i32).to_array(), v.faces.map(|f| f.map(|f| (f.plane, f.mask, f.albedo)))))
        .collect();
    let surfaces: usize = surfaces.iter().map(|(_, faces)| faces.iter().flatten().count()).sum();
    assert_eq!(
        (result.words as usize, result.faces as usize, result.voxels_surfaces as usize),
        (words.len(), lights.len(), brick.len() | surfaces << 16)
    );
}

/// The voxels that differ are those where the twin's own answer hangs on rounding.
fn assert_borderline(
    name: &str,
    source: &Source,
    model: HitModel,
    expected: &Brick,
    found: &Brick,
    different: &[IVec3],
) {
    if different.is_empty() {
        return;
    }
    let tries: Vec<Brick> = (0..TRIES).map(|k| resolve::voxelize(source, model, &Errors::seeded(k))).collect();
    for cell in different {
        let (a, b) = (expected.get(cell), found.get(cell));
        let hangs = tries.iter().any(|t| !agree(t.get(cell), a));
        assert!(hangs, "{name}, voxel {cell}:\ntwin {a:#x?}\nGPU {b:#x?}");
    }
}

const PASSES: [&str; 3] = ["voxel_mark", "voxelize", "face_resolve"];

#[test]
fn solids_on_eighths_become_the_same_bricks() {
    let mut gpu = Gpu::new(&PASSES);
    let mut random = Random::new(21);
    for (name, bodies) in [
        ("boxes", solids::boxes(&mut random)),
        ("ramps", solids::ramps(&mut random)),
        ("sheets", solids::sheets(&mut random)),
        ("crumbs", solids::crumbs(&mut random)),
    ] {
        for model in [HitModel::Plane, HitModel::Cube] {
            let tally = compare(&format!("{name}, {model:?} hits"), &mut gpu, &bodies, model);
            assert_eq!(tally.borderline, 0, "{name}: nothing here hangs on rounding");
            assert!(tally.unreached * 16 > tally.lit, "{name}: {} of {} faces masked", tally.unreached, tally.lit);
        }
    }
}

#[test]
fn a_crowded_voxel_is_cut_in_rounds() {
    let mut gpu = Gpu::new(&PASSES);
    let tally = compare("crowd", &mut gpu, &solids::crowd(&mut Random::new(23)), HitModel::Plane);
    assert_eq!((tally.voxels, tally.borderline), (1, 0));
}

#[test]
fn triangle_soups_become_the_same_bricks() {
    let mut gpu = Gpu::new(&PASSES);
    let mut random = Random::new(22);
    for name in ["soup 1", "soup 2"] {
        let tally = compare(name, &mut gpu, &solids::soup(&mut random), HitModel::Plane);
        assert!(tally.borderline * 200 < tally.voxels, "{name}: more than 0.5 % hang on rounding");
    }
}

/// A board of eight corners, `thin` voxels thick along z from `z` on, through the voxel but for its lower edge.
fn board(z: f32, thin: f32) -> Vec<Triangle> {
    let (positions, indices) = shapes::plate([1; 3], 1.0);
    let place = |p: [f32; 3]| [3.0 * p[0] - 1.0, 0.3 + 2.0 * p[1], z + thin * p[2]];
    let corner = |k: &u32| place(positions[*k as usize]);
    let triangle = |t: &[u32]| {
        let mut words = [0.0; 16];
        t.iter().enumerate().for_each(|(k, i)| words[4 * k..][..3].copy_from_slice(&corner(i)));
        Triangle::new(&words)
    };
    indices.chunks(3).map(triangle).collect()
}

#[test]
fn thin_edges_cover_what_they_cover() {
    let grey = Material { base_color: [0.5; 3], texture: NO_TEXTURE, opacity: 1.0, ..Material::default() };
    for thin in [0.07f32, 0.12, 0.2, 0.33] {
        let places = 200;
        let cells = |k: u32| {
            let z = 0.01 + (0.98 - thin) * k as f32 / places as f32;
            let source = Source {
                triangles: board(z, thin),
                materials: &[grey],
                texels: &[],
                emission_max: 1.0,
                seed: k,
                reach: None,
            };
            let cut = voxelize::cut(&source, IVec3::ZERO, &Errors::none());
            cut.sides[2].as_ref().map_or(0, |side| side.mask.count_ones())
        };
        let covered = f64::from((0..places).map(cells).sum::<u32>()) / f64::from(16 * places);
        assert!((covered / f64::from(thin) - 1.0).abs() < 0.08, "{thin} thick covers {covered}");
    }
}
