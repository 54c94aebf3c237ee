//! Recording a frame.

use super::guard::{Failure, guard_context};
use super::input::{self, structure_types};
use super::types::*;
use super::vk::*;
use crate::context::{Composite, DebugView, FrameInputs, Motion};
use ash::vk::Handle;
use std::ffi::c_void;

/// What the output shows: one of BGI_DEBUG_VIEW_*.
pub type BgiDebugView = u32;
/// E_ind.
pub const BGI_DEBUG_VIEW_NONE: BgiDebugView = 0;
/// A colour for each brick, a shade for each of its voxels.
pub const BGI_DEBUG_VIEW_BRICKS: BgiDebugView = 1;
/// Albedo of the voxel face that a ray of the camera hits, 0 to 1; 0 where it hits none.
pub const BGI_DEBUG_VIEW_ALBEDO: BgiDebugView = 2;
/// Normal of that face's plane in world space, halved, plus 0.5.
pub const BGI_DEBUG_VIEW_NORMALS: BgiDebugView = 3;
/// What that face sends out (radiance, in the lights' unit): the light that the gather finds there. The sky's where there
/// is none.
pub const BGI_DEBUG_VIEW_RADIANCE: BgiDebugView = 4;
/// Cells that the ray visits: black 0, blue 32, green 64, red 96, white 128 and more.
pub const BGI_DEBUG_VIEW_STEPS: BgiDebugView = 5;
/// Frames that the pixel has averaged, of those that it may: 0 to 1.
pub const BGI_DEBUG_VIEW_HISTORY: BgiDebugView = 6;
/// What the pixel's tile has: a screen probe of the last frame (green), one that looks in its turn (blue) or for want of a
/// settled one (red), or none (black).
pub const BGI_DEBUG_VIEW_PROBES: BgiDebugView = 7;
/// What arrives at the face that a ray of the camera hits (irradiance, direct and indirect, in the lights' unit): what it
/// sends out, its emission taken off, by its albedo. 0 where there is none, or no albedo.
pub const BGI_DEBUG_VIEW_IRRADIANCE: BgiDebugView = 8;
/// The radiance map of each tile's screen probe, 8 x 8 hemi-octahedral directions about its normal: the root of the mean
/// square of the luminance that came from there in some eight frames, in the lights' unit.
pub const BGI_DEBUG_VIEW_PROBE_RADIANCE: BgiDebugView = 9;
/// How far the probes stand for the pixel, green, 0 to 1; red where none does and it shoots rays into the world's cache
/// instead.
pub const BGI_DEBUG_VIEW_FALLBACK: BgiDebugView = 10;

