//! The reference host of brickgi: an engine that is not ours.
//!
//! It loads a scene ([`scene`]), rasterises a G-buffer through wgpu-hal, records brickgi into its own command buffer
//! ([`Host`]) and compares the result with the path-traced truth ([`metrics`]). It uses brickgi's public API only,
//! prints nothing, and reports every failure as an [`Error`].

pub mod direct;
mod error;
mod gbuffer;
mod gpu;
mod host;
pub mod image;
pub mod metrics;
mod raster;
mod readback;
pub mod reference;
pub mod scene;
mod shadows;
mod target;
mod upload;
mod validation;

pub use error::{Error, Result};
pub use gpu::Gpu;
pub use host::{Host, HostOptions};
pub use image::Image;
pub use reference::Reference;
pub use scene::{Scene, SceneCamera};
