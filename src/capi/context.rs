//! Creating and destroying contexts.

use super::device::{check_vulkan_handle, loader};
use super::guard::{Failure, Outcome, guard};
use super::handles::{self, Log, State};
use super::input::{self, structure_types};
use super::parallel::parallel_for;
use super::settings::BgiSettings;
use super::types::*;
use super::version::BGI_ABI_VERSION;
use super::vk::*;
use crate::context::{Context, ContextDesc, DeviceHandles};
use crate::settings::Settings;
use std::ffi::c_void;

/// What bgiCreateContext needs.
#[repr(C)]
pub struct BgiContextCreateInfo {
    /// BGI_STRUCTURE_TYPE_CONTEXT_CREATE_INFO
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// BGI_ABI_VERSION, of the header that the caller is compiled with.
    pub abi_version: u32,
    /// Frames that the host may have on the GPU at once, 1 to 8. When bgiDispatch is called on a context for the n-th
    /// time, the GPU must have finished with the command buffer of call n - framesInFlight (host that records several
    /// views a frame: frames times views). The host's own frame fence gives this.
    pub frames_in_flight: u32,
    /// The loader's entry point; required.
    pub get_instance_proc_addr: PFN_vkGetInstanceProcAddr,
    /// Created for Vulkan 1.1 or newer; required. Must outlive the context, as `device` must.
    pub instance: VkInstance,
    /// The physical device of `device`; required.
    pub physical_device: VkPhysicalDevice,
    /// Created with what bgiGetDeviceRequirements asks for; required. None of its queues is ever touched.
    pub device: VkDevice,
    /// Optional; NULL: the settings of BGI_PRESET_MEDIUM. Copied.
    pub settings: *const BgiSettings,
    /// Optional; receives log lines, those of this call included, until the context is destroyed.
    pub log: BgiLogCallback,
    /// Handed to `log` as it is; may be used on any thread that calls the library.
    pub log_user_data: *mut c_void,
    /// Optional; NULL: work is done on the calling thread. The result does not depend on it.
    pub parallel_for: BgiParallelFor,
    /// Handed to `parallelFor` as it is.
    pub parallel_user_data: *mut c_void,
}

structure_types! { BgiContextCreateInfo = BGI_STRUCTURE_TYPE_CONTEXT_CREATE_INFO }

/// Creates a context: pipelines and fixed tables. Records nothing, submits nothing. Takes some milliseconds, most of
/// them in the driver's compiler.
///
/// @param context Receives the handle; NULL where the call fails. The caller owns it and ends it with
/// bgiDestroyContext.
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_ARGUMENT, BGI_ERROR_INVALID_STRUCTURE, BGI_ERROR_INCOMPATIBLE_ABI,
/// BGI_ERROR_UNSUPPORTED_DEVICE, BGI_ERROR_OUT_OF_MEMORY, BGI_ERROR_DEVICE_LOST or BGI_ERROR_VULKAN; the text is in
/// bgiGetLastError(NULL, ...).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiCreateContext(info: *const BgiContextCreateInfo, context: *mut BgiContext) -> BgiResult {
    guard(|| {
        input::check_address(context, "context")?;
        // SAFETY: not NULL and aligned; the header asks for writable memory.
        unsafe { context.write(std::ptr::null_mut()) };
        // SAFETY: the header asks for a readable struct.
        let info = unsafe { input::structure(info)? };
        let log = Log::new(info.log, info.log_user_data);
        create(info, log, context).inspect_err(|failure| log.line(BGI_LOG_ERROR, &failure.text))
    })
}

fn create(info: &BgiContextCreateInfo, log: Log, context: *mut BgiContext) -> Outcome {
    if info.abi_version != BGI_ABI_VERSION {
        let text = format!("abiVersion is {}; this library has ABI {BGI_ABI_VERSION}", info.abi_version);
        return Err(Failure::new(BGI_ERROR_INCOMPATIBLE_ABI, text));
    }
    check_vulkan_handle(info.instance, "instance")?;
    check_vulkan_handle(info.physical_device, "physicalDevice")?;
    check_vulkan_handle(info.device, "device")?;
    let desc = ContextDesc {
        device: DeviceHandles {
            get_instance_proc_addr: loader(info.get_instance_proc_addr)?,
            instance: info.instance,
            physical_device: info.physical_device,
            device: info.device,
        },
        settings: if info.settings.is_null() {
            Settings::default()
        } else {
            // SAFETY: not NULL; the header asks for a readable struct.
            unsafe { input::structure(info.settings)? }.settings()?
        },
        frames_in_flight: info.frames_in_flight,
        parallel_for: parallel_for(info.parallel_for, info.parallel_user_data),
    };
    // SAFETY: the header asks for valid Vulkan handles that outlive the context; none is NULL.
    let created = unsafe { Context::new(desc)? };
    let handle = handles::insert(State::new(created), log);
    // SAFETY: bgiCreateContext has checked the address and written to it.
    unsafe { context.write(handle) };
    Ok(BGI_SUCCESS)
}

/// Destroys a context and its views, and frees all their memory. The GPU must have finished with every command buffer
/// that bgiDispatch recorded into, and the VkDevice must still exist (a lost device is fine). Waits for calls that
/// other threads are making on the context; they and all later ones get BGI_ERROR_INVALID_HANDLE.
///
/// @return BGI_SUCCESS or BGI_ERROR_INVALID_HANDLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiDestroyContext(context: BgiContext) -> BgiResult {
    guard(|| handles::remove(context).map(|()| BGI_SUCCESS))
}
