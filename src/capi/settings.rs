//! Quality knobs.

use super::guard::{Failure, guard};
use super::input::{self, Structure, structure_types};
use super::types::*;
use crate::settings::{HitModel, Preset, Settings};
use std::ffi::c_void;

/// A named point on the speed/accuracy curve: one of BGI_PRESET_*.
pub type BgiPreset = u32;
/// Fewest rays: phones at 60 Hz.
pub const BGI_PRESET_LOW: BgiPreset = 0;
/// The default.
pub const BGI_PRESET_MEDIUM: BgiPreset = 1;
/// More rays everywhere: desktop.
pub const BGI_PRESET_HIGH: BgiPreset = 2;
/// For screenshots and comparisons.
pub const BGI_PRESET_ULTRA: BgiPreset = 3;

/// How a ray hits an occupied voxel: one of BGI_HIT_MODEL_*.
pub type BgiHitModel = u32;
/// Where it crosses a stored face plane inside that face's coverage mask. Accurate; the default.
pub const BGI_HIT_MODEL_PLANE: BgiHitModel = 0;
/// Where it enters the voxel's cube. Kept for comparison.
pub const BGI_HIT_MODEL_CUBE: BgiHitModel = 1;

/// Settings of a context, fixed at its creation. Fill it with bgiGetDefaultSettings, then change what you must.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiSettings {
    /// BGI_STRUCTURE_TYPE_SETTINGS
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// Edge of a voxel in metres, 0.01 to 4; default 0.5. Memory and ray steps grow as it shrinks.
    pub voxel_size: f32,
    /// Shift of the voxel grid against the world's origin, in voxels per axis, -1024 to 1024; default 0.
    pub grid_offset: [f32; 3],
    /// World covered, in groups of 32 voxels per axis; powers of two, 1 to 64; default 32 x 8 x 32 (512 x 128 x 512 m
    /// at 0.5 m, Y up). Costs 16 bytes a group.
    pub coverage_groups: [u32; 3],
    /// Bricks voxelised a frame while any are waiting, 1 to 4096; default 512. Fewer where a sixteenth of
    /// memoryBudget (8 MiB at most), set aside for this, does not suffice. Costs nothing when none waits.
    pub voxelize_bricks_per_frame: u32,
    /// Upper limit of the world's device memory in bytes, at least 1 MiB; default 28 MiB. Holds in every frame: what does
    /// not fit is left out, the farthest first (BGI_WARNING_WORLD_INCOMPLETE). Textures, materials, coverageGroups and
    /// framesInFlight must leave room for a brick, else BGI_ERROR_OUT_OF_MEMORY.
    pub memory_budget: u64,
    /// Voxel faces lit a frame, 64 to 4194240; default 131072. The main cost of lighting. At most what an eighth of
    /// memoryBudget holds at 12 bytes a face. A brick with more of them (3072 at most) is lit alone.
    pub light_faces_per_frame: u32,
    /// Hemisphere rays a face shoots per lighting update, 0 to 64; default 4. 0 turns radiosity off.
    pub bounce_rays: u32,
    /// Shadow samples a face and light takes per lighting update, 1 to 16; default 2.
    pub direct_samples: u32,
    /// How a ray hits a voxel; default BGI_HIT_MODEL_PLANE.
    pub hit_model: BgiHitModel,
    /// Pixels along the edge of a screen-probe tile: 8, 16 or 32; default 16.
    pub probe_tile: u32,
    /// Frames that the full-resolution temporal filter averages at most while the world is at rest, 1 to 1024; default 256.
    /// 1 turns it off, for hosts with one of their own: each frame stands for itself, and pixels borrow from no neighbours.
    pub temporal_frames: u32,
    /// Rays that each pixel shoots into the world, 0 to 1024, instead of using probes; default 0: probes. The reference
    /// that probes are judged against; costs width * height * pixelRays rays a frame.
    pub pixel_rays: u32,
    /// Milliseconds of GPU time that voxelisation may take a frame, 0 to 1000; default 0: no limit. From the timestamps of
    /// earlier frames, bricks are handed to the GPU as far as they will fit, one at least and voxelizeBricksPerFrame at
    /// most. Without effect where the device has no timestamps.
    pub voxelize_ms: f32,
    /// 1: faces that neither light nor eye can reach go without light of their own while the world does not fit into
    /// memoryBudget otherwise. 0: never; the default.
    pub region_culling: u32,
    /// By how much dense meshes may be simplified, in voxels, 0 to 1; default 0: not at all. 0.1 suits meshes with many
    /// triangles a voxel. Triangles that voxels cannot tell apart are merged in the call that brings a mesh's first
    /// instance, for the largest scale of its instances, and anew when a larger one comes. What the host handed over is
    /// kept beside what is left.
    pub simplify_voxels: f32,
    /// Lights that each of a face's directSamples asks at most, 1 to 4096; default 4. Of more, it asks some by chance, the
    /// more often the more they bring: the mean is the same, and a face costs directSamples times directLights rays at most.
    pub direct_lights: u32,
    /// 1: bounceRays find light that comes straight from lights, sky and emitters alone. Costs a shadow ray more for each
    /// that hits, towards one of the lights, drawn evenly. 0: light of any number of bounces; the default.
    pub single_bounce: u32,
    /// Frames in which a screen probe that has been carried along, and a pixel that has been seen for long, look once: 1, 2
    /// or 4; default 4, one of each two by two. What has not been seen for long looks in every frame.
    pub gather_interval: u32,
    /// 1: each pixel looks for what stands within two voxels of it, and for what hides its probes' light within 16: contact
    /// shadows. Up to two short rays a pixel, the larger part of what the gather costs. 0: it takes what probes say.
    /// Default 1.
    pub near_field: u32,
    /// Screen probes of a view that look in a frame at most, 64 rays each, 0 to 1 048 576. Where more want to, tiles that would
    /// have no probe come first, and what is put off keeps what it saw before; pixels without a probe take those of tiles
    /// around. A 256th of them more may look, so that each comes to its turn. 0: no limit; the default.
    pub probes_per_frame: u32,
}

