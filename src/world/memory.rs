//! The world's buffers, and what the memory budget lets each of them have.
//!
//! Everything but the bricks has a share that follows from the settings, kept free for it whether it is used or not:
//! what voxelisation needs for a while, what lighting lists, what frames upload. The bricks have the rest. So nothing
//! that comes and goes takes from the bricks, and the bricks never keep the world from changing.
//!
//! A share is a plan. What holds the budget is [`Memory::room`]: whoever wants a buffer asks it first and, where there
//! is no room (old buffers are alive until no frame in flight uses them), makes do with what it has: fewer bricks
//! voxelised, fewer faces lit, farther bricks left out.

use super::FrameScope;
use crate::bricks::{Grid, unpack};
use crate::context::ResourceSize;
use crate::error::{Error, Result};
use crate::frame::Command;
use crate::gpu::shared::{
    APRON_COUNT, BATCH_BRICKS, BLOCK_WORDS, BrickResult, COUNTER_WORDS, LightBrick, LightChange, PAGE_WORDS,
    RECORD_WORDS, REQUESTS_WORD,
};
use crate::gpu::{Bound, Buffer, Copies, Location, Player, Slot};
use crate::settings::Settings;
use ash::vk;
use glam::IVec3;
use rustc_hash::FxHashMap;

pub const PAGE_BYTES: u64 = PAGE_WORDS as u64 * 4;
/// A brick with all faces of all voxels, all different, emissive.
const LARGEST_BRICK_BYTES: u64 = 4 * (1 + 8 * BLOCK_WORDS as u64 + 512 + 2 * 3072 + 2 * 3072);
/// Of `voxel_records`, a brick.
const RECORD_BYTES: u64 = 512 * RECORD_WORDS as u64 * 4;
/// Of `voxel_items` or `voxel_states`, a brick.
const APRON_BYTES: u64 = APRON_COUNT as u64 * 4;
const SCRATCH_BYTES: u64 = RECORD_BYTES + 2 * APRON_BYTES;
/// Of `vis_faces` and of `face_irradiance`, a face.
const FACE_BYTES: [u64; 2] = [4, 8];
/// A frame's payload at least: any brick fits into it.
const PAYLOAD_MIN: u64 = LARGEST_BRICK_BYTES.next_multiple_of(256);
/// What a frame may always upload of triangles.
const TRIANGLES_MIN: u64 = 8 << 10;
/// Faces by which the lists of lighting grow at least.
const FACES_STEP: u32 = 1024;
/// Faces that a brick has at most.
pub const BRICK_FACES: u32 = 6 * 512;
/// What a brick costs each frame's upload buffer: its part of the changes to the grid. (The list of the bricks to be lit
/// makes do with what is free.)
const UPLOAD_BRICK_BYTES: u64 = 8;
/// What a frame uploads whatever the world: uniforms, small lists, alignment.
const UPLOAD_BASE_BYTES: u64 = 4 << 10;
/// What a view adds to a frame's upload after the world's part.
const UPLOAD_VIEW_BYTES: u64 = 1 << 10;
/// Most that is set aside for voxelisation, however large the budget.
const VOXELIZATION_MAX: u64 = 8 << 20;
/// What a frame may always copy out of the host's buffers.
const READBACK_MIN: u64 = 1 << 10;
/// Most that it may copy beyond its share.
const READBACK_SPARE_MAX: u64 = 4 << 20;
/// Most that a frame's payload and triangles may take beyond their share of what the bricks will not need.
const FRAME_SPARE_MAX: u64 = 8 << 20;

/// Of `counters`.
const COUNTER_BYTES: u64 = COUNTER_WORDS as u64 * 4;
/// Of `light_changes`, a brick; and bricks by which it grows at least.
const CHANGE_BYTES: u64 = size_of::<LightChange>() as u64;
const CHANGES_STEP: u64 = 256;

/// Part of a frame's share that its results may take.
const RESULTS_PART: u64 = 16;

/// How the budget is divided. Bytes, unless said otherwise.
struct Shares {
    budget: u64,
    frames_in_flight: u64,
    /// All that voxelisation needs for a while.
    voxelization: u64,
    /// Bricks voxelised side by side.
    batch: u32,
    /// Of it, what all frames copy out of the host's buffers.
    readback: u64,
    /// Of it, one frame's payload and triangles.
    frame: u64,
    /// Faces that lighting lists at most.
    light_faces: u32,
}

