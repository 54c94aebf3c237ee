//! A view: a camera with its own probes and history.

use crate::context::{Composite, FrameInputs, ResourceSize};
use crate::error::{Error, Result};
use crate::gpu::shared::{LOBE_WORDS, NEAR_VOXELS, PROBE_LAYERS, PROBE_NEEDS, PROBE_RANKS, View as ViewUniform};
use crate::gpu::{Bound, Buffer, Device, Location};
use crate::passes::probes::mip_cells;
use crate::scene::Camera;
use ash::vk;
use glam::{DMat4, DVec2, DVec3, Mat4, UVec2, Vec2};
use rustc_hash::FxHashMap;

/// Buffers whose contents live from frame to frame, or that only this view needs.
pub const VIEW_BUFFERS: [&str; 11] = [
    "history_a",
    "history_b",
    "probe_lobes_a",
    "probe_lobes_b",
    "probes_a",
    "probes_b",
    "probe_guides_a",
    "probe_guides_b",
    "probe_irradiance_a",
    "probe_irradiance_b",
    "probe_claims",
];

/// A camera's state.
pub struct View {
    /// Largest rendered region.
    pub size: UVec2,
    pub buffers: Vec<Buffer>,
    pub camera: Option<Camera>,
    /// The dispatch call that last drew it.
    pub drawn: Option<u32>,
    previous: Option<(Camera, UVec2)>,
    /// The world's loads when it was.
    loads: u32,
    /// Its last frame has left lags.
    watched: bool,
    /// Which history holds the latest frame.
    pub flipped: bool,
}

impl View {
    pub fn new(device: &Device, size: UVec2, tile: u32) -> Result<Self> {
        let tiles = size.map(|s| s.div_ceil(tile));
        let probes = u64::from(PROBE_LAYERS) * u64::from(tiles.x) * u64::from(tiles.y);
        let lobes = probes * 4 * u64::from(LOBE_WORDS);
        let placed = probes * 32 + 16 * u64::from(mip_cells(tiles));
        let pairs = [history_bytes(size), lobes, placed, probes * 16, probes * 144];
        let claims = 4 * (probes + u64::from(PROBE_NEEDS * PROBE_RANKS));
        let sizes = pairs.into_iter().flat_map(|bytes| [bytes; 2]).chain([claims]);
        let mut view = Self {
            size,
            buffers: Vec::new(),
            camera: None,
            drawn: None,
            previous: None,
            loads: 0,
            watched: false,
            flipped: false,
        };
        for bytes in sizes {
            match Buffer::new(device, bytes, Location::Device) {
                Ok(buffer) => view.buffers.push(buffer),
                Err(error) => {
                    view.destroy(device);
                    return Err(error);
                }
            }
        }
        Ok(view)
    }

    /// Checks and takes a camera.
    pub fn set_camera(&mut self, camera: &Camera) -> Result<()> {
        camera.check().map_err(|fault| Error::invalid(format!("camera: {fault}")))?;
        self.camera = Some(*camera);
        Ok(())
    }

    /// What the shaders read; `window` is the grid window's low corner in voxels and `to_voxels` the camera there.
    pub fn uniform(&mut self, camera: &Camera, grid_camera: DVec3, frame: &FrameShape) -> ViewUniform {
        let to_world = Mat4::from_mat3(camera.rotation().inverse().as_mat3());
        let size = frame.size;
        let tiles = size.map(|s| s.div_ceil(frame.tile_size));
        let mut uniform = ViewUniform {
            clip_to_view: camera.projection().inverse().as_mat4().to_cols_array_2d(),
            view_to_world: to_world.to_cols_array_2d(),
            clip: camera.clip().as_mat4().to_cols_array_2d(),
            camera: grid_camera.as_vec3().to_array(),
            clear_depth: frame.clear_depth,
            origin: frame.origin,
            size: size.to_array(),
            tiles: tiles.to_array(),
            stride: self.size.x,
            tile_size: frame.tile_size,
            history_max: frame.history_max,
            pixel_rays: frame.pixel_rays,
            gather_interval: frame.gather_interval,
            probes_per_frame: frame.probes_per_frame,
            near_field: if frame.near_field { NEAR_VOXELS } else { -1.0 },
            has_motion: frame.motion_scale.is_some().into(),
            motion_scale: (frame.motion_scale.unwrap_or_default() / size.as_vec2()).to_array(),
            lag_start: 3 * self.size.x * self.size.y,
            pixel_width: 2.0 / (size.x as f32 * camera.projection[0][0].abs().max(1e-6)),
            ..ViewUniform::default()
        };
        if let Some((previous, previous_size)) = self.previous.filter(|_| self.loads == frame.loads) {
            let moved = DVec3::from(camera.position) - DVec3::from(previous.position);
            let to_previous = previous.clip() * DMat4::from_translation(moved);
            uniform.previous_clip = to_previous.as_mat4().to_cols_array_2d();
            uniform.camera_delta = (-moved).as_vec3().to_array();
            uniform.motion_shift = ((middle(&previous) - middle(camera)) / 2.0).as_vec2().to_array();
            uniform.previous_size = previous_size.x | previous_size.y << 16;
            uniform.history_valid = 1;
            uniform.knows_lag = (frame.watches && self.watched).into();
        }
        self.previous = Some((*camera, size));
        self.watched = frame.watches;
        self.loads = frame.loads;
        self.flipped = !self.flipped;
        uniform
    }

