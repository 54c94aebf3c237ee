//! A brick in plain words, and packed as lib/world.wgsl lays it out.

use crate::gpu::shared::{BLOCK_WORDS, BRICK_VOXELS};
use glam::IVec3;
use std::collections::HashMap;

/// One side of a voxel that holds surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Face {
    /// As `plane_encode` makes it.
    pub plane: u32,
    /// 4 x 4 coverage.
    pub mask: u16,
    /// Whether it has lighting of its own; albedo and emission are kept for these only.
    pub lit: bool,
    /// As `albedo_encode` makes it.
    pub albedo: u16,
    /// RGB9E5.
    pub emission: u32,
}

/// Sides of an occupied voxel: -x, +x, -y, +y, -z, +z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Voxel {
    pub faces: [Option<Face>; 6],
}

impl Voxel {
    pub fn is_lit(&self, side: usize) -> bool {
        self.faces[side].is_some_and(|f| f.lit)
    }
}

/// Voxels by position, 0 to 7 per axis.
pub type Brick = HashMap<IVec3, Voxel>;

/// Where a lit side's radiance stands: voxel and side to word of the brick.
pub type LightWords = HashMap<(IVec3, usize), u32>;

const SIDES: usize = 6;
const BLOCK: i32 = (BRICK_VOXELS / 2) as i32;

fn block_corner(block: u32) -> IVec3 {
    IVec3::new((block & 1) as i32, (block >> 1 & 1) as i32, (block >> 2) as i32) * BLOCK
}

fn child(bit: u32) -> IVec3 {
    IVec3::new((bit & 3) as i32, (bit >> 2 & 3) as i32, (bit >> 4) as i32)
}

/// Packs a brick. Light starts at the emission.
pub fn encode(brick: &Brick) -> (Vec<u32>, LightWords) {
    let blocks: Vec<Vec<(u32, IVec3, &Voxel)>> = (0..8)
        .map(|block| {
            let cells = (0..64).map(|bit| (bit, block_corner(block) + child(bit)));
            cells.filter_map(|(bit, cell)| Some((bit, cell, brick.get(&cell)?))).collect()
        })
        .collect();
    let filled: Vec<_> = (0..8usize).filter(|b| !blocks[*b].is_empty()).collect();
    let mut words = vec![0u32; 1 + BLOCK_WORDS as usize * filled.len()];
    let mut lights = LightWords::new();
    for (place, block) in filled.iter().enumerate() {
        words[0] |= 1 << block;
        let record = encode_block(&blocks[*block], &mut words, &mut lights);
        words[1 + place * BLOCK_WORDS as usize..][..BLOCK_WORDS as usize].copy_from_slice(&record);
    }
    (words, lights)
}

fn encode_block(voxels: &[(u32, IVec3, &Voxel)], words: &mut Vec<u32>, lights: &mut LightWords) -> [u32; 4] {
    let mask = voxels.iter().fold(0u64, |m, (bit, ..)| m | 1 << bit);
    let (mut planes, mut lit) = (Vec::new(), Vec::new());
    let voxel_run = words.len() as u32;
    for (_, cell, voxel) in voxels {
        let stored: Vec<(usize, Face)> = (0..SIDES).filter_map(|s| Some((s, voxel.faces[s]?))).collect();
        let part = stored.iter().any(|(_, f)| f.mask != 0xffff);
        let mut word = (planes.len() as u32) << 12 | (lit.len() as u32) << 22 | u32::from(part) << 31;
        for (side, face) in &stored {
            word |= 1 << side | u32::from(face.lit) << (side + 6);
        }
        words.push(word);
        planes.extend(stored.iter().map(|(_, f)| f.plane));
        if part {
            let pair = |pair: &[(usize, Face)]| {
                u32::from(pair[0].1.mask) | pair.get(1).map_or(0, |f| u32::from(f.1.mask) << 16)
            };
            planes.extend(stored.chunks(2).map(pair));
        }
        lit.extend(stored.iter().filter(|(_, f)| f.lit).map(|(s, f)| (*cell, *s, *f)));
    }
    let plane_run = words.len() as u32;
    words.extend(planes);
    let light_run = words.len() as u32;
    let emissive = lit.iter().any(|(_, _, f)| f.emission != 0);
    for (cell, side, face) in &lit {
        lights.insert((*cell, *side), words.len() as u32);
        words.push(face.emission);
    }
    if emissive {
        words.extend(lit.iter().map(|(_, _, f)| f.emission));
    }
    let albedo = |pair: &[(IVec3, usize, Face)]| {
        u32::from(pair[0].2.albedo) | pair.get(1).map_or(0, |f| u32::from(f.2.albedo) << 16)
    };
    words.extend(lit.chunks(2).map(albedo));
    let count = lit.len() as u32;
    [mask as u32, (mask >> 32) as u32, voxel_run | plane_run << 16, light_run | count << 16 | u32::from(emissive) << 31]
}

/// Reads a packed brick.
pub fn decode(words: &[u32]) -> Brick {
    let mut brick = Brick::new();
    let mut record = 1;
    for block in (0..8).filter(|b| words[0] >> b & 1 == 1) {
        decode_block(words, block, &words[record..record + BLOCK_WORDS as usize], &mut brick);
        record += BLOCK_WORDS as usize;
    }
    brick
}

fn decode_block(words: &[u32], block: u32, record: &[u32], brick: &mut Brick) {
    let mask = u64::from(record[0]) | u64::from(record[1]) << 32;
    let (voxel_run, plane_run) = (record[2] & 0xffff, record[2] >> 16);
    let (light_run, lit_count, emissive) = (record[3] & 0xffff, record[3] >> 16 & 511, record[3] >> 31);
    let half = |run: u32, index: u32| (words[(run + index / 2) as usize] >> (16 * (index & 1))) as u16;
    for (place, bit) in (0..64).filter(|bit| mask >> bit & 1 == 1).enumerate() {
        let word = words[voxel_run as usize + place];
        let planes = plane_run + (word >> 12 & 1023);
        let masks = planes + (word & 63).count_ones();
        let mut light = word >> 22 & 511;
        let mut voxel = Voxel::default();
        for (rank, side) in (0..SIDES).filter(|s| word >> s & 1 == 1).enumerate() {
            let rank = rank as u32;
            let mut face = Face { plane: words[(planes + rank) as usize], mask: 0xffff, ..Face::default() };
            if word >> 31 == 1 {
                face.mask = half(masks, rank);
            }
            if word >> (side + 6) & 1 == 1 {
                face.lit = true;
                face.albedo = half(light_run + lit_count * (1 + emissive), light);
                if emissive == 1 {
                    face.emission = words[(light_run + lit_count + light) as usize];
                }
                light += 1;
            }
            voxel.faces[side] = Some(face);
        }
        brick.insert(block_corner(block) + child(bit), voxel);
    }
}
