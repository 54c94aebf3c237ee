//! The host's shadow maps.

use super::guard::{Failure, guard_context};
use super::input::{self, structure_types};
use super::types::*;
use super::vk::VkImageView;
use crate::scene::{Camera, ShadowLayer, ShadowMap};
use std::ffi::c_void;

/// A part of a shadow map: a cascade, a face of a cube, or all of it. A point p of the world is at
/// projection * (viewRotation * (p - position)) in clip space, as with a BgiCamera. Who has only a matrix from world to
/// clip space gives it as `projection`, `position` zero and `viewRotation` the identity, and loses digits far away.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiShadowLayer {
    /// BGI_STRUCTURE_TYPE_SHADOW_LAYER
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// Array layer of the view; it exists.
    pub layer: u32,
    /// Its part of that layer, which the viewport was: left edge in texels.
    pub x: u32,
    /// Top edge in texels.
    pub y: u32,
    /// Width in texels. x, y, width and height all 0: the whole layer.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// World position in metres that it was drawn from.
    pub position: [f64; 3],
    /// Columns of the rotation from world to view space: viewRotation[column][row].
    pub view_rotation: [[f32; 3]; 3],
    /// Columns of the projection from view space to Vulkan's clip space (y down in the image, depth 0 to 1):
    /// projection[column][row].
    pub projection: [[f32; 4]; 4],
}

/// A shadow map of the host's, of one light: single, in cascades, or a cube.
///
/// A point of a voxel's face is lit by the first layer that covers it: 0 <= z <= w and -w <= x, y <= w in clip space. One
/// texel is read there, without filtering; the point is lit where its depth z / w is at most the texel's plus depthBias
/// (reversed: at least the texel's minus depthBias). Points move over their faces with time, which filters the shadow's
/// edge. What no layer covers gets its shadow by a ray through the bricks.
///
/// Before, the point is moved along its face's normal: by as much as the surface rises within half a texel, which follows
/// from the layer; by 0.05 voxel, for faces lie on mean planes; and by normalOffset. A map that was drawn without any bias
/// needs none here either. The map says alone who stands in the light: casters that are not among the meshes shadow, what
/// the map leaves out does not.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiShadowMap {
    /// BGI_STRUCTURE_TYPE_SHADOW_MAP
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// Its light's index in what bgiSetLights was last given: directional, point or spot. One map a light. A map whose
    /// light is no longer there, or has an extent now, is passed over.
    pub light: u32,
    /// Width of the view's first level in texels, 1 to BGI_MAX_EXTENT.
    pub width: u32,
    /// Height of the view's first level in texels, 1 to BGI_MAX_EXTENT.
    pub height: u32,
    /// Elements of `layers`, 1 to 6; of all maps at most BGI_MAX_SHADOW_LAYERS.
    pub layer_count: u32,
    /// VK_IMAGE_VIEW_TYPE_2D_ARRAY, of a cube map, too; depth aspect of a depth format, or VK_FORMAT_R32_SFLOAT;
    /// single-sampled. Usage VK_IMAGE_USAGE_SAMPLED_BIT. At each bgiDispatch in layout
    /// VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, visible to VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT with
    /// VK_ACCESS_SHADER_READ_BIT. Maps may share a view; at most BGI_MAX_SHADOW_VIEWS different ones.
    pub view: VkImageView,
    /// layerCount layers, cascades finest first. Copied.
    pub layers: *const BgiShadowLayer,
    /// 0 or 1. 1: larger is nearer (reverse depth).
    pub reversed: u32,
    /// 0: texels hold depth. Above, of points and spots: they hold the distance from the light in metres over `range`.
    pub range: f32,
    /// See above; in units of the texels, finite.
    pub depth_bias: f32,
    /// See above; metres, 0 or more.
    pub normal_offset: f32,
}

structure_types! { BgiShadowLayer = BGI_STRUCTURE_TYPE_SHADOW_LAYER, BgiShadowMap = BGI_STRUCTURE_TYPE_SHADOW_MAP }

impl BgiShadowLayer {
    fn layer(&self) -> ShadowLayer {
        let Self { layer, x, y, width, height, position, view_rotation, projection, .. } = *self;
        let camera = Camera { position, view_rotation, projection };
        ShadowLayer { layer, rectangle: [x, y, width, height], camera }
    }
}

impl BgiShadowMap {
    /// # Safety
    /// `layers` is NULL, or leads to `layer_count` readable structs.
    unsafe fn map(&self, index: usize) -> Result<ShadowMap, Failure> {
        // SAFETY: the caller's promise.
        let layers = unsafe { input::structures(self.layers, self.layer_count, &format!("maps[{index}].layers"))? };
        Ok(ShadowMap {
            light: self.light,
            view: self.view,
            size: [self.width, self.height],
            layers: layers.iter().map(BgiShadowLayer::layer).collect(),
            reversed: input::flag(self.reversed, &format!("maps[{index}].reversed"))?,
            range: self.range,
            depth_bias: self.depth_bias,
            normal_offset: self.normal_offset,
        })
    }
}

/// Replaces the host's shadow maps for the following dispatches; none: each shadow is a ray. Where a map covers a point that
/// is lit, a texel takes the ray's place. Cheap, and meant to be called each frame, as cascades follow the camera: averages
/// do not start over. Call it after bgiSetLights where both change. Records nothing.
///
/// While lighting sleeps, because nothing changes, no map is read. A sun that moves wakes it through bgiSetLights, and a
/// caster through bgiUpdateMeshes; where casters move that are not among the meshes, and where maps are given or taken away
/// for good, bgiInvalidateLighting does.
///
/// The views stay valid until the GPU has finished with the command buffers of all dispatches before they were replaced.
///
/// The first call with any map creates a pipeline.
///
/// @param maps count maps. Copied.
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT, BGI_ERROR_INVALID_STRUCTURE,
/// BGI_ERROR_OUT_OF_MEMORY, BGI_ERROR_DEVICE_LOST or BGI_ERROR_VULKAN.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiSetShadowMaps(context: BgiContext, count: u32, maps: *const BgiShadowMap) -> BgiResult {
    guard_context(context, |state| {
        // SAFETY: the header asks for arrays as long as their counts, and for valid views, which are not used here.
        unsafe {
            let maps = input::structures(maps, count, "maps")?;
            let maps = maps.iter().enumerate().map(|(index, map)| map.map(index)).collect::<Result<Vec<_>, _>>()?;
            state.context.set_shadow_maps(&maps)?;
        }
        Ok(BGI_SUCCESS)
    })
}
