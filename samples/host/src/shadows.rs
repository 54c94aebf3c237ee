//! Shadow maps of the lights, as an engine draws them: an atlas of square tiles, one for the sun, one for a spot, six for a
//! point.

use crate::error::{Error, Result};
use crate::gbuffer::{CLEAR_DEPTH, view_words};
use crate::gpu::Gpu;
use crate::raster::{DEPTH_FORMAT, Draw, Raster};
use crate::scene::{Instance, Light, Mesh};
use crate::target::{Target, Use};
use brickgi::scene::{Camera, ShadowLayer, ShadowMap};
use glam::{DMat3, DVec3, Vec3};
use std::sync::Arc;
use wgpu_hal::{CommandEncoder as _, vulkan as hal};
use wgpu_types as wgt;

/// Distance of the near plane of points and spots in metres.
const NEAR: f32 = 0.02;
/// Tiles in a row.
const COLUMNS: u32 = 6;

/// The atlas, and what its tiles are drawn with; reverse depth, as the G-buffer.
pub(crate) struct ShadowAtlas {
    depth: Target,
    /// Edge of a tile in texels.
    edge: u32,
    /// By tile: its light and its camera.
    tiles: Vec<(u32, Camera)>,
}

impl ShadowAtlas {
    /// Maps of those lights that can have one, about these instances.
    pub(crate) fn new<'a>(
        gpu: &Arc<Gpu>,
        edge: u32,
        lights: &[Light],
        meshes: &[Mesh],
        instances: impl Iterator<Item = &'a Instance> + Clone,
    ) -> Result<Self> {
        let corners = instances.flat_map(|i| meshes[i.mesh].positions.iter().map(|p| DVec3::from(i.to_world(*p))));
        let of_light = |(index, light)| cameras(light, corners.clone()).into_iter().map(move |camera| (index, camera));
        let tiles: Vec<_> = (0..).zip(lights).flat_map(of_light).collect();
        let rows = (tiles.len() as u32).div_ceil(COLUMNS).max(1);
        let usage = wgt::TextureUses::DEPTH_STENCIL_WRITE | wgt::TextureUses::RESOURCE;
        let size = [COLUMNS.min(tiles.len() as u32).max(1) * edge, rows * edge];
        Ok(Self { depth: Target::array(gpu, "shadow maps", DEPTH_FORMAT, usage, size)?, edge, tiles })
    }

    /// What brickgi is told of them, `offset` metres away from where they are drawn.
    pub(crate) fn maps(&self, offset: [f64; 3]) -> Vec<ShadowMap> {
        let layer = |index: usize| {
            let camera = self.tiles[index].1;
            let position = (DVec3::from(camera.position) + DVec3::from(offset)).to_array();
            ShadowLayer { layer: 0, rectangle: self.rectangle(index), camera: Camera { position, ..camera } }
        };
        let mut maps: Vec<ShadowMap> = Vec::new();
        for (index, (light, _)) in self.tiles.iter().enumerate() {
            match maps.last_mut().filter(|map| map.light == *light) {
                Some(map) => map.layers.push(layer(index)),
                None => maps.push(ShadowMap {
                    light: *light,
                    view: self.depth.raw_view(),
                    size: self.depth.size(),
                    layers: vec![layer(index)],
                    reversed: true,
                    range: 0.0,
                    depth_bias: 0.0,
                    normal_offset: 0.0,
                }),
            }
        }
        maps
    }

    fn rectangle(&self, index: usize) -> [u32; 4] {
        let index = index as u32;
        [index % COLUMNS * self.edge, index / COLUMNS * self.edge, self.edge, self.edge]
    }

    /// Records the rasterisation; afterwards the image is readable by compute shaders.
    ///
    /// # Safety
    /// `encoder` is recording, outside a pass, and is submitted in the order of these calls.
    pub(crate) unsafe fn record(&mut self, encoder: &mut hal::CommandEncoder, raster: &Raster) -> Result<()> {
        let [width, height] = self.depth.size();
        // SAFETY: by the caller; everything bound lives in `raster` until the queue is idle.
        unsafe {
            self.depth.transition(encoder.raw_handle(), Use::Depth, false);
            let pass = wgpu_hal::RenderPassDescriptor {
                label: Some("shadow maps"),
                extent: wgt::Extent3d { width, height, depth_or_array_layers: 1 },
                sample_count: 1,
                color_attachments: &[],
                depth_stencil_attachment: Some(wgpu_hal::DepthStencilAttachment {
                    target: wgpu_hal::Attachment {
                        view: self.depth.view(),
                        usage: wgt::TextureUses::DEPTH_STENCIL_WRITE,
                    },
                    depth_ops: wgpu_hal::AttachmentOps::LOAD_CLEAR | wgpu_hal::AttachmentOps::STORE,
                    stencil_ops: wgpu_hal::AttachmentOps::LOAD_DONT_CARE | wgpu_hal::AttachmentOps::STORE_DISCARD,
                    clear_value: (CLEAR_DEPTH, 0),
                }),
                multiview_mask: None,
                timestamp_writes: None,
                occlusion_query_set: None::<&hal::QuerySet>,
            };
            encoder.begin_render_pass(&pass).map_err(Error::gpu("beginning the shadow pass"))?;
            encoder.set_render_pipeline(raster.depth_pipeline());
            raster.bind(encoder);
            for (index, (_, camera)) in self.tiles.iter().enumerate() {
                let [x, y, w, h] = self.rectangle(index);
                let view = wgpu_hal::Rect { x: x as f32, y: y as f32, w: w as f32, h: h as f32 };
                encoder.set_viewport(&view, 0.0..1.0);
                encoder.set_scissor_rect(&wgpu_hal::Rect { x, y, w, h });
                encoder.set_immediates(raster.layout(), 0, &view_words(camera, camera));
                for Draw { vertices, instances } in raster.draws() {
                    encoder.draw(vertices.start, vertices.len() as u32, instances.start, instances.len() as u32);
                }
            }
            encoder.end_render_pass();
            self.depth.transition(encoder.raw_handle(), Use::Sampled, true);
        }
        Ok(())
    }
}

