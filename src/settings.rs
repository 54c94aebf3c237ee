//! Quality knobs: unit, range, default, and what each costs.

use crate::error::{Error, Result};

/// How a ray hits an occupied voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum HitModel {
    /// Where it crosses a stored face plane inside that face's coverage mask (accurate; default).
    Plane = 0,
    /// Where it enters the voxel's cube, as in the SIGGRAPH 2024 talk (kept for comparison).
    Cube = 1,
}

/// Named points on the speed/accuracy curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Preset {
    /// Fewest rays: phones at 60 Hz.
    Low = 0,
    /// The default.
    Medium = 1,
    /// More rays everywhere: desktop.
    High = 2,
    /// For screenshots and comparisons.
    Ultra = 3,
}

/// Settings of a context. Fixed at creation unless said otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Edge of a voxel in metres, 0.01 to 4; default 0.5. Memory and ray steps grow as it shrinks.
    pub voxel_size: f32,
    /// Shift of the voxel grid against the world's origin, in voxels per axis; default 0.
    pub grid_offset: [f32; 3],
    /// World covered, in groups of 32 voxels per axis; powers of two, 1 to 64; default 32 x 8 x 32
    /// (512 x 128 x 512 m at 0.5 m, Y up). Costs 16 bytes a group.
    pub coverage_groups: [u32; 3],
    /// Upper limit of the world's device memory in bytes, at least 1 MiB; default 28 MiB. Holds in every frame: what does
    /// not fit is left out, the farthest first. Textures, materials, `coverage_groups` and `frames_in_flight` must leave
    /// room for a brick.
    pub memory_budget: u64,
    /// Bricks voxelised a frame while any are waiting, 1 to 4096; default 512. Fewer where a sixteenth of
    /// `memory_budget` (8 MiB at most), set aside for this, does not suffice. Costs nothing when none waits.
    pub voxelize_bricks_per_frame: u32,
    /// Milliseconds of GPU time that voxelisation may take a frame, 0 to 1000; default 0: no limit. From the timestamps of
    /// earlier frames, bricks are handed to the GPU as far as they will fit, one at least and
    /// `voxelize_bricks_per_frame` at most. Without effect where the device has no timestamps.
    pub voxelize_ms: f32,
    /// By how much dense meshes may be simplified, in voxels, 0 to 1; default 0: not at all. 0.1 suits meshes with many
    /// triangles a voxel. Triangles that voxels cannot tell apart are merged in the call that brings a mesh's first
    /// instance, for the largest scale of its instances, and anew when a larger one comes. What the host handed over is
    /// kept beside what is left.
    pub simplify_voxels: f32,
    /// Voxel faces lit a frame, 64 to 4 194 240; default 131 072. The main cost of lighting. At most what an eighth of
    /// `memory_budget` holds at 12 bytes a face. A brick with more of them (3 072 at most) is lit alone.
    pub light_faces_per_frame: u32,
    /// Hemisphere rays a face shoots per lighting update, 0 to 64; default 4. 0 turns radiosity off.
    pub bounce_rays: u32,
    /// Whether these rays find light that comes straight from lights, sky and emitters alone; default false: light of any
    /// number of bounces. Costs a shadow ray more for each that hits, towards one of the lights, drawn evenly.
    pub single_bounce: bool,
    /// Shadow samples a face and light takes per lighting update, 1 to 16; default 2.
    pub direct_samples: u32,
    /// Lights that each of these samples asks at most, 1 to 4096; default 4. Of more, it asks some by chance, the more often
    /// the more they bring: the mean is the same, and a face costs `direct_samples` times `direct_lights` rays at most.
    pub direct_lights: u32,
    /// How a ray hits a voxel; default [`HitModel::Plane`].
    pub hit_model: HitModel,
    /// Pixels along the edge of a screen-probe tile: 8, 16 or 32; default 16.
    pub probe_tile: u32,
    /// Frames in which a screen probe that has been carried along, and a pixel that has been seen for long, look once: 1, 2
    /// or 4; default 4, one of each two by two. What has not been seen for long looks in every frame.
    pub gather_interval: u32,
    /// Screen probes of a view that look in a frame at most, 64 rays each, 0 to 1 048 576; default 0: no limit. Where more
    /// want to, tiles that would have no probe come first, and what is put off keeps what it saw before; pixels without a
    /// probe take those of tiles around. A 256th of them more may look, so that each comes to its turn.
    pub probes_per_frame: u32,
    /// Whether each pixel looks for what stands within two voxels of it, and for what hides its probes' light within 16:
    /// contact shadows; default true. Up to two short rays a pixel, the larger part of what the gather costs.
    pub near_field: bool,
    /// Frames that the full-resolution temporal filter averages at most while the world is at rest, 1 to 1024; default 256.
    /// 1 turns it off, for hosts with one of their own: each frame stands for itself, and pixels borrow from no neighbours.
    pub temporal_frames: u32,
    /// Rays that each pixel shoots into the world, 0 to 1024, instead of using probes; default 0: probes. The reference
    /// that probes are judged against; costs `width * height * pixel_rays` rays a frame.
    pub pixel_rays: u32,
    /// Whether faces that neither light nor eye can reach go without light of their own while the world does not fit into
    /// `memory_budget` otherwise; default false.
    pub region_culling: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            voxel_size: 0.5,
            grid_offset: [0.0; 3],
            coverage_groups: [32, 8, 32],
            memory_budget: 28 << 20,
            voxelize_bricks_per_frame: 512,
            voxelize_ms: 0.0,
            simplify_voxels: 0.0,
            light_faces_per_frame: 131_072,
            bounce_rays: 4,
            single_bounce: false,
            direct_samples: 2,
            direct_lights: 4,
            hit_model: HitModel::Plane,
            probe_tile: 16,
            gather_interval: 4,
            probes_per_frame: 0,
            near_field: true,
            temporal_frames: 256,
            pixel_rays: 0,
            region_culling: false,
        }
    }
}

