//! The claims.

mod limits;
mod pack;
mod trace;
mod voxelize;
mod worlds;