/// What a light's tiles are drawn with; none for lights with an extent.
fn cameras(light: &Light, corners: impl Iterator<Item = DVec3>) -> Vec<Camera> {
    match *light {
        Light::Directional { direction, .. } => {
            let rotation = looking(Vec3::from(direction).as_dvec3());
            let views = corners.map(|p| rotation * p);
            let bounds = views.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[a, b], p| [a.min(p), b.max(p)]);
            // A little room at every side.
            let (middle, half) = ((bounds[0] + bounds[1]) / 2.0, (bounds[1] - bounds[0]) * 0.505 + 0.1);
            let scale = half.recip().as_vec3();
            let projection = [
                [scale.x, 0.0, 0.0, 0.0],
                [0.0, scale.y, 0.0, 0.0],
                [0.0, 0.0, -0.5 * scale.z, 0.0],
                [0.0, 0.0, 0.5, 1.0],
            ];
            vec![camera(rotation.transpose() * middle, rotation, projection)]
        }
        Light::Point { position, .. } => {
            let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
            axes.map(|axis| camera(position.into(), looking(axis), perspective(1.0))).to_vec()
        }
        Light::Spot { position, direction, outer_angle, .. } => {
            let rotation = looking(Vec3::from(direction).as_dvec3());
            vec![camera(position.into(), rotation, perspective(outer_angle.min(1.5).tan()))]
        }
        Light::Sphere { .. } | Light::Rectangle { .. } => Vec::new(),
    }
}

fn camera(position: DVec3, rotation: DMat3, projection: [[f32; 4]; 4]) -> Camera {
    Camera { position: position.to_array(), view_rotation: rotation.as_mat3().to_cols_array_2d(), projection }
}

/// View space whose z is `forward`.
fn looking(forward: DVec3) -> DMat3 {
    let forward = forward.normalize();
    let right = forward.any_orthonormal_vector();
    DMat3::from_cols(right, forward.cross(right), forward).transpose()
}

/// Reverse and infinite, about +z.
fn perspective(tangent: f32) -> [[f32; 4]; 4] {
    let scale = tangent.recip();
    [[scale, 0.0, 0.0, 0.0], [0.0, scale, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, NEAR, 0.0]]
}
