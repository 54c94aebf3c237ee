//! Plays a frame's list into a command buffer: bindings by name, barriers where accesses meet.
//!
//! Barriers are coarse: one global memory barrier where a pass touches something that was written (or writes something
//! that was read) since the last one. Passes without such a meeting overlap.

use super::pipelines::{Pipeline, descriptor_type};
use super::{Buffer, Device, Location, Pipelines, Timing};
use crate::error::{Error, Result};
use crate::frame::{Command, Frame, Groups};
use ash::vk;
use rustc_hash::{FxHashMap, FxHashSet};

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

/// What one frame in flight owns.
pub struct Slot {
    pool: vk::DescriptorPool,
    upload: Option<Buffer>,
    pub timing: Timing,
    /// Buffers that this slot's frame was the last to use.
    retired: Vec<Buffer>,
}

/// Sets a slot's pool can hold: one a pipeline.
const SETS: u32 = 64;

impl Slot {
    pub fn new(device: &Device) -> Result<Self> {
        let sizes = [
            (vk::DescriptorType::UNIFORM_BUFFER, 2),
            (vk::DescriptorType::STORAGE_BUFFER, 8),
            (vk::DescriptorType::SAMPLED_IMAGE, 4),
            (vk::DescriptorType::STORAGE_IMAGE, 2),
        ]
        .map(|(ty, count)| vk::DescriptorPoolSize { ty, descriptor_count: count * SETS });
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(SETS).pool_sizes(&sizes);
        let mut timing = Timing::new(device)?;
        // SAFETY: valid device.
        match unsafe { device.raw.create_descriptor_pool(&info, None) } {
            Ok(pool) => Ok(Self { pool, upload: None, timing, retired: Vec::new() }),
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
    pub fn recycle(&mut self, device: &Device) -> Result<()> {
        for mut buffer in self.retired.drain(..) {
            buffer.destroy(device);
        }
        // SAFETY: no set of this pool is in use any more.
        unsafe { device.raw.reset_descriptor_pool(self.pool, vk::DescriptorPoolResetFlags::empty()) }
            .map_err(Error::vulkan("vkResetDescriptorPool"))
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

/// A pass's pipeline, and what its names stand for in this frame.
struct Prepared<'a> {
    pipeline: &'a Pipeline,
    set: vk::DescriptorSet,
    reads: Vec<u64>,
    writes: Vec<u64>,
}

/// Records one frame.
pub struct Player<'a> {
    device: &'a Device,
    pipelines: &'a Pipelines,
    commands: vk::CommandBuffer,
    bound: FxHashMap<&'static str, Bound>,
    prepared: FxHashMap<&'static str, Prepared<'a>>,
    copies: FxHashMap<&'static str, Vec<Copies>>,
    written: FxHashSet<u64>,
    read: FxHashSet<u64>,
    /// Nothing has been recorded yet: earlier frames may have written anything.
    fresh: bool,
}

impl<'a> Player<'a> {
    pub fn new(
        device: &'a Device,
        pipelines: &'a Pipelines,
        commands: vk::CommandBuffer,
        bound: FxHashMap<&'static str, Bound>,
        copies: FxHashMap<&'static str, Vec<Copies>>,
    ) -> Self {
        let (prepared, written, read) = Default::default();
        Self { device, pipelines, commands, bound, prepared, copies, written, read, fresh: true }
    }

    /// Records the list. The slot's upload buffer takes at most `upload_limit` bytes, which must hold the frame's.
    pub fn play(mut self, frame: &Frame, slot: &mut Slot, upload_limit: u64) -> Result<()> {
        let upload = slot.upload(self.device, frame.upload.bytes(), upload_limit)?;
        for (name, offset, size) in frame.upload.pieces() {
            self.bound.insert(name, Bound::Buffer(upload, *offset as u64, *size as u64));
        }
        slot.timing.begin(self.device, self.commands);
        for command in &frame.commands {
            match command {
                Command::Clear(name) => {
                    let Bound::Buffer(buffer, offset, size) = self.resource(name)? else {
                        return Err(Error::invalid(format!("{name} is not a buffer")));
                    };
                    self.synchronise(&[], &[buffer_key(buffer)], None);
                    // SAFETY: recording; the range is the buffer's.
                    unsafe { self.device.raw.cmd_fill_buffer(self.commands, buffer, offset, size, 0) };
                }
                Command::Copy(name) => self.copy(name),
                Command::Dispatch { pass, groups, push } => {
                    self.dispatch(pass, groups, push, slot)?;
                    slot.timing.mark(self.device, self.commands, pass);
                }
            }
        }
        slot.timing.end(self.device, self.commands);
        self.finish();
        Ok(())
    }

    fn resource(&self, name: &str) -> Result<Bound> {
        self.bound.get(name).copied().ok_or_else(|| Error::invalid(format!("no resource is bound to `{name}`")))
    }

    fn copy(&mut self, name: &str) {
        let copies = self.copies.remove(name).unwrap_or_default();
        let keys = |of: fn(&Copies) -> vk::Buffer| copies.iter().map(|c| buffer_key(of(c))).collect::<Vec<_>>();
        self.synchronise(&keys(|c| c.from), &keys(|c| c.to), None);
        for Copies { from, to, regions } in copies {
            // SAFETY: recording; every region lies in both buffers, and no two of them meet.
            unsafe { self.device.raw.cmd_copy_buffer(self.commands, from, to, &regions) };
        }
    }

    fn dispatch(&mut self, pass: &'static str, groups: &Groups, push: &[u8], slot: &Slot) -> Result<()> {
        let prepared = match self.prepared.remove(pass) {
            Some(prepared) => prepared,
            None => self.prepare(pass, slot)?,
        };
        let arguments = match groups {
            Groups::Direct(_) => None,
            Groups::Indirect(name) => Some(self.resource(name)?),
        };
        self.synchronise(&prepared.reads, &prepared.writes, arguments.map(Bound::key));
        let Prepared { pipeline, set, .. } = prepared;
        let (raw, commands) = (&self.device.raw, self.commands);
        let point = vk::PipelineBindPoint::COMPUTE;
        // SAFETY: recording; pipeline, layout and set belong together and live until the slot comes round again.
        unsafe {
            raw.cmd_bind_pipeline(commands, point, pipeline.raw);
            raw.cmd_bind_descriptor_sets(commands, point, pipeline.layout, 0, &[set], &[]);
            if !push.is_empty() {
                raw.cmd_push_constants(commands, pipeline.layout, vk::ShaderStageFlags::COMPUTE, 0, push);
            }
            match (groups, arguments) {
                (Groups::Direct([x, y, z]), _) => raw.cmd_dispatch(commands, *x, *y, *z),
                (_, Some(Bound::Buffer(buffer, offset, _))) => raw.cmd_dispatch_indirect(commands, buffer, offset),
                (name, _) => return Err(Error::invalid(format!("{name:?} is not a buffer"))),
            }
        }
        self.prepared.insert(pass, prepared);
        Ok(())
    }

    fn prepare(&self, pass: &'static str, slot: &Slot) -> Result<Prepared<'a>> {
        let pipeline = self.pipelines.get(pass);
        let bindings = pipeline.shader.bindings;
        let resources = bindings.iter().map(|b| self.resource(b.name)).collect::<Result<Vec<_>>>()?;
        let keys = |writes| {
            let of = bindings.iter().zip(&resources).filter(move |(b, _)| b.writes == writes);
            of.map(|(_, resource)| resource.key()).collect()
        };
        let layouts = [pipeline.set_layout];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(slot.pool).set_layouts(&layouts);
        // SAFETY: the pool is this slot's, which no frame in flight uses.
        let set = unsafe { self.device.raw.allocate_descriptor_sets(&info) }
            .map_err(Error::vulkan("vkAllocateDescriptorSets"))?[0];
        let infos: Vec<_> = resources.iter().map(|resource| resource.infos()).collect();
        let writes: Vec<_> = bindings
            .iter()
            .zip(&infos)
            .map(|(binding, (buffer, image))| {
                let write = vk::WriteDescriptorSet::default()
                    .dst_set(set)
                    .dst_binding(binding.slot)
                    .descriptor_type(descriptor_type(binding.kind));
                if buffer.is_some() { write.buffer_info(buffer.as_slice()) } else { write.image_info(image.as_slice()) }
            })
            .collect();
        // SAFETY: the infos live until the call returns; the set is not in use.
        unsafe { self.device.raw.update_descriptor_sets(&writes, &[]) };
        Ok(Prepared { pipeline, set, reads: keys(false), writes: keys(true) })
    }

    /// A barrier if the accesses meet earlier ones; then they are the latest.
    fn synchronise(&mut self, reads: &[u64], writes: &[u64], arguments: Option<u64>) {
        let meets = self.fresh
            || reads.iter().chain(&arguments).any(|k| self.written.contains(k))
            || writes.iter().any(|k| self.written.contains(k) || self.read.contains(k));
        if meets {
            self.barrier();
        }
        self.read.extend(reads.iter().chain(&arguments));
        self.written.extend(writes);
    }

    fn barrier(&mut self) {
        use vk::{AccessFlags as Access, PipelineStageFlags as Stage};
        let work = Stage::COMPUTE_SHADER | Stage::TRANSFER;
        let memory = [vk::MemoryBarrier::default()
            .src_access_mask(Access::SHADER_WRITE | Access::TRANSFER_WRITE)
            .dst_access_mask(
                Access::SHADER_READ
                    | Access::SHADER_WRITE
                    | Access::UNIFORM_READ
                    | Access::TRANSFER_READ
                    | Access::TRANSFER_WRITE
                    | Access::INDIRECT_COMMAND_READ,
            )];
        let after = work | Stage::DRAW_INDIRECT;
        let none = vk::DependencyFlags::empty();
        // SAFETY: recording, outside a render pass.
        unsafe {
            self.device.raw.cmd_pipeline_barrier(
                self.commands,
                work | Stage::DRAW_INDIRECT,
                after,
                none,
                &memory,
                &[],
                &[],
            );
        }
        self.written.clear();
        self.read.clear();
        self.fresh = false;
    }

    /// Makes what was written visible to the host's reads once the frame is done.
    fn finish(&self) {
        use vk::{AccessFlags as Access, PipelineStageFlags as Stage};
        let memory = [vk::MemoryBarrier::default()
            .src_access_mask(Access::SHADER_WRITE | Access::TRANSFER_WRITE)
            .dst_access_mask(Access::HOST_READ)];
        let none = vk::DependencyFlags::empty();
        // SAFETY: recording, outside a render pass.
        unsafe {
            let raw = &self.device.raw;
            let work = Stage::COMPUTE_SHADER | Stage::TRANSFER;
            raw.cmd_pipeline_barrier(self.commands, work, Stage::HOST, none, &memory, &[], &[]);
        }
    }
}

fn buffer_key(buffer: vk::Buffer) -> u64 {
    use vk::Handle;
    buffer.as_raw()
}
