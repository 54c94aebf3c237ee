//! # brickgi
//!
//! Real-time diffuse global illumination for engines that already exist.

pub mod capi;
mod context;
mod error;
pub mod scene;
mod settings;

pub use context::{
    Context, ContextDesc, DeviceHandles, DeviceRequirements, FrameInputs, PassTime, ResourceSize, Stats, ViewId,
};
pub use error::{Error, Result};
pub use settings::{HitModel, Preset, Settings};
