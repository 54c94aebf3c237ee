//! The frame loop: G-buffer, barriers, brickgi, submit.

use crate::direct::ShadowScene;
use crate::error::{Error, Result};
use crate::gbuffer::{CLEAR_DEPTH, GBuffer};
use crate::gpu::Gpu;
use crate::image::Image;
use crate::raster::Raster;
use crate::readback;
use crate::scene::{self, Instance, Light, Scene, SceneCamera, Sky};
use crate::shadows::ShadowAtlas;
use crate::target::{Target, Use};
use crate::upload;
use ash::vk;
use brickgi::{Context, ContextDesc, DebugView, FrameInputs, Motion, Settings, Stats, ViewId};
use glam::{DVec3, Vec3};
use std::collections::BTreeMap;
use std::sync::Arc;
use wgpu_hal::{CommandEncoder as _, Device as _, Queue as _, vulkan as hal};
use wgpu_types as wgt;

/// What a host is made from.
#[derive(Clone, Debug)]
pub struct HostOptions {
    /// What to draw.
    pub scene: Arc<Scene>,
    /// Name of the camera; `None`: the scene's first.
    pub camera: Option<String>,
    /// Width and height in pixels; `None`: the camera's own.
    pub size: Option<[u32; 2]>,
    /// brickgi's settings.
    pub settings: Settings,
    /// Command buffers that may be on the GPU at once, 1 to 8.
    pub frames_in_flight: u32,
    /// Runs under the validation layer and keeps its messages.
    pub validation: bool,
    /// Edge in texels of the shadow maps that brickgi is given of the sun, points and spots; 0: none.
    pub shadow_maps: u32,
    /// Whether brickgi is given motion vectors.
    pub motion: bool,
    /// Added to every position given to brickgi, in metres; the G-buffer stays where it is.
    pub world_offset: [f64; 3],
}

impl HostOptions {
    /// The scene's first camera at its own size, default settings, two frames in flight, motion vectors, no validation.
    pub fn new(scene: impl Into<Arc<Scene>>) -> Self {
        Self {
            scene: scene.into(),
            camera: None,
            size: None,
            settings: Settings::default(),
            frames_in_flight: 2,
            validation: false,
            shadow_maps: 0,
            motion: true,
            world_offset: [0.0; 3],
        }
    }
}

/// One command buffer in rotation.
struct Slot {
    encoder: hal::CommandEncoder,
    submitted: Option<(hal::CommandBuffer, u64)>,
}

/// An engine with one view. Dropping it waits for the GPU.
pub struct Host {
    // brickgi first: it must go before the device.
    context: Context,
    view: ViewId,
    slots: Vec<Slot>,
    fence: Option<hal::Fence>,
    gbuffer: GBuffer,
    output: Target,
    raster: Raster,
    /// Of the current instances; built when first asked for.
    shadows: Option<ShadowScene>,
    scene: Arc<Scene>,
    instances: BTreeMap<u64, Instance>,
    lights: Vec<Light>,
    camera: SceneCamera,
    /// Edge of the shadow maps; 0: there are none.
    shadow_edge: u32,
    /// Of the current instances and lights; drawn when it is made.
    shadow_maps: Option<ShadowAtlas>,
    /// The G-buffer is out of date.
    picture_changed: bool,
    /// So is what the raster draws.
    instances_changed: bool,
    /// What the last frame had; the G-buffer holds motion where it differs.
    drawn: (SceneCamera, BTreeMap<u64, Instance>),
    /// brickgi is given motion.
    motion: bool,
    /// What the output shows instead of E_ind.
    debug_view: Option<DebugView>,
    world_offset: [f64; 3],
    frames: u64,
    gpu: Arc<Gpu>,
}

