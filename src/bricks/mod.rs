//! Which bricks exist, where they lie in memory, and which are next. CPU only; no Vulkan.

mod allocator;
mod axis_counts;
mod grid;
mod light_queue;
mod primitives;
mod table;
mod viewpoint;

pub use allocator::ExtentAllocator;
use axis_counts::AxisCounts;
pub use grid::Grid;
pub use light_queue::LightBudget;
use light_queue::LightQueue;
#[cfg(test)]
pub use primitives::CubeTest;
pub use primitives::{Batch, BrickWindow, MAX_TRIANGLES, PrimitiveIndex, WorldGrid};
pub use table::{BrickTable, Finished};
pub use viewpoint::Viewpoint;
