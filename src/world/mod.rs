//! The shared world on the GPU: what a frame does to it.

mod growth;
mod hearing;
mod lights;
mod memory;
mod readback;
mod shadows;
mod voxelization;

use crate::bricks::{
    Batch, BrickTable, Cells, Finished, LightBudget, Lit, PrimitiveIndex, Regions, Viewpoint, WorldGrid, unpack,
};
use crate::context::ResourceSize;
use crate::error::Result;
use crate::frame::{Command, Frame};
use crate::gpu::shared::{
    ASKS, Frame as FrameUniform, Light as GpuLight, Material as GpuMaterial, NO_TEXTURE, PROBE_RAYS,
    ShadowLayer as GpuShadowLayer,
};
use crate::gpu::{Device, Player, Slot};
use crate::parallel::Workers;
use crate::passes::{self, light::Lights};
use crate::scene::{MAX_SHADOW_LAYERS, Scene};
use crate::settings::Settings;
use glam::{DMat4, DVec3, IVec3, UVec3};
use hearing::{Hear, Hearing};
use memory::{BRICK_FACES, Fixed, Memory};
use readback::Readback;
use rustc_hash::FxHashMap;

/// Bricks that arrive within some frames make a load, not something that moves about: so many, and a twentieth of the
/// world.
const LOADING_MIN: u32 = 4;
/// Frames after the last change of an instance in which light may still change with it.
const WATCHED_FRAMES: u32 = 64;
/// Lighting sweeps a frame when the face budget allows: the more, the faster light travels.
const SWEEPS_MAX: u32 = 4;

/// What a frame is made with, and what it has come to so far.
pub struct FrameScope<'a> {
    pub device: &'a Device,
    pub settings: &'a Settings,
    /// One a frame in flight.
    pub slots: &'a mut [Slot],
    /// This frame's slot.
    pub index: usize,
    /// Dispatch calls before this one.
    pub frame_index: u32,
    /// Bytes of the frame's upload that are kept free for its small parts.
    pub upload_reserve: u64,
    /// Bytes that each of the others' may need.
    pub upload_least: u64,
    pub frame: Frame,
}

impl<'a> FrameScope<'a> {
    /// `frame` is empty.
    pub fn new(
        device: &'a Device,
        settings: &'a Settings,
        slots: &'a mut [Slot],
        index: usize,
        frame_index: u32,
        frame: Frame,
    ) -> Self {
        Self { device, settings, slots, index, frame_index, upload_reserve: 0, upload_least: 0, frame }
    }

    fn slot(&mut self) -> &mut Slot {
        &mut self.slots[self.index]
    }
}

/// What one frame in flight will tell.
#[derive(Clone, Default)]
struct Flight {
    bricks: Vec<IVec3>,
    light_rays: u64,
    lit: Vec<Lit>,
    /// Low corner of the window, voxels.
    window: IVec3,
}

/// The world's CPU and GPU state.
pub struct World {
    pub table: BrickTable,
    primitives: PrimitiveIndex,
    regions: Regions,
    hearing: Hearing,
    /// The world, all of its faces lit, does not fit into its memory.
    short: bool,
    /// They find which triangles touch which bricks.
    pub workers: Workers,
    pub grid: WorldGrid,
    pub readback: Readback,
    memory: Memory,
    flights: Vec<Flight>,
    /// The last frame's; kept for its memory.
    batch: Batch,
    material_index: FxHashMap<u64, u32>,
    /// Materials have changed, and there is no room for the new ones yet.
    materials_wait: bool,
    /// Mean words of the bricks seen so far.
    mean_words: f32,
    /// Bytes of the budget that the bricks will not need, as far as is known.
    spare: u64,
    /// Mean bytes of triangles that they uploaded.
    mean_upload: f32,
    /// GPU milliseconds that a brick's voxelisation takes, 0 while nothing has been measured.
    brick_ms: f64,
    updates: u32,
    /// Bricks that have arrived of late where there were none.
    arriving: f64,
    /// How often a large part of the world has been loaded, or the host said so: what views saw before, with holes in the
    /// world, is of no use.
    pub loads: u32,
    /// Bricks near and in view that the last frame has to do without.
    pub missing_in_view: u32,
    /// Frames without voxelisation.
    idle: usize,
    /// Frames since a large part of the world, or its lights, changed.
    steady_frames: u32,
    /// In which views still look whether their averages lag behind.
    watched_frames: u32,
    /// Nothing had changed for a while before.
    abrupt: bool,
    /// Bricks were left out for lack of memory, and the host has been told.
    incomplete: bool,
    /// A brick had more triangles than are looked at, and the host has been told.
    crowded: bool,
    warnings: Vec<String>,
}

