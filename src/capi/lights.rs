//! Lights that are not surfaces, and the sky.

use super::guard::{Failure, guard_context};
use super::input::{self, structure_types};
use super::types::*;
use crate::scene::{Light, Sky};
use std::ffi::c_void;

/// Kind of a light: one of BGI_LIGHT_TYPE_*.
pub type BgiLightType = u32;
/// Parallel light: `direction` and `irradiance`.
pub const BGI_LIGHT_TYPE_DIRECTIONAL: BgiLightType = 1;
/// An isotropic point: `position` and `intensity`.
pub const BGI_LIGHT_TYPE_POINT: BgiLightType = 2;

/// A light that is not a surface. Fields of other types are ignored. Colours are linear Rec.709, 0 or more, finite;
/// their unit is the host's choice, the same for all lights, emission and sky: the output has it too.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiLight {
    /// BGI_STRUCTURE_TYPE_LIGHT
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// BGI_LIGHT_TYPE_*
    pub light_type: BgiLightType,
    /// Directional: in which the light travels; not zero, need not be normalised.
    pub direction: [f32; 3],
    /// Directional: irradiance on a plane perpendicular to it.
    pub irradiance: [f32; 3],
    /// Point: radiant intensity I; irradiance is I cos / d^2.
    pub intensity: [f32; 3],
    /// Point: world position in metres.
    pub position: [f64; 3],
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
    /// Radiance from every direction that leaves the scene, linear Rec.709, 0 or more, finite.
    pub sky_radiance: [f32; 3],
}

structure_types! { BgiLight = BGI_STRUCTURE_TYPE_LIGHT, BgiLighting = BGI_STRUCTURE_TYPE_LIGHTING }

impl BgiLight {
    fn light(&self, index: usize) -> Result<Light, Failure> {
        match self.light_type {
            BGI_LIGHT_TYPE_DIRECTIONAL => {
                Ok(Light::Directional { direction: self.direction, irradiance: self.irradiance })
            }
            BGI_LIGHT_TYPE_POINT => Ok(Light::Point { position: self.position, intensity: self.intensity }),
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

/// Replaces all lights and the sky for the following dispatches. Records nothing.
///
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT or BGI_ERROR_INVALID_STRUCTURE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiSetLights(context: BgiContext, lighting: *const BgiLighting) -> BgiResult {
    guard_context(context, |state| {
        // SAFETY: the header asks for a readable struct and an array as long as its count.
        let (lighting, lights) = unsafe {
            let lighting = input::structure(lighting)?;
            (lighting, input::structures(lighting.lights, lighting.light_count, "lights")?)
        };
        let lights = lights.iter().enumerate().map(|(index, light)| light.light(index));
        let lights = lights.collect::<Result<Vec<_>, _>>()?;
        state.context.set_lights(&lights, Sky { radiance: lighting.sky_radiance })?;
        Ok(BGI_SUCCESS)
    })
}
