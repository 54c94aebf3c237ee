//! The host's device and what it offers.

use crate::context::{DeviceHandles, DeviceRequirements};
use crate::error::{Error, Result};
use ash::vk;

/// Device functions, fetched through the host's `vkGetInstanceProcAddr`; libvulkan is never linked.
pub struct Device {
    pub raw: ash::Device,
    pub memory: vk::PhysicalDeviceMemoryProperties,
    pub limits: vk::PhysicalDeviceLimits,
    /// Bits of a timestamp that count; 0: none.
    pub timestamp_bits: u32,
}

/// What the shaders need of a device, as lines of (ok, text).
fn checks(properties: &vk::PhysicalDeviceProperties) -> Vec<(bool, String)> {
    let limits = &properties.limits;
    let at_least = |value: u32, need: u32, name: &str| (value >= need, format!("{name} is {value}, {need} is needed"));
    vec![
        (properties.api_version >= vk::API_VERSION_1_1, "Vulkan 1.1 is needed".to_owned()),
        at_least(limits.max_per_stage_descriptor_storage_buffers, 8, "maxPerStageDescriptorStorageBuffers"),
        at_least(limits.max_compute_shared_memory_size, 16_384, "maxComputeSharedMemorySize"),
        at_least(limits.max_compute_work_group_invocations, 128, "maxComputeWorkGroupInvocations"),
        at_least(limits.max_push_constants_size, 128, "maxPushConstantsSize"),
        at_least(limits.max_storage_buffer_range, 128 << 20, "maxStorageBufferRange"),
    ]
}

impl Device {
    /// # Safety
    /// The handles must be valid.
    pub unsafe fn requirements(
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
    ) -> Result<DeviceRequirements> {
        let static_fn = ash::StaticFn { get_instance_proc_addr };
        // SAFETY: the caller vouches for the handles.
        let properties =
            unsafe { ash::Instance::load(&static_fn, instance).get_physical_device_properties(physical_device) };
        let missing = checks(&properties).into_iter().filter(|(ok, _)| !ok).map(|(_, text)| text).collect();
        Ok(DeviceRequirements { api_version: vk::API_VERSION_1_1, missing })
    }

    /// # Safety
    /// The handles must be valid and outlive the value.
    pub unsafe fn new(handles: &DeviceHandles) -> Result<Self> {
        let static_fn = ash::StaticFn { get_instance_proc_addr: handles.get_instance_proc_addr };
        // SAFETY: the caller vouches for the handles.
        let instance = unsafe { ash::Instance::load(&static_fn, handles.instance) };
        let physical = handles.physical_device;
        // SAFETY: as above.
        let (properties, memory, queues) = unsafe {
            (
                instance.get_physical_device_properties(physical),
                instance.get_physical_device_memory_properties(physical),
                instance.get_physical_device_queue_family_properties(physical),
            )
        };
        if let Some((_, text)) = checks(&properties).into_iter().find(|(ok, _)| !ok) {
            return Err(Error::UnsupportedDevice(text));
        }
        let compute = queues.iter().filter(|q| q.queue_flags.contains(vk::QueueFlags::COMPUTE));
        let timestamp_bits = compute.map(|q| q.timestamp_valid_bits).min().unwrap_or(0);
        // SAFETY: as above.
        let raw = unsafe { ash::Device::load(instance.fp_v1_0(), handles.device) };
        Ok(Self { raw, memory, limits: properties.limits, timestamp_bits })
    }
    /// Bytes that one of the host's buffers has at most: those that it needs of memory.
    pub fn buffer_bytes(&self, buffer: vk::Buffer) -> u64 {
        // SAFETY: the host vouches for its buffers.
        unsafe { self.raw.get_buffer_memory_requirements(buffer) }.size
    }
}
