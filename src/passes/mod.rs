//! The frame's passes: what each reads and writes, how large it is. They add to the frame's list and never name Vulkan;
//! a pass with nothing to do is not recorded at all.

pub mod bricks;
pub mod light;
pub mod probes;