/// One view's frame. Every field but pNext, debugView, albedo, direct, composite, motion and motionScale is
/// required.
///
/// Images on entry, made so by the host's barrier: written and visible to VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT with
/// VK_ACCESS_SHADER_READ_BIT (depth, normal, albedo, direct, motion) or VK_ACCESS_SHADER_WRITE_BIT (output, composite). On exit their layouts are as on
/// entry, and `output` is last written in VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT with VK_ACCESS_SHADER_WRITE_BIT: the
/// host makes that visible to whatever reads it. Views are 2D, single-sampled, one level and one layer.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct BgiDispatchInfo {
    /// BGI_STRUCTURE_TYPE_DISPATCH_INFO
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// In the recording state, outside a render pass, primary or secondary, of a queue family with compute; executed in
    /// the order of the bgiDispatch calls, on one queue or ordered by semaphores.
    pub command_buffer: VkCommandBuffer,
    /// Which view; it has a camera.
    pub view: BgiView,
    /// Depth as rendered with the view's camera: depth aspect of a depth format, or VK_FORMAT_R32_SFLOAT. Usage
    /// VK_IMAGE_USAGE_SAMPLED_BIT, layout VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL.
    pub depth: VkImageView,
    /// World-space surface normal in xyz, towards the camera: a float or snorm format. Usage
    /// VK_IMAGE_USAGE_SAMPLED_BIT, layout VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL.
    pub normal: VkImageView,
    /// Receives the indirect irradiance E_ind in rgb (linear Rec.709, unit of the lights; multiply by albedo / pi) and
    /// 1 in a; all 0 where nothing was drawn. Usage VK_IMAGE_USAGE_STORAGE_BIT, layout VK_IMAGE_LAYOUT_GENERAL. Every
    /// pixel of the region is written, and none is read before: its contents on entry do not matter.
    pub output: VkImageView,
    /// Format of `output`: VK_FORMAT_R16G16B16A16_SFLOAT or VK_FORMAT_R32G32B32A32_SFLOAT.
    pub output_format: VkFormat,
    /// Value of `depth` where nothing was drawn: 1, or 0 with reverse depth.
    pub clear_depth: f32,
    /// Left column of the rendered region, the same in all images, in pixels; 0 to BGI_MAX_EXTENT - 1. The region lies inside
    /// the images; what is outside of it is neither read nor written, so that several views may share them.
    pub x: u32,
    /// Top row of the rendered region in pixels; 0 to BGI_MAX_EXTENT - 1.
    pub y: u32,
    /// Width of the rendered region in pixels; 1 to the view's width. It may be another one in each frame (dynamic
    /// resolution): what was averaged stays.
    pub width: u32,
    /// Height of the rendered region in pixels; 1 to the view's height.
    pub height: u32,
    /// What the output shows instead of E_ind: BGI_DEBUG_VIEW_NONE, or a picture for the host's developer. The first
    /// such call on a context creates a pipeline.
    pub debug_view: BgiDebugView,
    /// Optional, with `direct` and `composite`: albedo of the surfaces in rgb, linear Rec.709, 0 to 1. Usage
    /// VK_IMAGE_USAGE_SAMPLED_BIT, layout VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL.
    pub albedo: VkImageView,
    /// Optional, with `albedo` and `composite`: what the surfaces send out by direct light and emission, and the
    /// background, in rgb (radiance, linear Rec.709, unit of the lights). Usage and layout as for `albedo`.
    pub direct: VkImageView,
    /// Optional, with `albedo` and `direct`: receives what the host would draw, direct + albedo / pi x E_ind, in rgb and 1
    /// in a; what `output` shows where that is a debug view. Format, usage and layout as for `output`; another image,
    /// access on entry and exit as for `output`. The first such call on a context creates a pipeline.
    pub composite: VkImageView,
    /// Optional: motion vectors, as engines hand them to temporal upscalers. For each pixel, in xy, where its surface was in
    /// the frame of the view's last bgiDispatch: previous pixel = pixel + motion * motionScale. The full motion on screen,
    /// the camera's too, and without jitter: what the cameras' projections are off their middle by is added here. A float or
    /// snorm format of two channels or more; 16 bits suffice. Where nothing was drawn it is not read. Usage
    /// VK_IMAGE_USAGE_SAMPLED_BIT, layout VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL. NULL: all is taken to have stood still
    /// since, and what moves leaves trails. Either may be given from one frame to the next.
    pub motion: VkImageView,
    /// From the values of `motion` to pixels of this frame's region, x to the right and y down; finite and not 0. 1 and 1 if
    /// they are pixels, width and height if they are parts of the image, width / 2 and -height / 2 if they are clip space
    /// with y up; with the other sign if they point from where the surface was to where it is. Not read without `motion`.
    pub motion_scale: [f32; 2],
}

structure_types! { BgiDispatchInfo = BGI_STRUCTURE_TYPE_DISPATCH_INFO }

