//! Owns the persistent state: create, update, record, report.

use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::gpu::shared::{
    DEBUG_ALBEDO, DEBUG_BRICKS, DEBUG_FALLBACK, DEBUG_HISTORY, DEBUG_IRRADIANCE, DEBUG_NORMALS, DEBUG_PROBE_RADIANCE,
    DEBUG_PROBES, DEBUG_RADIANCE, DEBUG_STEPS, PROBE_LAYERS, PROBE_MASK,
};
use crate::gpu::{Device, Pipelines, Player, Slot, Target};
use crate::parallel::{ParallelFor, Workers};
use crate::passes::bricks::VOXELIZE_PASSES;
use crate::passes::light::{bounce_pass, direct_passes};
use crate::passes::probes::{composite, composite_pass, debug_pass, debug_view, gather, output_passes};
use crate::scene::{Camera, Light, MeshUpdate, Scene, ShadowMap, Sky, SkyImage, Triangles, check_shadow_maps};
use crate::settings::Settings;
use crate::view::{FrameShape, View, history_bytes};
use crate::world::{FrameScope, World};
use ash::vk;
use glam::{DVec3, UVec2};
use std::collections::HashMap;
use std::time::Instant;

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
    /// The host's threads, for `update_meshes` and `dispatch` calls in which many triangles have to be told apart by bricks;
    /// None: the calling thread. The result does not depend on them.
    pub parallel_for: Option<ParallelFor>,
}

/// A view of a context: a camera with its own probes and history.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ViewId(pub u64);

/// What the output shows in place of E_ind, for the host's developer. E_ind is worked out all the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum DebugView {
    /// A colour for each brick, a shade for each of its voxels.
    Bricks = DEBUG_BRICKS,
    /// Albedo of the voxel face that a ray of the camera hits, 0 to 1; 0 where it hits none.
    Albedo = DEBUG_ALBEDO,
    /// Normal of that face's plane in world space, halved, plus 0.5.
    Normals = DEBUG_NORMALS,
    /// What that face sends out (radiance, in the lights' unit): the light that the gather finds there. The sky's where
    /// there is none.
    Radiance = DEBUG_RADIANCE,
    /// Cells that the ray visits: black 0, blue 32, green 64, red 96, white 128 and more.
    Steps = DEBUG_STEPS,
    /// Frames that the pixel has averaged, of those that it may: 0 to 1.
    History = DEBUG_HISTORY,
    /// What the pixel's tile has: a screen probe of the last frame (green), one that looks in its turn (blue) or for want
    /// of a settled one (red), or none (black).
    Probes = DEBUG_PROBES,
    /// What arrives at the face that a ray of the camera hits (irradiance, direct and indirect, in the lights' unit): what
    /// it sends out, its emission taken off, by its albedo. 0 where there is none, or no albedo.
    Irradiance = DEBUG_IRRADIANCE,
    /// The radiance map of each tile's screen probe, 8 x 8 hemi-octahedral directions about its normal: the root of the
    /// mean square of the luminance that came from there in some eight frames, in the lights' unit.
    ProbeRadiance = DEBUG_PROBE_RADIANCE,
    /// How far the probes stand for the pixel, green, 0 to 1; red where none does and it shoots rays into the world's
    /// cache instead.
    Fallback = DEBUG_FALLBACK,
}

