//! What a device must offer, asked before there is one.

use super::guard::{Failure, guard};
use super::input::{self, structure_types};
use super::types::*;
use super::vk::*;
use crate::context::Context;
use std::ffi::{c_char, c_void};

/// A physical device to be judged. Every field is required.
#[repr(C)]
pub struct BgiDeviceQuery {
    /// BGI_STRUCTURE_TYPE_DEVICE_QUERY
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// The loader's entry point; every other function is fetched through it. The library never links the loader.
    pub get_instance_proc_addr: PFN_vkGetInstanceProcAddr,
    /// Created for Vulkan 1.1 or newer.
    pub instance: VkInstance,
    /// A physical device of `instance`.
    pub physical_device: VkPhysicalDevice,
}

/// What the library needs of a device. Zero it, then set sType.
#[repr(C)]
pub struct BgiDeviceRequirements {
    /// BGI_STRUCTURE_TYPE_DEVICE_REQUIREMENTS
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *mut c_void,
    /// Out: lowest apiVersion that the instance and the device must have been created for, as VK_MAKE_API_VERSION.
    pub api_version: u32,
    /// Out: 1 where the physical device will do, else 0.
    pub supported: u32,
    /// In: bytes at `missing`. Out: bytes written, terminating zero included, or needed where `missing` is NULL.
    pub missing_size: u32,
    /// Optional: receives what the device lacks as text, one readable line each; empty where it will do.
    pub missing: *mut c_char,
}

structure_types! { BgiDeviceQuery = BGI_STRUCTURE_TYPE_DEVICE_QUERY }

structure_types! { BgiDeviceRequirements = BGI_STRUCTURE_TYPE_DEVICE_REQUIREMENTS }

/// Says whether a physical device will do, before a VkDevice is made on it. A device that will not do is no error of
/// this call: `supported` is 0 and `missing` says why.
///
/// @return BGI_SUCCESS; BGI_INCOMPLETE where `missingSize` was too small; BGI_ERROR_INVALID_ARGUMENT,
/// BGI_ERROR_INVALID_STRUCTURE, BGI_ERROR_OUT_OF_MEMORY or BGI_ERROR_VULKAN.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiGetDeviceRequirements(
    query: *const BgiDeviceQuery,
    requirements: *mut BgiDeviceRequirements,
) -> BgiResult {
    guard(|| {
        // SAFETY: the header asks for readable structs, the second one writable and zeroed.
        let (query, out) = unsafe { (input::structure(query)?, input::structure_mut(requirements)?) };
        let entry = loader(query.get_instance_proc_addr)?;
        check_vulkan_handle(query.instance, "instance")?;
        check_vulkan_handle(query.physical_device, "physicalDevice")?;
        // SAFETY: the header asks for valid Vulkan handles; they are not NULL.
        let needed = unsafe { Context::device_requirements(entry, query.instance, query.physical_device)? };
        out.api_version = needed.api_version;
        out.supported = u32::from(needed.missing.is_empty());
        // The terminating zero is written even where the text is cut.
        let mut text = needed.missing.join("\n").into_bytes();
        let complete = out.missing.is_null() || text.len() < out.missing_size as usize;
        if !complete {
            text.truncate((out.missing_size as usize).saturating_sub(1));
        }
        text.push(0);
        // SAFETY: the header asks for `missingSize` writable bytes.
        let fits = unsafe { input::fill(out.missing.cast::<u8>(), &mut out.missing_size, &text, "missing")? };
        Ok(if complete && fits { BGI_SUCCESS } else { BGI_INCOMPLETE })
    })
}

/// Refuses a NULL loader entry point.
pub(super) fn loader(entry: PFN_vkGetInstanceProcAddr) -> Result<ash::vk::PFN_vkGetInstanceProcAddr, Failure> {
    entry.ok_or_else(|| Failure::argument("getInstanceProcAddr is NULL"))
}

/// Refuses VK_NULL_HANDLE.
pub(super) fn check_vulkan_handle(handle: impl ash::vk::Handle, field: &str) -> Result<(), Failure> {
    if handle.is_null() { Err(Failure::argument(format!("{field} is VK_NULL_HANDLE"))) } else { Ok(()) }
}