impl Shares {
    fn new(settings: &Settings, frames_in_flight: usize) -> Self {
        let (budget, frames) = (settings.memory_budget, frames_in_flight as u64);
        // A brick at a time must always be possible, and reading a mesh, however slowly.
        let frames_min = frames * (PAYLOAD_MIN + TRIANGLES_MIN);
        let least = SCRATCH_BYTES + frames_min + frames * READBACK_MIN;
        let voxelization = (budget / 16).min(VOXELIZATION_MAX).max(least);
        let readback = frames * READBACK_MIN + (voxelization - least) / 16;
        let side_by_side = (voxelization / 3).min(voxelization - frames_min - readback) / SCRATCH_BYTES;
        let batch = side_by_side.clamp(1, u64::from(BATCH_BRICKS));
        let faces = u32::try_from(budget / 8 / FACE_BYTES.iter().sum::<u64>()).unwrap_or(u32::MAX);
        let light_faces =
            settings.light_faces_per_frame.max(BRICK_FACES).next_multiple_of(FACES_STEP).min(faces & !(FACES_STEP - 1));
        Self {
            budget,
            frames_in_flight: frames,
            voxelization,
            batch: batch as u32,
            readback,
            frame: (voxelization - readback - batch * SCRATCH_BYTES) / frames,
            light_faces,
        }
    }

    fn lighting(&self) -> u64 {
        FACE_BYTES.iter().map(|bytes| bytes * u64::from(self.light_faces)).sum()
    }

    fn uploads(&self, lights: u64) -> u64 {
        self.frames_in_flight * (UPLOAD_BASE_BYTES + lights)
    }

    /// What bricks of this mean size may take if the fixed parts take so much.
    fn bricks(&self, fixed: &Fixed, mean_brick: u64) -> u64 {
        let others = fixed.grid
            + fixed.materials
            + self.lighting()
            + self.voxelization
            + self.uploads(fixed.lights)
            + self.frames_in_flight * (COUNTER_BYTES + CHANGES_STEP * CHANGE_BYTES);
        let left = self.budget.saturating_sub(others);
        let mean = mean_brick.max(PAGE_BYTES);
        left * mean / (mean + self.frames_in_flight * UPLOAD_BRICK_BYTES)
    }
}

/// What the scene takes and nobody can refuse. Bytes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fixed {
    pub grid: u64,
    pub materials: u64,
    /// Of a frame's upload: lights, shadow maps' layers, and the sky's map.
    pub lights: u64,
}

/// What one frame in flight has to itself.
#[derive(Default)]
struct FrameBuffers {
    results: Option<Buffer>,
    counters: Option<Buffer>,
    /// What lighting has found of each brick.
    changes: Option<Buffer>,
    payload: Option<Buffer>,
    /// What the frame copies out of the host's buffers.
    readback: Option<Buffer>,
    /// The payload that this frame's commits read.
    source: Option<(vk::Buffer, u64)>,
}

/// What a frame may voxelise with.
#[derive(Clone, Copy, Debug)]
pub struct Scratch {
    /// Bricks in all.
    pub bricks: usize,
    /// Bricks side by side.
    pub batch: u32,
    pub payload_words: u32,
    /// Bytes that their triangles may upload: a single brick's.
    pub upload: u64,
    /// Several bricks'.
    pub share: u64,
}

/// What `world_bricks` may be. Pages.
#[derive(Clone, Copy, Debug)]
pub struct BricksLimit {
    /// In the long run.
    pub steady: u32,
    /// Of a new buffer, as long as the old one is alive beside it.
    pub beside: u32,
    /// Buffers that frames in flight still use keep `beside` small for the moment.
    pub momentary: bool,
}

/// The world's buffers.
pub struct Memory {
    shares: Shares,
    buffers: FxHashMap<&'static str, Buffer>,
    frames: Vec<FrameBuffers>,
    /// What the frame's copies by name stand for.
    copies: FxHashMap<&'static str, Vec<Copies>>,
}

