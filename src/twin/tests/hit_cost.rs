//! What the compact layout of bricks costs a hit, against one without popcounts.

use super::worlds::{rays, shapes, window};
use crate::frame::Frame;
use crate::gpu::Location;
use crate::gpu::shared::NONE;
use crate::settings::HitModel;
use crate::twin::gpu::Gpu;
use crate::twin::random::Random;
use crate::twin::trace::trace;
use crate::twin::world::{Packed, World};
use glam::IVec4;
use std::collections::HashMap;

const RAYS: usize = 50_000;
/// Hits read in a dispatch.
const READS: usize = 1 << 20;
const ROUNDS: usize = 5;

/// What both layouts must find: plane and light.
fn words_of(world: &World, packed: &Packed, hit: IVec4) -> [u32; 2] {
    let (cell, side) = (hit.truncate(), hit.w as usize);
    let Some(face) = world.voxel(cell).and_then(|v| v.faces[side]) else { return [0; 2] };
    [face.plane, packed.lights.get(&(cell, side)).map_or(0, |word| packed.bricks[*word as usize])]
}

/// Grid of slots, masks and faces, as `hits_flat.wgsl` reads them.
fn flatten(world: &World, packed: &Packed) -> [Vec<u32>; 3] {
    let size = world.size() / 8;
    let mut grid = vec![NONE; (size.x * size.y * size.z) as usize];
    let (mut masks, mut faces) = (Vec::new(), Vec::new());
    for cell in world.occupied() {
        let (brick, own) = (cell >> 3i32, cell & 7i32);
        let slot = &mut grid[(brick.x + size.x * (brick.y + size.y * brick.z)) as usize];
        if *slot == NONE {
            *slot = (masks.len() / 16) as u32;
            masks.resize(masks.len() + 16, 0);
            faces.resize(faces.len() + 512 * 12, 0);
        }
        let (slot, voxel) = (*slot as usize, (own.x | own.y << 3 | own.z << 6) as usize);
        masks[slot * 16 + voxel / 32] |= 1 << (voxel % 32);
        for side in 0..6 {
            let words = words_of(world, packed, cell.extend(side));
            faces[(slot * 512 + voxel) * 12 + 2 * side as usize..][..2].copy_from_slice(&words);
        }
    }
    [grid, masks, faces]
}

/// Milliseconds of each pass, the least of some runs; what it found is what both must find.
fn cost(
    gpu: &mut Gpu,
    world: &World,
    packed: &Packed,
    flat: &[Vec<u32>; 3],
    hits: &[IVec4],
) -> HashMap<&'static str, f64> {
    let expected: Vec<[u32; 2]> = hits.iter().map(|hit| words_of(world, packed, *hit)).collect();
    let mut least = HashMap::new();
    for _ in 0..ROUNDS {
        for pass in ["hits_compact", "hits_flat"] {
            let mut frame = Frame::default();
            frame.upload.push("frame", &[packed.frame]);
            frame.upload.push("hits", &hits.iter().map(IVec4::to_array).collect::<Vec<_>>());
            if pass == "hits_compact" {
                frame.upload.push("world_grid", &packed.grid);
                frame.upload.push("world_bricks", &packed.bricks);
            } else {
                ["flat_grid", "flat_masks", "flat_faces"]
                    .iter()
                    .zip(flat)
                    .for_each(|(name, data)| frame.upload.push(name, data));
            }
            frame.dispatch(pass, [(hits.len() as u32).div_ceil(64), 1, 1], [0u32; 0]);
            gpu.buffer("hit_words", hits.len() * 8, Location::Readback);
            gpu.run(&frame);
            assert!(gpu.read::<[u32; 2]>("hit_words", hits.len()) == expected, "{pass} reads something else");
            let ms = gpu.times().into_iter().find(|time| time.0 == pass).map_or(0.0, |time| time.1);
            least.entry(pass).and_modify(|before: &mut f64| *before = before.min(ms)).or_insert(ms);
        }
    }
    least
}

#[test]
fn both_layouts_tell_the_same_of_a_hit() {
    let mut gpu = Gpu::new(&["hits_compact", "hits_flat"]);
    let mut random = Random::new(1);
    let mut world = window([4, 2, 4], [0, 0, 0]);
    shapes(&mut random, &mut world);
    let packed = world.pack();
    let flat = flatten(&world, &packed);
    let found = rays(&mut random, &world, RAYS).into_iter().filter_map(|ray| trace(&world, HitModel::Plane, &ray));
    let mut hits: Vec<IVec4> = found.map(|hit| hit.cell.extend(hit.side as i32)).collect();
    // Some places without a voxel.
    hits.extend((0..hits.len() / 8).map(|_| (random.point() * world.size().as_dvec3()).as_ivec3().extend(0)));
    let mut hits: Vec<IVec4> = hits.into_iter().cycle().take(READS).collect();
    let place = |hit: &IVec4| (*hit >> 3i32).truncate().to_array();
    for order in ["in the order of their places", "in random order"] {
        match order {
            "in random order" => hits.sort_by_cached_key(|_| random.next()),
            _ => hits.sort_by_key(|hit| (place(hit), hit.to_array())),
        }
        let cost = cost(&mut gpu, &world, &packed, &flat, &hits);
        let ns = |pass: &str| cost[pass] * 1e6 / READS as f64;
        println!(
            "hits {order}: compact {:.2} ns, flat {:.2} ns, ratio {:.2}; {} KiB and {} KiB",
            ns("hits_compact"),
            ns("hits_flat"),
            cost["hits_compact"] / cost["hits_flat"],
            (packed.grid.len() + packed.bricks.len()) * 4 / 1024,
            flat.iter().map(Vec::len).sum::<usize>() * 4 / 1024
        );
    }
}
