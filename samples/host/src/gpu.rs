//! The host's own device: opened by wgpu-hal, handed to brickgi as raw handles.

use crate::error::{Error, Result};
use crate::validation::Validation;
use wgpu_hal::{Adapter as _, Device as _, Instance as _, Queue as _, vulkan as hal};
use wgpu_types as wgt;

/// An opened device with its queue.
///
/// The fields drop in this order: Vulkan wants children before parents.
pub struct Gpu {
    pub(crate) queue: hal::Queue,
    pub(crate) device: hal::Device,
    adapter: hal::Adapter,
    validation: Option<Validation>,
    instance: hal::Instance,
    name: String,
}

impl Gpu {
    /// Opens the best device: discrete before integrated before software. With `validation`, the Khronos layer checks
    /// every call (core and synchronisation) and its messages are kept.
    pub fn open(validation: bool) -> Result<Self> {
        let mut flags = wgt::InstanceFlags::ALLOW_UNDERLYING_NONCOMPLIANT_ADAPTER;
        if validation {
            flags |= wgt::InstanceFlags::DEBUG | wgt::InstanceFlags::VALIDATION;
        }
        let description = wgpu_hal::InstanceDescriptor {
            name: "brickgi host",
            flags,
            memory_budget_thresholds: wgt::MemoryBudgetThresholds::default(),
            backend_options: wgt::BackendOptions::default(),
            telemetry: None,
            display: None,
        };
        // SAFETY: the descriptor is valid; the instance outlives everything made from it (field order of `Gpu`).
        let instance = unsafe { hal::Instance::init(&description) }.map_err(|e| Error::NoDevice(e.to_string()))?;
        let validation = if validation { Some(Validation::install(instance.shared_instance())?) } else { None };
        let (exposed, name) = best_adapter(&instance)?;
        // SAFETY: no feature is asked for beyond what every adapter has.
        let opened = unsafe {
            exposed.adapter.open(wgt::Features::empty(), &wgt::Limits::default(), &wgt::MemoryHints::default())
        };
        let opened = opened.map_err(|e| Error::NoDevice(format!("{name}: {e}")))?;
        Ok(Self { queue: opened.queue, device: opened.device, adapter: exposed.adapter, validation, instance, name })
    }

    /// The raw handles that brickgi works with; valid while `self` lives.
    pub fn handles(&self) -> brickgi::DeviceHandles {
        let shared = self.instance.shared_instance();
        brickgi::DeviceHandles {
            get_instance_proc_addr: shared.entry().static_fn().get_instance_proc_addr,
            instance: shared.raw_instance().handle(),
            physical_device: self.adapter.raw_physical_device(),
            device: self.device.raw_device().handle(),
        }
    }

    /// The device's name as its driver reports it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Every warning and error of the validation layer so far; empty without validation.
    pub fn validation_messages(&self) -> Vec<String> {
        self.validation.as_ref().map(Validation::messages).unwrap_or_default()
    }

    pub(crate) fn raw(&self) -> &ash::Device {
        self.device.raw_device()
    }

    /// Blocks until the queue is empty.
    pub(crate) fn wait_idle(&self) -> Result<()> {
        // SAFETY: the queue is used from the thread that owns the host only.
        unsafe { self.queue.wait_for_idle() }.map_err(Error::gpu("waiting for the queue"))
    }

    /// A host-visible buffer that starts with `bytes` (at least 16 bytes long).
    pub(crate) fn filled_buffer(
        &self,
        label: &'static str,
        usage: wgt::BufferUses,
        bytes: &[u8],
    ) -> Result<hal::Buffer> {
        let buffer = self.buffer(label, usage | wgt::BufferUses::MAP_WRITE, bytes.len() as u64)?;
        if bytes.is_empty() {
            return Ok(buffer);
        }
        // SAFETY: the buffer is at least `bytes.len()` long, mappable, coherent and not yet used by the GPU.
        unsafe {
            match self.device.map_buffer(&buffer, 0..bytes.len() as u64) {
                Ok(mapping) => {
                    std::ptr::copy_nonoverlapping(bytes.as_ptr(), mapping.ptr.as_ptr(), bytes.len());
                    self.device.unmap_buffer(&buffer);
                    Ok(buffer)
                }
                Err(e) => {
                    self.device.destroy_buffer(buffer);
                    Err(Error::gpu("mapping a buffer")(e))
                }
            }
        }
    }

    /// A host-visible, coherent buffer of at least 16 bytes.
    pub(crate) fn buffer(&self, label: &'static str, usage: wgt::BufferUses, size: u64) -> Result<hal::Buffer> {
        let description = wgpu_hal::BufferDescriptor {
            label: Some(label),
            size: size.max(16),
            usage,
            memory_flags: wgpu_hal::MemoryFlags::PREFER_COHERENT,
        };
        // SAFETY: the size is not zero.
        unsafe { self.device.create_buffer(&description) }.map_err(Error::gpu("creating a buffer"))
    }
}

/// The best adapter that brickgi accepts, with its name.
fn best_adapter(instance: &hal::Instance) -> Result<(wgpu_hal::ExposedAdapter<hal::Api>, String)> {
    // SAFETY: no surface is given.
    let mut adapters = unsafe { instance.enumerate_adapters(None) };
    adapters.sort_by_key(|a| match a.info.device_type {
        wgt::DeviceType::DiscreteGpu => 0,
        wgt::DeviceType::IntegratedGpu => 1,
        wgt::DeviceType::VirtualGpu => 2,
        wgt::DeviceType::Other => 3,
        wgt::DeviceType::Cpu => 4,
    });
    let mut lacking = Vec::new();
    for adapter in adapters {
        let name = adapter.info.name.clone();
        let missing = missing_on(instance, &adapter.adapter)?;
        if missing.is_empty() {
            return Ok((adapter, name));
        }
        lacking.push(format!("{name} lacks {}", missing.join(", ")));
    }
    Err(Error::NoDevice(if lacking.is_empty() { "none found".into() } else { lacking.join("; ") }))
}

fn missing_on(instance: &hal::Instance, adapter: &hal::Adapter) -> Result<Vec<String>> {
    let shared = instance.shared_instance();
    // SAFETY: the three handles are alive and belong together.
    let requirements = unsafe {
        brickgi::Context::device_requirements(
            shared.entry().static_fn().get_instance_proc_addr,
            shared.raw_instance().handle(),
            adapter.raw_physical_device(),
        )
    }?;
    let mut missing = requirements.missing;
    if adapter.physical_device_capabilities().properties().api_version < requirements.api_version {
        missing.push("a new enough Vulkan version".into());
    }
    Ok(missing)
}
