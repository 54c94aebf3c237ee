//! Light from beyond the world.

use super::lights::{check_color, check_direction, require};
use glam::{Mat3, Vec3};

/// Light from beyond the world: radiance from every direction that leaves the scene, linear Rec.709, 0 or more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sky {
    /// The same from everywhere.
    Constant {
        /// Radiance.
        radiance: [f32; 3],
    },
    /// Three colours: with s the sine of the elevation above the horizon, horizon + (zenith - horizon) s above it, and
    /// horizon + (ground - horizon) (-s) below.
    Gradient {
        /// Radiance from straight above.
        zenith: [f32; 3],
        /// Radiance from the horizon.
        horizon: [f32; 3],
        /// Radiance from straight below.
        ground: [f32; 3],
        /// Which way is up; need not be normalised.
        up: [f32; 3],
    },
    /// The image of [`Context::set_sky_image`](crate::Context::set_sky_image).
    Image {
        /// What the image's radiance is multiplied with.
        intensity: [f32; 3],
        /// Columns of the rotation from the image to the world.
        rotation: [[f32; 3]; 3],
    },
}

impl Default for Sky {
    fn default() -> Self {
        Self::Constant { radiance: [0.0; 3] }
    }
}

impl Sky {
    /// Says what is not finite or out of range.
    pub(crate) fn check(&self) -> Result<(), &'static str> {
        match *self {
            Self::Constant { radiance } => check_color(radiance, "radiance is not finite, or negative"),
            Self::Gradient { zenith, horizon, ground, up } => {
                check_color(zenith, "zenith is not finite, or negative")?;
                check_color(horizon, "horizon is not finite, or negative")?;
                check_color(ground, "ground is not finite, or negative")?;
                check_direction(up, "up is not finite, or zero")
            }
            Self::Image { intensity, rotation } => {
                check_color(intensity, "intensity is not finite, or negative")?;
                let rotation = Mat3::from_cols_array_2d(&rotation);
                let product = rotation.transpose() * rotation;
                let off = (product - Mat3::IDENTITY).to_cols_array().iter().fold(0.0, |most, v| v.abs().max(most));
                require(off < 1e-3 && rotation.determinant() > 0.0, "rotation is none")
            }
        }
    }

    /// What shaders read: kind, colour, and three vectors.
    pub(crate) fn uniform(&self) -> (u32, [f32; 3], [[f32; 3]; 3]) {
        use crate::gpu::shared::{SKY_CONSTANT, SKY_GRADIENT, SKY_IMAGE};
        match *self {
            Self::Constant { radiance } => (SKY_CONSTANT, radiance, [[0.0; 3]; 3]),
            Self::Gradient { zenith, horizon, ground, up } => {
                let up = Vec3::from(up).as_dvec3().normalize_or_zero().as_vec3().to_array();
                (SKY_GRADIENT, zenith, [up, horizon, ground])
            }
            Self::Image { intensity, rotation } => (SKY_IMAGE, intensity, rotation),
        }
    }
}
