//! A line of `frames.csv`.

use brickgi::Stats;
use serde::Serialize;

/// How the names of passes that gather light for pixels begin.
const GATHER_PASSES: [&str; 3] = ["probe_", "resolve", "disocclusion"];

/// One frame; the fields are the columns.
#[derive(Serialize, Clone, Debug, Default)]
pub struct Row {
    pub frame: u32,
    pub time_s: f64,
    /// Position of the camera in metres.
    pub camera_x: f64,
    pub camera_y: f64,
    pub camera_z: f64,
    /// Instances added, moved or removed before the frame.
    pub instances_changed: usize,
    pub bricks: u32,
    pub bricks_missing: u32,
    pub bricks_missing_in_view: u32,
    pub bricks_left_out: u32,
    pub bricks_voxelized: u32,
    pub faces: u32,
    pub world_bytes: u64,
    /// GPU time of all passes, and of groups of them; 0 without timestamps.
    pub gpu_ms: f64,
    /// `voxel_mark`, `voxelize`, `face_resolve`.
    pub voxelize_ms: f64,
    /// `brick_compact`, `brick_commit`, `grid_update`.
    pub commit_ms: f64,
    /// `face_compact`, `light_direct`, `light_bounce`, `light_store`.
    pub lighting_ms: f64,
    /// `probe_place`, `probe_trace`, `resolve`.
    pub gather_ms: f64,
    /// CPU time of telling which instances have changed.
    pub update_ms: f64,
    /// CPU time of the dispatch call.
    pub cpu_ms: f64,
    /// Mean luminance of E_ind over the pixels that see a surface.
    pub mean_indirect: f64,
}

impl Row {
    /// Takes over what the context holds and what the call took on the CPU.
    pub fn set_world(&mut self, stats: &Stats) {
        self.bricks = stats.bricks;
        self.bricks_missing = stats.bricks_missing;
        self.bricks_missing_in_view = stats.bricks_missing_in_view;
        self.bricks_left_out = stats.bricks_left_out;
        self.bricks_voxelized = stats.bricks_voxelized;
        self.faces = stats.faces;
        self.world_bytes = stats.world_bytes;
        self.cpu_ms = stats.cpu_ms;
    }

    /// Completes the row by the GPU's times, which arrive some frames later.
    pub fn set_gpu_times(&mut self, stats: &Stats) {
        self.gpu_ms = stats.frame_ms;
        for pass in &stats.passes {
            let group = match pass.name {
                "voxel_mark" | "voxelize" | "face_resolve" => &mut self.voxelize_ms,
                "brick_compact" | "light_carry" | "brick_commit" | "grid_update" => &mut self.commit_ms,
                name if name.starts_with("face_") || name.starts_with("light_") => &mut self.lighting_ms,
                name if GATHER_PASSES.iter().any(|pass| name.starts_with(pass)) => &mut self.gather_ms,
                _ => continue,
            };
            *group += pass.ms;
        }
        self.round();
    }

    /// To six decimals: what is beyond is binary fractions written out.
    fn round(&mut self) {
        let times = [&mut self.time_s, &mut self.gpu_ms, &mut self.voxelize_ms, &mut self.commit_ms];
        let more = [&mut self.lighting_ms, &mut self.gather_ms, &mut self.update_ms, &mut self.cpu_ms];
        let rest = [&mut self.camera_x, &mut self.camera_y, &mut self.camera_z, &mut self.mean_indirect];
        times.into_iter().chain(more).chain(rest).for_each(|value| *value = (*value * 1e6).round() / 1e6);
    }
}
