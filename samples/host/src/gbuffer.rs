//! Depth, normal, albedo, emission and motion of the camera's pixels.

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::raster::{COLOR_FORMATS, DEPTH_FORMAT, Draw, Raster};
use crate::scene::SceneCamera;
use crate::target::{Target, Use};
use brickgi::scene::Camera;
use glam::{DVec3, Mat3, Mat4, Vec3};
use std::sync::Arc;
use wgpu_hal::{CommandEncoder as _, vulkan as hal};
use wgpu_types as wgt;

/// Value of the depth buffer where nothing was drawn: infinitely far with reverse depth.
pub(crate) const CLEAR_DEPTH: f32 = 0.0;

/// The images that one camera's rasterisation fills.
pub(crate) struct GBuffer {
    /// near / distance along the view axis.
    pub(crate) depth: Target,
    /// World-space face normal towards the camera; normal, albedo and emission have 1 in alpha where drawn.
    pub(crate) normal: Target,
    /// Linear.
    pub(crate) albedo: Target,
    /// Radiance.
    pub(crate) emission: Target,
    /// Where a pixel's surface was in the last frame less where it is: parts of the image, x to the right, y down.
    pub(crate) motion: Target,
}

impl GBuffer {
    pub(crate) fn new(gpu: &Arc<Gpu>, size: [u32; 2]) -> Result<Self> {
        let sampled = wgt::TextureUses::RESOURCE;
        let depth_usage = wgt::TextureUses::DEPTH_STENCIL_WRITE | sampled;
        let color = |label, index: usize| {
            Target::new(gpu, label, COLOR_FORMATS[index], wgt::TextureUses::COLOR_TARGET | sampled, size)
        };
        Ok(Self {
            depth: Target::new(gpu, "depth", DEPTH_FORMAT, depth_usage, size)?,
            normal: color("normal", 0)?,
            albedo: color("albedo", 1)?,
            emission: color("emission", 2)?,
            motion: color("motion", 3)?,
        })
    }

    /// Records the rasterisation, and motion since it was `past`'s turn; afterwards every image is readable by compute shaders.
    ///
    /// # Safety
    /// `encoder` is recording, outside a pass, and is submitted in the order of these calls.
    pub(crate) unsafe fn record(
        &mut self,
        encoder: &mut hal::CommandEncoder,
        raster: &Raster,
        camera: &SceneCamera,
        past: &SceneCamera,
    ) -> Result<()> {
        // SAFETY: by the caller.
        unsafe {
            let commands = encoder.raw_handle();
            self.depth.transition(commands, Use::Depth, false);
            for target in [&mut self.normal, &mut self.albedo, &mut self.emission, &mut self.motion] {
                target.transition(commands, Use::Color, false);
            }
            self.draw(encoder, raster, camera, past)?;
            let Self { depth, normal, albedo, emission, motion } = self;
            for target in [depth, normal, albedo, emission, motion] {
                target.transition(commands, Use::Sampled, true);
            }
        }
        Ok(())
    }

    /// # Safety
    /// As for [`Self::record`]; the images are in attachment layouts.
    unsafe fn draw(
        &self,
        encoder: &mut hal::CommandEncoder,
        raster: &Raster,
        camera: &SceneCamera,
        past: &SceneCamera,
    ) -> Result<()> {
        let [width, height] = self.depth.size();
        let clear = wgpu_hal::AttachmentOps::LOAD_CLEAR | wgpu_hal::AttachmentOps::STORE;
        let color = |target| Some(color_attachment(target, clear));
        let pass = wgpu_hal::RenderPassDescriptor {
            label: Some("gbuffer"),
            extent: wgt::Extent3d { width, height, depth_or_array_layers: 1 },
            sample_count: 1,
            color_attachments: &[color(&self.normal), color(&self.albedo), color(&self.emission), color(&self.motion)],
            depth_stencil_attachment: Some(wgpu_hal::DepthStencilAttachment {
                target: wgpu_hal::Attachment { view: self.depth.view(), usage: wgt::TextureUses::DEPTH_STENCIL_WRITE },
                depth_ops: clear,
                stencil_ops: wgpu_hal::AttachmentOps::LOAD_DONT_CARE | wgpu_hal::AttachmentOps::STORE_DISCARD,
                clear_value: (CLEAR_DEPTH, 0),
            }),
            multiview_mask: None,
            timestamp_writes: None,
            occlusion_query_set: None::<&hal::QuerySet>,
        };
        // SAFETY: by the caller; everything bound lives in `raster` until the queue is idle.
        unsafe {
            encoder.begin_render_pass(&pass).map_err(Error::gpu("beginning the G-buffer pass"))?;
            encoder.set_render_pipeline(raster.pipeline());
            raster.bind(encoder);
            let [now, past] = [camera, past].map(|camera| camera.to_gi([width, height], [0.0; 3]));
            encoder.set_immediates(raster.layout(), 0, &view_words(&now, &past));
            encoder.set_viewport(&wgpu_hal::Rect { x: 0.0, y: 0.0, w: width as f32, h: height as f32 }, 0.0..1.0);
            encoder.set_scissor_rect(&wgpu_hal::Rect { x: 0, y: 0, w: width, h: height });
            for Draw { vertices, instances } in raster.draws() {
                encoder.draw(vertices.start, vertices.len() as u32, instances.start, instances.len() as u32);
            }
            encoder.end_render_pass();
        }
        Ok(())
    }
}

fn color_attachment(target: &Target, ops: wgpu_hal::AttachmentOps) -> wgpu_hal::ColorAttachment<'_, hal::TextureView> {
    wgpu_hal::ColorAttachment {
        target: wgpu_hal::Attachment { view: target.view(), usage: wgt::TextureUses::COLOR_TARGET },
        depth_slice: None,
        resolve_target: None,
        ops,
        clear_value: wgt::Color::TRANSPARENT,
    }
}

/// The shader's `View`: a matrix from camera-relative positions to clip space, the camera's position, and the rows for x, y
/// and w of a matrix from such positions to clip space of the camera in the last frame.
///
/// wgpu-hal flips the viewport, so clip space here has y up: the projection's y is negated once more.
pub(crate) fn view_words(camera: &Camera, past: &Camera) -> Vec<u32> {
    let y_up = Mat4::from_scale(Vec3::new(1.0, -1.0, 1.0));
    let clip = |camera: &Camera| {
        let rotation = Mat4::from_mat3(Mat3::from_cols_array_2d(&camera.view_rotation));
        y_up * Mat4::from_cols_array_2d(&camera.projection) * rotation
    };
    let position = DVec3::from(camera.position).as_vec3();
    let moved = (DVec3::from(camera.position) - DVec3::from(past.position)).as_vec3();
    let to_past = clip(past) * Mat4::from_translation(moved);
    let rows = [0, 1, 3].map(|row| to_past.row(row).to_array());
    let floats = clip(camera).to_cols_array().into_iter().chain(position.extend(0.0).to_array());
    floats.chain(rows.into_iter().flatten()).map(f32::to_bits).collect()
}