impl Memory {
    /// Refuses a budget that could not hold a single brick.
    pub fn new(settings: &Settings, frames_in_flight: usize, grid_bytes: u64) -> Result<Self> {
        let memory = Self {
            shares: Shares::new(settings, frames_in_flight),
            buffers: FxHashMap::default(),
            frames: (0..frames_in_flight).map(|_| FrameBuffers::default()).collect(),
            copies: FxHashMap::default(),
        };
        memory.check(&Fixed { grid: grid_bytes, ..Fixed::default() })?;
        Ok(memory)
    }

    /// Whether the fixed parts leave room for a brick.
    pub fn check(&self, fixed: &Fixed) -> Result<()> {
        let (left, needed) = (self.shares.bricks(fixed, LARGEST_BRICK_BYTES), LARGEST_BRICK_BYTES);
        if left >= needed {
            return Ok(());
        }
        let Fixed { grid, materials, .. } = fixed;
        Err(Error::OutOfMemory(format!(
            "memory_budget, {} bytes, has no room for bricks: the grid of coverage_groups takes {grid}, materials and \
             textures {materials}, and frames_in_flight, light_faces_per_frame and lights the most of the rest",
            self.shares.budget
        )))
    }

    fn size(&self, name: &str) -> u64 {
        self.buffers.get(name).map_or(0, |b| b.size)
    }

    fn voxelization_bytes(&self) -> u64 {
        let scratch: u64 = VOXEL_BUFFERS.iter().map(|name| self.size(name)).sum();
        let own = self.frames.iter().flat_map(|f| [&f.results, &f.payload, &f.readback]).flatten();
        scratch + own.map(|b| b.size).sum::<u64>()
    }

    /// Bytes of every live buffer but those of the slots.
    fn live(&self) -> u64 {
        let own = self.frames.iter();
        let own = own.flat_map(|f| [&f.results, &f.payload, &f.readback, &f.counters, &f.changes]).flatten();
        self.buffers.values().chain(own).map(|b| b.size).sum()
    }

    /// Bytes that this frame's upload buffer may have. What the other frames cannot do without is theirs.
    pub fn upload_limit(&self, scope: &FrameScope) -> u64 {
        let others = scope.slots.iter().enumerate().filter(|(i, _)| *i != scope.index);
        let others = others.map(|(_, s)| s.upload_bytes().max(scope.upload_least));
        let taken = self.live() + retired_bytes(scope.slots) + others.sum::<u64>();
        self.shares.budget.saturating_sub(taken)
    }

    /// Makes room for what lighting finds of up to `bricks` bricks; how many it may list.
    pub fn fit_light_bricks(&mut self, scope: &mut FrameScope, bricks: u32) -> Result<usize> {
        let have = self.frames[scope.index].changes.as_ref().map_or(0, |b| b.size);
        let wanted = u64::from(bricks).next_multiple_of(CHANGES_STEP) * CHANGE_BYTES;
        let wanted = [wanted, CHANGES_STEP * CHANGE_BYTES];
        if let Some(bytes) = wanted.into_iter().find(|bytes| *bytes > have && *bytes <= self.room(scope)) {
            let changes = Buffer::new(scope.device, bytes, Location::Readback)?;
            if let Some(old) = self.frames[scope.index].changes.replace(changes) {
                scope.slot().retire(old);
            }
        }
        let changes = self.frames[scope.index].changes.as_ref().map_or(0, |b| b.size / CHANGE_BYTES);
        let taken = scope.frame.upload.bytes().len() as u64 + UPLOAD_VIEW_BYTES;
        let listed = self.upload_limit(scope).saturating_sub(taken) / size_of::<LightBrick>() as u64;
        Ok(listed.min(changes) as usize)
    }

    /// What the lighting of the slot's last frame found of the first bricks, as [`crate::bricks::BrickTable::note_light`]
    /// takes it.
    pub fn light_changes(&self, index: usize, count: usize) -> Vec<LightChange> {
        let changes = self.frames[index].changes.as_ref().filter(|_| count > 0);
        changes.map_or(Vec::new(), |b| b.read(count))
    }

    /// Bytes that a new buffer may have now.
    pub fn room(&self, scope: &FrameScope) -> u64 {
        let upload = (scope.frame.upload.bytes().len() as u64 + scope.upload_reserve)
            .max(scope.slots[scope.index].upload_bytes());
        self.upload_limit(scope).saturating_sub(upload)
    }

    /// What no frame's upload can do without.
    pub fn upload_least(lights: u64) -> u64 {
        UPLOAD_BASE_BYTES + lights
    }