    /// Names of this view's buffers and the host's images.
    pub fn bind(&self, inputs: &FrameInputs, bound: &mut FxHashMap<&'static str, Bound>) {
        for (name, buffer) in VIEW_BUFFERS.iter().zip(&self.buffers) {
            bound.insert(name, Bound::Buffer(buffer.raw, 0, buffer.size));
        }
        let pairs = [
            ["history_in", "history_out"],
            ["lobes_in", "lobes_out"],
            ["probes_in", "probes"],
            ["probe_guides_in", "probe_guides"],
            ["probe_irradiance_in", "probe_irradiance"],
        ];
        for (pair, [input, output]) in pairs.into_iter().enumerate() {
            let pair = [0, 1].map(|k| &self.buffers[2 * pair + k]).map(|b| Bound::Buffer(b.raw, 0, b.size));
            bound.insert(output, pair[usize::from(self.flipped)]);
            bound.insert(input, pair[usize::from(!self.flipped)]);
        }
        let read = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        bound.insert("depth_image", Bound::Image(inputs.depth, read));
        bound.insert("normal_image", Bound::Image(inputs.normal, read));
        bound.insert("motion_image", Bound::Image(inputs.motion.map_or(inputs.normal, |motion| motion.image), read));
        bound.insert("output_image", Bound::Image(inputs.output, vk::ImageLayout::GENERAL));
        if let Some(Composite { albedo, direct, output }) = inputs.composite {
            bound.insert("albedo_image", Bound::Image(albedo, read));
            bound.insert("direct_image", Bound::Image(direct, read));
            bound.insert("composite_image", Bound::Image(output, vk::ImageLayout::GENERAL));
        }
    }

    /// Names and bytes of the view's buffers.
    pub fn sizes(&self) -> Vec<ResourceSize> {
        VIEW_BUFFERS.iter().zip(&self.buffers).map(|(name, b)| ResourceSize { name, bytes: b.size }).collect()
    }

    /// The GPU must have finished with it.
    pub fn destroy(&mut self, device: &Device) {
        self.buffers.drain(..).for_each(|mut b| b.destroy(device));
    }
}

/// Three words a pixel, and behind them two for each 8 x 8.
pub fn history_bytes(size: UVec2) -> u64 {
    let area = |size: UVec2| u64::from(size.x) * u64::from(size.y);
    12 * area(size) + 8 * area(size.map(|s| s.div_ceil(8)))
}

/// Where the view axis meets the image, in clip space: off its middle, jitter shows there.
fn middle(camera: &Camera) -> DVec2 {
    let projection = camera.projection();
    // The axis' point at infinity; an orthographic camera's is nowhere.
    let point = if projection.z_axis.w == 0.0 { projection.w_axis } else { projection.z_axis };
    point.truncate().truncate() / point.w
}

/// What a frame says of a view.
pub struct FrameShape {
    /// Of the rendered region, in the host's images.
    pub origin: [u32; 2],
    pub size: UVec2,
    pub tile_size: u32,
    pub clear_depth: f32,
    pub history_max: u32,
    /// The world's: what was averaged before the last of them does not count.
    pub loads: u32,
    pub pixel_rays: u32,
    pub gather_interval: u32,
    pub probes_per_frame: u32,
    pub near_field: bool,
    /// The world has changed of late.
    pub watches: bool,
    /// From the motion image's values to pixels; none: there is no such image.
    pub motion_scale: Option<Vec2>,
}