impl DebugView {
    /// Every one.
    pub const ALL: [Self; 10] = [
        Self::Bricks,
        Self::Albedo,
        Self::Normals,
        Self::Radiance,
        Self::Steps,
        Self::History,
        Self::Probes,
        Self::Irradiance,
        Self::ProbeRadiance,
        Self::Fallback,
    ];
}

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
    /// Where each pixel's surface was in the view's last frame.
    pub motion: Option<Motion>,
    /// Receives E_ind in rgb (irradiance, linear Rec.709, unit of the lights) and 1 in a, 0 where nothing was drawn.
    /// Format R16G16B16A16_SFLOAT or R32G32B32A32_SFLOAT as `output_float32` says; usage STORAGE; layout `GENERAL`.
    pub output: vk::ImageView,
    /// Whether `output` is R32G32B32A32_SFLOAT (else R16G16B16A16_SFLOAT).
    pub output_float32: bool,
    /// What the output shows instead of E_ind. The first such dispatch creates a pipeline.
    pub debug_view: Option<DebugView>,
    /// What the host would draw, made as well. The first such dispatch creates a pipeline.
    pub composite: Option<Composite>,
    /// Left column and top row of the rendered region in all images; it must lie inside them. A view's region may lie
    /// elsewhere in each frame.
    pub origin: [u32; 2],
    /// Width of the rendered region in pixels (at most the view's).
    pub width: u32,
    /// Height of the rendered region in pixels (at most the view's).
    pub height: u32,
}

/// Motion vectors: `previous pixel = pixel + motion * scale`, as engines hand them to temporal upscalers.
///
/// The full motion on screen, the camera's too, from this frame to the one that the view's last dispatch had. Without
/// jitter: what the two cameras' projections are off their middle by is added here. Without such an image all is taken to
/// have stood still, and what moves leaves trails.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Motion in xy (float or snorm format of two channels or more, 16 bits suffice); usage SAMPLED, layout
    /// `SHADER_READ_ONLY_OPTIMAL`. Not read where nothing was drawn.
    pub image: vk::ImageView,
    /// From the image's values to pixels of this frame's region, x to the right, y down.
    pub scale: [f32; 2],
}

/// Direct and indirect light in one picture: direct + albedo / pi x E_ind.
#[derive(Clone, Copy, Debug)]
pub struct Composite {
    /// Albedo of the surfaces in rgb, linear Rec.709, 0 to 1; usage SAMPLED, layout `SHADER_READ_ONLY_OPTIMAL`.
    pub albedo: vk::ImageView,
    /// What surfaces send out by direct light and emission, and the background, in rgb: radiance, linear Rec.709, unit of
    /// the lights; usage SAMPLED, layout `SHADER_READ_ONLY_OPTIMAL`.
    pub direct: vk::ImageView,
    /// Receives the sum in rgb and 1 in a; the output alone where that is a debug view. Format and layout as `output`'s;
    /// another image.
    pub output: vk::ImageView,
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
    /// Device memory of the world in bytes, upload buffers and what frames in flight still use included: what the
    /// memory budget bounds.
    pub world_bytes: u64,
    /// Device memory of all views in bytes.
    pub view_bytes: u64,
    /// Every device allocation.
    pub resources: Vec<ResourceSize>,
    /// Bricks resident.
    pub bricks: u32,
    /// Bricks that should be resident and are not (waiting, or no memory).
    pub bricks_missing: u32,
    /// Those of the missing bricks that are in view and nearer than 128 voxels, but for what is left out.
    pub bricks_missing_in_view: u32,
    /// Those of the missing bricks that are left out because the world does not fit into its memory budget.
    pub bricks_left_out: u32,
    /// Bricks that the latest `dispatch` call voxelises.
    pub bricks_voxelized: u32,
    /// Lit voxel faces resident.
    pub faces: u32,
    /// Voxel faces resident that are not lit, because neither light nor eye reaches them and memory is short.
    pub faces_unreached: u32,
    /// How far the light of the faces resident has settled since lights or sky last changed, 0 to 1, times the share of the
    /// bricks that are resident. 1: all is loaded and settled, no lighting is recorded until something changes. What a
    /// loading screen waits for; light has come to every corner long before 1.
    pub convergence: f32,
    /// Allocation units of 32 bytes in use by bricks.
    pub pages: u32,
    /// Meshes in the host's buffers that have not been read to the end yet: those handed over last.
    pub meshes_pending: u32,
    /// Rays traced in the frame; those to lights as if there were no shadow maps.
    pub rays: u64,
    /// Screen probes that looked in the frame, 64 rays each.
    pub probes_traced: u32,
    /// Those of the frame before that have come to a tile of this one's, one to each.
    pub probes_carried: u32,
    /// Those that came to a tile where another has come.
    pub probe_conflicts: u32,
    /// Those given up, since another surface is in their place.
    pub probes_rejected: u32,
    /// Triangles of all meshes, as the host handed them over.
    pub mesh_triangles: u64,
    /// Those that are kept of them ([`Settings::simplify_voxels`]).
    pub kept_triangles: u64,
    /// Dispatch calls so far.
    pub frames: u64,
}

