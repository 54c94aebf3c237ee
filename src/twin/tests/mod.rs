//! The claims.

mod limits;
mod pack;
mod solids;
mod trace;
mod voxelize;
mod worlds;
