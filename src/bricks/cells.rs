//! Sets of a brick's cells, and floods through them, 64 cells at a time.

use glam::{IVec3, UVec3};
use std::ops::{BitAnd, BitOr, BitOrAssign, Not};

/// Outward step of a side: -x, +x, -y, +y, -z, +z.
pub fn side_step(side: usize) -> IVec3 {
    IVec3::AXES[side >> 1] * if side & 1 == 1 { 1 } else { -1 }
}

/// Bits of a slice at x = 0, and at x = 7.
const FIRST_X: u64 = 0x0101_0101_0101_0101;
const LAST_X: u64 = FIRST_X << 7;

/// A set of the 8 x 8 x 8 cells of a brick: word z, bit x + 8 y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cells([u64; 8]);

impl Cells {
    pub const NONE: Self = Self([0; 8]);
    pub const ALL: Self = Self([!0; 8]);

    /// From eight masks of 4 x 4 x 4 blocks: block x + 2 y + 4 z, low and high word of bit x + 4 y + 16 z.
    pub fn from_blocks(words: &[u32; 16]) -> Self {
        let mut slices = [0; 8];
        for (block, mask) in words.chunks(2).enumerate() {
            let mask = u64::from(mask[0]) | u64::from(mask[1]) << 32;
            let shift = (block & 1) * 4 + (block >> 1 & 1) * 32;
            for z in 0..4 {
                let rows = (0..4).map(|y| (mask >> (16 * z + 4 * y) & 15) << (8 * y));
                slices[(block >> 2) * 4 + z] |= rows.fold(0, |a, b| a | b) << shift;
            }
        }
        Self(slices)
    }

    /// A single cell.
    pub fn cell(p: UVec3) -> Self {
        let mut cells = Self::NONE;
        cells.0[p.z as usize] = 1 << (p.x + 8 * p.y);
        cells
    }

    /// Whether a cell is one of these.
    pub fn has(self, p: UVec3) -> bool {
        self.0[p.z as usize] >> (p.x + 8 * p.y) & 1 == 1
    }

    /// The layer of cells along a side.
    pub fn layer(side: usize) -> Self {
        Self::ALL.across(side ^ 1)
    }

    pub fn is_empty(self) -> bool {
        self == Self::NONE
    }

    pub fn count(self) -> u32 {
        self.0.iter().map(|s| s.count_ones()).sum()
    }

    /// The cells, in order.
    pub fn iter(self) -> impl Iterator<Item = UVec3> {
        (0..8).flat_map(move |z| {
            (0..64u32)
                .filter(move |bit| self.0[z as usize] >> bit & 1 == 1)
                .map(move |bit| UVec3::new(bit & 7, bit >> 3, z))
        })
    }

    /// Moved by a cell towards a side; what leaves the brick is lost.
    pub fn shifted(self, side: usize) -> Self {
        let s = self.0;
        Self(match side {
            0 => s.map(|v| (v & !FIRST_X) >> 1),
            1 => s.map(|v| (v & !LAST_X) << 1),
            2 => s.map(|v| v >> 8),
            3 => s.map(|v| v << 8),
            4 => std::array::from_fn(|z| s.get(z + 1).copied().unwrap_or(0)),
            _ => std::array::from_fn(|z| if z > 0 { s[z - 1] } else { 0 }),
        })
    }

    /// Of the brick beyond a side, the cells that touch these.
    pub fn across(self, side: usize) -> Self {
        let s = self.0;
        let mut other = [0; 8];
        match side {
            0 => other = s.map(|v| (v & FIRST_X) << 7),
            1 => other = s.map(|v| (v & LAST_X) >> 7),
            2 => other = s.map(|v| v << 56),
            3 => other = s.map(|v| v >> 56),
            4 => other[7] = s[0],
            _ => other[0] = s[7],
        }
        Self(other)
    }

    /// These and the cells that share a side with one of them.
    pub fn grown(self) -> Self {
        (0..6).fold(self, |grown, side| grown | self.shifted(side))
    }