/// Dispatch calls for which the world keeps to a view's camera after the view's last one.
const IN_USE_FRAMES: u32 = 64;

/// The library's state on one device. See the crate's front page for the frame.
pub struct Context {
    // Declared first so that what lives on the device is destroyed explicitly in `drop`.
    world: World,
    scene: Scene,
    views: HashMap<u64, View>,
    next_view: u64,
    slots: Vec<Slot>,
    frame_index: u32,
    /// The latest frame's list; kept for its memory.
    frame: Frame,
    player: Player,
    stats: Stats,
    settings: Settings,
    pipelines: Pipelines,
    device: Device,
}

impl Context {
    /// Says whether a physical device will do, before a device is created on it.
    ///
    /// # Safety
    /// The handles must be valid.
    pub unsafe fn device_requirements(
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
    ) -> Result<DeviceRequirements> {
        // SAFETY: passed on.
        unsafe { Device::requirements(get_instance_proc_addr, instance, physical_device) }
    }

    /// Creates pipelines and the fixed tables.
    ///
    /// # Safety
    /// The handles in `desc.device` must be valid and outlive the context.
    pub unsafe fn new(desc: ContextDesc) -> Result<Self> {
        desc.settings.validate()?;
        if !(1..=8).contains(&desc.frames_in_flight) {
            return Err(Error::invalid("frames_in_flight must be 1 to 8"));
        }
        // SAFETY: passed on.
        let device = unsafe { Device::new(&desc.device)? };
        let mut world = World::new(&desc.settings, desc.frames_in_flight as usize)?;
        world.workers = Workers(desc.parallel_for);
        let mut context = Self {
            world,
            scene: Scene::new(&desc.settings),
            views: HashMap::new(),
            next_view: 1,
            slots: Vec::new(),
            frame_index: 0,
            frame: Frame::default(),
            player: Player::default(),
            stats: Stats::default(),
            settings: desc.settings,
            pipelines: Pipelines::new(&device)?,
            device,
        };
        if context.settings.bounce_rays > 0 {
            context.pipelines.add(&context.device, bounce_pass(&context.settings))?;
        }
        for pass in direct_passes(&[], false, &context.settings) {
            context.pipelines.add(&context.device, pass)?;
        }
        for _ in 0..desc.frames_in_flight {
            let slot = Slot::new(&context.device)?;
            context.slots.push(slot);
        }
        Ok(context)
    }

    /// Adds, replaces, moves or removes what the world is made of. On an error nothing of the batch is applied. Meshes in
    /// the host's buffers are read by the following dispatches, in the order in which they were handed over, up to some
    /// MiB a frame ([`BufferAddress`](crate::scene::BufferAddress) has the rules).
    pub fn update_meshes(&mut self, update: &MeshUpdate) -> Result<()> {
        self.scene.check(update)?;
        for mesh in update.buffer_meshes {
            mesh.check_ends(|buffer| self.device.buffer_bytes(buffer))?;
        }
        self.world.readback.update(update)?;
        let changed = self.scene.apply(update);
        self.world.instances_changed(&changed, &self.scene);
        self.count_meshes();
        Ok(())
    }

    fn count_meshes(&mut self) {
        self.stats.meshes_pending = self.world.readback.pending();
        let Triangles { given, kept } = self.scene.triangles;
        (self.stats.mesh_triangles, self.stats.kept_triangles) = (given, kept);
    }

