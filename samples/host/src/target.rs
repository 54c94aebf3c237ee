//! An image of the frame with the state the GPU last left it in.

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use ash::vk;
use std::sync::Arc;
use wgpu_hal::{Device as _, vulkan as hal};
use wgpu_types as wgt;

/// What the GPU does with an image: stages, access and layout in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Use {
    /// Contents do not matter.
    Undefined,
    /// Written as a colour attachment.
    Color,
    /// Written and tested as the depth attachment.
    Depth,
    /// Sampled by compute shaders.
    Sampled,
    /// Read and written by compute shaders as a storage image.
    Storage,
    /// Source of a copy.
    CopySource,
    /// Target of a clear.
    Clear,
}

impl Use {
    fn barrier(self) -> (vk::PipelineStageFlags, vk::AccessFlags, vk::ImageLayout) {
        use vk::{AccessFlags as A, ImageLayout as L, PipelineStageFlags as S};
        match self {
            Self::Undefined => (S::TOP_OF_PIPE, A::empty(), L::UNDEFINED),
            Self::Color => (S::COLOR_ATTACHMENT_OUTPUT, A::COLOR_ATTACHMENT_WRITE, L::COLOR_ATTACHMENT_OPTIMAL),
            Self::Depth => (
                S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS,
                A::DEPTH_STENCIL_ATTACHMENT_READ | A::DEPTH_STENCIL_ATTACHMENT_WRITE,
                L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
            ),
            Self::Sampled => (S::COMPUTE_SHADER, A::SHADER_READ, L::SHADER_READ_ONLY_OPTIMAL),
            Self::Storage => (S::COMPUTE_SHADER, A::SHADER_READ | A::SHADER_WRITE, L::GENERAL),
            Self::CopySource => (S::TRANSFER, A::TRANSFER_READ, L::TRANSFER_SRC_OPTIMAL),
            Self::Clear => (S::TRANSFER, A::TRANSFER_WRITE, L::TRANSFER_DST_OPTIMAL),
        }
    }
}

/// A single-layer 2D image and its view.
pub(crate) struct Target {
    gpu: Arc<Gpu>,
    texture: Option<hal::Texture>,
    view: Option<hal::TextureView>,
    format: wgt::TextureFormat,
    size: [u32; 2],
    state: Use,
}

impl Target {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        label: &'static str,
        format: wgt::TextureFormat,
        usage: wgt::TextureUses,
        size: [u32; 2],
    ) -> Result<Self> {
        Self::with_view(gpu, label, format, usage, size, wgt::TextureViewDimension::D2)
    }

    /// Seen as an array of one layer.
    pub(crate) fn array(
        gpu: &Arc<Gpu>,
        label: &'static str,
        format: wgt::TextureFormat,
        usage: wgt::TextureUses,
        size: [u32; 2],
    ) -> Result<Self> {
        Self::with_view(gpu, label, format, usage, size, wgt::TextureViewDimension::D2Array)
    }

    fn with_view(
        gpu: &Arc<Gpu>,
        label: &'static str,
        format: wgt::TextureFormat,
        usage: wgt::TextureUses,
        size: [u32; 2],
        dimension: wgt::TextureViewDimension,
    ) -> Result<Self> {
        let usage = usage | wgt::TextureUses::COPY_SRC;
        let description = wgpu_hal::TextureDescriptor {
            label: Some(label),
            size: wgt::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgt::TextureDimension::D2,
            format,
            usage,
            memory_flags: wgpu_hal::MemoryFlags::empty(),
            view_formats: Vec::new(),
        };
        // SAFETY: the size was checked by the host; the usages fit the format.
        let texture = unsafe { gpu.device.create_texture(&description) }.map_err(Error::gpu("creating an image"))?;
        let mut target =
            Self { gpu: gpu.clone(), texture: Some(texture), view: None, format, size, state: Use::Undefined };
        let view = wgpu_hal::TextureViewDescriptor {
            label: Some(label),
            format,
            dimension,
            usage: usage - wgt::TextureUses::COPY_SRC - wgt::TextureUses::COPY_DST,
            range: wgt::ImageSubresourceRange::default(),
        };
        // SAFETY: the view covers the whole image in its own format.
        let view = unsafe { gpu.device.create_texture_view(target.texture(), &view) };
        target.view = Some(view.map_err(Error::gpu("creating an image view"))?);
        Ok(target)
    }

    pub(crate) fn format(&self) -> wgt::TextureFormat {
        self.format
    }

    pub(crate) fn size(&self) -> [u32; 2] {
        self.size
    }

    pub(crate) fn texture(&self) -> &hal::Texture {
        self.texture.as_ref().expect("present until drop")
    }

    pub(crate) fn view(&self) -> &hal::TextureView {
        self.view.as_ref().expect("present since creation")
    }

    pub(crate) fn raw_image(&self) -> vk::Image {
        // SAFETY: the handle is used while `self` lives.
        unsafe { self.texture().raw_handle() }
    }

    pub(crate) fn raw_view(&self) -> vk::ImageView {
        // SAFETY: the handle is used while `self` lives.
        unsafe { self.view().raw_handle() }
    }

    pub(crate) fn state(&self) -> Use {
        self.state
    }

    pub(crate) fn whole(&self) -> vk::ImageSubresourceRange {
        let depth = self.format == wgt::TextureFormat::Depth32Float;
        vk::ImageSubresourceRange {
            aspect_mask: if depth { vk::ImageAspectFlags::DEPTH } else { vk::ImageAspectFlags::COLOR },
            base_mip_level: 0,
            level_count: 1,
            base_array_layer: 0,
            layer_count: 1,
        }
    }

    /// Records the barrier from the last use to `next`; `keep` tells whether the contents matter.
    ///
    /// # Safety
    /// `commands` is recording, outside a render pass, and is submitted in the order of these calls.
    pub(crate) unsafe fn transition(&mut self, commands: vk::CommandBuffer, next: Use, keep: bool) {
        let (from_stage, from_access, from_layout) = self.state.barrier();
        let (to_stage, to_access, to_layout) = next.barrier();
        let barrier = vk::ImageMemoryBarrier::default()
            .src_access_mask(from_access)
            .dst_access_mask(to_access)
            .old_layout(if keep { from_layout } else { vk::ImageLayout::UNDEFINED })
            .new_layout(to_layout)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(self.raw_image())
            .subresource_range(self.whole());
        // SAFETY: by the caller; the image is alive.
        unsafe {
            self.gpu.raw().cmd_pipeline_barrier(
                commands,
                from_stage,
                to_stage,
                vk::DependencyFlags::empty(),
                &[],
                &[],
                &[barrier],
            );
        }
        self.state = next;
    }
}

impl Drop for Target {
    fn drop(&mut self) {
        // SAFETY: the host waits for the queue before it drops its targets.
        unsafe {
            if let Some(view) = self.view.take() {
                self.gpu.device.destroy_texture_view(view);
            }
            if let Some(texture) = self.texture.take() {
                self.gpu.device.destroy_texture(texture);
            }
        }
    }
}