    /// What is to be kept free for the small parts of a frame's upload.
    pub fn upload_reserve(bricks: u32, lights: u64) -> u64 {
        Self::upload_least(lights) + u64::from(bricks) * size_of::<LightBrick>() as u64
    }

    /// The frame's upload must fit: the limit of its buffer.
    pub fn finish(&self, scope: &FrameScope) -> Result<u64> {
        let (limit, needed) = (self.upload_limit(scope), scope.frame.upload.bytes().len() as u64 + UPLOAD_VIEW_BYTES);
        if needed > limit {
            let text = format!("a frame's upload of {needed} bytes does not fit into memory_budget, {limit} are left");
            return Err(Error::OutOfMemory(text));
        }
        Ok(limit)
    }

    /// Makes a buffer, empty, or with those regions of the one before that are to be kept.
    fn replace(
        &mut self,
        scope: &mut FrameScope,
        name: &'static str,
        bytes: u64,
        kept: Vec<vk::BufferCopy>,
    ) -> Result<()> {
        let new = Buffer::new(scope.device, bytes, Location::Device)?;
        let raw = new.raw;
        scope.frame.commands.push(Command::Clear(name));
        if let Some(old) = self.buffers.insert(name, new) {
            if !kept.is_empty() {
                self.copies.insert(name, vec![Copies { from: old.raw, to: raw, regions: kept }]);
                scope.frame.commands.push(Command::Copy(name));
            }
            scope.slot().retire(old);
        }
        Ok(())
    }

    /// Makes `world_bricks` hold so many pages; `kept`: first page before, first page now, pages.
    pub fn replace_bricks(&mut self, scope: &mut FrameScope, pages: u32, kept: &[[u32; 3]]) -> Result<()> {
        let region = |[from, to, pages]: &[u32; 3]| {
            let [src_offset, dst_offset, size] = [*from, *to, *pages].map(|p| u64::from(p) * PAGE_BYTES);
            vk::BufferCopy { src_offset, dst_offset, size }
        };
        self.replace(scope, "world_bricks", u64::from(pages) * PAGE_BYTES, kept.iter().map(region).collect())
    }

    /// Makes `world_grid` as large as the host's image of it; there must be room.
    pub fn fit_grid(&mut self, scope: &mut FrameScope, grid: &Grid) -> Result<()> {
        let (before, bytes) = (self.size("world_grid"), u64::from(grid.words()) * 4);
        if before >= bytes {
            return Ok(());
        }
        let whole = vk::BufferCopy { src_offset: 0, dst_offset: 0, size: before };
        self.replace(scope, "world_grid", bytes, if before > 0 { vec![whole] } else { Vec::new() })
    }

    /// Makes the counters of this frame, if they are missing.
    pub fn fit_counters(&mut self, scope: &FrameScope) -> Result<()> {
        let counters = &mut self.frames[scope.index].counters;
        if counters.is_none() {
            *counters = Some(Buffer::new(scope.device, COUNTER_BYTES, Location::Readback)?);
        }
        Ok(())
    }

    /// Replaces materials and texels. False where old and new do not fit beside each other now.
    pub fn replace_materials(&mut self, scope: &mut FrameScope, materials: &[u8], texels: &[u8]) -> Result<bool> {
        // Buffers come in units of 256 bytes.
        if (materials.len() + texels.len()) as u64 + 512 > self.room(scope) {
            return Ok(false);
        }
        for (name, bytes) in [("materials", materials), ("texels", texels)] {
            let mut buffer = Buffer::new(scope.device, bytes.len() as u64, Location::Upload)?;
            buffer.write(bytes);
            if let Some(old) = self.buffers.insert(name, buffer) {
                scope.slot().retire(old);
            }
        }
        Ok(true)
    }

    pub fn has_materials(&self) -> bool {
        self.buffers.contains_key("materials")
    }

    /// Bytes of materials and texels at present.
    pub fn materials_bytes(&self) -> u64 {
        self.size("materials") + self.size("texels")
    }