    /// Replaces all lights and the sky.
    pub fn set_lights(&mut self, lights: &[Light], sky: Sky) -> Result<()> {
        if lights.len() > 4096 {
            return Err(Error::invalid("at most 4096 lights"));
        }
        for (index, light) in lights.iter().enumerate() {
            light.check().map_err(|fault| Error::invalid(format!("lights[{index}]: {fault}")))?;
        }
        sky.check().map_err(|fault| Error::invalid(format!("sky: {fault}")))?;
        if matches!(sky, Sky::Image { .. }) && self.scene.sky_map.is_empty() {
            return Err(Error::invalid("sky: no image has been handed over"));
        }
        for pass in direct_passes(lights, !self.scene.shadow_maps.is_empty(), &self.settings) {
            self.pipelines.add(&self.device, pass)?;
        }
        if self.scene.lights != lights || self.scene.sky != sky {
            self.scene.lights = lights.to_vec();
            self.scene.sky = sky;
            self.world.lights_changed();
        }
        Ok(())
    }

    /// Takes or replaces the image that [`Sky::Image`] means. It is reduced, in some ten milliseconds a million texels, to
    /// 64 x 64 mean radiances. Its sum over the sphere stays, and so do, within 1 %, those over hemispheres, but for a sun
    /// that stands on their horizon. Rays that miss the scene read the map: a sun in it is found by few of them and makes
    /// noise. Better paint it out, and hand it over as a directional light.
    pub fn set_sky_image(&mut self, image: &SkyImage) -> Result<()> {
        let map = image.reduce()?;
        if self.scene.sky_map != map {
            self.scene.sky_map = map;
            self.world.lights_changed();
        }
        Ok(())
    }

    /// Replaces the host's shadow maps for the following dispatches: where one covers a point of a face, it says whether its
    /// light arrives there; where none does, a ray through the bricks does. Cheap: meant to be called every frame, as cascades
    /// follow the camera. Lights that have jumped are told by `set_lights`; averages do not start over for another map.
    ///
    /// While lighting sleeps (nothing changes) no map is read. Where shadows change by what neither `set_lights` nor
    /// `update_meshes` is told of, such as casters that are not among the meshes, or maps that come first or go,
    /// `invalidate_lighting` has them seen.
    ///
    /// # Safety
    /// The views are as [`ShadowMap`] says in each following dispatch, and stay valid until the GPU has finished with the
    /// command buffers of these, until they are replaced.
    pub unsafe fn set_shadow_maps(&mut self, maps: &[ShadowMap]) -> Result<()> {
        check_shadow_maps(maps, &self.scene.lights)?;
        for pass in direct_passes(&self.scene.lights, !maps.is_empty(), &self.settings) {
            self.pipelines.add(&self.device, pass)?;
        }
        self.scene.shadow_maps = maps.to_vec();
        Ok(())
    }

    /// All light is wrong: lights have jumped, a level has loaded. Averages start over, and views forget theirs. What changes
    /// through `set_lights` and `update_meshes` needs no such hint.
    pub fn invalidate_lighting(&mut self) {
        self.world.forget_light();
    }

    /// Creates a view for images of up to `width` x `height` pixels, 1 to 16384 each.
    pub fn create_view(&mut self, width: u32, height: u32) -> Result<ViewId> {
        if !(1..=16_384).contains(&width) || !(1..=16_384).contains(&height) {
            return Err(Error::invalid("a view's sides must be 1 to 16384"));
        }
        let limit = u64::from(self.device.limits.max_storage_buffer_range);
        let [x, y] = [width, height].map(|side| u64::from(side.div_ceil(self.settings.probe_tile)));
        let probes = u64::from(PROBE_LAYERS) * x * y;
        if history_bytes(UVec2::new(width, height)) > limit || probes * 144 > limit || probes > u64::from(PROBE_MASK) {
            return Err(Error::invalid(
                "the view has more pixels or probes than the device's buffers and dispatches hold",
            ));
        }
        let view = View::new(&self.device, UVec2::new(width, height), self.settings.probe_tile)?;
        let id = self.next_view;
        self.next_view += 1;
        self.views.insert(id, view);
        Ok(ViewId(id))
    }