fn debug_view(view: BgiDebugView) -> Result<Option<DebugView>, Failure> {
    Ok(Some(match view {
        BGI_DEBUG_VIEW_NONE => return Ok(None),
        BGI_DEBUG_VIEW_BRICKS => DebugView::Bricks,
        BGI_DEBUG_VIEW_ALBEDO => DebugView::Albedo,
        BGI_DEBUG_VIEW_NORMALS => DebugView::Normals,
        BGI_DEBUG_VIEW_RADIANCE => DebugView::Radiance,
        BGI_DEBUG_VIEW_STEPS => DebugView::Steps,
        BGI_DEBUG_VIEW_HISTORY => DebugView::History,
        BGI_DEBUG_VIEW_PROBES => DebugView::Probes,
        BGI_DEBUG_VIEW_IRRADIANCE => DebugView::Irradiance,
        BGI_DEBUG_VIEW_PROBE_RADIANCE => DebugView::ProbeRadiance,
        BGI_DEBUG_VIEW_FALLBACK => DebugView::Fallback,
        other => return Err(Failure::argument(format!("debugView is {other}"))),
    }))
}

fn composite(info: &BgiDispatchInfo) -> Result<Option<Composite>, Failure> {
    let given = [info.albedo, info.direct, info.composite].map(|view| !view.is_null());
    match given {
        [false, false, false] => Ok(None),
        [true, true, true] if info.composite == info.output => Err(Failure::argument("composite is output's image")),
        [true, true, true] => Ok(Some(Composite { albedo: info.albedo, direct: info.direct, output: info.composite })),
        _ => Err(Failure::argument("albedo, direct and composite are given together or not at all")),
    }
}

fn motion(info: &BgiDispatchInfo) -> Result<Option<Motion>, Failure> {
    if info.motion.is_null() {
        return Ok(None);
    }
    if !info.motion_scale.iter().all(|s| s.is_finite() && *s != 0.0) {
        return Err(Failure::argument(format!("motionScale is {:?}: finite and not 0", info.motion_scale)));
    }
    Ok(Some(Motion { image: info.motion, scale: info.motion_scale }))
}

/// Records one view's frame into the host's command buffer: copies of pending meshes, queued bricks, lighting, probes,
/// resolve. Compute and copies only; valid in secondary command buffers; no queue is touched and nothing is waited for.
/// Clobbered and not restored: the compute pipeline, compute descriptor sets and push constants. Barriers for the library's
/// own buffers are its own. The first call with an outputFormat creates its pipelines. The handles in `info` and the buffers of pending meshes must stay valid until the GPU has
/// finished with the command buffer.
///
/// @return BGI_SUCCESS; BGI_WARNING_WORLD_INCOMPLETE, after all its work, where bricks are left out for lack of memory
/// (the log says so once, when it begins); BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT, BGI_ERROR_INVALID_STRUCTURE,
/// BGI_ERROR_OUT_OF_MEMORY, BGI_ERROR_DEVICE_LOST or BGI_ERROR_VULKAN. After an error the host submits the command
/// buffer or drops it as it likes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiDispatch(context: BgiContext, info: *const BgiDispatchInfo) -> BgiResult {
    guard_context(context, |state| {
        // SAFETY: the header asks for a readable struct.
        let info = unsafe { input::structure(info)? };
        let view = state.view(info.view)?;
        if !info.clear_depth.is_finite() {
            return Err(Failure::argument("clearDepth is not finite"));
        }
        let output_float32 = match info.output_format {
            VkFormat::R16G16B16A16_SFLOAT => false,
            VkFormat::R32G32B32A32_SFLOAT => true,
            other => {
                let text = "R16G16B16A16_SFLOAT and R32G32B32A32_SFLOAT are possible";
                return Err(Failure::argument(format!("outputFormat is {}; {text}", other.as_raw())));
            }
        };
        let inputs = FrameInputs {
            command_buffer: info.command_buffer,
            view,
            depth: info.depth,
            clear_depth: info.clear_depth,
            normal: info.normal,
            motion: motion(info)?,
            output: info.output,
            output_float32,
            origin: [info.x, info.y],
            width: info.width,
            height: info.height,
            debug_view: debug_view(info.debug_view)?,
            composite: composite(info)?,
        };
        // SAFETY: the header asks for valid Vulkan handles as documented at each field; the core refuses NULL.
        unsafe { state.context.dispatch(&inputs)? };
        let complete = state.context.stats().bricks_left_out == 0;
        Ok(if complete { BGI_SUCCESS } else { BGI_WARNING_WORLD_INCOMPLETE })
    })
}
