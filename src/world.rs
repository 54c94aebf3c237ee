//! The shared world on the GPU: what a frame does to it, and its memory.

use crate::bricks::{BrickTable, Finished, PrimitiveIndex, WorldGrid};
use crate::context::ResourceSize;
use crate::error::Result;
use crate::frame::{Command, Frame};
use crate::gpu::shared::{
    BATCH_BRICKS, BatchBrick, BrickResult, Frame as FrameUniform, LIGHT_DIRECTIONAL, LIGHT_POINT, Light as GpuLight,
    Material as GpuMaterial, NO_TEXTURE, PAGE_WORDS, RECORD_WORDS,
};
use crate::gpu::{Bound, Buffer, Device, Location, Slot};
use crate::passes;
use crate::scene::{Light, Scene};
use crate::settings::Settings;
use ash::vk;
use glam::{DVec3, IVec3, UVec3, Vec3};
use std::collections::{HashMap, HashSet};

/// Lighting sweeps a frame when the face budget allows: the more, the faster light travels.
const SWEEPS_MAX: u32 = 4;
/// Triangle bytes handed over in one frame at most.
const TRIANGLE_BYTES_MAX: usize = 4 << 20;
/// First size of `world_bricks` in pages.
const FIRST_PAGES: u32 = 2048;
const PAGE_BYTES: u64 = PAGE_WORDS as u64 * 4;
/// A brick with all faces of all voxels, in words.
const LARGEST_BRICK_WORDS: u32 = 1 + 8 * 4 + 512 + 3072 + 1536 + 2 * 3072 + 1536;

/// What one frame in flight will tell.
#[derive(Default)]
struct Flight {
    bricks: Vec<IVec3>,
    results: Option<Buffer>,
    counters: Option<Buffer>,
    payload: Option<Buffer>,
    /// The payload that this frame's commits read.
    source: Option<(vk::Buffer, u64)>,
    light_rays: u64,
}

/// The world's CPU and GPU state.
pub struct World {
    pub table: BrickTable,
    primitives: PrimitiveIndex,
    pub grid: WorldGrid,
    buffers: HashMap<&'static str, Buffer>,
    grown: HashMap<&'static str, (vk::Buffer, vk::Buffer, u64)>,
    flights: Vec<Flight>,
    material_index: HashMap<u64, u32>,
    /// Mean words of the bricks seen so far.
    mean_words: f32,
    updates: u32,
    idle: usize,
    /// Frames since a large part of the world, or its lights, changed.
    steady_frames: u32,
}

impl World {
    pub fn new(settings: &Settings, frames_in_flight: usize) -> Self {
        let extent = UVec3::from(settings.coverage_groups);
        Self {
            table: BrickTable::new(extent, 0),
            primitives: PrimitiveIndex::default(),
            grid: WorldGrid {
                voxel_size: f64::from(settings.voxel_size),
                offset: DVec3::from(settings.grid_offset.map(f64::from)),
            },
            buffers: HashMap::new(),
            grown: HashMap::new(),
            flights: (0..frames_in_flight).map(|_| Flight::default()).collect(),
            material_index: HashMap::new(),
            mean_words: 1024.0,
            updates: 0,
            idle: 0,
            steady_frames: 0,
        }
    }

    /// Low corner of the window in voxels.
    pub fn window_voxels(&self) -> DVec3 {
        (self.table.window() * 8).as_dvec3()
    }

    /// Re-registers changed instances and queues the bricks that they left or touch.
    pub fn instances_changed(&mut self, changed: &HashSet<u64>, scene: &Scene) {
        let mut ids: Vec<u64> = changed.iter().copied().collect();
        ids.sort_unstable();
        // Without a window yet, the first camera brings everything in.
        let Some(window) = self.table.window_bricks() else { return };
        for id in ids {
            let left = self.primitives.remove(id);
            self.table.touch(&left);
            let entered = self.primitives.insert(id, scene, &self.grid, window);
            self.table.touch(&entered);
        }
    }