    /// Destroys a view. The GPU must have finished with it.
    pub fn destroy_view(&mut self, view: ViewId) -> Result<()> {
        let mut gone = self.views.remove(&view.0).ok_or_else(|| Error::UnknownId(format!("view {}", view.0)))?;
        gone.destroy(&self.device);
        Ok(())
    }

    /// Sets a view's camera for the following dispatches.
    pub fn set_camera(&mut self, view: ViewId, camera: &Camera) -> Result<()> {
        let view = self.views.get_mut(&view.0).ok_or_else(|| Error::UnknownId(format!("view {}", view.0)))?;
        view.set_camera(camera)
    }

    /// Records one frame into the host's command buffer.
    ///
    /// # Safety
    /// `inputs` must hold valid handles as documented at [`FrameInputs`].
    pub unsafe fn dispatch(&mut self, inputs: &FrameInputs) -> Result<()> {
        let start = Instant::now();
        let view = self.views.get_mut(&inputs.view.0);
        let view = view.ok_or_else(|| Error::UnknownId(format!("view {}", inputs.view.0)))?;
        let size = UVec2::new(inputs.width, inputs.height);
        if size.cmpeq(UVec2::ZERO).any() || size.cmpgt(view.size).any() {
            return Err(Error::invalid(format!("width and height must be 1 to the view's {}", view.size)));
        }
        if inputs.origin.iter().any(|at| *at >= 16_384) {
            return Err(Error::invalid(format!("the region begins at {:?}; 0 to 16383 are possible", inputs.origin)));
        }
        if vk::Handle::as_raw(inputs.command_buffer) == 0
            || [inputs.depth, inputs.normal, inputs.output].contains(&vk::ImageView::null())
        {
            return Err(Error::invalid("command_buffer, depth, normal and output must not be null"));
        }
        if let Some(Motion { image, scale }) = inputs.motion
            && (image == vk::ImageView::null() || !scale.iter().all(|s| s.is_finite() && *s != 0.0))
        {
            return Err(Error::invalid("motion must not be null, and its scale finite and not zero"));
        }
        if let Some(Composite { albedo, direct, output }) = inputs.composite
            && ([albedo, direct, output].contains(&vk::ImageView::null()) || output == inputs.output)
        {
            return Err(Error::invalid("albedo, direct and composite must not be null, nor composite the output"));
        }
        let camera = view.camera.ok_or_else(|| Error::invalid("the view has no camera yet"))?;
        for pass in output_passes(self.settings.near_field, inputs.output_float32) {
            self.pipelines.add(&self.device, pass)?;
        }
        if inputs.debug_view.is_some() {
            self.pipelines.add(&self.device, debug_pass(inputs.output_float32))?;
        }
        if inputs.composite.is_some() {
            self.pipelines.add(&self.device, composite_pass(inputs.output_float32))?;
        }
        view.drawn = Some(self.frame_index);

        let index = self.frame_index as usize % self.slots.len();
        self.read_back(index);
        let eye = self.world.grid.to_voxels(DVec3::from(camera.position));
        let now = self.frame_index;
        let in_use = |view: &&View| view.drawn.is_some_and(|drawn| now.wrapping_sub(drawn) < IN_USE_FRAMES);
        let grid = self.world.grid;
        let cameras = self.views.values().filter(in_use).filter_map(|view| view.camera.as_ref());
        self.world.follow(cameras.map(|c| grid.to_voxels(DVec3::from(c.position))), &self.scene);
        let mut frame = std::mem::take(&mut self.frame);
        frame.clear();
        let mut scope = FrameScope::new(&self.device, &self.settings, &mut self.slots, index, self.frame_index, frame);
        let upload_limit = self.world.frame(&mut scope, &mut self.scene, eye, camera.clip())?;
        let mut frame = scope.frame;
        let shape = FrameShape {
            origin: inputs.origin,
            size,
            tile_size: self.settings.probe_tile,
            clear_depth: inputs.clear_depth,
            history_max: self.world.history_max(&self.settings),
            loads: self.world.loads,
            pixel_rays: self.settings.pixel_rays,
            // The reference for probes looks always.
            gather_interval: if self.settings.pixel_rays == 0 { self.settings.gather_interval } else { 1 },
            probes_per_frame: self.settings.probes_per_frame,
            near_field: self.settings.near_field,
            watches: self.world.watches(),
            motion_scale: inputs.motion.map(|motion| motion.scale.into()),
        };
        let view = self.views.get_mut(&inputs.view.0).expect("found above");
        let uniform = view.uniform(&camera, eye - self.world.window_voxels(), &shape);
        gather(&mut frame, &uniform, self.frame_index, shape.watches, inputs.output_float32);
        if let Some(shown) = inputs.debug_view {
            debug_view(&mut frame, &uniform, shown, inputs.output_float32);
        }
        if inputs.composite.is_some() {
            composite(&mut frame, &uniform, inputs.debug_view.is_some(), inputs.output_float32);
        }

        self.world.bind(index, &self.scene, &mut self.player);
        view.bind(inputs, &mut self.player.bound);
        let to = Target { device: &self.device, pipelines: &self.pipelines, commands: inputs.command_buffer };
        self.player.play(to, &frame, &mut self.slots[index], upload_limit)?;
        self.frame = frame;
        self.frame_index = self.frame_index.wrapping_add(1);
        self.stats.bricks_voxelized = self.world.voxelizing(index);
        self.report(start);
        Ok(())
    }

