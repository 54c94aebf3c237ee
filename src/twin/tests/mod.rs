//! The claims.

mod compact;
mod limits;
mod pack;
mod settled;
mod solids;
mod trace;
mod voxelize;
mod worlds;
