//! Skies that are not the same from everywhere.

use super::guard::{Failure, guard_context};
use super::input::{self, structure_types};
use super::types::*;
use super::vk::VkFormat;
use crate::scene::{Sky, SkyFormat, SkyImage, SkyLayout};
use ash::vk;
use std::ffi::c_void;

/// Kind of a sky: one of BGI_SKY_TYPE_*.
pub type BgiSkyType = u32;
/// Three colours: `zenith`, `horizon`, `ground`, `up`.
pub const BGI_SKY_TYPE_GRADIENT: BgiSkyType = 1;
/// The image of bgiSetSkyImage: `intensity`, `rotation`.
pub const BGI_SKY_TYPE_IMAGE: BgiSkyType = 2;

/// How a sky's image covers the directions: one of BGI_SKY_LAYOUT_*.
pub type BgiSkyLayout = u32;
/// Equirectangular. The top row is +y, the middle of the image -z, and +x is to the right of it.
pub const BGI_SKY_LAYOUT_LAT_LONG: BgiSkyLayout = 1;
/// Six square faces, one after another: +x, -x, +y, -y, +z, -z, each as Vulkan lays out a cube map.
pub const BGI_SKY_LAYOUT_CUBE: BgiSkyLayout = 2;

/// Light from beyond the world: radiance, linear Rec.709, 0 or more, finite. Fields of the other type are ignored.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiSky {
    /// BGI_STRUCTURE_TYPE_SKY
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// BGI_SKY_TYPE_*
    pub sky_type: BgiSkyType,
    /// Gradient: radiance from straight above. With s the sine of the elevation, radiance is
    /// horizon + (zenith - horizon) s above the horizon, and horizon + (ground - horizon) (-s) below it.
    pub zenith: [f32; 3],
    /// Gradient: radiance from the horizon.
    pub horizon: [f32; 3],
    /// Gradient: radiance from straight below.
    pub ground: [f32; 3],
    /// Gradient: which way is up; not zero, need not be normalised.
    pub up: [f32; 3],
    /// Image: what its radiance is multiplied with.
    pub intensity: [f32; 3],
    /// Image: columns of the rotation from the image to the world; all zero: none.
    pub rotation: [[f32; 3]; 3],
}

/// A sky's image: radiance, linear Rec.709. What is negative or not a number counts as 0, what is infinite as 65504.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct BgiSkyImage {
    /// BGI_STRUCTURE_TYPE_SKY_IMAGE
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// BGI_SKY_LAYOUT_*
    pub layout: BgiSkyLayout,
    /// VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT (their alpha is passed over) or
    /// VK_FORMAT_B10G11R11_UFLOAT_PACK32.
    pub format: VkFormat,
    /// Texels per row, 1 to BGI_MAX_EXTENT.
    pub width: u32,
    /// Rows (of a face), 1 to BGI_MAX_EXTENT; of a cube, as many as `width`.
    pub height: u32,
    /// Rows from the top, no padding; any alignment. Copied.
    pub texels: *const c_void,
    /// Bytes at `texels`: width * height texels, of a cube six times as many.
    pub texels_size: u64,
}

structure_types! { BgiSky = BGI_STRUCTURE_TYPE_SKY, BgiSkyImage = BGI_STRUCTURE_TYPE_SKY_IMAGE }

const IDENTITY: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

impl BgiSky {
    pub(super) fn sky(&self) -> Result<Sky, Failure> {
        let Self { zenith, horizon, ground, up, intensity, .. } = *self;
        match self.sky_type {
            BGI_SKY_TYPE_GRADIENT => Ok(Sky::Gradient { zenith, horizon, ground, up }),
            BGI_SKY_TYPE_IMAGE => {
                let rotation = if self.rotation == [[0.0; 3]; 3] { IDENTITY } else { self.rotation };
                Ok(Sky::Image { intensity, rotation })
            }
            other => Err(Failure::argument(format!("sky.skyType: {other} is no BGI_SKY_TYPE_* of this version"))),
        }
    }
}

impl BgiSkyImage {
    /// # Safety
    /// `texels` is NULL, or leads to `texels_size` readable bytes, unchanged for 'a.
    unsafe fn image<'a>(&self) -> Result<SkyImage<'a>, Failure> {
        let layout = match self.layout {
            BGI_SKY_LAYOUT_LAT_LONG => SkyLayout::LatLong,
            BGI_SKY_LAYOUT_CUBE => SkyLayout::Cube,
            other => return Err(Failure::argument(format!("layout: {other} is no BGI_SKY_LAYOUT_* of this version"))),
        };
        let format = match self.format {
            vk::Format::R16G16B16A16_SFLOAT => SkyFormat::Rgba16Float,
            vk::Format::R32G32B32A32_SFLOAT => SkyFormat::Rgba32Float,
            vk::Format::B10G11R11_UFLOAT_PACK32 => SkyFormat::B10G11R11,
            other => {
                let text = format!("format: VkFormat {} is not one of a sky's image", other.as_raw());
                return Err(Failure::argument(text));
            }
        };
        // SAFETY: the caller's promise.
        let texels = unsafe { input::bytes(self.texels, 0, self.texels_size, 1, "texels")? };
        Ok(SkyImage { layout, format, width: self.width, height: self.height, texels })
    }
}

/// Takes or replaces the image that skies of BGI_SKY_TYPE_IMAGE mean. Records nothing. The image is reduced, in some ten
/// milliseconds a million texels, to 64 x 64 mean radiances (16 KiB for each frame in flight while they are in use). Its
/// sum over the sphere stays, and so do, within 1 %, those over hemispheres, but for a sun that stands on their horizon.
/// Rays that miss the scene read the map: a sun in it is found by few of them and makes noise. Better paint it out, and
/// hand it over as a directional light.
///
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT or BGI_ERROR_INVALID_STRUCTURE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiSetSkyImage(context: BgiContext, image: *const BgiSkyImage) -> BgiResult {
    guard_context(context, |state| {
        // SAFETY: the header asks for a readable struct, and texels as many as it says.
        let image = unsafe { input::structure(image)?.image()? };
        state.context.set_sky_image(&image)?;
        Ok(BGI_SUCCESS)
    })
}