    /// What `world_bricks` may be, with bricks of this mean size, so many of them resident.
    pub fn bricks_limit(&self, scope: &FrameScope, fixed: &Fixed, mean_brick: u64, resident: u32) -> BricksLimit {
        let shares = &self.shares;
        let steady = shares.bricks(fixed, mean_brick);
        let uploads: u64 = scope.slots.iter().map(Slot::upload_bytes).sum();
        let lists = LIGHT_BUFFERS.iter().map(|name| self.size(name)).sum::<u64>();
        let uploads_share =
            shares.uploads(fixed.lights) + u64::from(resident) * shares.frames_in_flight * UPLOAD_BRICK_BYTES;
        // What takes more than its share does so for a while.
        let excess = lists.saturating_sub(shares.lighting())
            + (self.voxelization_bytes() + uploads).saturating_sub(shares.voxelization + uploads_share);
        let retired = retired_bytes(scope.slots);
        let beside = steady.saturating_sub(self.size("world_bricks") + excess + retired).min(self.room(scope));
        let pages = |bytes: u64| u32::try_from(bytes / PAGE_BYTES).unwrap_or(u32::MAX / PAGE_WORDS);
        let momentary = excess + retired > steady / 64;
        BricksLimit { steady: pages(steady), beside: pages(beside), momentary }
    }

    /// Pages by which `world_bricks` may be too large without harm: voxelisation makes do with less than its share.
    pub fn tolerance(&self) -> u32 {
        ((self.shares.voxelization / 4) / PAGE_BYTES) as u32
    }

    /// Makes room to voxelise up to `bricks` bricks, each of which takes about `brick` bytes when it is done and uploads
    /// about `upload` bytes of triangles; `spare` bytes of the budget will not be needed by bricks. None where there is
    /// no room now.
    pub fn scratch(
        &mut self,
        scope: &mut FrameScope,
        bricks: u32,
        [brick, upload]: [u64; 2],
        spare: u64,
    ) -> Result<Option<Scratch>> {
        let frame = self.shares.frame + (spare / 4 * 3 / self.shares.frames_in_flight).min(FRAME_SPARE_MAX);
        let bricks = bricks.min((frame / RESULTS_PART / size_of::<BrickResult>() as u64) as u32);
        let results = u64::from(bricks) * size_of::<BrickResult>() as u64;
        let have = self.frames[scope.index].results.as_ref().map_or(0, |b| b.size);
        if have < results && results.next_multiple_of(256) <= self.room(scope) {
            let results = Buffer::new(scope.device, results, Location::Readback)?;
            if let Some(old) = self.frames[scope.index].results.replace(results) {
                scope.slot().retire(old);
            }
        }
        let results = self.frames[scope.index].results.as_ref().map_or(0, |b| b.size);
        let bricks = bricks.min((results / size_of::<BrickResult>() as u64) as u32);

        let have = (self.size("voxel_records") / RECORD_BYTES) as u32;
        let wanted = bricks.next_power_of_two().min(self.shares.batch);
        let least = if have == 0 { 1 } else { wanted };
        // Buffers come in units of 256 bytes.
        let fits = |n: &u32| u64::from(*n) * SCRATCH_BYTES + 5 * 256 <= self.room(scope);
        let new = if have < wanted { [wanted, least].into_iter().find(fits) } else { None };
        if let Some(new) = new.map(u64::from) {
            let sizes = [16, 16, new * APRON_BYTES, new * APRON_BYTES, new * RECORD_BYTES];
            for (name, bytes) in VOXEL_BUFFERS.into_iter().zip(sizes) {
                self.replace(scope, name, bytes, Vec::new())?;
            }
        }
        let batch = new.unwrap_or(have);

        let bytes = brick * u64::from(bricks).min(frame / (brick + upload).max(1));
        let wanted = bytes.clamp(PAYLOAD_MIN, frame - TRIANGLES_MIN).next_multiple_of(256);
        let have = self.frames[scope.index].payload.as_ref().map_or(0, |b| b.size);
        // A little less than wanted will do; far too much is taken from the triangles, or from other frames.
        let new = if have + have / 2 < wanted || have > frame.min(4 * wanted) {
            let sizes = [wanted, if have == 0 { PAYLOAD_MIN } else { wanted }];
            sizes.into_iter().find(|bytes| *bytes <= self.room(scope))
        } else {
            None
        };
        if let Some(bytes) = new {
            let payload = Buffer::new(scope.device, bytes, Location::Device)?;
            if let Some(old) = self.frames[scope.index].payload.replace(payload) {
                scope.slot().retire(old);
            }
        }
        let payload = new.unwrap_or(have);
        let payload_words = (payload / 4) as u32;
        if bricks == 0 || batch == 0 || payload_words == 0 {
            return Ok(None);
        }
        let taken = scope.frame.upload.bytes().len() as u64 + scope.upload_reserve;
        let upload = self.upload_limit(scope).saturating_sub(taken);
        let share = frame.saturating_sub(payload).max(TRIANGLES_MIN).min(upload);
        Ok(Some(Scratch { bricks: bricks as usize, batch, payload_words, upload, share }))
    }

