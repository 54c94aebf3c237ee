//! Renders the frames of a path.

use super::row::Row;
use super::stage::Stage;
use crate::args::Args;
use crate::{lit, mean_over_surfaces, measure, tonemap};
use anyhow::{Context as _, Result, bail};
use brickgi_host::Host;
use std::path::Path;
use std::time::Instant;

/// Plays the whole path into `frame_0000.png` and on, and `frames.csv`, in the folder `out`. Fails for values that are
/// not numbers and for validation messages, after everything was written.
pub fn run(host: &mut Host, mut stage: Stage, args: &Args, out: &Path) -> Result<()> {
    let csv = out.join("frames.csv");
    let cannot = || format!("cannot write {}", csv.display());
    let mut table = csv::Writer::from_path(&csv).with_context(cannot)?;
    let start = Instant::now();
    place(host, &mut stage, 0.0)?;
    let bar = measure::progress(args.settle + stage.frames);
    for _ in 0..args.settle {
        host.frame()?;
        bar.inc(1);
    }
    let (mut rows, mut exposure, mut finite) = (Vec::new(), stage.exposure, true);
    // The GPU's times of a frame are known `lag` frames later: as many are rendered after the last one.
    let lag = args.frames_in_flight;
    for frame in 0..stage.frames + lag {
        let time = stage.time(frame.min(stage.frames - 1));
        let mut row = place(host, &mut stage, time)?;
        host.frame()?;
        if frame < stage.frames {
            row.frame = frame;
            row.set_world(host.stats());
            let indirect = host.read_indirect()?;
            row.mean_indirect = mean_over_surfaces(&indirect, &host.read_depth()?);
            finite &= indirect.is_finite();
            let picture = lit(host, &indirect)?;
            let exposure = *exposure.get_or_insert_with(|| tonemap::exposure(&picture));
            let file = out.join(format!("frame_{frame:04}.png"));
            let saved = tonemap::develop(&picture, exposure).save(&file);
            saved.with_context(|| format!("cannot write {}", file.display()))?;
            rows.push(row);
            bar.inc(1);
        }
        if let Some(row) = frame.checked_sub(lag).and_then(|measured| rows.get_mut(measured as usize)) {
            row.set_gpu_times(host.stats());
            table.serialize(row).and_then(|()| Ok(table.flush()?)).with_context(cannot)?;
        }
    }
    bar.finish_and_clear();
    host.context_mut().take_warnings().iter().for_each(|text| eprintln!("warning: {text}"));
    let (seconds, device) = (start.elapsed().as_secs_f64(), host.device_name());
    println!("{} frames in {seconds:.1} s on {device}\n  files {}", stage.frames, out.display());
    if !finite {
        bail!("an image holds values that are not numbers");
    }
    match &host.validation_messages()[..] {
        [] => Ok(()),
        [first, ..] => bail!("{} validation messages, the first: {first}", host.validation_messages().len()),
    }
}

/// Sets camera and instances as they are at `time` seconds; a row that says so.
fn place(host: &mut Host, stage: &mut Stage, time: f64) -> Result<Row> {
    let camera = stage.camera(time);
    let [camera_x, camera_y, camera_z] = camera.position;
    if camera != *host.camera() {
        host.set_camera(camera)?;
    }
    let changes = stage.changes(time);
    let start = Instant::now();
    if !changes.is_empty() {
        host.update_instances(&changes)?;
    }
    let update_ms = start.elapsed().as_secs_f64() * 1e3;
    Ok(Row {
        time_s: time,
        camera_x,
        camera_y,
        camera_z,
        instances_changed: changes.len(),
        update_ms,
        ..Row::default()
    })
}
