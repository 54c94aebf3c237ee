//! From where bricks are seen.

use glam::{DMat4, DVec3, DVec4, IVec3};

/// Radius of a brick's bounding sphere, in bricks.
const RADIUS: f64 = 0.87;
/// Bricks nearer than this are near: 64 m at voxels of half a metre.
const NEAR: f64 = 16.0;
/// What lies outside the view may wait as long as what lies so many times farther away in it.
const OUT_OF_VIEW: f64 = 4.0;

/// A camera, in bricks.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    eye: DVec3,
    /// Inward planes of the view's four sides: unit normal, distance of the eye.
    sides: [DVec4; 4],
}

impl Viewpoint {
    /// Of a camera at `eye` (bricks) whose clip space is `clip` of the position relative to it in metres; a brick is
    /// `brick_size` metres wide.
    pub fn new(eye: DVec3, clip: DMat4, brick_size: f64) -> Self {
        let sides = [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)].map(|(row, sign)| {
            let side = clip.row(3) + clip.row(row) * sign;
            let normal = side.truncate();
            (normal / normal.length().max(1e-30)).extend(side.w / normal.length().max(1e-30) / brick_size)
        });
        Self { eye, sides }
    }

    /// Of a camera that sees everything.
    #[cfg(test)]
    pub fn all_round(eye: DVec3) -> Self {
        Self { eye, sides: [DVec4::W * 1e9; 4] }
    }

    /// Whether a brick may be in view.
    fn sees(&self, brick: IVec3) -> bool {
        let center = (brick.as_dvec3() + 0.5 - self.eye).extend(1.0);
        self.sides.iter().all(|side| side.dot(center) >= -RADIUS)
    }

    /// Whether a brick is near and may be in view.
    pub fn sees_near(&self, brick: IVec3) -> bool {
        (brick.as_dvec3() + 0.5 - self.eye).length() < NEAR && self.sees(brick)
    }

    /// Frames that a brick may wait: its distance in bricks, more out of view.
    pub fn patience(&self, brick: IVec3) -> f64 {
        let distance = (brick.as_dvec3() + 0.5 - self.eye).length();
        // A camera soon looks at what is beside it.
        if distance < 2.0 || self.sees(brick) { distance } else { distance * OUT_OF_VIEW }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_in_view_is_seen() {
        // One radian wide and high, along -z.
        let scale = 1.0 / 0.5f64.tan();
        let clip = DMat4::from_cols(DVec4::X * scale, DVec4::Y * scale, -DVec4::W, DVec4::ZERO);
        let view = Viewpoint::new(DVec3::splat(10.0), clip, 4.0);
        let at = |x: f64, y: f64, z: f64| (DVec3::new(x, y, z) + 10.0).floor().as_ivec3();
        assert!(view.sees(at(0.0, 0.0, -20.0)));
        assert!(view.sees(at(10.0, 0.0, -20.0)), "half the tangent of half a radian is 10.9 of 20");
        assert!(!view.sees(at(14.0, 0.0, -20.0)));
        assert!(!view.sees(at(0.0, -14.0, -20.0)));
        assert!(!view.sees(at(0.0, 0.0, 20.0)), "behind");
        assert!(view.patience(at(0.0, 0.0, -20.0)) < view.patience(at(0.0, 0.0, 10.0)));
    }
}
