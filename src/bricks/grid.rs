//! The host's image of `world_grid`: which bricks each group holds and where their entries stand.
//! The only host code that knows its layout (shaders: lib/world.wgsl).

use super::ExtentAllocator;
use crate::gpu::shared::GROUP_WORDS;
use glam::{IVec3, UVec3};

#[derive(Clone, Copy, Default)]
struct Group {
    mask: u64,
    /// First entry, in units of [`Grid::ENTRY_UNIT`], and how many units.
    entries: u32,
    units: u32,
    /// Since the last [`Grid::take_writes`].
    changed: bool,
}

/// Two-level grid of bricks: a 64-bit mask a group, then an entry for each brick that exists.
pub struct Grid {
    extent: UVec3,
    groups: Vec<Group>,
    entries: Vec<u32>,
    space: ExtentAllocator,
    /// Groups that have changed since the last [`Grid::take_writes`].
    changed: Vec<usize>,
}

impl Grid {
    const ENTRY_UNIT: u32 = 4;
    /// Entries of a new grid.
    const FIRST_ENTRIES: u32 = 4096;

    /// An empty grid of `extent` groups.
    pub fn new(extent: UVec3) -> Self {
        Self {
            extent,
            groups: vec![Group::default(); (extent.x * extent.y * extent.z) as usize],
            entries: vec![0; Self::FIRST_ENTRIES as usize],
            space: ExtentAllocator::new(Self::FIRST_ENTRIES / Self::ENTRY_UNIT),
            changed: Vec::new(),
        }
    }

    fn first_entry_word(&self) -> u32 {
        self.groups.len() as u32 * GROUP_WORDS
    }

    /// Words that `world_grid` must have.
    pub fn words(&self) -> u32 {
        self.first_entry_word() + self.entries.len() as u32
    }

    /// Entries that there is room for.
    pub fn capacity(&self) -> u32 {
        self.entries.len() as u32
    }

    /// Entries that so many bricks ask for: half as many again, as groups have them in units; more where this has
    /// turned out too few.
    pub fn entries_for(&self, bricks: u32) -> u32 {
        let (used, capacity) = (self.space.used() * Self::ENTRY_UNIT, self.capacity());
        let crowded = if used > capacity / 8 * 7 { capacity + capacity / 2 } else { 0 };
        (bricks + bricks / 2).max(crowded).next_multiple_of(Self::FIRST_ENTRIES)
    }

    /// Makes room for more entries; [`Grid::words`] grows with it.
    pub fn grow(&mut self, entries: u32) {
        let units = entries.div_ceil(Self::ENTRY_UNIT).max(self.space.capacity());
        self.space.grow(units);
        self.entries.resize((units * Self::ENTRY_UNIT) as usize, 0);
    }

    /// The groups that have changed since the last call, as pairs of address and value.
    pub fn take_writes(&mut self) -> Vec<[u32; 2]> {
        let mut writes = Vec::new();
        for index in std::mem::take(&mut self.changed) {
            self.groups[index].changed = false;
            let group = self.groups[index];
            let (at, first) = (index as u32 * GROUP_WORDS, self.first_entry_word() + group.entries * Self::ENTRY_UNIT);
            writes.extend([[at, group.mask as u32], [at + 1, (group.mask >> 32) as u32], [at + 2, first]]);
            writes.extend((first..).zip(self.list(group)).map(|(at, word)| [at, *word]));
        }
        writes
    }

    /// Physical group and bit of a brick (world position in bricks): toroidal, so that nothing moves with the camera.
    fn place(&self, brick: IVec3) -> (usize, u32) {
        let group = (brick >> 2i32).as_uvec3() & (self.extent - 1);
        let child = (brick & 3i32).as_uvec3();
        let index = group.x + self.extent.x * (group.y + self.extent.y * group.z);
        (index as usize, child.x | child.y << 2 | child.z << 4)
    }

    /// A brick's first word, as the GPU finds it.
    pub fn find(&self, brick: IVec3) -> Option<u32> {
        let (index, bit) = self.place(brick);
        let group = self.groups[index];
        let rank = (group.mask & ((1u64 << bit) - 1)).count_ones();
        (group.mask >> bit & 1 == 1).then(|| self.entries[(group.entries * Self::ENTRY_UNIT + rank) as usize])
    }