impl Settings {
    /// The settings of a preset; everything it does not name is the default.
    pub fn preset(preset: Preset) -> Self {
        let base = Self::default();
        match preset {
            Preset::Low => Self { bounce_rays: 2, light_faces_per_frame: 32_768, probe_tile: 32, ..base },
            Preset::Medium => base,
            Preset::High => Self { bounce_rays: 8, light_faces_per_frame: 262_144, probe_tile: 8, ..base },
            Preset::Ultra => {
                Self { bounce_rays: 16, light_faces_per_frame: 1 << 20, probe_tile: 8, temporal_frames: 1024, ..base }
            }
        }
    }

    /// Checks every field against its range.
    pub fn validate(&self) -> Result<()> {
        let in_range = |ok: bool, text: &str| if ok { Ok(()) } else { Err(Error::invalid(text)) };
        in_range((0.01..=4.0).contains(&self.voxel_size), "voxel_size must be 0.01 to 4 metres")?;
        in_range(
            self.grid_offset.iter().all(|v| v.is_finite() && v.abs() <= 1024.0),
            "grid_offset must be finite and within 1024 voxels",
        )?;
        in_range(
            self.coverage_groups.iter().all(|g| g.is_power_of_two() && *g <= 64),
            "coverage_groups must be powers of two, 1 to 64",
        )?;
        in_range(self.memory_budget >= 1 << 20, "memory_budget must be at least 1 MiB")?;
        in_range((1..=4096).contains(&self.voxelize_bricks_per_frame), "voxelize_bricks_per_frame must be 1 to 4096")?;
        in_range((0.0..=1000.0).contains(&self.voxelize_ms), "voxelize_ms must be 0 to 1000")?;
        in_range((0.0..=1.0).contains(&self.simplify_voxels), "simplify_voxels must be 0 to 1")?;
        in_range(
            (64..=4_194_240).contains(&self.light_faces_per_frame),
            "light_faces_per_frame must be 64 to 4194240",
        )?;
        in_range(self.bounce_rays <= 64, "bounce_rays must be 0 to 64")?;
        in_range((1..=16).contains(&self.direct_samples), "direct_samples must be 1 to 16")?;
        in_range((1..=4096).contains(&self.direct_lights), "direct_lights must be 1 to 4096")?;
        in_range(matches!(self.probe_tile, 8 | 16 | 32), "probe_tile must be 8, 16 or 32")?;
        in_range(matches!(self.gather_interval, 1 | 2 | 4), "gather_interval must be 1, 2 or 4")?;
        in_range(self.probes_per_frame <= 1 << 20, "probes_per_frame must be 0 to 1048576")?;
        in_range((1..=1024).contains(&self.temporal_frames), "temporal_frames must be 1 to 1024")?;
        in_range(self.pixel_rays <= 1024, "pixel_rays must be 0 to 1024")
    }
}