    /// Takes in what the GPU wrote when this slot was last used.
    fn read_back(&mut self, index: usize) {
        let passes = &mut self.stats.passes;
        let slot = &mut self.slots[index];
        if slot.timing.has_times() {
            passes.clear();
            slot.timing.read(&self.device, |name, ms| match passes.iter_mut().find(|p| p.name == name) {
                Some(pass) => pass.ms += ms,
                None => passes.push(PassTime { name, ms }),
            });
            self.stats.frame_ms = passes.iter().map(|p| p.ms).sum();
            let own = passes.iter().filter(|p| VOXELIZE_PASSES.contains(&p.name));
            self.world.voxelized_in(index, own.map(|p| p.ms).sum());
        }
        slot.recycle(&self.device);
        self.stats.rays = self.world.rays(index);
        let [traced, carried, conflicts, rejected] = self.world.probe_counts(index);
        self.stats.probes_traced = traced;
        self.stats.probes_carried = carried;
        self.stats.probe_conflicts = conflicts;
        self.stats.probes_rejected = rejected;
    }

    fn report(&mut self, start: Instant) {
        self.count_meshes();
        let stats = &mut self.stats;
        stats.resources.clear();
        self.world.list(&self.slots, &mut stats.resources);
        stats.world_bytes = stats.resources.iter().map(|r| r.bytes).sum();
        stats.view_bytes = self.views.values().flat_map(View::sizes).map(|r| r.bytes).sum();
        stats.resources.extend(self.views.values().flat_map(View::sizes));
        stats.bricks = self.world.table.resident();
        stats.bricks_missing = self.world.table.missing();
        stats.bricks_missing_in_view = self.world.missing_in_view;
        stats.bricks_left_out = self.world.table.left_out();
        stats.faces = self.world.table.faces();
        stats.faces_unreached = self.world.table.unreached();
        stats.convergence = self.world.table.convergence() as f32;
        stats.pages = self.world.table.pages.used();
        stats.frames += 1;
        stats.cpu_ms = start.elapsed().as_secs_f64() * 1e3;
    }

    /// What the host's developer should know, one readable line each, since the last call; never the same line a frame.
    pub fn take_warnings(&mut self) -> Vec<String> {
        self.world.take_warnings()
    }

    /// What the context holds and did.
    pub fn stats(&self) -> &Stats {
        &self.stats
    }
}

impl Drop for Context {
    /// The GPU must have finished with every recorded frame.
    fn drop(&mut self) {
        self.world.destroy(&self.device);
        self.views.values_mut().for_each(|v| v.destroy(&self.device));
        self.slots.iter_mut().for_each(|s| s.destroy(&self.device));
        self.pipelines.destroy(&self.device);
    }
}
