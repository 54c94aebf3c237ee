//! The claims.

mod carry;
mod compact;
mod hit_cost;
mod limits;
mod pack;
mod settled;
mod solids;
mod trace;
mod voxelize;
mod worlds;