    /// Whether nothing is entered and no entry is taken.
    #[cfg(test)]
    pub fn is_empty(&self) -> bool {
        self.space.used() == 0 && self.groups.iter().all(|group| group.mask == 0)
    }

    /// Enters a brick's first word, or replaces it. False, and nothing changed, where there is no room for an entry.
    pub fn insert(&mut self, brick: IVec3, word: u32) -> bool {
        let (index, bit) = self.place(brick);
        let group = self.groups[index];
        let rank = (group.mask & ((1u64 << bit) - 1)).count_ones() as usize;
        let (mut list, count) = ([0; 64], self.list(group).len());
        list[..rank].copy_from_slice(&self.list(group)[..rank]);
        list[rank] = word;
        let there = usize::from(group.mask >> bit & 1 == 1);
        list[rank + 1..=count - there].copy_from_slice(&self.list(group)[rank + there..]);
        self.store(index, group.mask | 1 << bit, &list[..=count - there])
    }

    /// Takes a brick out.
    pub fn remove(&mut self, brick: IVec3) {
        let (index, bit) = self.place(brick);
        let group = self.groups[index];
        if group.mask >> bit & 1 == 1 {
            let rank = (group.mask & ((1u64 << bit) - 1)).count_ones() as usize;
            let (mut list, count) = ([0; 64], self.list(group).len() - 1);
            list[..rank].copy_from_slice(&self.list(group)[..rank]);
            list[rank..count].copy_from_slice(&self.list(group)[rank + 1..]);
            let stored = self.store(index, group.mask & !(1 << bit), &list[..count]);
            debug_assert!(stored, "a shorter list fits where the longer one was");
        }
    }

    fn list(&self, group: Group) -> &[u32] {
        let first = (group.entries * Self::ENTRY_UNIT) as usize;
        &self.entries[first..first + group.mask.count_ones() as usize]
    }

    fn store(&mut self, index: usize, mask: u64, list: &[u32]) -> bool {
        let group = self.groups[index];
        let units = (list.len() as u32).div_ceil(Self::ENTRY_UNIT);
        let mut entries = group.entries;
        if units > group.units {
            let Some(start) = self.space.allocate(units) else { return false };
            entries = start;
        }
        // A shorter list keeps its place and gives back the end of it.
        let (kept, first) = if units > group.units { (0, group.entries) } else { (units, group.entries + units) };
        if group.units > kept {
            self.space.free(first, group.units - kept);
        }
        self.groups[index] = Group { mask, entries, units, changed: true };
        let first = (entries * Self::ENTRY_UNIT) as usize;
        self.entries[first..first + list.len()].copy_from_slice(list);
        if !group.changed {
            self.changed.push(index);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    /// What the writes add up to gives every brick its word, whatever the history.
    #[test]
    fn the_gpu_finds_what_the_host_entered() {
        let mut grid = Grid::new(UVec3::new(2, 1, 2));
        let mut expected: HashMap<IVec3, u32> = HashMap::new();
        let mut memory = vec![0u32; 1 << 16];
        let mut random = 7u32;
        for step in 0..20_000u32 {
            random = random.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            let brick = IVec3::new((random >> 8 & 7) as i32, (random >> 12 & 3) as i32, (random >> 16 & 7) as i32);
            if random >> 30 == 0 {
                grid.remove(brick);
                expected.remove(&brick);
            } else {
                assert!(grid.insert(brick, step + 1), "4 096 entries hold 256 bricks");
                expected.insert(brick, step + 1);
            }
            for [at, value] in grid.take_writes() {
                memory[at as usize] = value;
            }
        }
        for x in 0..8 {
            for y in 0..4 {
                for z in 0..8 {
                    let brick = IVec3::new(x, y, z);
                    let (index, bit) = grid.place(brick);
                    let at = index * GROUP_WORDS as usize;
                    let mask = u64::from(memory[at]) | u64::from(memory[at + 1]) << 32;
                    let rank = (mask & ((1u64 << bit) - 1)).count_ones();
                    let found = (mask >> bit & 1 == 1).then(|| memory[(memory[at + 2] + rank) as usize]);
                    assert_eq!(found, expected.get(&brick).copied());
                }
            }
        }
    }
}
