//! CPU twins of the shaders, and the tests that hold the two together.
//!
//! A twin is the plain reading of what its shader must do: f64, no hierarchy, no shared memory, nothing packed until
//! the end. `pack`, `layout` and `world` read and write the data; `trace`, `voxelize` and `resolve` compute it;
//! `gpu` runs the shaders with the validation layer on.

pub mod gpu;
pub mod layout;
pub mod pack;
pub mod random;
mod resolve;
pub mod shapes;
mod surface;
mod tests;
mod trace;
mod triangle;
mod voxelize;
pub mod world;

/// Rust twins of what only the test shaders declare.
mod shared {
    include!(concat!(env!("OUT_DIR"), "/test_shared.rs"));
}

#[path = "../../tests/common/vulkan.rs"]
mod vulkan;
