//! Which bricks exist, where they lie in memory, and which are next. CPU only; no Vulkan.

mod allocator;
mod grid;
mod primitives;
mod table;

pub use allocator::ExtentAllocator;
pub use grid::Grid;
pub use primitives::{MAX_TRIANGLES, PrimitiveIndex, WorldGrid};
pub use table::{BrickTable, Finished};
