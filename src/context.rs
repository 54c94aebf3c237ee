//! Owns the persistent state: create, update, record, report.

use crate::error::Result;
use crate::scene::{Camera, Light, MeshUpdate, Sky};
use crate::settings::Settings;
use ash::vk;

/// The host's Vulkan objects. They must outlive the context; no queue is ever touched.
#[derive(Clone, Copy)]
pub struct DeviceHandles {
    /// The loader's entry point; every other function is fetched through it.
    pub get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
    /// Created for Vulkan 1.1 or newer.
    pub instance: vk::Instance,
    /// The physical device of `device`.
    pub physical_device: vk::PhysicalDevice,
    /// Created with what [`DeviceRequirements`] names.
    pub device: vk::Device,
}

/// What a device must offer; ask before the device exists ([`Context::device_requirements`]).
#[derive(Clone, Debug, Default)]
pub struct DeviceRequirements {
    /// Lowest Vulkan version, as `VK_MAKE_API_VERSION`.
    pub api_version: u32,
    /// What the device lacks, one readable line each; empty: the device will do.
    pub missing: Vec<String>,
}

/// What [`Context::new`] needs.
pub struct ContextDesc {
    /// The host's device.
    pub device: DeviceHandles,
    /// Fixed for the context's life.
    pub settings: Settings,
    /// 1 to 8. When `dispatch` is called for the n-th time, the GPU has finished with the command buffer of call
    /// n - frames_in_flight: the host's own frame fence already guarantees this.
    pub frames_in_flight: u32,
}

/// A view of a context: a camera with its own probes and history.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ViewId(pub u64);

/// One frame's inputs and output for [`Context::dispatch`].
///
/// Only compute work is recorded, outside a render pass. Clobbered: the compute pipeline, compute descriptor sets and
/// push constants. The images must be readable by compute shaders on entry (the host's barrier); `output` is written
/// by compute shaders (`SHADER_WRITE`) and is the host's to make visible afterwards.
#[derive(Clone, Copy, Debug)]
pub struct FrameInputs {
    /// In the recording state, on a queue family with compute; executed in the order of the dispatch calls.
    pub command_buffer: vk::CommandBuffer,
    /// Which view.
    pub view: ViewId,
    /// Depth as rendered with the view's camera (depth aspect of a depth format, or R32_SFLOAT); usage SAMPLED, layout
    /// `SHADER_READ_ONLY_OPTIMAL`.
    pub depth: vk::ImageView,
    /// Value of `depth` where nothing was drawn (1.0, or 0.0 with reverse depth).
    pub clear_depth: f32,
    /// World-space normal in xyz, towards the camera (float or snorm format); usage SAMPLED, layout
    /// `SHADER_READ_ONLY_OPTIMAL`.
    pub normal: vk::ImageView,
    /// Receives E_ind in rgb (irradiance, linear Rec.709, unit of the lights) and 1 in a, 0 where nothing was drawn.
    /// Format R16G16B16A16_SFLOAT or R32G32B32A32_SFLOAT as `output_float32` says; usage STORAGE; layout `GENERAL`.
    pub output: vk::ImageView,
    /// Whether `output` is R32G32B32A32_SFLOAT (else R16G16B16A16_SFLOAT).
    pub output_float32: bool,
    /// Width of the rendered region in pixels (at most the view's).
    pub width: u32,
    /// Height of the rendered region in pixels (at most the view's).
    pub height: u32,
}

/// GPU time of one pass.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// The pass, as in the frame list.
    pub name: &'static str,
    /// Milliseconds, by timestamps; all its dispatches of the frame summed.
    pub ms: f64,
}

/// A device allocation.
#[derive(Clone, Debug, PartialEq)]
pub struct ResourceSize {
    /// What it holds.
    pub name: &'static str,
    /// Bytes allocated.
    pub bytes: u64,
}

/// What the context holds and did; times are those of the latest frame whose results have arrived.
#[derive(Clone, Debug, Default)]
pub struct Stats {
    /// GPU milliseconds of the whole recording; 0 without timestamps.
    pub frame_ms: f64,
    /// GPU milliseconds by pass, in recording order; empty without timestamps.
    pub passes: Vec<PassTime>,
    /// CPU milliseconds of the latest `dispatch` call.
    pub cpu_ms: f64,
    /// Device memory of the world in bytes.
    pub world_bytes: u64,
    /// Device memory of all views in bytes.
    pub view_bytes: u64,
    /// Every device allocation.
    pub resources: Vec<ResourceSize>,
    /// Bricks resident.
    pub bricks: u32,
    /// Bricks that should be resident and are not (waiting, or no memory).
    pub bricks_missing: u32,
    /// Lit voxel faces resident.
    pub faces: u32,
    /// Allocation units of 64 bytes in use by bricks.
    pub pages: u32,
    /// Rays traced in the frame.
    pub rays: u64,
    /// Dispatch calls so far.
    pub frames: u64,
}

/// The library's state on one device. See the crate's front page for the frame.
pub struct Context {
    stats: Stats,
}

impl Context {
    /// Says whether a physical device will do, before a device is created on it.
    ///
    /// # Safety
    /// The handles must be valid.
    pub unsafe fn device_requirements(
        _get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        _instance: vk::Instance,
        _physical_device: vk::PhysicalDevice,
    ) -> Result<DeviceRequirements> {
        Ok(DeviceRequirements { api_version: vk::API_VERSION_1_1, missing: Vec::new() })
    }

    /// Creates pipelines and the fixed tables.
    ///
    /// # Safety
    /// The handles in `desc.device` must be valid and outlive the context.
    pub unsafe fn new(desc: ContextDesc) -> Result<Self> {
        desc.settings.validate()?;
        Ok(Self { stats: Stats::default() })
    }

    /// Adds, replaces, moves or removes what the world is made of. On an error nothing of the batch is applied.
    pub fn update_meshes(&mut self, _update: &MeshUpdate) -> Result<()> {
        Ok(())
    }

    /// Replaces all lights and the sky.
    pub fn set_lights(&mut self, _lights: &[Light], _sky: Sky) -> Result<()> {
        Ok(())
    }

    /// Creates a view for images of up to `width` x `height` pixels, 1 to 16384 each.
    pub fn create_view(&mut self, _width: u32, _height: u32) -> Result<ViewId> {
        Ok(ViewId(1))
    }

    /// Destroys a view. The GPU must have finished with it.
    pub fn destroy_view(&mut self, _view: ViewId) -> Result<()> {
        Ok(())
    }

    /// Sets a view's camera for the following dispatches.
    pub fn set_camera(&mut self, _view: ViewId, _camera: &Camera) -> Result<()> {
        Ok(())
    }

    /// Records one frame into the host's command buffer.
    ///
    /// # Safety
    /// `inputs` must hold valid handles as documented at [`FrameInputs`].
    pub unsafe fn dispatch(&mut self, _inputs: &FrameInputs) -> Result<()> {
        Ok(())
    }

    /// What the context holds and did.
    pub fn stats(&self) -> &Stats {
        &self.stats
    }
}
