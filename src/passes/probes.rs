//! Groups "probes" and "resolve": `probe_reproject`, `probe_place`, `probe_adapt`, `probe_ration`, `probe_mips`, `probe_carry`, `probe_trace`, `resolve`,
//! `disocclusion`, `debug_view`, `composite`.

use crate::context::DebugView;
use crate::frame::{Command, Frame};
use crate::gpu::shared::{CompositePush, DebugPush, PROBE_LAYERS, PROBE_MIPS, View, ViewPush};
use glam::UVec2;

/// The irradiance of every pixel: by screen probes, or by each pixel's own rays. `watches`: the world has changed of late.
pub fn gather(frame: &mut Frame, view: &View, frame_index: u32, watches: bool, output_float32: bool) {
    frame.upload.push("view", &[*view]);
    let [x, y] = view.tiles;
    let push = ViewPush { frame_index };
    if view.pixel_rays == 0 {
        let has_past = view.history_valid == 1;
        frame.commands.push(Command::Clear("probe_claims"));
        if has_past {
            let previous = [view.previous_size & 0xffff, view.previous_size >> 16];
            let probes: u32 = previous.map(|side| side.div_ceil(view.tile_size)).iter().product();
            frame.dispatch("probe_reproject", [(PROBE_LAYERS * probes).div_ceil(64), 1, 1], push);
        }
        for pass in ["probe_place", "probe_adapt"] {
            frame.dispatch(pass, [(x * y).div_ceil(64), 1, 1], push);
        }
        if (1..PROBE_LAYERS * x * y).contains(&view.probes_per_frame) {
            frame.dispatch("probe_ration", [(PROBE_LAYERS * x * y).div_ceil(64), 1, 1], push);
        }
        frame.dispatch("probe_mips", [mip_cells(view.tiles.into()).div_ceil(64), 1, 1], ());
        if has_past {
            frame.dispatch("probe_carry", [x, y, PROBE_LAYERS], push);
        }
        frame.dispatch("probe_trace", [x, y, PROBE_LAYERS], push);
    }
    let groups = [view.size[0].div_ceil(8), view.size[1].div_ceil(8), 1];
    frame.dispatch(resolve_pass(view.near_field >= 0.0, watches, output_float32), groups, push);
    // Without an average over time each frame stands for itself.
    if view.pixel_rays == 0 && view.history_max > 1 {
        frame.dispatch(disocclusion_pass(output_float32), groups, push);
    }
}

/// Cells of all mips of so many tiles of probes.
pub fn mip_cells(tiles: UVec2) -> u32 {
    (1..=PROBE_MIPS).map(|level| tiles.map(|side| side.div_ceil(1 << level)).element_product()).sum()
}

/// The pass that interpolates probes.
fn resolve_pass(near_field: bool, watches: bool, output_float32: bool) -> &'static str {
    let [half, float32] = match (near_field, watches) {
        (true, false) => ["resolve", "resolve_float32"],
        (true, true) => ["resolve_watching", "resolve_watching_float32"],
        (false, false) => ["resolve_far", "resolve_far_float32"],
        (false, true) => ["resolve_far_watching", "resolve_far_watching_float32"],
    };
    if output_float32 { float32 } else { half }
}

fn disocclusion_pass(output_float32: bool) -> &'static str {
    if output_float32 { "disocclusion_float32" } else { "disocclusion" }
}

/// The passes that write an output of this format, whatever comes.
pub fn output_passes(near_field: bool, output_float32: bool) -> [&'static str; 3] {
    let [resting, watching] = [false, true].map(|watches| resolve_pass(near_field, watches, output_float32));
    [resting, watching, disocclusion_pass(output_float32)]
}

/// What the output shows instead; goes after [`gather`].
pub fn debug_view(frame: &mut Frame, view: &View, shown: DebugView, output_float32: bool) {
    let groups = [view.size[0].div_ceil(8), view.size[1].div_ceil(8), 1];
    frame.dispatch(debug_pass(output_float32), groups, DebugPush { shown: shown as u32 });
}

/// What the host would draw; goes last. `shown`: the output is a debug view.
pub fn composite(frame: &mut Frame, view: &View, shown: bool, output_float32: bool) {
    let groups = [view.size[0].div_ceil(8), view.size[1].div_ceil(8), 1];
    let push = CompositePush {
        origin: view.origin,
        size: view.size,
        shows_output: u32::from(shown),
        ..CompositePush::default()
    };
    frame.dispatch(composite_pass(output_float32), groups, push);
}

/// The pass that makes it.
pub fn composite_pass(output_float32: bool) -> &'static str {
    if output_float32 { "composite_float32" } else { "composite" }
}

/// The pass that shows it.
pub fn debug_pass(output_float32: bool) -> &'static str {
    if output_float32 { "debug_view_float32" } else { "debug_view" }
}
