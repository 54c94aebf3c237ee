//! Faces that neither light nor eye can reach need no light of their own: which they are.

use super::cells::{Cells, side_step};
use super::flood::{Flood, Space};
use crate::gpu::shared::{APRON_VOXELS, REACH_WORDS};
use glam::IVec3;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeSet;

/// Steps of a flood in one frame: under a microsecond each.
const STEPS: usize = 4096;
/// Bricks looked at in one frame for sides that light has ceased to reach.
const CHECKS: usize = 1024;
/// Of each frame, how much of what has been counted before is kept.
const KEPT: f64 = 0.9;
/// Cells that a camera may move in a frame without being looked for.
const WAY_MAX: i32 = 256;
/// Sides by which a brick must gain to be voxelised again.
const GAIN_MIN: u32 = 8;

/// A brick and one voxel around it, a bit a cell: set where a face that looks at the cell, if it is empty, is not lit.
pub type Mask = [u32; REACH_WORDS as usize];

/// The world's empty space and what of it light and eye reach.
///
/// Bricks that have not been voxelised count as empty: they do not stand in anyone's way, as they do not on the GPU.
/// What has been voxelised and found no memory counts as if it were there. From outside, from the cameras and from where
/// rays have asked, a [`Flood`] goes on for some steps a frame; when it is done it replaces the one before, which has
/// followed all that opened meanwhile.
#[derive(Default)]
pub struct Regions {
    space: Space,
    reached: Option<Flood>,
    next: Option<Flood>,
    /// Something has changed since the latest flood began.
    stale: bool,
    /// Cells of the cameras.
    eyes: Vec<IVec3>,
    /// Cells that rays have come to, though no empty cell leads there.
    asked: BTreeSet<[i32; 3]>,
    /// Bricks voxelised with a mask, and how many sides of them might have gone unlit.
    masked: FxHashMap<IVec3, u32>,
    /// Rays that have come to faces without light, and all rays, of late.
    asking: f64,
    rays: f64,
    /// Bricks that look at more that is not reached than what they were voxelised with says.
    outdated: FxHashSet<IVec3>,
    /// Bricks to be looked at since a flood has replaced another.
    checks: Vec<IVec3>,
}

impl Regions {
    /// A brick has been voxelised: which of its cells hold surface.
    pub fn arrive(&mut self, brick: IVec3, occupied: Cells) {
        self.set(brick, occupied);
        if occupied.is_empty() {
            self.forget(brick);
        } else if self.masked.contains_key(&brick) {
            self.outdated.remove(&brick);
        } else if self.unreached_sides(brick) > 0 {
            self.outdated.insert(brick);
        }
    }

    fn set(&mut self, brick: IVec3, occupied: Cells) {
        if self.space.occupied(brick) == occupied {
            return;
        }
        let floods = self.reached.iter().chain(&self.next);
        let was: Vec<Cells> = floods.map(|flood| flood.reached(&self.space, brick)).collect();
        self.space.set(brick, occupied);
        for (flood, was) in self.reached.iter_mut().chain(&mut self.next).zip(was) {
            flood.changed(&self.space, brick, was);
        }
        self.stale = true;
    }

    /// Nothing is known of a brick any more.
    pub fn forget(&mut self, brick: IVec3) {
        self.set(brick, Cells::NONE);
        self.masked.remove(&brick);
        self.outdated.remove(&brick);
    }

    /// Forgets all bricks but some.
    pub fn retain(&mut self, keep: impl Fn(IVec3) -> bool) {
        self.bricks().into_iter().filter(|b| !keep(*b)).for_each(|b| self.forget(b));
        let asked = self.asked.len();
        self.asked.retain(|cell| keep(IVec3::from(*cell) >> 3i32));
        self.stale |= self.asked.len() < asked;
    }

    /// The cameras are in these cells. Where one has gone through a wall, what it has left may be out of reach.
    pub fn follow(&mut self, eyes: impl Iterator<Item = IVec3> + Clone) {
        if eyes.clone().eq(self.eyes.iter().copied()) {
            return;
        }
        let left = self.eyes.iter().zip(eyes.clone()).any(|(from, to)| !self.has_way(*from, to));
        self.stale |= left || eyes.clone().count() < self.eyes.len();
        self.eyes.clear();
        self.eyes.extend(eyes.clone());
        eyes.for_each(|cell| self.seed(cell));
    }

