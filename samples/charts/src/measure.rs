//! What is measured, as tables.

use crate::field::{Cost, Field};
use anyhow::Result;
use brickgi::Settings;
use brickgi_host::Host;
use std::time::Duration;

/// Frames that a median is taken over.
const FRAMES: usize = 24;
/// The passes that turn triangles into bricks.
const VOXELIZE_PASSES: [&str; 3] = ["voxel_mark", "voxelize", "face_resolve"];
/// Boxes that move in each frame.
const MOVING: usize = 100;

/// Columns of numbers over a first one; all are charted.
pub struct Table {
    pub title: &'static str,
    /// Of the first column, then of the others.
    pub columns: Vec<&'static str>,
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    /// Enters a value in a row of which there may be others already; what nobody enters is not a number.
    pub fn put(&mut self, across: f64, column: usize, value: f64) {
        let at = self.rows.partition_point(|row| row[0] < across);
        if self.rows.get(at).is_none_or(|row| row[0] != across) {
            let mut row = vec![f64::NAN; self.columns.len()];
            row[0] = across;
            self.rows.insert(at, row);
        }
        self.rows[at][column] = value;
    }

    pub fn csv(&self) -> String {
        let cell = |v: &f64| if v.is_nan() { String::new() } else { format!("{v:.6}") };
        let line = |row: &Vec<f64>| row.iter().map(cell).collect::<Vec<_>>().join(",");
        let rows = self.rows.iter().map(line);
        std::iter::once(self.columns.join(",")).chain(rows).map(|l| l + "\n").collect()
    }
}

/// Default settings, but rays: they are the GPU's, and not what is measured.
fn settings() -> Settings {
    Settings { bounce_rays: 0, ..Settings::default() }
}

/// CPU milliseconds against instances, 10 to `most` by factors of 10: a frame in which nothing changes, one in which
/// light still settles, one in which [`MOVING`] boxes move (or all, where there are fewer), and all that it takes to load.
pub fn instances(most: usize) -> Result<Table> {
    let columns = vec!["instances", "settled_ms", "settling_ms", "moving_update_ms", "moving_dispatch_ms", "load_ms"];
    let mut table = Table { title: "CPU time against instances", columns, rows: Vec::new() };
    let mut count = 10;
    while count <= most {
        let (mut field, load) = Field::new(count, 400.0 / (count as f64).sqrt(), settings())?;
        let settling = median((0..FRAMES).map(|_| field.frame()).collect::<Result<_>>()?);
        while field.stats().convergence < 1.0 {
            field.frame()?;
        }
        let settled = median((0..FRAMES).map(|_| field.frame()).collect::<Result<_>>()?);
        let moving: Vec<Cost> = (0..FRAMES).map(|_| field.step(MOVING.min(count))).collect::<Result<_>>()?;
        let update = median(moving.iter().map(|c| c.update).collect());
        let dispatch = median(moving.iter().map(|c| c.dispatch).collect());
        let row = vec![count as f64, settled, settling, update, dispatch, milliseconds(load.update + load.dispatch)];
        println!("{count} instances: {:?} = {row:.3?}; {} bricks", &table.columns[1..], field.stats().bricks);
        table.rows.push(row);
        count *= 10;
    }
    Ok(table)
}

/// Bricks voxelised, GPU and CPU milliseconds against bricks that change at once, 1 to `most` by factors of 4. Each box
/// stands alone in a brick.
pub fn bricks(most: usize) -> Result<Table> {
    let columns = vec!["bricks_changed", "bricks_voxelized", "gpu_ms", "cpu_ms"];
    let mut table = Table { title: "Work against bricks changed", columns, rows: Vec::new() };
    let brick = 8.0 * f64::from(Settings::default().voxel_size);
    let (mut field, _) = Field::new(4096, brick, settings())?;
    let mut changed = 1;
    while changed <= most.min(4096) {
        let mut work = [0.0; 3];
        let mut add = |field: &Field, cost: Cost| {
            let passes = field.stats().passes.iter().filter(|p| VOXELIZE_PASSES.contains(&p.name));
            let gpu: f64 = passes.map(|p| p.ms).sum();
            let voxelized = field.stats().bricks_voxelized;
            work = [work[0] + f64::from(voxelized), work[1] + gpu, work[2] + milliseconds(cost.update + cost.dispatch)];
            voxelized > 0
        };
        let cost = field.step(changed)?;
        add(&field, cost);
        // Times arrive as many frames later as frames are in flight.
        let mut quiet = 0;
        while quiet < 4 {
            let dispatch = field.frame()?;
            quiet = if add(&field, Cost { dispatch, ..Cost::default() }) { 0 } else { quiet + 1 };
        }
        let row = vec![changed as f64, work[0], work[1], work[2]];
        println!("{changed} bricks change: {:?} = {row:.3?}", &table.columns[1..]);
        table.rows.push(row);
        changed *= 4;
    }
    Ok(table)
}

/// Frames until the world is loaded.
pub fn settle(host: &mut Host) -> Result<()> {
    let mut quiet = 0;
    while quiet < 8 {
        host.frame()?;
        quiet = if host.stats().bricks_missing == host.stats().bricks_left_out { quiet + 1 } else { 0 };
    }
    Ok(())
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    milliseconds(times[times.len() / 2])
}