    /// Whether bytes are taken that will be free as soon as no frame in flight uses them any more.
    pub fn is_momentary(&self, scope: &FrameScope) -> bool {
        retired_bytes(scope.slots) > 0
    }

    /// Gives back what only voxelisation needs. Whether there was anything.
    pub fn release_scratch(&mut self, scope: &mut FrameScope) -> bool {
        let own = &mut self.frames[scope.index];
        let shared = VOXEL_BUFFERS.iter().filter_map(|name| self.buffers.remove(name));
        let buffers: Vec<Buffer> = shared.chain(own.payload.take()).chain(own.results.take()).collect();
        let any = !buffers.is_empty();
        buffers.into_iter().for_each(|b| scope.slot().retire(b));
        any
    }

    /// Bytes that this frame may copy out of the host's buffers; `spare` bytes of the budget will not be needed by bricks.
    pub fn readback_room(&self, scope: &FrameScope, spare: u64) -> u64 {
        let have = self.frames[scope.index].readback.as_ref().map_or(0, |b| b.size);
        let frames = self.shares.frames_in_flight;
        let share = self.shares.readback / frames + (spare / 4 / frames).min(READBACK_SPARE_MAX);
        // Buffers come in units of 256 bytes.
        let most = share.min(self.room(scope) + have) & !255;
        // One that is about as large need not be made anew.
        if (most / 2..=2 * most).contains(&have) { have } else { most }
    }

    /// Has the frame make copies into the first `bytes` bytes of the slot's buffer, which has `room` as just said.
    pub fn read_back(
        &mut self,
        scope: &mut FrameScope,
        [bytes, room]: [u64; 2],
        regions: &[(vk::Buffer, vk::BufferCopy)],
    ) -> Result<()> {
        let have = self.frames[scope.index].readback.as_ref().map_or(0, |b| b.size);
        if !(bytes..=2 * room).contains(&have) {
            self.release_readback(scope);
            self.frames[scope.index].readback = Some(Buffer::new(scope.device, bytes, Location::Readback)?);
        }
        let to = self.frames[scope.index].readback.as_ref().expect("just made").raw;
        let mut copies: Vec<Copies> = Vec::new();
        for (from, region) in regions {
            // Meshes often share buffers, one for each kind of array.
            match copies.iter_mut().rev().take(3).find(|c| c.from == *from) {
                Some(copies) => copies.regions.push(*region),
                None => copies.push(Copies { from: *from, to, regions: vec![*region] }),
            }
        }
        self.copies.insert("readback", copies);
        scope.frame.commands.push(Command::Copy("readback"));
        Ok(())
    }

    /// What the slot's last frame copied out of the host's buffers.
    pub fn readback(&self, index: usize) -> &[u8] {
        self.frames[index].readback.as_ref().map_or(&[], Buffer::bytes)
    }

    /// Gives the slot's buffer back: no other frame uses it.
    pub fn release_readback(&mut self, scope: &FrameScope) {
        self.frames[scope.index].readback.take().into_iter().for_each(|mut b| b.destroy(scope.device));
    }

    /// Makes room to light `faces` faces; how many there is room for now.
    pub fn fit_lighting(&mut self, scope: &mut FrameScope, faces: u32) -> Result<u32> {
        let have = (self.size("vis_faces") / FACE_BYTES[0]) as u32;
        let wanted = faces.next_multiple_of(FACES_STEP).min(self.shares.light_faces);
        if have >= wanted {
            return Ok(have);
        }
        let bytes = |faces: u32| FACE_BYTES.map(|bytes| bytes * u64::from(faces));
        let ample = (have + have / 2).next_multiple_of(FACES_STEP).clamp(wanted, self.shares.light_faces);
        let fits = |faces: &u32| bytes(*faces).iter().sum::<u64>() <= self.room(scope);
        let Some(faces) = [ample, wanted].into_iter().find(fits) else { return Ok(have) };
        for (name, bytes) in LIGHT_BUFFERS.into_iter().zip(bytes(faces)) {
            self.replace(scope, name, bytes, Vec::new())?;
        }
        Ok(faces)
    }

