//! Plays a frame's list into a command buffer: bindings by name, barriers where accesses meet.
//!
//! Barriers are coarse: one global memory barrier where a pass touches something that was written (or writes something
//! that was read) since the last one. Passes without such a meeting overlap.

use super::pipelines::{Pipeline, descriptor_type};
use super::shaders::Shader;
use super::{Buffer, Device, Location, Pipelines, Timing};
use crate::error::{Error, Result};
use crate::frame::{Command, Frame, Groups};
use ash::vk;
use rustc_hash::FxHashMap;
use std::collections::hash_map::Entry;

/// What a name stands for in one frame.
#[derive(Clone, Copy)]
pub enum Bound {
    /// A range of a buffer.
    Buffer(vk::Buffer, u64, u64),
    /// The host's image, in the layout that the contract names.
    Image(vk::ImageView, vk::ImageLayout),
}

impl Bound {
    fn key(self) -> u64 {
        use vk::Handle;
        match self {
            Self::Buffer(buffer, ..) => buffer.as_raw(),
            Self::Image(view, _) => view.as_raw(),
        }
    }

    /// What a descriptor holds: one of the two.
    fn infos(self) -> (Option<vk::DescriptorBufferInfo>, Option<vk::DescriptorImageInfo>) {
        match self {
            Self::Buffer(buffer, offset, range) => (Some(vk::DescriptorBufferInfo { buffer, offset, range }), None),
            Self::Image(image_view, image_layout) => {
                (None, Some(vk::DescriptorImageInfo { image_view, image_layout, ..Default::default() }))
            }
        }
    }
}

/// What is copied from one buffer into another. The regions lie in both, and no two meet, of other copies of the same name
/// neither.
pub struct Copies {
    pub from: vk::Buffer,
    pub to: vk::Buffer,
    pub regions: Vec<vk::BufferCopy>,
}

/// A pass's pipeline, and its descriptors in a slot's frame.
struct PassSet {
    shader: &'static Shader,
    pipeline: vk::Pipeline,
    layout: vk::PipelineLayout,
    raw: vk::DescriptorSet,
    reads: Vec<u64>,
    writes: Vec<u64>,
    /// Whether it holds what this frame's names stand for.
    current: bool,
}

/// What one frame in flight owns.
pub struct Slot {
    pool: vk::DescriptorPool,
    /// Made when their pass is first played.
    sets: FxHashMap<&'static str, PassSet>,
    upload: Option<Buffer>,
    pub timing: Timing,
    /// Buffers that this slot's frame was the last to use.
    retired: Vec<Buffer>,
}

/// Sets a slot's pool can hold: one a pipeline.
const SETS: u32 = 64;
/// Bindings that a shader has at most.
const BINDINGS: usize = 16;

impl Slot {
    pub fn new(device: &Device) -> Result<Self> {
        let sizes = [
            (vk::DescriptorType::UNIFORM_BUFFER, 3),
            (vk::DescriptorType::STORAGE_BUFFER, 8),
            (vk::DescriptorType::SAMPLED_IMAGE, 4),
            (vk::DescriptorType::STORAGE_IMAGE, 2),
        ]
        .map(|(ty, count)| vk::DescriptorPoolSize { ty, descriptor_count: count * SETS });
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(SETS).pool_sizes(&sizes);
        let mut timing = Timing::new(device)?;
        // SAFETY: valid device.
        match unsafe { device.raw.create_descriptor_pool(&info, None) } {
            Ok(pool) => Ok(Self { pool, sets: FxHashMap::default(), upload: None, timing, retired: Vec::new() }),
            Err(result) => {
                timing.destroy(device);
                Err(Error::Vulkan { call: "vkCreateDescriptorPool", result })
            }
        }
    }

    /// Bytes of the slot's upload buffer.
    pub fn upload_bytes(&self) -> u64 {
        self.upload.as_ref().map_or(0, |b| b.size)
    }

    /// Bytes of the buffers that wait for this slot to come round.
    pub fn retired_bytes(&self) -> u64 {
        self.retired.iter().map(|b| b.size).sum()
    }

    /// Keeps a buffer until this slot comes round again.
    pub fn retire(&mut self, buffer: Buffer) {
        self.retired.push(buffer);
    }

    /// The slot's last frame is done: frees what only that frame still used.
    pub fn recycle(&mut self, device: &Device) {
        for mut buffer in self.retired.drain(..) {
            buffer.destroy(device);
        }
    }

    /// The GPU must have finished with it.
    pub fn destroy(&mut self, device: &Device) {
        self.retired.drain(..).chain(self.upload.take()).for_each(|mut b| b.destroy(device));
        self.timing.destroy(device);
        // SAFETY: made on this device, no longer in use.
        unsafe { device.raw.destroy_descriptor_pool(self.pool, None) };
    }