impl Host {
    /// Opens the device, uploads the scene and creates brickgi's context.
    pub fn new(options: HostOptions) -> Result<Self> {
        let camera = options.scene.camera(options.camera.as_deref())?.clone();
        let size = options.size.unwrap_or([camera.width, camera.height]);
        check(size, options.frames_in_flight)?;
        let gpu = Arc::new(Gpu::open(options.validation)?);
        let raster = Raster::new(&gpu, &options.scene)?;
        let usage = wgt::TextureUses::STORAGE_READ_WRITE | wgt::TextureUses::COPY_DST;
        let mut output = Target::new(&gpu, "E_ind", wgt::TextureFormat::Rgba32Float, usage, size)?;
        clear(&gpu, &mut output)?;
        let frames_in_flight = options.frames_in_flight;
        let description =
            ContextDesc { device: gpu.handles(), settings: options.settings, frames_in_flight, parallel_for: None };
        // SAFETY: the handles live as long as `gpu`, which drops after the context.
        let mut context = unsafe { Context::new(description) }?;
        upload::scene(&mut context, &options.scene, options.world_offset)?;
        let view = context.create_view(size[0], size[1])?;
        let instances: BTreeMap<u64, Instance> = (0..).zip(options.scene.instances.iter().cloned()).collect();
        let mut host = Self {
            context,
            view,
            slots: slots(&gpu, frames_in_flight)?,
            // SAFETY: destroyed in `drop`, after the queue is idle.
            fence: Some(unsafe { gpu.device.create_fence() }.map_err(Error::gpu("creating a fence"))?),
            gbuffer: GBuffer::new(&gpu, size)?,
            output,
            raster,
            shadows: None,
            drawn: (camera.clone(), instances.clone()),
            instances,
            lights: options.scene.lights.clone(),
            scene: options.scene,
            camera: camera.clone(),
            shadow_edge: options.shadow_maps,
            shadow_maps: None,
            picture_changed: true,
            instances_changed: true,
            motion: options.motion,
            debug_view: None,
            world_offset: options.world_offset,
            frames: 0,
            gpu,
        };
        host.set_camera(camera)?;
        Ok(host)
    }

    /// Records and submits one frame; blocks only for the frame `frames_in_flight` before it.
    pub fn frame(&mut self) -> Result<()> {
        let index = (self.frames % self.slots.len() as u64) as usize;
        self.reclaim(index)?;
        self.raster.collect((self.frames + 1).saturating_sub(self.slots.len() as u64));
        self.place()?;
        let mut slot = self.slots.swap_remove(index);
        let recorded = self.record(&mut slot.encoder);
        let result = recorded.and_then(|commands| self.submit(&mut slot, commands));
        self.slots.push(slot);
        let last = self.slots.len() - 1;
        self.slots.swap(index, last);
        result
    }

    /// Sets the camera of the following frames.
    pub fn set_camera(&mut self, camera: SceneCamera) -> Result<()> {
        if !camera.is_usable() {
            return Err(Error::InvalidOption(format!("camera {:?} is degenerate", camera.name)));
        }
        self.context.set_camera(self.view, &camera.to_gi(self.size(), self.world_offset))?;
        self.camera = camera;
        self.picture_changed = true;
        Ok(())
    }

    /// Adds, moves and changes instances (`Some`) and removes them (`None`), by id, from the next frame on. The scene's
    /// own have their indices as ids. Meshes and materials are the scene's. On an error nothing has changed.
    pub fn update_instances(&mut self, changes: &[(u64, Option<Instance>)]) -> Result<()> {
        upload::instances(&mut self.context, changes, self.world_offset)?;
        for (id, instance) in changes {
            match instance {
                Some(instance) => self.instances.insert(*id, instance.clone()),
                None => self.instances.remove(id),
            };
        }
        self.instances_changed = true;
        self.shadows = None;
        self.picture_changed = true;
        self.forget_shadow_maps()
    }

    /// Replaces all lights and the sky.
    pub fn set_lights(&mut self, lights: Vec<Light>, sky: Sky) -> Result<()> {
        upload::lights(&mut self.context, &lights, sky, self.world_offset)?;
        self.lights = lights;
        self.forget_shadow_maps()
    }

    /// Has the raster draw what there is now.
    fn place(&mut self) -> Result<()> {
        if std::mem::take(&mut self.instances_changed) {
            let past = &self.drawn.1;
            let pairs = self.instances.iter().map(|(id, now)| (now, past.get(id).unwrap_or(now)));
            self.raster.place(pairs, self.frames)?;
        }
        Ok(())
    }

    /// They are drawn anew in the next frame. Waits for the GPU, which may still read them.
    fn forget_shadow_maps(&mut self) -> Result<()> {
        if self.shadow_maps.is_some() {
            self.gpu.wait_idle()?;
            self.shadow_maps = None;
        }
        Ok(())
    }

    /// Draws the shadow maps if there are to be some and they are out of date, and hands them over.
    ///
    /// # Safety
    /// As of [`Self::record_passes`].
    unsafe fn record_shadow_maps(&mut self, encoder: &mut hal::CommandEncoder) -> Result<()> {
        if self.shadow_edge == 0 || self.shadow_maps.is_some() {
            return Ok(());
        }
        let (edge, lights) = (self.shadow_edge, &self.lights);
        let mut atlas = ShadowAtlas::new(&self.gpu, edge, lights, &self.scene.meshes, self.instances.values())?;
        // SAFETY: by the caller; the atlas lives until nothing reads it.
        unsafe {
            atlas.record(encoder, &self.raster)?;
            self.context.set_shadow_maps(&atlas.maps(self.world_offset))?;
        }
        self.shadow_maps = Some(atlas);
        Ok(())
    }

