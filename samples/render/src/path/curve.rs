//! Values over time, through keys.

use serde::Deserialize;

/// What happens between two keys.
#[derive(Deserialize, Clone, Copy, Debug, Default, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// Straight lines.
    Linear,
    /// Cubic, with the slope at a key of the line between its neighbours (Catmull and Rom 1974), for keys at uneven
    /// times; at the ends the slope of the line to the neighbour.
    #[default]
    CatmullRom,
}

/// N values at once. Before the first key and after the last one they stand still.
#[derive(Clone, Debug)]
pub struct Curve<const N: usize> {
    interpolation: Interpolation,
    /// Time in seconds, ascending, and values; at least one.
    keys: Vec<(f64, [f64; N])>,
}

impl<const N: usize> Curve<N> {
    /// Through `keys`: seconds, ascending, and values; at least one.
    pub fn new(interpolation: Interpolation, keys: Vec<(f64, [f64; N])>) -> Self {
        Self { interpolation, keys }
    }

    /// The values at `time` seconds.
    pub fn at(&self, time: f64) -> [f64; N] {
        let next = self.keys.partition_point(|key| key.0 <= time);
        if next == 0 || next == self.keys.len() {
            return self.keys[next.saturating_sub(1)].1;
        }
        let ((t0, from), (t1, to)) = (self.keys[next - 1], self.keys[next]);
        let (span, u) = (t1 - t0, (time - t0) / (t1 - t0));
        std::array::from_fn(|i| match self.interpolation {
            Interpolation::Linear => from[i] + (to[i] - from[i]) * u,
            Interpolation::CatmullRom => {
                let (leaving, arriving) = (self.slope(next - 1, i) * span, self.slope(next, i) * span);
                hermite(u, from[i], to[i], leaving, arriving)
            }
        })
    }

    /// Change of value `i` a second at a key.
    fn slope(&self, key: usize, i: usize) -> f64 {
        let (before, after) = (key.saturating_sub(1), (key + 1).min(self.keys.len() - 1));
        let ((t0, from), (t1, to)) = (self.keys[before], self.keys[after]);
        (to[i] - from[i]) / (t1 - t0)
    }
}

/// The cubic that goes from `a` at 0 to `b` at 1 with the slopes `da` and `db` there.
fn hermite(u: f64, a: f64, b: f64, da: f64, db: f64) -> f64 {
    let (u2, u3) = (u * u, u * u * u);
    a * (2.0 * u3 - 3.0 * u2 + 1.0) + da * (u3 - 2.0 * u2 + u) + b * (3.0 * u2 - 2.0 * u3) + db * (u3 - u2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(interpolation: Interpolation) -> Curve<1> {
        Curve::new(interpolation, vec![(1.0, [0.0]), (2.0, [4.0]), (4.0, [6.0])])
    }

    #[test]
    fn both_kinds_pass_through_the_keys_and_stand_still_outside() {
        for kind in [Interpolation::Linear, Interpolation::CatmullRom] {
            let at = |time| curve(kind).at(time)[0];
            assert_eq!([at(-9.0), at(1.0), at(2.0), at(4.0), at(9.0)], [0.0, 0.0, 4.0, 6.0, 6.0], "{kind:?}");
        }
    }

    #[test]
    fn linear_is_straight() {
        let curve = curve(Interpolation::Linear);
        assert_eq!([1.25, 3.0].map(|time| curve.at(time)[0]), [1.0, 5.0]);
    }

    #[test]
    fn catmull_rom_has_no_kink() {
        let curve = curve(Interpolation::CatmullRom);
        let slope = |time: f64| (curve.at(time + 1e-6)[0] - curve.at(time - 1e-6)[0]) / 2e-6;
        // At the middle key both sides have the slope from the first key to the last: 6 in 3 seconds.
        for time in [2.0 - 1e-5, 2.0, 2.0 + 1e-5] {
            assert!((slope(time) - 2.0).abs() < 1e-3, "{} at {time}", slope(time));
        }
        let even =
            Curve::new(Interpolation::CatmullRom, (0..5).map(|i| (f64::from(i), [3.0 * f64::from(i)])).collect());
        assert!((even.at(2.6)[0] - 7.8).abs() < 1e-12, "keys on a line give the line");
    }

    #[test]
    fn one_key_is_a_constant() {
        let curve = Curve::new(Interpolation::CatmullRom, vec![(5.0, [7.0])]);
        assert_eq!([0.0, 5.0, 9.0].map(|time| curve.at(time)[0]), [7.0; 3]);
    }
}
