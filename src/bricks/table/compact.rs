//! Compaction: bricks move together, so that holes that nothing fits into become one.

use super::{Brick, BrickTable};
use crate::gpu::shared::{BrickCopy, PAGE_WORDS};
use glam::IVec3;

/// Pages that move in one frame, by one workgroup: 128 KiB.
const PAGES_PER_FRAME: u32 = 4096;

impl BrickTable {
    /// Where bricks are left out although a sixteenth of the pages is free, in holes too small for them, moves bricks
    /// together, some a frame; then what is free is shared out. Returns what the GPU is to move inside `world_bricks`.
    pub fn compact(&mut self) -> Vec<BrickCopy> {
        if !self.is_scattered() {
            return Vec::new();
        }
        let moves = self.close_gaps(PAGES_PER_FRAME);
        if self.pages.first_gap().is_none() {
            self.compacted = Some(self.pages.used());
            self.freed = true;
        }
        moves
    }

    /// Not while anything else is to be done: what arrives fills holes by itself. Nor again where it was of no use.
    fn is_scattered(&self) -> bool {
        let (used, capacity) = (self.pages.used(), self.pages.capacity());
        let lacking = self.is_full() && !self.waiting.is_empty();
        self.is_idle() && lacking && capacity - used > capacity / 16 && self.compacted != Some(used)
    }

    /// Moves bricks, in the order of their pages and up to so many pages of them, to the end of those before. One after the
    /// other, as these moves are returned, none writes over what is still to move.
    pub(super) fn close_gaps(&mut self, pages: u32) -> Vec<BrickCopy> {
        let mut moves: Vec<BrickCopy> = Vec::new();
        let mut left = pages;
        for position in self.behind_first_gap() {
            let brick = self.resident[&position];
            let Some((start, hole)) = self.pages.first_gap().filter(|_| brick.pages <= left) else { break };
            debug_assert_eq!(brick.page, start + hole, "every page that is used is a brick's");
            left -= brick.pages;
            self.pages.close_up(brick.pages);
            self.resident.insert(position, Brick { page: start, ..brick });
            let [source, target_word, words] = [brick.page, start, brick.pages].map(|pages| pages * PAGE_WORDS);
            if let Some(turn) = brick.turn {
                self.lighting.relocate(turn, target_word);
            }
            let shown = self.grid.insert(position, target_word);
            debug_assert!(shown, "its entry is only replaced");
            match moves.last_mut() {
                Some(last) if last.source + last.words == source => last.words += words,
                _ => moves.push(BrickCopy { source, target_word, words, unused: 0 }),
            }
        }
        moves
    }

    /// Bricks whose pages lie behind the first gap, in their order.
    fn behind_first_gap(&self) -> Vec<IVec3> {
        let Some((start, _)) = self.pages.first_gap() else { return Vec::new() };
        let behind = self.resident.iter().filter(|(_, b)| b.pages > 0 && b.page > start);
        let mut bricks: Vec<(u32, IVec3)> = behind.map(|(position, b)| (b.page, *position)).collect();
        bricks.sort_unstable_by_key(|(page, _)| *page);
        bricks.into_iter().map(|(_, position)| position).collect()
    }
}
