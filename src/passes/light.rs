//! Group "lighting": `face_compact`, `light_direct` (or `light_direct_areas`), `light_bounce`, `light_store`.

use crate::frame::Frame;
use crate::gpu::shared::{LIGHT_SPHERE, Light, LightBrick, LightPush};

/// Lights `face_count` faces of the chosen bricks `sweeps` times; `first_update` numbers the sweeps over time.
pub fn light(
    frame: &mut Frame,
    bricks: &[LightBrick],
    face_count: u32,
    sweeps: u32,
    first_update: u32,
    lights: &[Light],
    bounces: bool,
) {
    frame.upload.push("light_bricks", bricks);
    let groups = face_count.div_ceil(64);
    let direct = if lights.iter().any(|l| l.kind >= LIGHT_SPHERE) { "light_direct_areas" } else { "light_direct" };
    frame.dispatch("face_compact", [bricks.len() as u32, 1, 1], [0u32; 0]);
    for sweep in 0..sweeps {
        let push = LightPush { face_count, brick_count: bricks.len() as u32, update: first_update + sweep };
        // Without bounces it still clears what the sweep before left.
        if !lights.is_empty() || !bounces {
            frame.dispatch(direct, [groups, 1, 1], push);
        }
        if bounces {
            frame.dispatch("light_bounce", [groups, 1, 1], push);
        }
        frame.dispatch("light_store", [push.brick_count, 1, 1], push);
    }
}