    /// The results of the first bricks of the slot's last frame.
    pub fn results(&self, index: usize, count: usize) -> Vec<BrickResult> {
        let results = self.frames[index].results.as_ref().filter(|_| count > 0);
        results.map_or(Vec::new(), |b| b.read(count))
    }

    /// This frame's commits read the slot's payload as it is now.
    pub fn take_payload(&mut self, index: usize) {
        let frame = &mut self.frames[index];
        frame.source = frame.payload.as_ref().map(|b| (b.raw, b.size));
    }

    /// Probes of the slot's last frame that looked, came to a tile, met another one there, and were given up.
    pub fn probe_counts(&self, index: usize) -> [u32; 4] {
        let words = self.frames[index].counters.as_ref().map_or(Vec::new(), |b| b.read::<u32>(4));
        words.try_into().unwrap_or_default()
    }

    /// Cells (window, even) that rays of the slot's last frame asked light for, and how many did.
    pub fn requests(&self, index: usize) -> Vec<(IVec3, u32)> {
        let words = self.frames[index].counters.as_ref().map_or(Vec::new(), |b| b.read::<u32>(COUNTER_WORDS as usize));
        let places = words.chunks(2).skip(REQUESTS_WORD as usize / 2).filter(|place| place[0] > 0);
        places.map(|place| (unpack(place[1]) * 2, place[0])).collect()
    }

    /// Says what the passes' names stand for in this slot's frame.
    pub fn bind(&mut self, index: usize, player: &mut Player) {
        let whole = |b: &Buffer| Bound::Buffer(b.raw, 0, b.size);
        let frame = &self.frames[index];
        let own = [
            ("brick_results", &frame.results),
            ("counters", &frame.counters),
            ("light_changes", &frame.changes),
            ("payload", &frame.payload),
        ];
        player.bound.extend(self.buffers.iter().map(|(name, b)| (*name, whole(b))));
        player.bound.extend(frame.source.map(|(raw, size)| ("brick_source", Bound::Buffer(raw, 0, size))));
        player.bound.extend(own.into_iter().filter_map(|(name, b)| b.as_ref().map(|b| (name, whole(b)))));
        player.copies.extend(self.copies.drain());
    }

    /// Adds names and bytes of everything that counts against the budget.
    pub fn list(&self, slots: &[Slot], sizes: &mut Vec<ResourceSize>) {
        sizes.extend(self.buffers.iter().map(|(name, b)| ResourceSize { name, bytes: b.size }));
        sizes.sort_unstable_by_key(|r| r.name);
        let total = |pick: fn(&FrameBuffers) -> &Option<Buffer>| {
            self.frames.iter().filter_map(|f| pick(f).as_ref()).map(|b| b.size).sum::<u64>()
        };
        let others = [
            ("brick_results", total(|f| &f.results)),
            ("counters", total(|f| &f.counters)),
            ("light_changes", total(|f| &f.changes)),
            ("payload", total(|f| &f.payload)),
            ("readback", total(|f| &f.readback)),
            ("upload", slots.iter().map(Slot::upload_bytes).sum()),
            ("retired", retired_bytes(slots)),
        ];
        sizes.extend(others.into_iter().filter(|o| o.1 > 0).map(|(name, bytes)| ResourceSize { name, bytes }));
    }

    /// The GPU must have finished with it.
    pub fn destroy(&mut self, device: &crate::gpu::Device) {
        self.buffers.drain().for_each(|(_, mut b)| b.destroy(device));
        for frame in &mut self.frames {
            let FrameBuffers { results, counters, changes, payload, readback, .. } = std::mem::take(frame);
            [results, counters, changes, payload, readback].into_iter().flatten().for_each(|mut b| b.destroy(device));
        }
    }
}

const VOXEL_BUFFERS: [&str; 5] = ["voxel_args", "payload_used", "voxel_items", "voxel_states", "voxel_records"];
const LIGHT_BUFFERS: [&str; 2] = ["vis_faces", "face_irradiance"];

fn retired_bytes(slots: &[Slot]) -> u64 {
    slots.iter().map(Slot::retired_bytes).sum()
}
