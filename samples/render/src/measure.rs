//! Runs the frames and takes the medians of the settled second half.

use brickgi::Stats;
use brickgi_host::{Host, Result};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::time::Instant;

/// Milliseconds of one pass.
#[derive(Serialize, Clone, Debug)]
pub struct PassMs {
    pub name: &'static str,
    pub ms: f64,
}

/// What was measured on the way: medians over the second half of the frames, in milliseconds, and a maximum.
#[derive(Serialize, Clone, Debug, Default)]
pub struct Timing {
    /// GPU time of brickgi's whole recording.
    pub frame_ms: f64,
    /// GPU time by pass, in recording order.
    pub passes: Vec<PassMs>,
    /// CPU time of the dispatch call.
    pub cpu_ms: f64,
    /// Most bytes that brickgi's world held in any frame.
    pub peak_world_bytes: u64,
    /// Wall time of all frames in seconds.
    #[serde(skip)]
    pub wall_seconds: f64,
}

/// A bar for so many frames; a message can say what is worth knowing.
pub fn progress(frames: u32) -> ProgressBar {
    let bar = ProgressBar::new(u64::from(frames));
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {eta} left{msg}") {
        bar.set_style(style);
    }
    bar
}

/// Renders `frames` frames under a progress bar.
pub fn run(host: &mut Host, frames: u32) -> Result<Timing> {
    let bar = progress(frames);
    let start = Instant::now();
    let (mut settled, mut peak_world_bytes) = (Vec::new(), 0);
    for frame in 0..frames {
        host.frame()?;
        peak_world_bytes = peak_world_bytes.max(host.stats().world_bytes);
        if frame >= frames / 2 {
            settled.push(host.stats().clone());
        }
        bar.set_message(format!(", {:.2} ms", host.stats().frame_ms));
        bar.inc(1);
    }
    host.wait_idle()?;
    bar.finish_and_clear();
    Ok(Timing { peak_world_bytes, wall_seconds: start.elapsed().as_secs_f64(), ..medians(&settled) })
}

fn medians(frames: &[Stats]) -> Timing {
    let over = |value: &dyn Fn(&Stats) -> Option<f64>| median(frames.iter().filter_map(value).collect());
    let names = frames.last().map_or(&[][..], |stats| &stats.passes);
    let pass = |name: &'static str| PassMs {
        name,
        ms: over(&|stats| stats.passes.iter().find(|p| p.name == name).map(|p| p.ms)),
    };
    Timing {
        frame_ms: over(&|stats| Some(stats.frame_ms)),
        passes: names.iter().map(|p| pass(p.name)).collect(),
        cpu_ms: over(&|stats| Some(stats.cpu_ms)),
        ..Timing::default()
    }
}

/// The middle value, the mean of the two middle ones, or 0 for none.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => (values[n / 2 - 1] + values[n / 2]) / 2.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_takes_the_middle() {
        assert_eq!([median(vec![]), median(vec![3.0, 1.0, 2.0]), median(vec![4.0, 1.0])], [0.0, 2.0, 2.5]);
    }
}