impl World {
    pub fn new(settings: &Settings, frames_in_flight: usize) -> Result<Self> {
        let table = BrickTable::new(UVec3::from(settings.coverage_groups));
        Ok(Self {
            memory: Memory::new(settings, frames_in_flight, u64::from(table.grid.words()) * 4)?,
            table,
            primitives: PrimitiveIndex::default(),
            regions: Regions::default(),
            hearing: Hearing::default(),
            short: false,
            workers: Workers::default(),
            grid: WorldGrid {
                voxel_size: f64::from(settings.voxel_size),
                offset: DVec3::from(settings.grid_offset.map(f64::from)),
            },
            readback: Readback::new(frames_in_flight),
            flights: vec![Flight::default(); frames_in_flight],
            batch: Batch::default(),
            material_index: FxHashMap::default(),
            materials_wait: false,
            mean_words: 1024.0,
            spare: 0,
            mean_upload: 2048.0,
            brick_ms: 0.0,
            arriving: 0.0,
            loads: 0,
            updates: 0,
            missing_in_view: 0,
            idle: 0,
            steady_frames: 0,
            watched_frames: 0,
            abrupt: false,
            incomplete: false,
            crowded: false,
            warnings: Vec::new(),
        })
    }

    /// Low corner of the window in voxels.
    pub fn window_voxels(&self) -> DVec3 {
        (self.table.window() * 8).as_dvec3()
    }

    /// Re-registers changed instances and queues the bricks that they left or touch.
    pub fn instances_changed(&mut self, changed: &[u64], scene: &Scene) {
        let Self { table, primitives, regions, grid, workers, .. } = self;
        let mut touch = |bricks: &[IVec3]| {
            table.touch(bricks);
            // Of what is not resident, what was known is no longer true.
            bricks.iter().filter(|b| !table.holds(**b)).for_each(|b| regions.forget(*b));
        };
        let left = primitives.remove(changed);
        touch(&left);
        let present: Vec<u64> = changed.iter().filter(|id| scene.instances.contains_key(id)).copied().collect();
        primitives.insert(&present, scene, grid, workers);
        present.iter().for_each(|id| touch(primitives.touched(*id)));
        left.into_iter().filter(|b| !self.primitives.holds(*b)).for_each(|b| self.table.forget(b));
        // What has never been whole is averaged anew when it is.
        if self.loads > 0 {
            self.watched_frames = WATCHED_FRAMES;
        }
    }

    /// Everything converges anew: the lights have changed.
    pub fn lights_changed(&mut self) {
        self.table.invalidate_lighting();
        // What changes in every frame would otherwise have no average at all.
        self.abrupt = self.steady_frames >= 32;
        self.steady_frames = 0;
    }

    /// What faces and views know of light is of no use any more.
    pub fn forget_light(&mut self) {
        self.lights_changed();
        self.loads += 1;
    }

    /// Frames that a view's history may average: few while the world is changing.
    pub fn history_max(&self, settings: &Settings) -> u32 {
        settings.temporal_frames.min(self.steady_frames.max(if self.abrupt { 2 } else { 8 }))
    }

    /// Whether light may have changed, with what stands in its way, since views have averaged it.
    pub fn watches(&self) -> bool {
        self.watched_frames > 0
    }

    /// Bricks that the slot's last frame voxelises.
    pub fn voxelizing(&self, index: usize) -> u32 {
        self.flights[index].bricks.len() as u32
    }

    /// Rays that the slot's last frame traced.
    pub fn rays(&self, index: usize) -> u64 {
        let [probes, ..] = self.memory.probe_counts(index);
        self.flights[index].light_rays + u64::from(PROBE_RAYS) * u64::from(probes)
    }

