//! Copies images of the GPU to the CPU, outside the frame loop.

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::image::Image;
use crate::target::{Target, Use};
use half::f16;
use wgpu_hal::{CommandEncoder as _, Device as _, vulkan as hal};
use wgpu_types as wgt;

/// Waits for the queue, then reads `target` as four channels; single-channel formats fill the first.
pub(crate) fn read(gpu: &Gpu, target: &mut Target) -> Result<Image<[f32; 4]>> {
    gpu.wait_idle()?;
    let [width, height] = target.size();
    let texel = texel_bytes(target.format());
    let size = u64::from(width) * u64::from(height) * texel as u64;
    let usage = wgt::BufferUses::COPY_DST | wgt::BufferUses::MAP_READ;
    let buffer = gpu.buffer("readback", usage, size)?;
    let result = copy(gpu, target, &buffer, texel).and_then(|()| mapped(gpu, &buffer, size));
    // SAFETY: `copy` waited for the queue or submitted nothing.
    unsafe { gpu.device.destroy_buffer(buffer) };
    let pixels = decode(&result?, target.format());
    Ok(Image { width, height, pixels })
}

fn copy(gpu: &Gpu, target: &mut Target, buffer: &hal::Buffer, texel: usize) -> Result<()> {
    let [width, height] = target.size();
    let region = wgpu_hal::BufferTextureCopy {
        buffer_layout: wgt::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * texel as u32),
            rows_per_image: Some(height),
        },
        texture_base: wgpu_hal::TextureCopyBase {
            mip_level: 0,
            array_layer: 0,
            origin: wgt::Origin3d::ZERO,
            aspect: wgpu_hal::FormatAspects::from(target.format()),
        },
        size: wgpu_hal::CopyExtent { width, height, depth: 1 },
    };
    let state = target.state();
    once(gpu, |encoder| {
        // SAFETY: the encoder records; the region covers the whole image and fits the buffer.
        unsafe {
            target.transition(encoder.raw_handle(), Use::CopySource, true);
            let source = wgt::TextureUses::COPY_SRC;
            encoder.copy_texture_to_buffer(target.texture(), source, buffer, std::iter::once(region));
            target.transition(encoder.raw_handle(), state, true);
            let barrier = wgpu_hal::BufferBarrier {
                buffer,
                usage: wgpu_hal::StateTransition { from: wgt::BufferUses::COPY_DST, to: wgt::BufferUses::MAP_READ },
            };
            encoder.transition_buffers(std::iter::once(barrier));
        }
    })
}

/// Records, submits and waits.
pub(crate) fn once(gpu: &Gpu, record: impl FnOnce(&mut hal::CommandEncoder)) -> Result<()> {
    use wgpu_hal::Queue as _;
    let description = wgpu_hal::CommandEncoderDescriptor { label: None, queue: &gpu.queue };
    // SAFETY: the encoder is used by this thread alone; the queue is idle before anything is dropped.
    unsafe {
        let mut encoder = gpu.device.create_command_encoder(&description).map_err(Error::gpu("creating an encoder"))?;
        encoder.begin_encoding(None).map_err(Error::gpu("beginning a command buffer"))?;
        record(&mut encoder);
        let commands = encoder.end_encoding().map_err(Error::gpu("ending a command buffer"))?;
        let mut fence = gpu.device.create_fence().map_err(Error::gpu("creating a fence"))?;
        let submitted = gpu.queue.submit(&[&commands], &[], (&mut fence, 1)).map_err(Error::gpu("submitting"));
        let waited = gpu.wait_idle();
        encoder.reset_all(std::iter::once(commands));
        gpu.device.destroy_fence(fence);
        submitted.and(waited)
    }
}

fn mapped(gpu: &Gpu, buffer: &hal::Buffer, size: u64) -> Result<Vec<u8>> {
    // SAFETY: the range is inside the buffer, whose writes are finished.
    unsafe {
        let mapping = gpu.device.map_buffer(buffer, 0..size).map_err(Error::gpu("mapping a buffer"))?;
        if !mapping.is_coherent {
            gpu.device.invalidate_mapped_ranges(buffer, std::iter::once(0..size));
        }
        let bytes = std::slice::from_raw_parts(mapping.ptr.as_ptr(), size as usize).to_vec();
        gpu.device.unmap_buffer(buffer);
        Ok(bytes)
    }
}

fn texel_bytes(format: wgt::TextureFormat) -> usize {
    match format {
        wgt::TextureFormat::Depth32Float => 4,
        wgt::TextureFormat::Rgba16Float => 8,
        _ => 16,
    }
}

fn decode(bytes: &[u8], format: wgt::TextureFormat) -> Vec<[f32; 4]> {
    let single = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let half = |b: &[u8]| f16::from_le_bytes([b[0], b[1]]).to_f32();
    let texels = bytes.chunks_exact(texel_bytes(format));
    match format {
        wgt::TextureFormat::Depth32Float => texels.map(|t| [single(t), 0.0, 0.0, 0.0]).collect(),
        wgt::TextureFormat::Rgba16Float => texels.map(|t| std::array::from_fn(|i| half(&t[i * 2..]))).collect(),
        _ => texels.map(|t| std::array::from_fn(|i| single(&t[i * 4..]))).collect(),
    }
}