    /// Everything inside `within` that is connected, by sides, with these cells of it.
    pub fn flood(self, within: Self) -> Self {
        let mut reached = self & within;
        loop {
            let before = reached;
            for (cells, free) in reached.0.iter_mut().zip(within.0) {
                *cells = fill_slice(*cells, free);
            }
            for z in 1..8 {
                reached.0[z] |= reached.0[z - 1] & within.0[z];
            }
            for z in (0..7).rev() {
                reached.0[z] |= reached.0[z + 1] & within.0[z];
            }
            if reached == before {
                return reached;
            }
        }
    }
}

/// Along x, then along y, as far as free cells go on (Kogge-Stone).
fn fill_slice(mut cells: u64, free: u64) -> u64 {
    let (mut up, mut down) = (free & !FIRST_X, free & !LAST_X);
    for step in [1, 2, 4] {
        cells |= (up & (cells << step)) | (down & (cells >> step));
        up &= up << step;
        down &= down >> step;
    }
    let (mut up, mut down) = (free, free);
    for step in [8, 16, 32] {
        cells |= (up & (cells << step)) | (down & (cells >> step));
        up &= up << step;
        down &= down >> step;
    }
    cells
}

impl BitAnd for Cells {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        Self(std::array::from_fn(|z| self.0[z] & other.0[z]))
    }
}

impl BitOr for Cells {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(std::array::from_fn(|z| self.0[z] | other.0[z]))
    }
}

impl BitOrAssign for Cells {
    fn bitor_assign(&mut self, other: Self) {
        *self = *self | other;
    }
}

impl Not for Cells {
    type Output = Self;
    fn not(self) -> Self {
        Self(self.0.map(|s| !s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::twin::random::Random;
    use std::collections::HashSet;

    fn random_cells(random: &mut Random, share: f64) -> Cells {
        let all = Cells::ALL.iter().filter(|_| random.chance(share));
        all.fold(Cells::NONE, |cells, p| cells | Cells::cell(p))
    }

    fn set(cells: Cells) -> HashSet<IVec3> {
        cells.iter().map(|p| p.as_ivec3()).collect()
    }

    #[test]
    fn a_flood_reaches_what_cell_by_cell_is_reached() {
        let mut random = Random::new(51);
        for round in 0..2000 {
            let within = random_cells(&mut random, f64::from(round % 10) / 10.0 + 0.05);
            let start = random_cells(&mut random, 0.004);
            let free = set(within);
            let mut stack: Vec<IVec3> = set(start).into_iter().filter(|p| free.contains(p)).collect();
            let mut expected: HashSet<IVec3> = stack.iter().copied().collect();
            while let Some(p) = stack.pop() {
                let next = (0..6).map(|side| p + side_step(side)).filter(|n| free.contains(n));
                stack.extend(next.filter(|n| expected.insert(*n)));
            }
            assert_eq!(set(start.flood(within)), expected, "round {round}");
        }
    }

    #[test]
    fn neighbours_are_one_step_away() {
        let mut random = Random::new(52);
        for _ in 0..200 {
            let cells = random_cells(&mut random, 0.3);
            for side in 0..6 {
                let moved: HashSet<IVec3> = set(cells).iter().map(|p| *p + side_step(side)).collect();
                let (inside, outside): (HashSet<IVec3>, HashSet<IVec3>) =
                    moved.iter().copied().partition(|p| (*p & 7i32) == *p);
                assert_eq!(set(cells.shifted(side)), inside);
                assert_eq!(set(cells.across(side)), outside.iter().map(|p| *p & 7i32).collect());
            }
        }
    }

    #[test]
    fn blocks_become_cells() {
        let mut random = Random::new(53);
        for _ in 0..200 {
            let words: [u32; 16] = std::array::from_fn(|_| random.next() as u32);
            let has = |p: UVec3| {
                let (block, child) = (p >> 2u32, p & 3u32);
                let bit = child.x + 4 * child.y + 16 * child.z;
                words[(2 * (block.x + 2 * block.y + 4 * block.z) + bit / 32) as usize] >> (bit % 32) & 1 == 1
            };
            let expected: HashSet<IVec3> = Cells::ALL.iter().filter(|p| has(*p)).map(|p| p.as_ivec3()).collect();
            assert_eq!(set(Cells::from_blocks(&words)), expected);
        }
    }
}
