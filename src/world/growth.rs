//! How large `world_bricks` and `world_grid` are.

use super::memory::{BricksLimit, PAGE_BYTES};
use super::{FrameScope, World};
use crate::bricks::Finished;
use crate::error::Result;
use crate::gpu::shared::PAGE_WORDS;
use crate::scene::Scene;

/// Pages of a new `world_bricks`, before anything is known of the scene.
const FIRST_PAGES: u32 = 8;
/// One brick of so many is too few to tell what all of them take.
const FEW: u32 = 32;

impl World {
    /// Makes the grid and the pages as large as what has arrived and what still waits asks for, within the budget.
    ///
    /// A larger `world_bricks` stands beside the old one until no frame in flight uses that. So what grows past the
    /// middle of its share grows only once more, to all that fits beside it; what is then still too small for a world
    /// that needs more, and what is too large since others need more, shrinks to the nearest bricks and grows anew.
    pub(super) fn fit_pages(&mut self, scope: &mut FrameScope, scene: &Scene, arriving: &[Finished]) -> Result<()> {
        let fixed = self.fixed(scene);
        let demand = self.table.demand(arriving);
        let bricks = self.table.resident() + self.table.missing();
        let mean_brick = u64::from(demand) * PAGE_BYTES / u64::from(bricks.max(1));
        let BricksLimit { steady, .. } = self.memory.bricks_limit(scope, &fixed, mean_brick, self.table.resident());

        let fitting = u64::from(bricks).min(u64::from(steady) * PAGE_BYTES / mean_brick.max(PAGE_BYTES)) as u32;
        let entries = self.table.grid.entries_for(fitting);
        let grown = (u64::from(self.table.grid.words()) + u64::from(entries)) * 4;
        if entries > self.table.grid.capacity() && grown <= self.memory.room(scope) {
            self.table.grid.grow(entries);
        }
        self.memory.fit_grid(scope, &self.table.grid)?;

        let BricksLimit { steady, beside, momentary } =
            self.memory.bricks_limit(scope, &fixed, mean_brick, self.table.resident());
        // Once bricks have been refused, until everything would fit with all of its faces lit.
        let saved = self.table.unreached() / PAGE_WORDS;
        let would_fill = saved > 0 && demand.saturating_add(saved) > steady - steady / 8;
        self.short = scope.settings.region_culling && (self.table.is_full() || would_fill);
        let capacity = self.table.pages.capacity();
        if capacity == 0 {
            self.table.grow(FIRST_PAGES);
            self.memory.replace_bricks(scope, FIRST_PAGES, &[])?;
            return Ok(());
        }
        let fits = self.table.fits(arriving);
        // Where what arrives finds no hole, an eighth over what is needed was not enough.
        let over = if fits { demand / 8 } else { (demand / 8).max((capacity + capacity / 4).saturating_sub(demand)) };
        let wanted = demand.saturating_add(over).min(steady);
        // While they grow, the old pages stand beside the new ones.
        self.spare = u64::from(steady.saturating_sub(wanted).saturating_sub(capacity)) * PAGE_BYTES;
        let small = (steady / 16).min(beside).max(FIRST_PAGES);
        if capacity > steady + self.memory.tolerance() && small < capacity {
            let kept = self.table.shrink(small);
            return self.memory.replace_bricks(scope, small, &kept);
        }
        if fits && !self.table.is_full() || wanted <= capacity {
            return Ok(());
        }
        // A few bricks say little of the others: what they ask for must leave room for the last step.
        let first_step = if (self.table.resident() + arriving.len() as u32) * FEW < bricks {
            (steady / FEW).max(self.table.pages_with(arriving) + arriving_slack(arriving))
        } else {
            u32::MAX
        };
        let target = if wanted > steady / 2 { beside } else { wanted.min(beside) }.min(first_step);
        if target < wanted && momentary {
            return Ok(());
        }
        if target > capacity + capacity / 8 {
            self.table.grow(target);
            self.memory.replace_bricks(scope, target, &[[0, 0, capacity]])
        } else if capacity < steady / 32 * 27 && small < capacity {
            let kept = self.table.shrink(small);
            self.memory.replace_bricks(scope, small, &kept)
        } else {
            Ok(())
        }
    }
}

/// Pages that should be free beside what arrives: holes are not all of use.
fn arriving_slack(arriving: &[Finished]) -> u32 {
    arriving.iter().map(|f| f.result.words).sum::<u32>() / PAGE_WORDS / 8
}
