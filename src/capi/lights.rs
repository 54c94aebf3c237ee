//! Lights that are not surfaces, and the sky.

use super::guard::{Failure, guard_context};
use super::input::{self, structure_types};
use super::sky::BgiSky;
use super::types::*;
use crate::scene::{Light, Sky};
use std::ffi::c_void;

/// Kind of a light: one of BGI_LIGHT_TYPE_*.
pub type BgiLightType = u32;
/// Parallel light: `direction` and `irradiance`.
pub const BGI_LIGHT_TYPE_DIRECTIONAL: BgiLightType = 1;
/// An isotropic point: `position`, `intensity`, `range`.
pub const BGI_LIGHT_TYPE_POINT: BgiLightType = 2;
/// A point that shines into a cone: `position`, `direction`, `intensity`, `innerAngle`, `outerAngle`, `range`.
pub const BGI_LIGHT_TYPE_SPOT: BgiLightType = 3;
/// A ball: `position`, `radius`, `radiance`. Nothing is lit inside it.
pub const BGI_LIGHT_TYPE_SPHERE: BgiLightType = 4;
/// A rectangle: `position`, `halfAxisU`, `halfAxisV`, `radiance`, `twoSided`.
pub const BGI_LIGHT_TYPE_RECTANGLE: BgiLightType = 5;

/// A light that is not a surface. Fields of other types are ignored. Colours are linear Rec.709, 0 or more, finite;
/// their unit is the host's choice, the same for all lights, emission and sky: the output has it too.
///
/// No light stands in its own way, but the meshes around one do: a lamp's shade shadows it, and a closed bulb lets nothing
/// out, unless it is left out of the meshes that are handed over.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiLight {
    /// BGI_STRUCTURE_TYPE_LIGHT
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// BGI_LIGHT_TYPE_*
    pub light_type: BgiLightType,
    /// Directional: in which the light travels. Spot: the cone's axis. Not zero, need not be normalised.
    pub direction: [f32; 3],
    /// Directional: irradiance on a plane perpendicular to it.
    pub irradiance: [f32; 3],
    /// Point: radiant intensity I; irradiance is I cos / d^2. Spot: I on the axis; irradiance is I f cos / d^2, and at
    /// the angle a to the axis f = clamp((cos a - cos outer) / max(cos inner - cos outer, 0.001), 0, 1)^2 (glTF,
    /// KHR_lights_punctual).
    pub intensity: [f32; 3],
    /// Not directional: world position in metres, of the middle where it has an extent.
    pub position: [f64; 3],
    /// Sphere, rectangle: radiance L. Of a sphere that is all above the horizon, irradiance is
    /// pi L (radius / d)^2 cos.
    pub radiance: [f32; 3],
    /// Point, spot: metres at which it ends, or 0: nowhere. Irradiance is multiplied with
    /// max(1 - (d / range)^4, 0)^2 (Karis, Real Shading in Unreal Engine 4, SIGGRAPH 2013).
    pub range: f32,
    /// Spot: from the axis to where the light begins to fall off, radians, 0 to outerAngle.
    pub inner_angle: f32,
    /// Spot: from the axis to where it ends, radians, above 0, at most pi / 2.
    pub outer_angle: f32,
    /// Sphere: metres, above 0.
    pub radius: f32,
    /// Rectangle: 0 or 1. 0: it shines to the side that halfAxisU x halfAxisV points to; 1: to both.
    pub two_sided: u32,
    /// Rectangle: from the middle to that of an edge, metres; not zero.
    pub half_axis_u: [f32; 3],
    /// Rectangle: the same of a neighbouring edge; perpendicular to halfAxisU.
    pub half_axis_v: [f32; 3],
}

/// All lights and the sky.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiLighting {
    /// BGI_STRUCTURE_TYPE_LIGHTING
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// lightCount lights. Copied.
    pub lights: *const BgiLight,
    /// Elements of `lights`, 0 to 4096.
    pub light_count: u32,
    /// Radiance from every direction that leaves the scene, linear Rec.709, 0 or more, finite. Ignored where there is a
    /// `sky`.
    pub sky_radiance: [f32; 3],
    /// Optional: a sky that is not the same from everywhere. Copied.
    pub sky: *const BgiSky,
}

structure_types! { BgiLight = BGI_STRUCTURE_TYPE_LIGHT, BgiLighting = BGI_STRUCTURE_TYPE_LIGHTING }

impl BgiLight {
    fn light(&self, index: usize) -> Result<Light, Failure> {
        let position = self.position;
        match self.light_type {
            BGI_LIGHT_TYPE_DIRECTIONAL => {
                Ok(Light::Directional { direction: self.direction, irradiance: self.irradiance })
            }
            BGI_LIGHT_TYPE_POINT => Ok(Light::Point { position, intensity: self.intensity, range: self.range }),
            BGI_LIGHT_TYPE_SPOT => Ok(Light::Spot {
                position,
                direction: self.direction,
                intensity: self.intensity,
                inner_angle: self.inner_angle,
                outer_angle: self.outer_angle,
                range: self.range,
            }),
            BGI_LIGHT_TYPE_SPHERE => Ok(Light::Sphere { position, radius: self.radius, radiance: self.radiance }),
            BGI_LIGHT_TYPE_RECTANGLE => Ok(Light::Rectangle {
                position,
                half_u: self.half_axis_u,
                half_v: self.half_axis_v,
                radiance: self.radiance,
                two_sided: input::flag(self.two_sided, &format!("lights[{index}].twoSided"))?,
            }),
            other => {
                let text = format!("lights[{index}].lightType: {other} is no BGI_LIGHT_TYPE_* of this version");
                Err(Failure::argument(text))
            }
        }
    }
}

/// All light is wrong: the sun has jumped, a level has loaded. Averages over time start over, those of the views too. What
/// changes through bgiSetLights and bgiUpdateMeshes needs no such hint. Records nothing.
///
/// @return BGI_SUCCESS or BGI_ERROR_INVALID_HANDLE.
#[unsafe(no_mangle)]
pub extern "C" fn bgiInvalidateLighting(context: BgiContext) -> BgiResult {
    guard_context(context, |state| {
        state.context.invalidate_lighting();
        Ok(BGI_SUCCESS)
    })
}

/// Replaces all lights and the sky for the following dispatches. Records nothing. The first call with any light, with
/// spheres or rectangles, and with more than directLights, creates a pipeline each.
///
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT, BGI_ERROR_INVALID_STRUCTURE,
/// BGI_ERROR_OUT_OF_MEMORY, BGI_ERROR_DEVICE_LOST or BGI_ERROR_VULKAN.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiSetLights(context: BgiContext, lighting: *const BgiLighting) -> BgiResult {
    guard_context(context, |state| {
        // SAFETY: the header asks for a readable struct and an array as long as its count.
        let (lighting, lights) = unsafe {
            let lighting = input::structure(lighting)?;
            (lighting, input::structures(lighting.lights, lighting.light_count, "lights")?)
        };
        let sky = if lighting.sky.is_null() {
            Sky::Constant { radiance: lighting.sky_radiance }
        } else {
            // SAFETY: the header asks for a readable struct.
            unsafe { input::structure(lighting.sky)? }.sky()?
        };
        let lights = lights.iter().enumerate().map(|(index, light)| light.light(index));
        let lights = lights.collect::<Result<Vec<_>, _>>()?;
        state.context.set_lights(&lights, sky)?;
        Ok(BGI_SUCCESS)
    })
}
