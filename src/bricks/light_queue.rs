//! Whose turn it is to be lit.

use glam::IVec3;
use std::collections::BTreeSet;

/// Deadlines of bricks that were never lit lie below this.
const LIT: u64 = 1 << 32;
/// Frames after which a brick at the camera is due again.
const PERIOD_MIN: f64 = 8.0;

/// Bricks by the frame in which their lighting is due, earliest first: a brick is due as many frames after it was lit as
/// it is bricks away from the camera. What was never lit comes before everything, the nearest first. A brick that is due
/// does not starve, for what is lit goes behind it.
#[derive(Debug, Default)]
pub struct LightQueue {
    due: BTreeSet<(u64, [i32; 3])>,
}

impl LightQueue {
    /// A brick that has never been lit, `distance` bricks from the camera. Returns its place.
    pub fn enter(&mut self, brick: IVec3, distance: f64) -> u64 {
        self.put(brick, ((distance * 16.0) as u64).min(LIT - 1))
    }

    /// A brick lit in frame `clock`. Returns its place.
    pub fn enter_again(&mut self, brick: IVec3, clock: u64, distance: f64) -> u64 {
        self.put(brick, LIT + clock + (PERIOD_MIN + distance) as u64)
    }

    fn put(&mut self, brick: IVec3, due: u64) -> u64 {
        self.due.insert((due, brick.to_array()));
        due
    }

    /// Takes a brick out of its place.
    pub fn remove(&mut self, brick: IVec3, due: u64) {
        self.due.remove(&(due, brick.to_array()));
    }

    /// Whose turn it is.
    pub fn first(&self) -> Option<IVec3> {
        self.due.first().map(|(_, brick)| IVec3::from(*brick))
    }
}
