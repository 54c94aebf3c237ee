//! # brickgi
//!
//! Real-time diffuse global illumination for engines that already exist: the host hands over Vulkan handles, meshes,
//! lights, a camera and, each frame, a command buffer with a G-buffer; the library records compute work into it and
//! gives back indirect irradiance. No baking, no ray-tracing hardware.
//!
//! ## The idea
//!
//! The world is a sparse grid of bricks of 8 x 8 x 8 voxels. Each side of a voxel that holds surface stores the mean
//! plane of that surface and a 4 x 4 mask of where it lies; a ray hits a voxel where it crosses such a plane inside its
//! mask. Each face that can be seen stores the radiance it sends out. Faces light each other, a few rays a frame:
//! bounces without end over time. Screen probes gather that radiance, and each pixel interpolates probes.
//!
//! ## The frame
//!
//! [`Context::dispatch`] makes a list of passes as plain data, which one player records:
//!
//! | group | passes |
//! |---|---|
//! | bricks | `brick_compact`, `brick_commit`, `grid_update`, `voxel_mark`, `voxelize`, `face_resolve` |
//! | lighting | `face_compact`, then `light_direct`, `light_bounce`, `light_store` for each sweep |
//! | probes | `probe_reproject`, `probe_place`, `probe_adapt`, `probe_ration`, `probe_mips`, `probe_carry`, `probe_trace` |
//! | resolve | `resolve`, `disocclusion`, `composite` |
//!
//! ## The folders
//!
//! | where | what |
//! |---|---|
//! | `context.rs` | owns the state: create, update, record, report |
//! | `settings.rs` | quality knobs with unit, range and default |
//! | `scene/` | what the host said: meshes, instances, materials, lights, sky, cameras |
//! | `bricks/` | which bricks exist, where they lie in memory, which are next; CPU only |
//! | `world/`, `view.rs` | the world's and a view's part of a frame, and their memory on the GPU |
//! | `parallel.rs` | work on the host's threads |
//! | `frame.rs` | the frame as a list |
//! | `passes/` | what goes into the list: inputs, shader, extent |
//! | `gpu/` | every Vulkan call: device, memory, pipelines, player, timestamps |
//! | `capi/` | the C ABI |
//! | `twin/` | CPU twins of the shaders and the tests that hold both together |
//! | `../shaders/` | `passes/` one file a pass, `lib/` shared code, `shared/` structs that both sides see, `tests/` |
//!
//! `ARCHITECTURE.md` has the data layout, the rules and the reasons.

mod bricks;
pub mod capi;
mod context;
mod error;
mod frame;
mod gpu;
mod parallel;
mod passes;
pub mod scene;
mod settings;
#[cfg(test)]
mod twin;
mod view;
mod world;

pub use context::{
    Composite, Context, ContextDesc, DebugView, DeviceHandles, DeviceRequirements, FrameInputs, Motion, PassTime,
    ResourceSize, Stats, ViewId,
};
pub use error::{Error, Result};
pub use parallel::ParallelFor;
pub use settings::{HitModel, Preset, Settings};