    fn upload(&mut self, device: &Device, bytes: &[u8], limit: u64) -> Result<vk::Buffer> {
        let size = bytes.len() as u64;
        if self.upload.as_ref().is_none_or(|b| b.size < size || b.size > 4 * size.max(16 << 10)) {
            if let Some(mut old) = self.upload.take() {
                old.destroy(device);
            }
            // Some to spare, so that the next frame's fits too.
            let size = (size + size / 8).min(limit).max(size);
            self.upload = Some(Buffer::new(device, size, Location::Upload)?);
        }
        let buffer = self.upload.as_mut().expect("just made");
        buffer.write(bytes);
        Ok(buffer.raw)
    }
}

/// Where a frame is recorded, and with what.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    pub device: &'a Device,
    pub pipelines: &'a Pipelines,
    pub commands: vk::CommandBuffer,
}

/// Records frames.
#[derive(Default)]
pub struct Player {
    /// What the passes' names stand for in the frame to be played.
    pub bound: FxHashMap<&'static str, Bound>,
    /// What its copies by name stand for.
    pub copies: FxHashMap<&'static str, Vec<Copies>>,
    written: Vec<u64>,
    read: Vec<u64>,
    /// Nothing has been recorded yet: earlier frames may have written anything.
    fresh: bool,
}

impl Player {
    /// Records the list. The slot's upload buffer takes at most `upload_limit` bytes, which must hold the frame's.
    pub fn play(&mut self, to: Target, frame: &Frame, slot: &mut Slot, upload_limit: u64) -> Result<()> {
        let upload = slot.upload(to.device, frame.upload.bytes(), upload_limit)?;
        for (name, offset, size) in frame.upload.pieces() {
            self.bound.insert(name, Bound::Buffer(upload, *offset as u64, *size as u64));
        }
        slot.sets.values_mut().for_each(|set| set.current = false);
        self.written.clear();
        self.read.clear();
        self.fresh = true;
        slot.timing.begin(to.device, to.commands);
        for command in &frame.commands {
            match command {
                Command::Clear(name) => {
                    let Bound::Buffer(buffer, offset, size) = self.resource(name)? else {
                        return Err(Error::invalid(format!("{name} is not a buffer")));
                    };
                    self.synchronise(to, &[], &[buffer_key(buffer)], None);
                    // SAFETY: recording; the range is the buffer's.
                    unsafe { to.device.raw.cmd_fill_buffer(to.commands, buffer, offset, size, 0) };
                }
                Command::Copy(name) => self.copy(to, name),
                Command::Dispatch { pass, groups, push } => {
                    self.dispatch(to, pass, groups, push.bytes(), slot)?;
                    slot.timing.mark(to.device, to.commands, pass);
                }
            }
        }
        slot.timing.end(to.device, to.commands);
        finish(to);
        self.bound.clear();
        self.copies.clear();
        Ok(())
    }

    fn resource(&self, name: &str) -> Result<Bound> {
        self.bound.get(name).copied().ok_or_else(|| Error::invalid(format!("no resource is bound to `{name}`")))
    }

    fn copy(&mut self, target: Target, name: &str) {
        let copies = self.copies.remove(name).unwrap_or_default();
        let keys = |of: fn(&Copies) -> vk::Buffer| copies.iter().map(|c| buffer_key(of(c))).collect::<Vec<_>>();
        self.synchronise(target, &keys(|c| c.from), &keys(|c| c.to), None);
        for Copies { from, to, regions } in copies {
            // SAFETY: recording; every region lies in both buffers, and no two of them meet.
            unsafe { target.device.raw.cmd_copy_buffer(target.commands, from, to, &regions) };
        }
    }

