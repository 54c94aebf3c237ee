//! Which bricks a frame voxelises.

use super::{FrameScope, World};
use crate::bricks::{Batch, MAX_TRIANGLES, Viewpoint};
use crate::error::Result;
use crate::frame::Command;
use crate::gpu::shared::PAGE_WORDS;
use crate::passes;
use crate::passes::bricks::Voxelization;
use crate::scene::Scene;

/// Bricks voxelised in a frame to learn how long they take.
const FIRST_BRICKS: usize = 16;

impl World {
    /// What voxelisation took in the slot's last frame: slower bricks count at once, faster ones by and by.
    pub fn voxelized_in(&mut self, index: usize, ms: f64) {
        let bricks = self.flights[index].bricks.len();
        if bricks > 0 && ms > 0.0 {
            let each = ms / bricks as f64;
            self.brick_ms = each.max(0.75 * self.brick_ms + 0.25 * each);
        }
    }

    /// Bricks to hand to the GPU in this frame. Where time is limited and nothing has been measured yet: a few.
    fn bricks_per_frame(&self, scope: &FrameScope) -> usize {
        let most = scope.settings.voxelize_bricks_per_frame as usize;
        match f64::from(scope.settings.voxelize_ms) {
            limit if limit == 0.0 || scope.device.timestamp_bits == 0 => most,
            _ if self.brick_ms == 0.0 => most.min(FIRST_BRICKS),
            limit => most.min((limit / self.brick_ms) as usize).max(1),
        }
    }

    pub(super) fn voxelize(&mut self, scope: &mut FrameScope, scene: &Scene, viewpoint: &Viewpoint) -> Result<()> {
        let queue = self.table.next(self.bricks_per_frame(scope), viewpoint);
        // Materials that wait for room get it when nothing is voxelised.
        if queue.is_empty() || self.materials_wait {
            self.release_scratch(scope);
            return Ok(());
        }
        let expected = 1.125 * self.mean_words;
        let (brick_bytes, upload_bytes) = ((4.0 * expected) as u64, self.mean_upload as u64);
        let scratch = self.memory.scratch(scope, queue.len() as u32, [brick_bytes, upload_bytes], self.spare)?;
        let Some(scratch) = scratch else { return Ok(()) };
        let mut batch = std::mem::take(&mut self.batch);
        batch.clear();
        let mut payload = 0.0;
        for (position, pages) in queue.into_iter().take(scratch.bricks) {
            let before = batch.triangles.len();
            let all = self.primitives.triangles(position, scene, &self.grid, &self.material_index, &mut batch);
            payload += pages.map_or(expected, |p| (p * PAGE_WORDS) as f32);
            let bytes = batch.bytes();
            if batch.bricks.len() > 1 && (bytes > scratch.share || payload > scratch.payload_words as f32) {
                batch.drop_last(before);
                break;
            }
            if bytes > scratch.upload {
                batch.drop_last(before);
                if self.table.busy() || self.memory.is_momentary(scope) {
                    break;
                }
                self.table.leave_out(position);
                payload = 0.0;
                continue;
            }
            if !all && !self.crowded {
                self.crowded = true;
                self.warnings.push(format!(
                    "a brick at {} m has more than {MAX_TRIANGLES} triangles: the others are not looked at (told once)",
                    self.grid.to_world(position.as_dvec3() * 8.0 + 4.0)
                ));
            }
            self.table.start(position);
            self.flights[scope.index].bricks.push(position);
        }
        if batch.bricks.is_empty() {
            self.batch = batch;
            return Ok(());
        }
        self.idle = 0;
        let upload = batch.bytes() as f32 / batch.bricks.len() as f32;
        self.mean_upload = 0.5 * self.mean_upload + 0.5 * upload;
        scope.frame.commands.push(Command::Clear("payload_used"));
        let how = Voxelization {
            batch: scratch.batch,
            payload_words: scratch.payload_words,
            emission_max: scene.emission_max(),
            hit_model: scope.settings.hit_model,
        };
        passes::bricks::voxelize(&mut scope.frame, &batch, &how);
        self.batch = batch;
        Ok(())
    }

    /// Gives back what only voxelisation needs, once nothing has been voxelised for two rounds of slots.
    fn release_scratch(&mut self, scope: &mut FrameScope) {
        self.idle += 1;
        let quiet = 2 * self.flights.len();
        let released = quiet + 1 + self.flights.len();
        if self.table.busy() || self.idle <= quiet || self.idle > released {
            return;
        }
        self.memory.release_scratch(scope);
        self.batch = Batch::default();
        // All slots have given back theirs: bricks with too many triangles may fit now.
        if self.idle == released {
            self.table.retry_oversized();
        }
    }
}
