//! When rays are heard that ask for light where none reaches.

/// Share of all rays that may come to faces without light: next to none. A room may have no other light.
const SHARE_MIN: f64 = 5e-6;
/// The same once what rays asked for has been more than there is memory for.
const SHARE: f64 = 1e-4;
/// Frames for which nothing must have been to do.
const STILL: u32 = 8;
/// Frames after which they are heard even if there is always something to do.
const DEAF_MAX: u32 = 256;

/// What to do with the rays' requests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hear {
    Nothing,
    /// Those that are more than a share of all rays.
    Requests {
        share: f64,
    },
    /// Nothing, and what has been heard is forgotten.
    Anew,
}

/// Where bricks are left out walls are missing, and rays come through the holes: what they ask for takes the memory that
/// those walls would need. So rays are not heard while bricks come in, and what they asked for with bricks left out is
/// forgotten, as often as that has brought more of them in.
pub struct Hearing {
    deaf: bool,
    /// Since that began.
    frames: u32,
    still: u32,
    /// Bricks left out when requests were last forgotten; `u32::MAX`: they never were.
    left_out: u32,
}

impl Default for Hearing {
    fn default() -> Self {
        Self { deaf: true, frames: 0, still: 0, left_out: u32::MAX }
    }
}

impl Hearing {
    /// A frame in which memory is short. `is_still`: nothing is to be voxelised or flooded.
    pub fn update(&mut self, is_still: bool, left_out: u32) -> Hear {
        self.frames += 1;
        self.still = if is_still { self.still + 1 } else { 0 };
        if self.deaf {
            self.deaf = self.still < STILL && self.frames < DEAF_MAX;
            return Hear::Nothing;
        }
        if self.still >= STILL && left_out > 0 && left_out < self.left_out {
            *self = Self { left_out, ..Self::default() };
            return Hear::Anew;
        }
        Hear::Requests { share: if self.left_out == u32::MAX { SHARE_MIN } else { SHARE } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_are_heard_once_all_is_still() {
        let mut hearing = Hearing::default();
        (0..100).for_each(|_| assert_eq!(hearing.update(false, 0), Hear::Nothing));
        (0..STILL).for_each(|_| assert_eq!(hearing.update(true, 0), Hear::Nothing));
        (0..100).for_each(|frame| assert_eq!(hearing.update(frame % 3 == 0, 0), Hear::Requests { share: SHARE_MIN }));
    }

    #[test]
    fn a_restless_world_is_heard_too() {
        let mut hearing = Hearing::default();
        let heard = (0..1000).filter(|_| matches!(hearing.update(false, 5), Hear::Requests { .. })).count();
        assert_eq!(heard as u32, 1000 - DEAF_MAX);
    }

    /// Else they would come and go for ever.
    #[test]
    fn requests_are_forgotten_only_if_that_has_helped() {
        let mut hearing = Hearing::default();
        let mut anew = |left_out| (0..1000).filter(|_| hearing.update(true, left_out) == Hear::Anew).count();
        assert_eq!([anew(9), anew(9), anew(12), anew(0), anew(9), anew(4), anew(5)], [1, 0, 0, 0, 0, 1, 0]);
        assert_eq!(hearing.update(true, 0), Hear::Requests { share: SHARE }, "fewer are heard from then on");
    }
}
