//! Extents of a linear space: best fit, with coalescing.

use std::collections::{BTreeMap, BTreeSet};

/// Hands out extents of `0..capacity` units. Freed neighbours join; the smallest hole that fits is taken, so that after
/// churn the high water stays near what lives: at most 1.21 of it for bricks of 5 to 60 pages.
#[derive(Clone, Debug, Default)]
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

    /// Units of the longest extent that is free.
    pub fn longest_hole(&self) -> u32 {
        self.by_length.last().map_or(0, |(length, _)| *length)
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
    use crate::twin::random::Random;

    /// A space with a note of who owns each unit.
    struct Owned {
        space: ExtentAllocator,
        units: Vec<bool>,
        extents: Vec<(u32, u32)>,
    }

    impl Owned {
        fn new(capacity: u32) -> Self {
            let units = vec![false; capacity as usize];
            Self { space: ExtentAllocator::new(capacity), units, extents: Vec::new() }
        }

        fn mark(&mut self, (start, length): (u32, u32), owned: bool) {
            let units = &mut self.units[start as usize..(start + length) as usize];
            assert!(units.iter().all(|unit| *unit != owned), "a unit is owned twice");
            units.fill(owned);
        }

        fn allocate(&mut self, length: u32) -> bool {
            let Some(start) = self.space.allocate(length) else { return false };
            self.mark((start, length), true);
            self.extents.push((start, length));
            true
        }

        fn free(&mut self, index: usize) {
            let (start, length) = self.extents.swap_remove(index);
            self.space.free(start, length);
            self.mark((start, length), false);
        }

        fn grow(&mut self, capacity: u32) {
            self.space.grow(capacity);
            self.units.resize(capacity as usize, false);
        }

        /// Holes are what nobody owns, each as long as it can be and found by its length.
        fn check(&self) {
            let runs = self.units.chunk_by(|a, b| a == b).scan(0, |start, run| {
                *start += run.len() as u32;
                Some((*start - run.len() as u32, run.len() as u32, run[0]))
            });
            let free: Vec<(u32, u32)> = runs.filter(|run| !run.2).map(|run| (run.0, run.1)).collect();
            assert_eq!(self.space.holes.iter().map(|(s, l)| (*s, *l)).collect::<Vec<_>>(), free);
            assert_eq!(self.space.by_length, free.iter().map(|(s, l)| (*l, *s)).collect());
            assert_eq!(self.space.used() + free.iter().map(|f| f.1).sum::<u32>(), self.space.capacity());
        }
    }

    #[test]
    fn every_unit_is_owned_once_or_free() {
        let mut random = Random::new(1);
        let mut owned = Owned::new(4096);
        for step in 0..20_000 {
            let length = 1 + random.below(97);
            if random.chance(0.5) {
                let longest = owned.space.holes.values().max().copied().unwrap_or(0);
                assert_eq!(owned.allocate(length), length <= longest, "what fits is found");
            } else if !owned.extents.is_empty() {
                owned.free(random.below(owned.extents.len() as u32) as usize);
            }
            if step % 2000 == 1999 {
                owned.grow(owned.space.capacity() + random.below(200));
            }
            owned.check();
        }
        while !owned.extents.is_empty() {
            owned.free(random.below(owned.extents.len() as u32) as usize);
        }
        let whole = BTreeMap::from([(0, owned.space.capacity())]);
        assert_eq!((owned.space.used(), owned.space.holes), (0, whole), "all holes have joined");
    }

    /// Bricks of 5 to 60 pages change their size, 10 000 times, in a space of which 31/32 are given away: what the table
    /// counts on where memory is short. A page is 8 words; no brick ends with its last page.
    #[test]
    fn a_nearly_full_space_stays_well_used() {
        const CAPACITY: u32 = 16_384;
        let mut random = Random::new(2);
        let mut owned = Owned::new(CAPACITY);
        let mut words: Vec<u32> = Vec::new();
        let (mut refused, mut least_live, mut least_used, mut highest) = (0, 1.0f64, 1.0f64, 0);
        for update in 0..11_000 {
            // The first thousand fill it.
            if update >= 1000 {
                let index = random.below(words.len() as u32) as usize;
                owned.free(index);
                words.swap_remove(index);
            }
            loop {
                let brick = 33 + random.below(448);
                let pages = brick.div_ceil(8);
                if owned.space.used() + pages > CAPACITY - CAPACITY / 32 {
                    break;
                }
                if !owned.allocate(pages) {
                    refused += 1;
                    break;
                }
                words.push(brick);
            }
            if update >= 1000 {
                let (live, used) = (words.iter().sum::<u32>(), owned.space.used());
                least_live = least_live.min(f64::from(live) / f64::from(used * 8));
                least_used = least_used.min(f64::from(used) / f64::from(CAPACITY));
                highest = highest.max(owned.extents.iter().map(|e| e.0 + e.1).max().unwrap_or(0));
            }
        }
        owned.check();
        println!(
            "least {least_live:.4} of the pages in use hold words, least {least_used:.4} of the space is in use; \
             {refused} times no hole was large enough; high water {highest} of {CAPACITY}"
        );
        assert!(least_live > 0.95, "{least_live:.4} of the pages in use hold words");
        assert!(least_used > 0.9, "{least_used:.4} of the space is in use");
    }

    /// With an eighth to spare, as the table asks for, bricks that change stay close together.
    #[test]
    fn the_high_water_stays_near_what_lives() {
        let mut random = Random::new(3);
        let mut owned = Owned::new(1 << 16);
        (0..500).for_each(|_| assert!(owned.allocate(5 + random.below(56))));
        let mut most = 0.0f64;
        for _ in 0..10_000 {
            owned.free(random.below(500) as usize);
            assert!(owned.allocate(5 + random.below(56)));
            let highest = owned.extents.iter().map(|e| e.0 + e.1).max().unwrap_or(0);
            most = most.max(f64::from(highest) / f64::from(owned.space.used()));
        }
        println!("high water {most:.4} of what lives");
        assert!(most < 1.25, "{most:.4}");
    }
}
