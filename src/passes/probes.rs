//! Groups "probes" and "resolve": `probe_place`, `probe_trace`, `probe_filter`, `resolve`.

use crate::frame::Frame;
use crate::gpu::shared::{View, ViewPush};

/// The irradiance of every pixel: by screen probes, or by each pixel's own rays.
pub fn gather(frame: &mut Frame, view: &View, frame_index: u32, output_float32: bool) {
    frame.upload.push("view", &[*view]);
    let [x, y] = view.tiles;
    let push = ViewPush { frame_index };
    if view.pixel_rays == 0 {
        frame.dispatch("probe_place", [(x * y).div_ceil(64), 1, 1], push);
        frame.dispatch("probe_trace", [x, y, 1], push);
        frame.dispatch("probe_filter", [(x * y * 9).div_ceil(64), 1, 1], push);
    }
    let resolve = if output_float32 { "resolve_float32" } else { "resolve" };
    frame.dispatch(resolve, [view.size[0].div_ceil(8), view.size[1].div_ceil(8), 1], push);
}
