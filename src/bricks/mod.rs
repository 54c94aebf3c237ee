//! Which bricks exist, where they lie in memory, and which are next. CPU only; no Vulkan.

mod allocator;
mod axis_counts;
mod cells;
mod flood;
mod grid;
mod light_queue;
mod primitives;
mod regions;
mod table;
mod viewpoint;

pub use allocator::ExtentAllocator;
use axis_counts::AxisCounts;
pub use cells::Cells;
pub use grid::Grid;
use light_queue::LightQueue;
pub use light_queue::{LightBudget, Lit};
#[cfg(test)]
pub use primitives::CubeTest;
pub use primitives::{Batch, BrickWindow, MAX_TRIANGLES, PrimitiveIndex, WorldGrid};
pub use regions::{Mask, Regions};
pub use table::{Arrived, BrickTable, Finished};
pub use viewpoint::Viewpoint;

use glam::{IVec3, UVec3};

/// Three coordinates of ten bits each, x lowest.
pub fn unpack(word: u32) -> IVec3 {
    (UVec3::new(word, word >> 10, word >> 20) & 1023).as_ivec3()
}