    /// What the following frames' output shows instead of E_ind; [`Host::read_indirect`] reads it.
    pub fn show(&mut self, view: Option<DebugView>) {
        self.debug_view = view;
    }

    /// E_ind of the latest frame: irradiance, linear Rec.709. Waits for the GPU.
    pub fn read_indirect(&mut self) -> Result<Image> {
        Ok(readback::read(&self.gpu, &mut self.output)?.map(rgb))
    }

    /// Alpha of the output: 1 where brickgi shaded a surface.
    pub fn read_coverage(&mut self) -> Result<Image<f32>> {
        Ok(readback::read(&self.gpu, &mut self.output)?.map(|p| p[3]))
    }

    /// Distance along the view axis in metres; 0 where nothing was drawn. Needs a frame with the current camera.
    pub fn read_depth(&mut self) -> Result<Image<f32>> {
        let near = self.camera.near as f32;
        let depth = readback::read(&self.gpu, &mut self.gbuffer.depth)?;
        Ok(depth.map(|p| if p[0] == CLEAR_DEPTH { 0.0 } else { near / p[0] }))
    }

    /// World-space face normal towards the camera; 0 where nothing was drawn.
    pub fn read_normal(&mut self) -> Result<Image> {
        Ok(readback::read(&self.gpu, &mut self.gbuffer.normal)?.map(rgb))
    }

    /// Linear albedo; 0 where nothing was drawn.
    pub fn read_albedo(&mut self) -> Result<Image> {
        Ok(readback::read(&self.gpu, &mut self.gbuffer.albedo)?.map(rgb))
    }

    /// Radiance that the seen surfaces emit.
    pub fn read_emission(&mut self) -> Result<Image> {
        Ok(readback::read(&self.gpu, &mut self.gbuffer.emission)?.map(rgb))
    }

    /// E_direct: irradiance of the lights with their shadows, by rays on the CPU from the G-buffer's surfaces.
    pub fn direct(&mut self) -> Result<Image> {
        let (depth, normal, size) = (self.read_depth()?, self.read_normal()?, self.size());
        let (camera, eye) = (&self.camera, DVec3::from(self.camera.position));
        let surface = |x, y| {
            let distance = f64::from(*depth.at(x, y));
            let normal = Vec3::from(*normal.at(x, y)).as_dvec3().normalize_or_zero();
            (distance > 0.0).then(|| (eye + camera.pixel_ray(x, y, size) * distance, normal))
        };
        let build = || ShadowScene::new(&scene::flatten(&self.scene.meshes, self.instances.values()));
        Ok(self.shadows.get_or_insert_with(build).render(size, &self.lights, surface))
    }

    /// What brickgi holds and did.
    pub fn stats(&self) -> &Stats {
        self.context.stats()
    }

    /// brickgi's context, for calls that the host does not wrap; the G-buffer does not follow them.
    pub fn context_mut(&mut self) -> &mut Context {
        &mut self.context
    }

    /// The scene as loaded.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The camera of the next frame.
    pub fn camera(&self) -> &SceneCamera {
        &self.camera
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.output.size()
    }

    /// The device's name.
    pub fn device_name(&self) -> &str {
        self.gpu.name()
    }

    /// Every warning and error of the validation layer so far; empty without validation.
    pub fn validation_messages(&self) -> Vec<String> {
        self.gpu.validation_messages()
    }

    /// Waits until the GPU has finished everything.
    pub fn wait_idle(&self) -> Result<()> {
        self.gpu.wait_idle()
    }

    /// Waits for the slot's previous frame and takes its command buffer back.
    fn reclaim(&mut self, index: usize) -> Result<()> {
        let slot = &mut self.slots[index];
        if let (Some((commands, value)), Some(fence)) = (slot.submitted.take(), &self.fence) {
            // SAFETY: the fence is signalled with `value` by the submission of these commands.
            unsafe {
                self.gpu.device.wait(fence, value, None).map_err(Error::gpu("waiting for a frame"))?;
                slot.encoder.reset_all(std::iter::once(commands));
            }
        }
        Ok(())
    }

    fn record(&mut self, encoder: &mut hal::CommandEncoder) -> Result<hal::CommandBuffer> {
        // SAFETY: the encoder is idle (`reclaim`), and is submitted right after, in the order of the frames.
        unsafe {
            encoder.begin_encoding(Some("frame")).map_err(Error::gpu("beginning a command buffer"))?;
            match self.record_passes(encoder) {
                Ok(()) => encoder.end_encoding().map_err(Error::gpu("ending a command buffer")),
                Err(error) => {
                    encoder.discard_encoding();
                    Err(error)
                }
            }
        }
    }