    /// Of the slot's last frame, probes that looked, came to a tile, met another one there, and were given up.
    pub fn probe_counts(&self, index: usize) -> [u32; 4] {
        self.memory.probe_counts(index)
    }

    /// Follows the views in use, whose cameras are at `eyes` (voxels): the window's middle is the middle between them, and
    /// where they are is reached. Before each frame.
    pub fn follow(&mut self, eyes: impl Iterator<Item = DVec3> + Clone, scene: &Scene) {
        self.regions.follow(eyes.clone().map(|eye| eye.floor().as_ivec3()));
        let Some((low, high)) = eyes.map(|eye| (eye, eye)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))) else { return };
        if self.table.follow((low + high) / 2.0, self.primitives.bounds) {
            // What has moved holds other triangles.
            let window = self.table.window_bricks().expect("it has just moved");
            self.primitives.follow(window, scene, &self.grid, &self.workers);
            self.table.enter(self.primitives.bricks());
            self.regions.retain(|brick| window.holds(brick));
        }
    }

    /// The world's part of a frame seen from `eye` (voxels); `clip` is clip space of the position relative to it in metres.
    /// Returns the bytes that the frame's upload buffer may have.
    pub fn frame(&mut self, scope: &mut FrameScope, scene: &mut Scene, eye: DVec3, clip: DMat4) -> Result<u64> {
        self.take_in_meshes(scope.index, scene);
        self.table.tick();
        let fixed = self.fixed(scene);
        self.memory.check(&fixed)?;
        self.steady_frames = self.steady_frames.saturating_add(1);
        self.watched_frames = self.watched_frames.saturating_sub(1);
        scope.upload_reserve = Memory::upload_reserve(self.table.resident(), fixed.lights);
        scope.upload_least = Memory::upload_least(fixed.lights);
        self.memory.fit_counters(scope)?;
        scope.frame.commands.push(Command::Clear("counters"));
        self.upload_materials(scope, scene)?;
        self.commit(scope, scene)?;
        self.take_requests(scope.index);
        let lit = &mut self.flights[scope.index].lit;
        let found = self.memory.light_changes(scope.index, lit.len());
        self.table.note_light(lit.drain(..).zip(found));
        let again = self.regions.update(self.short);
        self.table.touch_reach(&again);
        let viewpoint = Viewpoint::new(eye / 8.0, clip, 8.0 * self.grid.voxel_size);
        self.voxelize(scope, scene, &viewpoint)?;
        self.missing_in_view = self.table.missing_in_view(&viewpoint);
        self.ask_for_meshes(scope)?;
        self.light(scope, scene, eye / 8.0)?;
        self.tell(scope.settings);
        self.memory.finish(scope)
    }

    /// What cannot be refused. Materials count twice while old ones stand in the way of new ones.
    fn fixed(&self, scene: &Scene) -> Fixed {
        let materials = (scene.materials.len() * size_of::<GpuMaterial>()) as u64 + scene.texel_bytes;
        // As many as there may be, for their number changes with what is in view.
        let shadows = if scene.shadow_maps.is_empty() { 0 } else { MAX_SHADOW_LAYERS * size_of::<GpuShadowLayer>() };
        Fixed {
            grid: u64::from(self.table.grid.words()) * 4,
            materials: materials + if self.materials_wait { self.memory.materials_bytes() } else { 0 },
            lights: (size_of::<GpuLight>() * scene.lights.len() + shadows + size_of_val(scene.sky_texels())) as u64,
        }
    }

    fn upload_materials(&mut self, scope: &mut FrameScope, scene: &mut Scene) -> Result<()> {
        if !scene.materials_changed && self.memory.has_materials() {
            return Ok(());
        }
        let mut texels: Vec<u32> = Vec::new();
        let mut places = FxHashMap::default();
        let mut textures: Vec<_> = scene.textures.iter().collect();
        textures.sort_by_key(|t| t.0);
        for (id, texture) in textures {
            places.insert(*id, (texels.len() as u32, texture.width | texture.height << 16));
            texels.extend_from_slice(&texture.texels);
        }
        let mut ids: Vec<u64> = scene.materials.keys().copied().collect();
        ids.sort_unstable();
        let materials: Vec<GpuMaterial> = ids
            .iter()
            .map(|id| {
                let m = &scene.materials[id];
                let place = m.texture.and_then(|t| places.get(&t)).copied();
                let (texture, texture_size) = place.unwrap_or((NO_TEXTURE, 0));
                GpuMaterial {
                    base_color: m.base_color.to_array(),
                    texture,
                    emission: m.emission.to_array(),
                    texture_size,
                    opacity: m.opacity,
                    texture_alpha: m.texture_alpha.into(),
                    unused: [0; 2],
                }
            })
            .collect();
        let (materials, texels) = (bytemuck::cast_slice(&materials), bytemuck::cast_slice(&texels));
        self.materials_wait = !self.memory.replace_materials(scope, materials, texels)?;
        if !self.materials_wait {
            scene.materials_changed = false;
            self.material_index = ids.iter().enumerate().map(|(index, id)| (*id, index as u32)).collect();
        }
        Ok(())
    }

    /// Takes in the bricks that the slot's last frame finished.
    fn commit(&mut self, scope: &mut FrameScope, scene: &Scene) -> Result<()> {
        let bricks = std::mem::take(&mut self.flights[scope.index].bricks);
        self.memory.take_payload(scope.index);
        let results = self.memory.results(scope.index, bricks.len());
        let finished: Vec<Finished> =
            bricks.into_iter().zip(results).map(|(position, result)| Finished { position, result }).collect();
        if !finished.is_empty() {
            let words: u32 = finished.iter().map(|f| f.result.words).sum();
            let filled = finished.iter().filter(|f| f.result.words > 0).count().max(1);
            self.mean_words = 0.5 * self.mean_words + 0.5 * words as f32 / filled as f32;
        }
        if scope.settings.region_culling {
            for Finished { position, result } in finished.iter().filter(|f| self.table.takes(f)) {
                self.regions.arrive(*position, Cells::from_blocks(&result.occupied));
            }
        }
        self.fit_pages(scope, scene, &finished)?;
        self.table.survey(self.short);
        let moves = self.table.compact();
        self.table.share_out();
        let arrived = self.table.finish(&finished);
        finished.iter().filter(|f| !self.primitives.holds(f.position)).for_each(|f| self.table.forget(f.position));
        // What was lit in a world with holes must not linger.
        self.arriving = 0.75 * self.arriving + f64::from(arrived.new);
        if self.arriving > f64::from((self.table.resident() / 20).max(LOADING_MIN)) {
            self.lights_changed();
        }
        if !finished.is_empty() && self.table.has_loaded() {
            self.regions.forget_requests();
            self.hearing = Hearing::default();
            self.forget_light();
        }
        let grid_writes = self.table.grid.take_writes();
        passes::bricks::commit(&mut scope.frame, &moves, &arrived, &grid_writes);
        Ok(())
    }

    /// Takes in which faces without light rays came to in the slot's last frame.
    fn take_requests(&mut self, index: usize) {
        if !self.short {
            self.hearing = Hearing::default();
            return;
        }
        let is_still = self.table.is_idle() && self.regions.is_idle();
        match self.hearing.update(is_still, self.table.left_out()) {
            Hear::Requests { share } if self.regions.any_masked() => {
                let window = self.flights[index].window;
                let requests = self.memory.requests(index).into_iter().map(|(cell, count)| (window + cell, count));
                self.regions.take_requests(requests, self.rays(index), share);
            }
            Hear::Requests { .. } | Hear::Nothing => {}
            Hear::Anew => self.regions.forget_requests(),
        }
    }

    fn light(&mut self, scope: &mut FrameScope, scene: &Scene, camera: DVec3) -> Result<()> {
        let settings = scope.settings;
        let low_corner = self.window_voxels();
        let (low, high) = self.table.bounds().unwrap_or((self.table.window(), self.table.window()));
        let relative = |b: IVec3| ((b - self.table.window()) * 8).as_vec3().to_array();
        let extent = UVec3::from(settings.coverage_groups);
        let (sky_kind, sky, [sky_x, sky_y, sky_z]) = scene.sky.uniform();
        let uniform = FrameUniform {
            extent: extent.to_array(),
            frame_index: scope.frame_index,
            torus: ((self.table.window() >> 2i32).as_uvec3() & (extent - 1)).to_array(),
            hit_model: settings.hit_model as u32,
            bounds_min: relative(low),
            voxel_size: settings.voxel_size,
            bounds_max: relative(high),
            emission_max: scene.emission_max(),
            sky,
            sky_kind,
            sky_x,
            sky_y,
            sky_z,
            light_count: scene.lights.len() as u32,
            seed_origin: (self.table.window() * 8).as_uvec3().to_array(),
            bounce_rays: settings.bounce_rays,
            direct_samples: settings.direct_samples,
            direct_lights: settings.direct_lights,
            unreached: u32::from(self.regions.any_masked()),
            ..FrameUniform::default()
        };
        scope.frame.upload.push("frame", &[uniform]);
        scope.frame.upload.push("sky_map", scene.sky_texels());

        let total = self.table.faces();
        let sweeps = (settings.light_faces_per_frame / total.max(1)).clamp(1, SWEEPS_MAX);
        let most = settings.light_faces_per_frame;
        let room = self.memory.fit_lighting(scope, total.min(most.max(BRICK_FACES)))?;
        let bricks = self.memory.fit_light_bricks(scope, self.table.resident())?;
        let budget = LightBudget { faces: most.min(room), room, bricks, sweeps };
        let window = self.table.window();
        if self.regions.any_masked() {
            // Rays of faces are to ask.
            self.table.rouse_lighting();
        }
        let (bricks, faces) = self.table.choose_for_light(&budget, camera);
        if self.regions.any_masked() {
            let asking = bricks.iter_mut().filter(|b| self.regions.asks(window + unpack(b.position)));
            asking.for_each(|b| b.position |= ASKS);
        }
        if !bricks.is_empty() {
            let place = |l| lights::gpu_light(l, &self.grid, low_corner);
            let mut all: Vec<GpuLight> = scene.lights.iter().map(place).collect();
            let layers = shadows::gpu_layers(&scene.shadow_maps, &mut all, &self.grid, low_corner);
            let lights = Lights { all, layers };
            passes::light::light(&mut scope.frame, bricks, faces, sweeps, self.updates, &lights, settings);
            self.updates = self.updates.wrapping_add(sweeps);
        }
        let asked = settings.direct_lights.min(scene.lights.len() as u32);
        let per_face = u64::from(settings.bounce_rays + settings.direct_samples * asked);
        self.flights[scope.index].lit.extend_from_slice(self.table.lit());
        self.flights[scope.index].window = window * 8;
        self.flights[scope.index].light_rays = u64::from(faces) * u64::from(sweeps) * per_face;
        Ok(())
    }

    /// A warning when bricks begin to be left out; again only after the world has been complete.
    fn tell(&mut self, settings: &Settings) {
        let left_out = self.table.left_out();
        if left_out > 0 && !self.incomplete {
            let text = "bricks are left out, the farthest: the world does not fit into memory_budget";
            self.warnings.push(format!("{left_out} {text}, {} bytes", settings.memory_budget));
        }
        self.incomplete = left_out > 0 || self.incomplete && self.table.missing() > 0;
    }

    /// What the host should be told, since the last call.
    pub fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    /// Says what the passes' names stand for in this slot's frame, and its copies.
    pub fn bind(&mut self, index: usize, scene: &Scene, player: &mut Player) {
        self.memory.bind(index, player);
        shadows::bind(&scene.shadow_maps, player);
    }

    /// Adds names and bytes of everything that counts against the budget.
    pub fn list(&self, slots: &[Slot], sizes: &mut Vec<ResourceSize>) {
        self.memory.list(slots, sizes);
    }

    /// The GPU must have finished with it.
    pub fn destroy(&mut self, device: &Device) {
        self.memory.destroy(device);
    }
}

#[cfg(test)]
mod counts;
#[cfg(test)]
mod floor;
#[cfg(test)]
mod histories;
#[cfg(test)]
mod settling;
#[cfg(test)]
mod simplified;
