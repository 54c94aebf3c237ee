//! Things that walk over an area: where each is follows from the time alone.

use super::file::Crowd;
use glam::{DMat3, DVec3};
use oorandom::Rand64;
use std::f64::consts::TAU;

/// One of a crowd.
#[derive(Clone, Copy, Debug)]
pub struct Walker {
    start: DVec3,
    /// Metres a second; level.
    velocity: DVec3,
    low: DVec3,
    high: DVec3,
}

impl Walker {
    /// All of a crowd: places even over the area, directions even over the circle, the same for the same seed.
    pub fn all(crowd: &Crowd) -> Vec<Self> {
        let mut random = Rand64::new(crowd.seed.into());
        let (low, high) = (DVec3::from(crowd.low), DVec3::from(crowd.high));
        let mut walker = || {
            let share = DVec3::from_array(std::array::from_fn(|_| random.rand_float()));
            let (sine, cosine) = (TAU * random.rand_float()).sin_cos();
            let velocity = crowd.speed * DVec3::new(sine, 0.0, cosine);
            Self { start: low + share * (high - low), velocity, low, high }
        };
        (0..crowd.count).map(|_| walker()).collect()
    }

    /// Where it is after `time` seconds, in metres, and its rotation: z points ahead.
    pub fn at(&self, time: f64) -> (DVec3, DMat3) {
        let free = self.start + self.velocity * time;
        let folded: [(f64, f64); 3] = std::array::from_fn(|axis| fold(free[axis], self.low[axis], self.high[axis]));
        let ahead = DVec3::from_array(folded.map(|f| f.1)) * self.velocity;
        let position = DVec3::from_array(folded.map(|f| f.0));
        (position, DMat3::from_rotation_y(ahead.x.atan2(ahead.z)))
    }
}

/// A straight way reflected between two walls: the place, and -1 where it has been turned back, else 1.
fn fold(place: f64, low: f64, high: f64) -> (f64, f64) {
    let span = high - low;
    if span <= 0.0 {
        return (low, 1.0);
    }
    let along = (place - low).rem_euclid(2.0 * span);
    if along <= span { (low + along, 1.0) } else { (low + 2.0 * span - along, -1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::file::{BoxShape, Shape};

    fn crowd(seed: u64) -> Crowd {
        let shape = Shape::Box(BoxShape::default());
        Crowd { shape, count: 500, low: [-3.0, 1.0, 2.0], high: [5.0, 1.0, 9.0], speed: 2.0, seed }
    }

    #[test]
    fn a_crowd_stays_in_its_area_at_its_speed() {
        for walker in Walker::all(&crowd(1)) {
            for time in [0.0, 0.5, 7.0, 100.0] {
                let (place, rotation) = walker.at(time);
                assert!(place.cmpge(walker.low).all() && place.cmple(walker.high).all(), "{place} at {time}");
                let (soon, _) = walker.at(time + 1e-6);
                let turned = (soon - place).length() < 1.99e-6;
                assert!(turned || (rotation.z_axis * 2e-6).distance(soon - place) < 1e-9, "it looks where it goes");
            }
        }
    }

    #[test]
    fn the_seed_makes_the_crowd() {
        let places = |seed| Walker::all(&crowd(seed)).iter().map(|w| w.at(3.0).0).collect::<Vec<_>>();
        assert_eq!(places(1), places(1));
        assert_ne!(places(1), places(2));
        let mean = places(1).iter().sum::<DVec3>() / 500.0;
        assert!(mean.distance(DVec3::new(1.0, 1.0, 5.5)) < 0.5, "even over the area: {mean}");
    }
}