structure_types! { BgiSettings = BGI_STRUCTURE_TYPE_SETTINGS }

impl From<Settings> for BgiSettings {
    fn from(from: Settings) -> Self {
        Self {
            s_type: Self::TYPE,
            p_next: std::ptr::null(),
            voxel_size: from.voxel_size,
            grid_offset: from.grid_offset,
            coverage_groups: from.coverage_groups,
            voxelize_bricks_per_frame: from.voxelize_bricks_per_frame,
            memory_budget: from.memory_budget,
            light_faces_per_frame: from.light_faces_per_frame,
            bounce_rays: from.bounce_rays,
            direct_samples: from.direct_samples,
            hit_model: from.hit_model as u32,
            probe_tile: from.probe_tile,
            temporal_frames: from.temporal_frames,
            pixel_rays: from.pixel_rays,
            voxelize_ms: from.voxelize_ms,
            region_culling: from.region_culling.into(),
            simplify_voxels: from.simplify_voxels,
            direct_lights: from.direct_lights,
            single_bounce: from.single_bounce.into(),
            gather_interval: from.gather_interval,
            near_field: from.near_field.into(),
            probes_per_frame: from.probes_per_frame,
        }
    }
}

impl BgiSettings {
    /// Ranges are checked by [`Settings::validate`]; only what a Rust type cannot hold is refused here.
    pub(super) fn settings(&self) -> Result<Settings, Failure> {
        Ok(Settings {
            voxel_size: self.voxel_size,
            grid_offset: self.grid_offset,
            coverage_groups: self.coverage_groups,
            memory_budget: self.memory_budget,
            voxelize_bricks_per_frame: self.voxelize_bricks_per_frame,
            light_faces_per_frame: self.light_faces_per_frame,
            bounce_rays: self.bounce_rays,
            single_bounce: input::flag(self.single_bounce, "singleBounce")?,
            direct_samples: self.direct_samples,
            direct_lights: self.direct_lights,
            hit_model: match self.hit_model {
                BGI_HIT_MODEL_PLANE => HitModel::Plane,
                BGI_HIT_MODEL_CUBE => HitModel::Cube,
                other => return Err(Failure::argument(format!("hitModel: {other} is no BGI_HIT_MODEL_*"))),
            },
            probe_tile: self.probe_tile,
            temporal_frames: self.temporal_frames,
            pixel_rays: self.pixel_rays,
            voxelize_ms: self.voxelize_ms,
            region_culling: input::flag(self.region_culling, "regionCulling")?,
            simplify_voxels: self.simplify_voxels,
            gather_interval: self.gather_interval,
            near_field: input::flag(self.near_field, "nearField")?,
            probes_per_frame: self.probes_per_frame,
        })
    }
}

/// Fills the settings of a preset. `settings` must have its sType set and pNext NULL; the rest is overwritten.
///
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_ARGUMENT or BGI_ERROR_INVALID_STRUCTURE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiGetDefaultSettings(preset: BgiPreset, settings: *mut BgiSettings) -> BgiResult {
    guard(|| {
        // SAFETY: the header asks for a writable struct with its head filled in.
        let out = unsafe { input::structure_mut(settings)? };
        let preset = match preset {
            BGI_PRESET_LOW => Preset::Low,
            BGI_PRESET_MEDIUM => Preset::Medium,
            BGI_PRESET_HIGH => Preset::High,
            BGI_PRESET_ULTRA => Preset::Ultra,
            other => return Err(Failure::argument(format!("preset: {other} is no BGI_PRESET_*"))),
        };
        *out = Settings::preset(preset).into();
        Ok(BGI_SUCCESS)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_survive_the_boundary() {
        for preset in [Preset::Low, Preset::Medium, Preset::High, Preset::Ultra] {
            let settings = Settings {
                hit_model: HitModel::Cube,
                grid_offset: [0.1, 0.2, 0.3],
                voxelize_ms: 1.5,
                region_culling: preset == Preset::Low,
                ..Settings::preset(preset)
            };
            let back = BgiSettings::from(settings.clone()).settings().unwrap();
            assert_eq!(settings, back);
        }
    }
}