    /// Follows the camera; a window that moved holds other triangles.
    fn follow(&mut self, eye: DVec3, scene: &Scene) {
        if !self.table.follow(eye) {
            return;
        }
        let window = self.table.window_bricks().expect("it has just moved");
        self.primitives.clear();
        let mut ids: Vec<u64> = scene.instances.keys().copied().collect();
        ids.sort_unstable();
        for id in ids {
            self.primitives.insert(id, scene, &self.grid, window);
        }
        self.table.enter(self.primitives.bricks());
    }

    /// Everything converges anew: the lights have changed.
    pub fn lights_changed(&mut self) {
        self.table.invalidate_lighting();
        self.steady_frames = 0;
    }

    /// Frames that a view's history may average: few while the world is changing.
    pub fn history_max(&self, settings: &Settings) -> u32 {
        settings.temporal_frames.min(self.steady_frames.max(8))
    }

    /// Rays that the slot's last frame traced.
    pub fn rays(&self, index: usize) -> u64 {
        let flight = &self.flights[index];
        let probes = flight.counters.as_ref().map_or(0, |b| u64::from(b.read::<u32>(1)[0]));
        flight.light_rays + probes
    }

    /// The world's part of a frame.
    #[expect(clippy::too_many_arguments, reason = "one call site; each is a different owner's state")]
    pub fn frame(
        &mut self,
        device: &Device,
        slot: &mut Slot,
        index: usize,
        settings: &Settings,
        scene: &mut Scene,
        eye: DVec3,
        frame_index: u32,
    ) -> Result<Frame> {
        let mut frame = Frame::default();
        self.steady_frames = self.steady_frames.saturating_add(1);
        let camera = eye / 8.0;
        self.follow(eye, scene);
        if self.flights[index].counters.is_none() {
            self.flights[index].counters = Some(Buffer::new(device, 16, Location::Readback)?);
        }
        frame.commands.push(Command::Clear("counters"));
        self.upload_materials(device, slot, scene)?;
        self.commit(device, slot, index, settings, camera, &mut frame)?;
        self.voxelize(device, slot, index, settings, scene, camera, &mut frame)?;
        self.light(device, slot, index, settings, scene, camera, frame_index, &mut frame)?;
        Ok(frame)
    }

    /// Makes sure that a buffer has room; `keep` copies what it held, when the frame is played.
    fn ensure(
        &mut self,
        device: &Device,
        slot: &mut Slot,
        name: &'static str,
        bytes: u64,
        keep: bool,
        frame: &mut Frame,
    ) -> Result<()> {
        if self.buffers.get(name).is_some_and(|b| b.size >= bytes) {
            return Ok(());
        }
        let new = Buffer::new(device, bytes, Location::Device)?;
        let raw = new.raw;
        frame.commands.push(Command::Clear(name));
        if let Some(old) = self.buffers.insert(name, new) {
            if keep {
                self.grown.insert(name, (old.raw, raw, old.size));
                frame.commands.push(Command::Grow(name));
            }
            slot.retire(old);
        }
        Ok(())
    }

