//! Which bricks exist, where they lie in memory, and which are next. CPU only; no Vulkan.

mod allocator;
mod cells;
mod flood;
mod grid;
mod light_queue;
mod primitives;
mod regions;
mod table;
mod viewpoint;

pub use allocator::ExtentAllocator;
pub use cells::Cells;
pub use grid::Grid;
pub use light_queue::LightQueue;
pub use primitives::{Batch, MAX_TRIANGLES, PrimitiveIndex, WorldGrid};
pub use regions::{Mask, Regions};
pub use table::{BrickTable, Finished};
pub use viewpoint::Viewpoint;
