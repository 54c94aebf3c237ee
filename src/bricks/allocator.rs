//! Extents of a linear space: best fit, with coalescing.

use std::collections::{BTreeMap, BTreeSet};

/// Hands out extents of `0..capacity` units. Freed neighbours join; the smallest hole that fits is taken, so that after
/// churn the high water stays near what lives (memory.md: 1.02).
#[derive(Debug, Default)]
pub struct ExtentAllocator {
    capacity: u32,
    used: u32,
    /// Start to length of every hole.
    holes: BTreeMap<u32, u32>,
    /// (length, start) of every hole.
    by_length: BTreeSet<(u32, u32)>,
}

impl ExtentAllocator {
    /// An empty space.
    pub fn new(capacity: u32) -> Self {
        let mut space = Self::default();
        space.grow(capacity);
        space
    }

    /// Units handed out.
    pub fn used(&self) -> u32 {
        self.used
    }

    /// Units there are.
    pub fn capacity(&self) -> u32 {
        self.capacity
    }

    /// Makes the space larger.
    pub fn grow(&mut self, capacity: u32) {
        if capacity > self.capacity {
            let start = self.capacity;
            self.capacity = capacity;
            self.insert_hole(start, capacity - start);
        }
    }

    /// The start of a free extent of `length` units, or none.
    pub fn allocate(&mut self, length: u32) -> Option<u32> {
        let (hole, start) = self.by_length.range((length, 0)..).next().copied()?;
        self.remove_hole(start, hole);
        if hole > length {
            self.put_hole(start + length, hole - length);
        }
        self.used += length;
        Some(start)
    }

    /// Gives back an extent that `allocate` returned.
    pub fn free(&mut self, start: u32, length: u32) {
        self.used -= length;
        self.insert_hole(start, length);
    }

    fn insert_hole(&mut self, mut start: u32, mut length: u32) {
        if let Some((&before, &size)) = self.holes.range(..start).next_back()
            && before + size == start
        {
            self.remove_hole(before, size);
            start = before;
            length += size;
        }
        if let Some(&size) = self.holes.get(&(start + length)) {
            self.remove_hole(start + length, size);
            length += size;
        }
        self.put_hole(start, length);
    }

    fn put_hole(&mut self, start: u32, length: u32) {
        self.holes.insert(start, length);
        self.by_length.insert((length, start));
    }

    fn remove_hole(&mut self, start: u32, length: u32) {
        self.holes.remove(&start);
        self.by_length.remove(&(length, start));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Owned extents never overlap, and everything is owned once or free, after any history.
    #[test]
    fn every_unit_is_owned_once_or_free() {
        let mut space = ExtentAllocator::new(4096);
        let mut owned: Vec<(u32, u32)> = Vec::new();
        let mut random = 1u32;
        for step in 0..20_000 {
            random = random.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            let length = 1 + (random >> 20) % 97;
            if random >> 31 == 0 {
                if let Some(start) = space.allocate(length) {
                    owned.push((start, length));
                }
            } else if !owned.is_empty() {
                let (start, length) = owned.swap_remove((random >> 8) as usize % owned.len());
                space.free(start, length);
            }
            if step == 10_000 {
                space.grow(6000);
            }
            assert_eq!(space.used(), owned.iter().map(|e| e.1).sum::<u32>());
            let free: u32 = space.holes.values().sum();
            assert_eq!(free + space.used(), space.capacity());
        }
        owned.sort_unstable();
        assert!(owned.windows(2).all(|p| p[0].0 + p[0].1 <= p[1].0));
        for (start, length) in owned {
            space.free(start, length);
        }
        assert_eq!(space.holes.into_iter().collect::<Vec<_>>(), [(0, 6000)], "all holes have joined");
    }
}
