//! `stats.json` and the summary for people.

use crate::measure::Timing;
use brickgi::{Settings, Stats};
use brickgi_host::metrics::Score;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};

/// Everything a run says, in the words of `stats.json`. Scores are null without a truth or where it is zero.
#[derive(Serialize)]
pub struct Report {
    pub scene: String,
    pub camera: String,
    pub size: [u32; 2],
    pub frames: u32,
    pub device: String,
    #[serde(flatten)]
    pub timing: Timing,
    pub wall_seconds: f64,
    #[serde(flatten)]
    pub world: World,
    #[serde(rename = "relMSE")]
    pub rel_mse: Option<f64>,
    pub nrmse: Option<f64>,
    pub bias: Option<f64>,
    /// Mean luminance of E_ind over the seen pixels.
    pub mean: f64,
    pub max_abs: Option<f64>,
    pub reference_noise: Option<f64>,
    /// `null`: not run under validation.
    pub validation_messages: Option<usize>,
    pub settings: SettingsEntry,
}

/// What brickgi holds after the last frame.
#[derive(Serialize)]
pub struct World {
    pub world_bytes: u64,
    pub view_bytes: u64,
    pub resources: Vec<Resource>,
    pub bricks: u32,
    pub bricks_missing: u32,
    pub bricks_left_out: u32,
    pub faces: u32,
    pub faces_unreached: u32,
    pub convergence: f32,
    pub pages: u32,
    pub rays: u64,
    /// Screen probes: those that looked; of the frame before, kept; given up for a nearer one; for another surface.
    pub probes_traced: u32,
    pub probes_carried: u32,
    pub probe_conflicts: u32,
    pub probes_rejected: u32,
    pub mesh_triangles: u64,
    pub kept_triangles: u64,
}

/// One device allocation.
#[derive(Serialize)]
pub struct Resource {
    pub name: &'static str,
    pub bytes: u64,
}

/// [`Settings`] in JSON.
#[derive(Serialize)]
pub struct SettingsEntry {
    voxel_size: f32,
    grid_offset: [f32; 3],
    coverage_groups: [u32; 3],
    memory_budget: u64,
    voxelize_bricks_per_frame: u32,
    voxelize_ms: f32,
    simplify_voxels: f32,
    light_faces_per_frame: u32,
    bounce_rays: u32,
    direct_samples: u32,
    single_bounce: bool,
    direct_lights: u32,
    hit_model: String,
    probe_tile: u32,
    gather_interval: u32,
    probes_per_frame: u32,
    near_field: bool,
    temporal_frames: u32,
    pixel_rays: u32,
    region_culling: bool,
}

impl Report {
    /// Takes over the scores against the truth, where there is one.
    pub fn set_score(&mut self, score: &Score) {
        self.rel_mse = score.rel_mse;
        self.nrmse = score.nrmse;
        self.bias = score.bias;
        self.mean = score.mean;
        self.max_abs = Some(score.max_abs);
        self.reference_noise = score.reference_noise;
    }
}

impl From<&Stats> for World {
    fn from(stats: &Stats) -> Self {
        let resource = |r: &brickgi::ResourceSize| Resource { name: r.name, bytes: r.bytes };
        Self {
            world_bytes: stats.world_bytes,
            view_bytes: stats.view_bytes,
            resources: stats.resources.iter().map(resource).collect(),
            bricks: stats.bricks,
            bricks_missing: stats.bricks_missing,
            bricks_left_out: stats.bricks_left_out,
            faces: stats.faces,
            faces_unreached: stats.faces_unreached,
            convergence: stats.convergence,
            pages: stats.pages,
            rays: stats.rays,
            probes_traced: stats.probes_traced,
            probes_carried: stats.probes_carried,
            probe_conflicts: stats.probe_conflicts,
            probes_rejected: stats.probes_rejected,
            mesh_triangles: stats.mesh_triangles,
            kept_triangles: stats.kept_triangles,
        }
    }
}

impl From<&Settings> for SettingsEntry {
    fn from(settings: &Settings) -> Self {
        Self {
            voxel_size: settings.voxel_size,
            grid_offset: settings.grid_offset,
            coverage_groups: settings.coverage_groups,
            memory_budget: settings.memory_budget,
            voxelize_bricks_per_frame: settings.voxelize_bricks_per_frame,
            voxelize_ms: settings.voxelize_ms,
            simplify_voxels: settings.simplify_voxels,
            light_faces_per_frame: settings.light_faces_per_frame,
            bounce_rays: settings.bounce_rays,
            direct_samples: settings.direct_samples,
            single_bounce: settings.single_bounce,
            direct_lights: settings.direct_lights,
            hit_model: format!("{:?}", settings.hit_model).to_lowercase(),
            probe_tile: settings.probe_tile,
            gather_interval: settings.gather_interval,
            probes_per_frame: settings.probes_per_frame,
            near_field: settings.near_field,
            temporal_frames: settings.temporal_frames,
            pixel_rays: settings.pixel_rays,
            region_culling: settings.region_culling,
        }
    }
}

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        let Self { scene, camera, frames, device, .. } = self;
        writeln!(f, "{scene} {camera}, {width} x {height}, {frames} frames in {:.1} s on {device}", self.wall_seconds)?;
        let timing = &self.timing;
        writeln!(f, "  GPU   {:.3} ms a frame, dispatch {:.3} ms on the CPU", timing.frame_ms, timing.cpu_ms)?;
        for pass in &timing.passes {
            writeln!(f, "        {:<24} {:.3} ms", pass.name, pass.ms)?;
        }
        let world = &self.world;
        let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        let (in_world, at_most) = (mib(world.world_bytes), mib(timing.peak_world_bytes));
        writeln!(f, "  world {in_world:.2} MiB, {at_most:.2} at most, {} bricks, {} faces", world.bricks, world.faces)?;
        if world.kept_triangles < world.mesh_triangles {
            writeln!(f, "        {} of {} triangles are kept", world.kept_triangles, world.mesh_triangles)?;
        }
        if world.bricks_missing > 0 {
            let (missing, left_out) = (world.bricks_missing, world.bricks_left_out);
            writeln!(f, "        {missing} bricks are missing, {left_out} of them for lack of memory")?;
        }
        if world.faces_unreached > 0 {
            writeln!(f, "        {} faces are out of reach of light and eye, and not lit", world.faces_unreached)?;
        }
        writeln!(f, "  views {:.2} MiB", mib(world.view_bytes))?;
        match (self.rel_mse, self.nrmse, self.bias) {
            (Some(rel_mse), Some(nrmse), Some(bias)) => {
                write!(f, "  truth relMSE {rel_mse:.5}, NRMSE {nrmse:.4}, bias {:+.2} %", bias * 100.0)
            }
            _ if self.max_abs.is_some() => write!(f, "  truth is zero; ours has mean {:.3e}", self.mean),
            _ => write!(f, "  no truth of this size beside the scene; mean E_ind {:.4}", self.mean),
        }
    }
}