    fn dispatch(
        &mut self,
        to: Target,
        pass: &'static str,
        groups: &Groups,
        push: &[u8],
        slot: &mut Slot,
    ) -> Result<()> {
        let set = match slot.sets.entry(pass) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => entry.insert(PassSet::new(to, slot.pool, pass)?),
        };
        if !set.current {
            self.prepare(to.device, set)?;
        }
        let arguments = match groups {
            Groups::Direct(_) => None,
            Groups::Indirect(name) => Some(self.resource(name)?),
        };
        self.synchronise(to, &set.reads, &set.writes, arguments.map(Bound::key));
        let (raw, commands, point) = (&to.device.raw, to.commands, vk::PipelineBindPoint::COMPUTE);
        // SAFETY: recording; pipeline, layout and set belong together and live until the slot comes round again.
        unsafe {
            raw.cmd_bind_pipeline(commands, point, set.pipeline);
            raw.cmd_bind_descriptor_sets(commands, point, set.layout, 0, &[set.raw], &[]);
            if !push.is_empty() {
                raw.cmd_push_constants(commands, set.layout, vk::ShaderStageFlags::COMPUTE, 0, push);
            }
            match (groups, arguments) {
                (Groups::Direct([x, y, z]), _) => raw.cmd_dispatch(commands, *x, *y, *z),
                (_, Some(Bound::Buffer(buffer, offset, _))) => raw.cmd_dispatch_indirect(commands, buffer, offset),
                (name, _) => return Err(Error::invalid(format!("{name:?} is not a buffer"))),
            }
        }
        Ok(())
    }

    /// Fills a set with what the pass's names stand for.
    fn prepare(&self, device: &Device, set: &mut PassSet) -> Result<()> {
        let bindings = set.shader.bindings;
        set.reads.clear();
        set.writes.clear();
        let mut infos = [(None, None); BINDINGS];
        for (binding, infos) in bindings.iter().zip(&mut infos) {
            let resource = self.resource(binding.name)?;
            if binding.writes { &mut set.writes } else { &mut set.reads }.push(resource.key());
            *infos = resource.infos();
        }
        let mut writes = [vk::WriteDescriptorSet::default(); BINDINGS];
        for (write, (binding, (buffer, image))) in writes.iter_mut().zip(bindings.iter().zip(&infos)) {
            *write = vk::WriteDescriptorSet::default()
                .dst_set(set.raw)
                .dst_binding(binding.slot)
                .descriptor_type(descriptor_type(binding.kind));
            *write = if buffer.is_some() {
                write.buffer_info(buffer.as_slice())
            } else {
                write.image_info(image.as_slice())
            };
        }
        // SAFETY: the infos live until the call returns; the slot's last frame, which used the set, is done.
        unsafe { device.raw.update_descriptor_sets(&writes[..bindings.len()], &[]) };
        set.current = true;
        Ok(())
    }

    /// A barrier if the accesses meet earlier ones; then they are the latest.
    fn synchronise(&mut self, to: Target, reads: &[u64], writes: &[u64], arguments: Option<u64>) {
        let meets = self.fresh
            || reads.iter().chain(&arguments).any(|k| self.written.contains(k))
            || writes.iter().any(|k| self.written.contains(k) || self.read.contains(k));
        if meets {
            barrier(to);
            self.written.clear();
            self.read.clear();
            self.fresh = false;
        }
        self.read.extend(reads.iter().chain(&arguments));
        self.written.extend(writes);
    }
}

impl PassSet {
    fn new(to: Target, pool: vk::DescriptorPool, pass: &str) -> Result<Self> {
        let Pipeline { shader, raw: pipeline, layout, set_layout } = *to.pipelines.get(pass);
        assert!(shader.bindings.len() <= BINDINGS, "{pass} has too many bindings");
        let layouts = [set_layout];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
        // SAFETY: the pool is the slot's, which only this thread uses.
        let sets = unsafe { to.device.raw.allocate_descriptor_sets(&info) };
        let raw = sets.map_err(Error::vulkan("vkAllocateDescriptorSets"))?[0];
        let (reads, writes) = Default::default();
        Ok(Self { shader, pipeline, layout, raw, reads, writes, current: false })
    }
}

fn barrier(to: Target) {
    use vk::{AccessFlags as Access, PipelineStageFlags as Stage};
    let work = Stage::COMPUTE_SHADER | Stage::TRANSFER;
    let memory =
        [vk::MemoryBarrier::default().src_access_mask(Access::SHADER_WRITE | Access::TRANSFER_WRITE).dst_access_mask(
            Access::SHADER_READ
                | Access::SHADER_WRITE
                | Access::UNIFORM_READ
                | Access::TRANSFER_READ
                | Access::TRANSFER_WRITE
                | Access::INDIRECT_COMMAND_READ,
        )];
    let all = work | Stage::DRAW_INDIRECT;
    let none = vk::DependencyFlags::empty();
    // SAFETY: recording, outside a render pass.
    unsafe { to.device.raw.cmd_pipeline_barrier(to.commands, all, all, none, &memory, &[], &[]) };
}

/// Makes what was written visible to the host's reads once the frame is done.
fn finish(to: Target) {
    use vk::{AccessFlags as Access, PipelineStageFlags as Stage};
    let memory = [vk::MemoryBarrier::default()
        .src_access_mask(Access::SHADER_WRITE | Access::TRANSFER_WRITE)
        .dst_access_mask(Access::HOST_READ)];
    let none = vk::DependencyFlags::empty();
    let work = Stage::COMPUTE_SHADER | Stage::TRANSFER;
    // SAFETY: recording, outside a render pass.
    unsafe { to.device.raw.cmd_pipeline_barrier(to.commands, work, Stage::HOST, none, &memory, &[], &[]) };
}

fn buffer_key(buffer: vk::Buffer) -> u64 {
    use vk::Handle;
    buffer.as_raw()
}