    /// Whether empty cells lead from one cell to another: along x, then y, then z.
    fn has_way(&self, from: IVec3, to: IVec3) -> bool {
        let is_empty = |c: IVec3| !self.space.occupied(c >> 3i32).has((c & 7i32).as_uvec3());
        let mut cell = from;
        for axis in 0..3 {
            while cell[axis] != to[axis] && is_empty(cell) && (cell - from).abs().element_sum() < WAY_MAX {
                cell[axis] += (to[axis] - cell[axis]).signum();
            }
        }
        cell == to && is_empty(to)
    }

    /// Takes in cells (the low corner of 2 x 2 x 2 of them) at which rays have come to faces without light, how many came
    /// to each, and how many rays there were. Where they are more than this share of them, what most came to is flooded in.
    pub fn take_requests(&mut self, requests: impl Iterator<Item = (IVec3, u32)>, rays: u64, share: f64) {
        let found: Vec<(IVec3, u32)> =
            requests.filter_map(|(corner, count)| Some((self.unreached_beside(corner)?, count))).collect();
        let count: f64 = found.iter().map(|(_, count)| f64::from(*count)).sum();
        self.asking = KEPT * self.asking + count;
        self.rays = KEPT * self.rays + rays as f64;
        if self.asking <= share * self.rays {
            return;
        }
        let most = found.iter().map(|(_, count)| *count).max().unwrap_or(0);
        for (cell, _) in found.into_iter().filter(|(_, count)| *count >= most.div_ceil(4)) {
            self.asked.insert(cell.to_array());
            self.seed(cell);
        }
        (self.asking, self.rays) = (0.0, 0.0);
    }

    /// Forgets what rays have asked for: walls were missing then.
    pub fn forget_requests(&mut self) {
        self.stale |= !self.asked.is_empty();
        self.asked.clear();
    }

    /// The first of 2 x 2 x 2 cells that is empty and not reached.
    fn unreached_beside(&self, corner: IVec3) -> Option<IVec3> {
        let cells = (0..8).map(|i| corner + IVec3::new(i & 1, i >> 1 & 1, i >> 2));
        cells.into_iter().find(|cell| self.unreached(*cell >> 3i32).has((*cell & 7i32).as_uvec3()))
    }

    /// Whether all that has changed has been flooded and looked at.
    pub fn is_idle(&self) -> bool {
        !self.stale
            && self.next.is_none()
            && self.checks.is_empty()
            && self.reached.as_ref().is_some_and(Flood::is_done)
    }

    /// Whether rays that start at open faces of a brick start where light or eye reaches.
    pub fn asks(&self, brick: IVec3) -> bool {
        self.any_masked() && self.checks.is_empty() && !self.outdated.contains(&brick)
    }

    fn seed(&mut self, cell: IVec3) {
        for flood in self.reached.iter_mut().chain(&mut self.next) {
            self.stale |= seed(flood, &self.space, cell);
        }
    }