    /// # Safety
    /// `encoder` is recording and is submitted in the order of these calls.
    unsafe fn record_passes(&mut self, encoder: &mut hal::CommandEncoder) -> Result<()> {
        let [width, height] = self.size();
        // SAFETY: by the caller; images are in the layouts that `FrameInputs` asks for.
        unsafe {
            if self.picture_changed {
                self.gbuffer.record(encoder, &self.raster, &self.camera, &self.drawn.0)?;
                self.settle();
            }
            self.record_shadow_maps(encoder)?;
            let commands = encoder.raw_handle();
            self.output.transition(commands, Use::Storage, true);
            self.context.dispatch(&FrameInputs {
                command_buffer: commands,
                view: self.view,
                depth: self.gbuffer.depth.raw_view(),
                clear_depth: CLEAR_DEPTH,
                normal: self.gbuffer.normal.raw_view(),
                motion: self
                    .motion
                    .then(|| Motion { image: self.gbuffer.motion.raw_view(), scale: [width as f32, height as f32] }),
                output: self.output.raw_view(),
                output_float32: true,
                origin: [0, 0],
                width,
                height,
                debug_view: self.debug_view,
                composite: None,
            })?;
        }
        Ok(())
    }

    /// The G-buffer is drawn. If anything has moved it is to be drawn once more, at rest.
    fn settle(&mut self) {
        self.picture_changed = false;
        if self.drawn.0 != self.camera {
            self.drawn.0 = self.camera.clone();
            self.picture_changed = true;
        }
        if self.drawn.1 != self.instances {
            self.drawn.1 = self.instances.clone();
            self.instances_changed = true;
            self.picture_changed = true;
        }
    }

    fn submit(&mut self, slot: &mut Slot, commands: hal::CommandBuffer) -> Result<()> {
        let Some(fence) = self.fence.as_mut() else { return Ok(()) };
        self.frames += 1;
        // SAFETY: the commands reference objects that live until the queue is idle.
        let submitted = unsafe { self.gpu.queue.submit(&[&commands], &[], (fence, self.frames)) };
        slot.submitted = Some((commands, self.frames));
        submitted.map_err(Error::gpu("submitting a frame"))
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // A lost device cannot be waited for; everything is released all the same.
        let _ = self.gpu.wait_idle();
        for slot in &mut self.slots {
            if let Some((commands, _)) = slot.submitted.take() {
                // SAFETY: the queue is idle.
                unsafe { slot.encoder.reset_all(std::iter::once(commands)) };
            }
        }
        if let Some(fence) = self.fence.take() {
            // SAFETY: the queue is idle.
            unsafe { self.gpu.device.destroy_fence(fence) };
        }
    }
}

fn check([width, height]: [u32; 2], frames_in_flight: u32) -> Result<()> {
    if ![width, height].iter().all(|edge| (1..=16384).contains(edge)) {
        return Err(Error::InvalidOption(format!("size {width} x {height}: 1 to 16384 pixels per edge")));
    }
    if !(1..=8).contains(&frames_in_flight) {
        return Err(Error::InvalidOption("frames in flight must be 1 to 8".into()));
    }
    Ok(())
}

fn slots(gpu: &Gpu, count: u32) -> Result<Vec<Slot>> {
    let description = wgpu_hal::CommandEncoderDescriptor { label: None, queue: &gpu.queue };
    let slot = |_| {
        // SAFETY: dropped before the device.
        let encoder = unsafe { gpu.device.create_command_encoder(&description) };
        Ok(Slot { encoder: encoder.map_err(Error::gpu("creating an encoder"))?, submitted: None })
    };
    (0..count).map(slot).collect()
}

/// Zeroes the output, so that a pixel nobody writes reads as black.
fn clear(gpu: &Gpu, target: &mut Target) -> Result<()> {
    readback::once(gpu, |encoder| {
        let zero = vk::ClearColorValue { float32: [0.0; 4] };
        // SAFETY: the encoder records; the image is in the layout of a clear.
        unsafe {
            let commands = encoder.raw_handle();
            target.transition(commands, Use::Clear, false);
            let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
            gpu.raw().cmd_clear_color_image(commands, target.raw_image(), layout, &zero, &[target.whole()]);
            target.transition(commands, Use::Storage, true);
        }
    })
}

fn rgb(pixel: &[f32; 4]) -> [f32; 3] {
    [pixel[0], pixel[1], pixel[2]]
}