    fn upload_materials(&mut self, device: &Device, slot: &mut Slot, scene: &mut Scene) -> Result<()> {
        if !scene.materials_changed && self.buffers.contains_key("materials") {
            return Ok(());
        }
        scene.materials_changed = false;
        let mut texels: Vec<u32> = Vec::new();
        let mut places = HashMap::new();
        let mut textures: Vec<_> = scene.textures.iter().collect();
        textures.sort_by_key(|t| t.0);
        for (id, texture) in textures {
            places.insert(*id, (texels.len() as u32, texture.width | texture.height << 16));
            texels.extend_from_slice(&texture.texels);
        }
        let mut ids: Vec<u64> = scene.materials.keys().copied().collect();
        ids.sort_unstable();
        self.material_index = ids.iter().enumerate().map(|(index, id)| (*id, index as u32)).collect();
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
                }
            })
            .collect();
        for (name, bytes) in
            [("materials", bytemuck::cast_slice(&materials)), ("texels", bytemuck::cast_slice::<u32, u8>(&texels))]
        {
            let mut buffer = Buffer::new(device, bytes.len() as u64, Location::Upload)?;
            buffer.write(bytes);
            if let Some(old) = self.buffers.insert(name, buffer) {
                slot.retire(old);
            }
        }
        Ok(())
    }

    /// Takes in the bricks that the slot's last frame finished.
    fn commit(
        &mut self,
        device: &Device,
        slot: &mut Slot,
        index: usize,
        settings: &Settings,
        camera: DVec3,
        frame: &mut Frame,
    ) -> Result<()> {
        let flight = &mut self.flights[index];
        let bricks = std::mem::take(&mut flight.bricks);
        flight.source = flight.payload.as_ref().map(|b| (b.raw, b.size));
        let results: Vec<BrickResult> = flight
            .results
            .as_ref()
            .map_or(Vec::new(), |b| if bricks.is_empty() { Vec::new() } else { b.read(bricks.len()) });
        let finished: Vec<Finished> =
            bricks.into_iter().zip(results).map(|(position, result)| Finished { position, result }).collect();
        if !finished.is_empty() {
            let words: u32 = finished.iter().map(|f| f.result.words).sum();
            let filled = finished.iter().filter(|f| f.result.words > 0).count().max(1);
            self.mean_words = 0.5 * self.mean_words + 0.5 * words as f32 / filled as f32;
            let pages: u32 = finished.iter().map(|f| f.result.words.div_ceil(PAGE_WORDS)).sum();
            self.grow_pages(pages, settings);
        }
        let copies = self.table.finish(&finished, camera);
        if copies.len() as u32 * 20 > self.table.resident() {
            self.steady_frames = 0;
        }
        let grid_writes = self.table.grid.take_writes();
        let bytes = u64::from(self.table.pages.capacity().max(FIRST_PAGES)) * PAGE_BYTES;
        self.ensure(device, slot, "world_bricks", bytes, true, frame)?;
        let words = u64::from(self.table.grid.words());
        self.ensure(device, slot, "world_grid", words * 4, true, frame)?;
        passes::bricks::commit(frame, &copies, &grid_writes);
        Ok(())
    }

    /// Grows the pages by doubling, within what the budget leaves.
    fn grow_pages(&mut self, needed: u32, settings: &Settings) {
        let others: u64 = self.resources().iter().filter(|r| r.name != "world_bricks").map(|r| r.bytes).sum();
        // Scratch, uploads and the grid go on growing after the pages have been given theirs.
        let reserve = settings.memory_budget / 16;
        let limit = (settings.memory_budget.saturating_sub(others + reserve) / PAGE_BYTES) as u32;
        let mut capacity = self.table.pages.capacity().max(FIRST_PAGES.min(limit));
        while capacity < limit && capacity - self.table.pages.used() < needed + needed / 8 {
            capacity = (capacity * 2).min(limit);
        }
        self.table.pages.grow(capacity);
    }

    #[expect(clippy::too_many_arguments, reason = "as `frame`")]
    fn voxelize(
        &mut self,
        device: &Device,
        slot: &mut Slot,
        index: usize,
        settings: &Settings,
        scene: &Scene,
        camera: DVec3,
        frame: &mut Frame,
    ) -> Result<()> {
        let mut batch = Vec::new();
        let mut triangles = Vec::new();
        for position in self.table.next(settings.voxelize_bricks_per_frame as usize, camera) {
            let first_triangle = triangles.len() as u32;
            self.primitives.triangles(position, scene, &self.grid, &self.material_index, &mut triangles);
            let seed = position.to_array().iter().fold(0u32, |h, v| (h ^ *v as u32).wrapping_mul(0x9e37_79b1));
            let triangle_count = triangles.len() as u32 - first_triangle;
            batch.push(BatchBrick { first_triangle, triangle_count, seed, unused: 0 });
            self.table.start(position);
            self.flights[index].bricks.push(position);
            if std::mem::size_of_val(triangles.as_slice()) > TRIANGLE_BYTES_MAX {
                break;
            }
        }
        if batch.is_empty() {
            self.release_scratch(slot, index);
            return Ok(());
        }
        self.idle = 0;
        let wide = (batch.len() as u64).min(u64::from(BATCH_BRICKS));
        self.ensure(device, slot, "voxel_args", 16, false, frame)?;
        self.ensure(device, slot, "voxel_items", wide * 4000, false, frame)?;
        self.ensure(device, slot, "voxel_states", wide * 4000, false, frame)?;
        self.ensure(device, slot, "voxel_records", wide * 512 * u64::from(RECORD_WORDS) * 4, false, frame)?;
        self.ensure(device, slot, "payload_used", 16, false, frame)?;
        let payload_words =
            ((batch.len() as f32 * self.mean_words * 1.25) as u32).clamp(2 * LARGEST_BRICK_WORDS, 1 << 22);
        let flight = &mut self.flights[index];
        let results_bytes = (batch.len() * size_of::<BrickResult>()) as u64;
        for (buffer, bytes, location) in [
            (&mut flight.results, results_bytes, Location::Readback),
            (&mut flight.payload, u64::from(payload_words) * 4, Location::Device),
        ] {
            if buffer.as_ref().is_none_or(|b| b.size < bytes)
                && let Some(old) = buffer.replace(Buffer::new(device, bytes, location)?)
            {
                slot.retire(old);
            }
        }
        frame.commands.push(Command::Clear("payload_used"));
        let emission_max = emission_max(scene);
        passes::bricks::voxelize(frame, &batch, &triangles, payload_words, emission_max, settings.hit_model);
        Ok(())
    }

    /// Gives back what only voxelisation needs, once nothing has waited for a whole round of slots.
    fn release_scratch(&mut self, slot: &mut Slot, index: usize) {
        self.idle += 1;
        if self.table.busy() || self.idle <= 2 * self.flights.len() {
            return;
        }
        for name in ["voxel_args", "voxel_items", "voxel_states", "voxel_records", "payload_used"] {
            if let Some(old) = self.buffers.remove(name) {
                slot.retire(old);
            }
        }
        let flight = &mut self.flights[index];
        flight.payload.take().into_iter().chain(flight.results.take()).for_each(|b| slot.retire(b));
    }

    #[expect(clippy::too_many_arguments, reason = "as `frame`")]
    fn light(
        &mut self,
        device: &Device,
        slot: &mut Slot,
        index: usize,
        settings: &Settings,
        scene: &Scene,
        camera: DVec3,
        frame_index: u32,
        frame: &mut Frame,
    ) -> Result<()> {
        let window = self.window_voxels();
        let lights: Vec<GpuLight> = scene.lights.iter().map(|l| self.gpu_light(l, window)).collect();
        let (low, high) = self.table.bounds().unwrap_or((self.table.window(), self.table.window()));
        let relative = |b: IVec3| ((b - self.table.window()) * 8).as_vec3().to_array();
        let extent = UVec3::from(settings.coverage_groups);
        let uniform = FrameUniform {
            extent: extent.to_array(),
            frame_index,
            torus: ((self.table.window() >> 2i32).as_uvec3() & (extent - 1)).to_array(),
            hit_model: settings.hit_model as u32,
            bounds_min: relative(low),
            voxel_size: settings.voxel_size,
            bounds_max: relative(high),
            emission_max: emission_max(scene),
            sky: scene.sky.radiance,
            light_count: lights.len() as u32,
            seed_origin: (self.table.window() * 8).as_uvec3().to_array(),
            bounce_rays: settings.bounce_rays,
            direct_samples: settings.direct_samples,
            ..FrameUniform::default()
        };
        frame.upload.push("frame", &[uniform]);
        frame.upload.push("lights", &lights);

        let total = self.table.faces();
        let sweeps = (settings.light_faces_per_frame / total.max(1)).clamp(1, SWEEPS_MAX);
        let (bricks, faces) = self.table.choose_for_light(settings.light_faces_per_frame, sweeps, frame_index, camera);
        if !bricks.is_empty() {
            let room = u64::from(total.min(settings.light_faces_per_frame).next_multiple_of(1024));
            self.ensure(device, slot, "vis_faces", room * 4, false, frame)?;
            self.ensure(device, slot, "face_irradiance", room * 8, false, frame)?;
            passes::light::light(
                frame,
                &bricks,
                faces,
                sweeps,
                self.updates,
                !lights.is_empty(),
                settings.bounce_rays > 0,
            );
            self.updates = self.updates.wrapping_add(sweeps);
        }
        let per_face = u64::from(settings.bounce_rays) + u64::from(settings.direct_samples) * lights.len() as u64;
        self.flights[index].light_rays = u64::from(faces) * u64::from(sweeps) * per_face;
        Ok(())
    }

    fn gpu_light(&self, light: &Light, window: DVec3) -> GpuLight {
        match light {
            Light::Directional { direction, irradiance } => GpuLight {
                vector: Vec3::from(*direction).normalize_or_zero().to_array(),
                kind: LIGHT_DIRECTIONAL,
                color: *irradiance,
                unused: 0,
            },
            Light::Point { position, intensity } => GpuLight {
                vector: (self.grid.to_voxels(DVec3::from(*position)) - window).as_vec3().to_array(),
                kind: LIGHT_POINT,
                color: *intensity,
                unused: 0,
            },
        }
    }

    /// What the passes' names stand for in this slot's frame.
    pub fn bindings(&self, index: usize) -> HashMap<&'static str, Bound> {
        let whole = |b: &Buffer| Bound::Buffer(b.raw, 0, b.size);
        let mut bound: HashMap<_, _> = self.buffers.iter().map(|(name, b)| (*name, whole(b))).collect();
        let flight = &self.flights[index];
        let own = [("brick_results", &flight.results), ("counters", &flight.counters), ("payload", &flight.payload)];
        bound.extend(flight.source.map(|(raw, size)| ("brick_source", Bound::Buffer(raw, 0, size))));
        bound.extend(own.into_iter().filter_map(|(name, b)| b.as_ref().map(|b| (name, whole(b)))));
        bound
    }

    /// Buffers that have grown since the last call.
    pub fn take_grown(&mut self) -> HashMap<&'static str, (vk::Buffer, vk::Buffer, u64)> {
        std::mem::take(&mut self.grown)
    }

    /// Names and bytes of the world's buffers.
    pub fn resources(&self) -> Vec<ResourceSize> {
        let mut sizes: Vec<_> = self.buffers.iter().map(|(name, b)| ResourceSize { name, bytes: b.size }).collect();
        sizes.sort_by_key(|r| r.name);
        for (name, pick) in [
            ("brick_results", (|f| &f.results) as fn(&Flight) -> &Option<Buffer>),
            ("counters", |f| &f.counters),
            ("payload", |f| &f.payload),
        ] {
            let bytes: u64 = self.flights.iter().filter_map(|f| pick(f).as_ref()).map(|b| b.size).sum();
            if bytes > 0 {
                sizes.push(ResourceSize { name, bytes });
            }
        }
        sizes
    }

    /// The GPU must have finished with it.
    pub fn destroy(&mut self, device: &Device) {
        self.buffers.drain().for_each(|(_, mut b)| b.destroy(device));
        for flight in &mut self.flights {
            for buffer in [&mut flight.results, &mut flight.counters, &mut flight.payload] {
                if let Some(mut b) = buffer.take() {
                    b.destroy(device);
                }
            }
        }
    }
}

fn emission_max(scene: &Scene) -> f32 {
    scene.materials.values().map(|m| m.emission.max_element()).fold(1e-6, f32::max)
}