    /// The frame's work: none while memory is not `short`, and none while nothing changes. Returns bricks that are to be
    /// voxelised again, for light has come to reach a face of them, has ceased to, or is wanted everywhere again.
    pub fn update(&mut self, short: bool) -> Vec<IVec3> {
        if !short {
            (self.reached, self.next) = (None, None);
            self.asked.clear();
            self.checks.clear();
            let mut masked: Vec<IVec3> = self.masked.keys().copied().collect();
            masked.sort_unstable_by_key(IVec3::to_array);
            return masked;
        }
        let mut again = Vec::new();
        if let Some(reached) = &mut self.reached {
            if !reached.go_on(&self.space, STEPS) {
                return again;
            }
            again = reached.take_opened();
            again.retain(|b| self.masked.contains_key(b));
        }
        if self.next.is_none() && self.checks.is_empty() && (self.stale || self.reached.is_none()) {
            let mut flood = Flood::new(&self.space);
            for cell in self.eyes.iter().copied().chain(self.asked.iter().map(|cell| IVec3::from(*cell))) {
                seed(&mut flood, &self.space, cell);
            }
            self.next = Some(flood);
            self.stale = false;
        }
        if let Some(next) = &mut self.next
            && next.go_on(&self.space, STEPS)
        {
            next.take_opened();
            self.reached = self.next.take();
            self.checks = self.bricks();
        }
        let first = self.checks.len().saturating_sub(CHECKS);
        for brick in self.checks.split_off(first) {
            let before = self.masked.get(&brick).copied().unwrap_or(0);
            let now = self.unreached_sides(brick);
            if now > before {
                self.outdated.insert(brick);
            } else {
                self.outdated.remove(&brick);
            }
            if now < before || now >= before + GAIN_MIN {
                again.push(brick);
            }
        }
        again
    }

    /// Bricks that hold surface, in an order that does not hang on what a hash map happens to do.
    fn bricks(&self) -> Vec<IVec3> {
        let mut bricks: Vec<IVec3> = self.space.bricks().collect();
        bricks.sort_unstable_by_key(IVec3::to_array);
        bricks
    }

    /// Empty cells of a brick that are not reached.
    fn unreached(&self, brick: IVec3) -> Cells {
        let Some(reached) = &self.reached else { return Cells::NONE };
        !self.space.occupied(brick) & !reached.reached(&self.space, brick)
    }

    /// Of a brick's cells, those whose neighbour towards `side` is in another brick, and is empty and not reached.
    fn unreached_beyond(&self, brick: IVec3, side: usize) -> Cells {
        self.unreached(brick + side_step(side)).across(side ^ 1)
    }

    /// Sides of a brick's voxels that look at cells which are not reached.
    fn unreached_sides(&self, brick: IVec3) -> u32 {
        let (occupied, own) = (self.space.occupied(brick), self.unreached(brick));
        let looking = |side: usize| occupied & (own.shifted(side ^ 1) | self.unreached_beyond(brick, side));
        (0..6).map(|side| looking(side).count()).sum()
    }

    /// The mask to voxelise a brick with; none: all of its faces are lit. A brick that has never been voxelised has none.
    pub fn mask(&self, brick: IVec3) -> Option<Mask> {
        if self.reached.is_none() || self.unreached_sides(brick) == 0 {
            return None;
        }
        let mut mask = Mask::default();
        let mut set = |cell: IVec3| {
            let c = (cell + 1).as_uvec3();
            let bit = c.x + APRON_VOXELS * (c.y + APRON_VOXELS * c.z);
            mask[(bit / 32) as usize] |= 1 << (bit % 32);
        };
        self.unreached(brick).iter().for_each(|cell| set(cell.as_ivec3()));
        for side in 0..6 {
            self.unreached_beyond(brick, side).iter().for_each(|cell| set(cell.as_ivec3() + side_step(side)));
        }
        Some(mask)
    }

    /// A brick is being voxelised, with the mask that it has now or without one.
    pub fn start(&mut self, brick: IVec3, masked: bool) {
        if masked {
            self.masked.insert(brick, self.unreached_sides(brick));
        } else {
            self.masked.remove(&brick);
        }
    }

    /// Whether any brick has been voxelised with a mask.
    pub fn any_masked(&self) -> bool {
        !self.masked.is_empty()
    }
}

/// Seeds a flood in a cell or, where that is occupied, in the cells around it. Whether that was new.
fn seed(flood: &mut Flood, space: &Space, cell: IVec3) -> bool {
    let at = |cell: IVec3| (cell >> 3i32, (cell & 7i32).as_uvec3());
    let (brick, own) = at(cell);
    if !space.occupied(brick).has(own) {
        return flood.seed(space, brick, own);
    }
    let around = (0..27).map(|i| at(cell + IVec3::new(i % 3, i / 3 % 3, i / 9) - 1));
    around.fold(false, |new, (brick, cell)| flood.seed(space, brick, cell) | new)
}

#[cfg(test)]
mod tests;
