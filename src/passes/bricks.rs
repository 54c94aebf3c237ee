//! Group "bricks": `brick_compact`, `light_carry`, `grid_update`, `brick_commit`, `voxel_mark`, `voxelize`, `face_resolve`.

use crate::bricks::{Arrived, Batch};
use crate::frame::{Command, Frame};
use crate::gpu::shared::{
    BATCH_BRICKS, BrickCommitPush, BrickCompactPush, BrickCopy, FaceResolvePush, GridUpdatePush, VoxelMarkPush,
    VoxelizePush,
};
use crate::settings::HitModel;

/// Workgroups that every device takes along an axis.
const GROUPS_MAX: u32 = 65_535;

/// Bricks move together (`moves`, in this order), finished ones take over the light of what they replace (`carries`) and
/// move to their places, and then the grid shows them. Places
/// may be other bricks' of the frame before: no pass of this frame may have looked for those.
pub fn commit(frame: &mut Frame, moves: &[BrickCopy], arrived: &Arrived, grid_writes: &[[u32; 2]]) {
    let passes = frame.commands.iter().filter(|c| matches!(c, Command::Dispatch { .. }));
    debug_assert_eq!(passes.count(), 0, "nothing reads the world before it is brought up to date");
    if !moves.is_empty() {
        frame.upload.push("brick_moves", moves);
        frame.dispatch("brick_compact", [1, 1, 1], BrickCompactPush { count: moves.len() as u32 });
    }
    let Arrived { carries, copies, .. } = arrived;
    if !carries.is_empty() {
        frame.upload.push("light_carries", carries);
        frame.dispatch("light_carry", [carries.len() as u32, 1, 1], [0u32; 0]);
    }
    frame.upload.push("brick_copies", copies);
    frame.upload.push("grid_writes", grid_writes);
    for first in (0..copies.len() as u32).step_by(GROUPS_MAX as usize) {
        let count = (copies.len() as u32 - first).min(GROUPS_MAX);
        frame.dispatch("brick_commit", [count, 1, 1], BrickCommitPush { first });
    }
    let count = grid_writes.len() as u32;
    frame.dispatch("grid_update", [count.div_ceil(64), 1, 1], GridUpdatePush { count });
}

/// How bricks are voxelised.
pub struct Voxelization {
    /// Bricks side by side, 1 to [`BATCH_BRICKS`].
    pub batch: u32,
    /// Words of the payload.
    pub payload_words: u32,
    /// Largest emission of any material.
    pub emission_max: f32,
    pub hit_model: HitModel,
}

/// The passes of [`voxelize`].
pub const VOXELIZE_PASSES: [&str; 3] = ["voxel_mark", "voxelize", "face_resolve"];

/// Queued bricks become packed bricks in the payload, a batch at a time.
pub fn voxelize(frame: &mut Frame, queued: &Batch, how: &Voxelization) {
    let Voxelization { batch, payload_words, emission_max, hit_model } = *how;
    assert!((1..=BATCH_BRICKS).contains(&batch), "a dispatch of voxels has at most 65 535 workgroups");
    let bricks = &queued.bricks;
    frame.upload.push("batch_bricks", bricks);
    frame.upload.push("triangle_lists", &queued.lists);
    frame.upload.push("triangles", &queued.triangles);
    frame.upload.push("reach_masks", queued.masks.as_flattened());
    for first_brick in (0..bricks.len() as u32).step_by(batch as usize) {
        let count = (bricks.len() as u32 - first_brick).min(batch);
        frame.dispatch("voxel_mark", [count, 1, 1], VoxelMarkPush { first_brick });
        frame.dispatch_indirect("voxelize", "voxel_args", VoxelizePush { first_brick, emission_max });
        let push = FaceResolvePush { first_brick, payload_words, hit_model: hit_model as u32 };
        frame.dispatch("face_resolve", [count, 1, 1], push);
    }
}
