//! # brickgi
//!
//! Real-time diffuse global illumination for engines that already exist: the host hands over Vulkan handles, meshes,
//! lights, a camera and, each frame, a command buffer with a G-buffer; the library records compute work into it and
//! gives back indirect irradiance. No baking, no ray-tracing hardware.

mod bricks;
pub mod capi;
mod context;
mod error;
mod frame;
mod gpu;
mod passes;
pub mod scene;
mod settings;
#[cfg(test)]
mod twin;
mod view;
mod world;

pub use context::{
    Context, ContextDesc, DeviceHandles, DeviceRequirements, FrameInputs, PassTime, ResourceSize, Stats, ViewId,
};
pub use error::{Error, Result};
pub use settings::{HitModel, Preset, Settings};
