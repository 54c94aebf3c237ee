//! Bounds of a set of bricks that changes.

use glam::{IVec3, UVec3};

/// Counts the bricks of a window at each place along each axis, so that the bounds of those that are left need no search.
#[derive(Debug)]
pub struct AxisCounts {
    axes: [Vec<u32>; 3],
}

impl AxisCounts {
    /// Of a window of `size` bricks, powers of two; places are taken modulo it.
    pub fn new(size: UVec3) -> Self {
        Self { axes: size.to_array().map(|n| vec![0; n as usize]) }
    }

    fn counts(&mut self, brick: IVec3) -> impl Iterator<Item = &mut u32> {
        self.axes.iter_mut().zip(brick.to_array()).map(|(axis, at)| {
            let place = at as usize & (axis.len() - 1);
            &mut axis[place]
        })
    }

    pub fn add(&mut self, brick: IVec3) {
        self.counts(brick).for_each(|count| *count += 1);
    }

    pub fn remove(&mut self, brick: IVec3) {
        self.counts(brick).for_each(|count| *count -= 1);
    }

    /// Low corner of the first brick and high corner of the last one along each axis, in bricks; `window`: the low corner of
    /// the window that holds them all.
    pub fn bounds(&self, window: IVec3) -> Option<(IVec3, IVec3)> {
        let window = window.to_array();
        let (mut low, mut high) = ([0; 3], [0; 3]);
        for (axis, counts) in self.axes.iter().enumerate() {
            let taken = |i: &i32| counts[(window[axis] + i) as usize & (counts.len() - 1)] > 0;
            let size = counts.len() as i32;
            low[axis] = window[axis] + (0..size).find(taken)?;
            high[axis] = window[axis] + (0..size).rev().find(taken)? + 1;
        }
        Some((IVec3::from(low), IVec3::from(high)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_follow_what_comes_and_goes() {
        let mut counts = AxisCounts::new(UVec3::new(8, 4, 8));
        let window = IVec3::new(-5, 100, -8);
        assert_eq!(counts.bounds(window), None);
        let bricks =
            [IVec3::new(-5, 100, -1), IVec3::new(2, 103, -8), IVec3::new(-1, 101, -4), IVec3::new(-1, 101, -4)];
        bricks.iter().for_each(|b| counts.add(*b));
        assert_eq!(counts.bounds(window), Some((IVec3::new(-5, 100, -8), IVec3::new(3, 104, 0))));
        bricks[..3].iter().for_each(|b| counts.remove(*b));
        assert_eq!(counts.bounds(window), Some((bricks[3], bricks[3] + 1)));
        counts.remove(bricks[3]);
        assert_eq!(counts.bounds(window), None);
    }
}
