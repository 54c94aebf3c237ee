//! Lights that are not surfaces.

use glam::{DVec3, Vec3};
use std::f32::consts::FRAC_PI_2;

/// A light that is not a surface. Colours are linear Rec.709, 0 or more.
///
/// No light stands in its own way, but what the scene holds around one does: a lamp's shade shadows it, and a closed
/// bulb lets nothing out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Parallel light.
    Directional {
        /// The direction in which the light travels; need not be normalised.
        direction: [f32; 3],
        /// Irradiance on a plane perpendicular to it.
        irradiance: [f32; 3],
    },
    /// An isotropic point.
    Point {
        /// World position in metres.
        position: [f64; 3],
        /// Radiant intensity I: E = I cos / d^2.
        intensity: [f32; 3],
        /// Metres at which it ends; 0: nowhere. Within, it is multiplied with max(1 - (d / range)^4, 0)^2 (Karis, Real
        /// Shading in Unreal Engine 4, SIGGRAPH 2013).
        range: f32,
    },
    /// A point that shines into a cone.
    Spot {
        /// World position in metres.
        position: [f64; 3],
        /// The direction of the cone's axis; need not be normalised.
        direction: [f32; 3],
        /// Radiant intensity I on the axis: E = I f cos / d^2. At the angle a to the axis f = clamp((cos a - cos outer)
        /// / max(cos inner - cos outer, 0.001), 0, 1)^2 (glTF, KHR_lights_punctual).
        intensity: [f32; 3],
        /// From the axis to where the light begins to fall off, radians, 0 to `outer_angle`.
        inner_angle: f32,
        /// From the axis to where it ends, radians, above 0, at most pi / 2.
        outer_angle: f32,
        /// As a point's.
        range: f32,
    },
    /// A ball that sends out the same radiance everywhere. Nothing is lit inside it.
    Sphere {
        /// World position of its middle in metres.
        position: [f64; 3],
        /// Metres, above 0.
        radius: f32,
        /// Radiance L: E = pi L (radius / d)^2 cos while all of it is above the horizon.
        radiance: [f32; 3],
    },
    /// A rectangle that sends out the same radiance everywhere, to the side that `half_u` x `half_v` points to.
    Rectangle {
        /// World position of its middle in metres.
        position: [f64; 3],
        /// From the middle to that of an edge, metres; not zero.
        half_u: [f32; 3],
        /// The same of a neighbouring edge, perpendicular to `half_u`.
        half_v: [f32; 3],
        /// Radiance.
        radiance: [f32; 3],
        /// Whether the other side sends it out, too.
        two_sided: bool,
    },
}

impl Light {
    /// Where it stands, if it stands anywhere.
    pub fn position_mut(&mut self) -> Option<&mut [f64; 3]> {
        match self {
            Self::Directional { .. } => None,
            Self::Point { position, .. }
            | Self::Spot { position, .. }
            | Self::Sphere { position, .. }
            | Self::Rectangle { position, .. } => Some(position),
        }
    }

    /// Whether more than one direction comes from it.
    pub(crate) fn has_extent(&self) -> bool {
        matches!(self, Self::Sphere { .. } | Self::Rectangle { .. })
    }

    /// Says what is not finite or out of range.
    pub(crate) fn check(&self) -> Result<(), &'static str> {
        let mut light = *self;
        let finite = light.position_mut().is_none_or(|p| DVec3::from(*p).is_finite());
        require(finite, "position is not finite")?;
        match light {
            Self::Directional { direction, irradiance } => {
                check_direction(direction, "direction is not finite, or zero")?;
                check_color(irradiance, "irradiance is not finite, or negative")
            }
            Self::Point { intensity, range, .. } => {
                check_color(intensity, "intensity is not finite, or negative")?;
                check_range(range)
            }
            Self::Spot { direction, intensity, inner_angle, outer_angle, range, .. } => {
                check_direction(direction, "direction is not finite, or zero")?;
                check_color(intensity, "intensity is not finite, or negative")?;
                let outer = outer_angle > 0.0 && outer_angle <= FRAC_PI_2;
                require(outer, "the outer angle must be above 0 and at most pi / 2")?;
                require((0.0..=outer_angle).contains(&inner_angle), "the inner angle must be 0 to the outer angle")?;
                check_range(range)
            }
            Self::Sphere { radius, radiance, .. } => {
                require(radius.is_finite() && radius > 0.0, "radius must be finite and above 0")?;
                check_color(radiance, "radiance is not finite, or negative")
            }
            Self::Rectangle { half_u, half_v, radiance, .. } => {
                let [u, v] = [half_u, half_v].map(|axis| Vec3::from(axis).as_dvec3());
                let area = u.length() * v.length();
                require(area.is_finite() && area > 1e-12, "a half axis of the rectangle is not finite, or zero")?;
                require(u.dot(v).abs() < 1e-3 * area, "the half axes of the rectangle are not perpendicular")?;
                check_color(radiance, "radiance is not finite, or negative")
            }
        }
    }
}

pub(super) fn require(holds: bool, fault: &'static str) -> Result<(), &'static str> {
    if holds { Ok(()) } else { Err(fault) }
}

pub(super) fn check_color(color: [f32; 3], fault: &'static str) -> Result<(), &'static str> {
    require(color.iter().all(|v| v.is_finite() && *v >= 0.0), fault)
}

pub(super) fn check_direction(direction: [f32; 3], fault: &'static str) -> Result<(), &'static str> {
    let length = Vec3::from(direction).as_dvec3().length();
    require(length.is_finite() && length > 1e-12, fault)
}

fn check_range(range: f32) -> Result<(), &'static str> {
    require(range.is_finite() && range >= 0.0, "range is not finite, or negative")
}
