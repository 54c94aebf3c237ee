//! Views and their cameras.

use super::guard::guard_context;
use super::input::{self, structure_types};
use super::types::*;
use crate::scene::Camera;
use std::ffi::c_void;

/// What bgiCreateView needs.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiViewCreateInfo {
    /// BGI_STRUCTURE_TYPE_VIEW_CREATE_INFO
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// Largest width of the view's images in pixels, 1 to BGI_MAX_EXTENT.
    pub width: u32,
    /// Largest height of the view's images in pixels, 1 to BGI_MAX_EXTENT.
    pub height: u32,
}

/// A camera exactly as the G-buffer was rendered with it: any handedness; reverse, infinite, jittered or orthographic
/// projection. Everything finite. A point p of the world is at projection * (viewRotation * (p - position)) in clip
/// space.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiCamera {
    /// BGI_STRUCTURE_TYPE_CAMERA
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// World position in metres.
    pub position: [f64; 3],
    /// Columns of the rotation from world to view space: viewRotation[column][row].
    pub view_rotation: [[f32; 3]; 3],
    /// Columns of the projection from view space to Vulkan's clip space (y down in the framebuffer, depth 0 to 1):
    /// projection[column][row].
    pub projection: [[f32; 4]; 4],
}

structure_types! { BgiViewCreateInfo = BGI_STRUCTURE_TYPE_VIEW_CREATE_INFO, BgiCamera = BGI_STRUCTURE_TYPE_CAMERA }

/// Creates a view: probes and history for images of up to the given size. Needs a camera (bgiSetCamera) before its
/// first dispatch.
///
/// @param view Receives the handle; NULL where the call fails. The context owns it.
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT, BGI_ERROR_INVALID_STRUCTURE,
/// BGI_ERROR_OUT_OF_MEMORY, BGI_ERROR_DEVICE_LOST or BGI_ERROR_VULKAN.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiCreateView(
    context: BgiContext,
    info: *const BgiViewCreateInfo,
    view: *mut BgiView,
) -> BgiResult {
    guard_context(context, |state| {
        input::check_address(view, "view")?;
        // SAFETY: not NULL and aligned; the header asks for writable memory.
        unsafe { view.write(std::ptr::null_mut()) };
        // SAFETY: the header asks for a readable struct.
        let info = unsafe { input::structure(info)? };
        let handle = state.context.create_view(info.width, info.height)?;
        let handle = state.insert_view(handle);
        // SAFETY: as above.
        unsafe { view.write(handle) };
        Ok(BGI_SUCCESS)
    })
}

/// Destroys a view and frees its memory. The GPU must have finished with every command buffer into which bgiDispatch
/// recorded it.
///
/// @return BGI_SUCCESS or BGI_ERROR_INVALID_HANDLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiDestroyView(context: BgiContext, view: BgiView) -> BgiResult {
    guard_context(context, |state| {
        let id = state.view(view)?;
        state.context.destroy_view(id)?;
        state.remove_view(view);
        Ok(BGI_SUCCESS)
    })
}

/// Sets a view's camera for its following dispatches. Records nothing.
///
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT or BGI_ERROR_INVALID_STRUCTURE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiSetCamera(context: BgiContext, view: BgiView, camera: *const BgiCamera) -> BgiResult {
    guard_context(context, |state| {
        let id = state.view(view)?;
        // SAFETY: the header asks for a readable struct.
        let camera = unsafe { input::structure(camera)? };
        let BgiCamera { position, view_rotation, projection, .. } = *camera;
        state.context.set_camera(id, &Camera { position, view_rotation, projection })?;
        Ok(BGI_SUCCESS)
    })
}
