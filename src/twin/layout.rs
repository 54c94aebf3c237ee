//! A brick in plain words, and packed as lib/brick.wgsl lays it out.

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
    /// Whether it has lighting of its own; emission is kept for these only.
    pub lit: bool,
    /// As `fine_albedo_encode` makes it, in part-filled voxels as `albedo_encode`.
    pub albedo: u32,
    /// RGB9E5.
    pub emission: u32,
}

/// Sides of an occupied voxel: -x, +x, -y, +y, -z, +z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Voxel {
    pub faces: [Option<Face>; 6],
    /// Whether light comes through.
    pub translucent: bool,
}

impl Voxel {
    pub fn is_lit(&self, side: usize) -> bool {
        self.faces[side].is_some_and(|f| f.lit)
    }

    /// Whether a side is not covered wholly.
    pub fn is_part_filled(&self) -> bool {
        self.faces.iter().flatten().any(|f| f.mask != 0xffff)
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

fn encode_block(voxels: &[(u32, IVec3, &Voxel)], words: &mut Vec<u32>, lights: &mut LightWords) -> [u32; 3] {
    let mask = voxels.iter().fold(0u64, |m, (bit, ..)| m | 1 << bit);
    let run = words.len() as u32;
    let (mut packed, mut lit, mut surfaces) = (Vec::new(), Vec::new(), Vec::new());
    let mut known: HashMap<Vec<(usize, [u32; 2])>, usize> = HashMap::new();
    for (_, cell, voxel) in voxels {
        let stored: Vec<(usize, Face)> = (0..SIDES).filter_map(|s| Some((s, voxel.faces[s]?))).collect();
        let part = voxel.is_part_filled();
        let albedo = |f: &Face| if part { u32::from(f.mask) << 16 | f.albedo & 0xffff } else { f.albedo };
        let own: Vec<(usize, [u32; 2])> = stored.iter().map(|(side, f)| (*side, [f.plane, albedo(f)])).collect();
        let first = *known.entry(own.clone()).or_insert(surfaces.len());
        if first == surfaces.len() {
            surfaces.extend(own.iter().map(|(_, surface)| *surface));
        }
        let sides = stored.iter().fold(0, |sides, (side, f)| sides | 1 << side | u32::from(f.lit) << (side + 6));
        let flags = u32::from(voxel.translucent) << 30 | u32::from(part) << 31;
        packed.push(sides | (first as u32) << 12 | (lit.len() as u32) << 21 | flags);
        lit.extend(stored.iter().filter(|(_, f)| f.lit).map(|(side, f)| (*cell, *side, f.emission)));
    }
    lights.extend((run..).zip(&lit).map(|(word, (cell, side, _))| ((*cell, *side), word)));
    let emissive = lit.iter().any(|(.., emission)| *emission != 0);
    for _ in 0..1 + u32::from(emissive) {
        words.extend(lit.iter().map(|(.., emission)| emission));
    }
    words.extend(packed);
    words.extend(surfaces.iter().flatten());
    [mask as u32, (mask >> 32) as u32, run | (lit.len() as u32) << 16 | u32::from(emissive) << 31]
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
    let (light, lit, emissive) = (record[2] & 0xffff, record[2] >> 16 & 511, record[2] >> 31);
    let voxels = light + lit * (1 + emissive);
    for (place, bit) in (0..64).filter(|bit| mask >> bit & 1 == 1).enumerate() {
        let word = words[voxels as usize + place];
        let part = word >> 31 == 1;
        let mut surfaces = words[(voxels + mask.count_ones() + 2 * (word >> 12 & 511)) as usize..].chunks(2);
        let mut emissions = words[(light + emissive * lit + (word >> 21 & 511)) as usize..].iter();
        let mut voxel = Voxel { translucent: word >> 30 & 1 == 1, ..Voxel::default() };
        for side in (0..SIDES).filter(|s| word >> s & 1 == 1) {
            let surface = surfaces.next().expect("a surface for each stored side");
            let lit = word >> (side + 6) & 1 == 1;
            let emission = if lit { emissions.next() } else { None };
            voxel.faces[side] = Some(Face {
                plane: surface[0],
                mask: if part { (surface[1] >> 16) as u16 } else { 0xffff },
                lit,
                albedo: if part { surface[1] & 0xffff } else { surface[1] },
                emission: emission.copied().filter(|_| emissive == 1).unwrap_or(0),
            });
        }
        brick.insert(block_corner(block) + child(bit), voxel);
    }
}
