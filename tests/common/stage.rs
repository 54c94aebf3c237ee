//! An engine of the smallest kind: one flat G-buffer, frames in flight, buffers of its own, and contexts on its device.

#![allow(dead_code, reason = "each test program uses a part")]

use crate::bench::{last_error, settings, zeroed};
use crate::vulkan::Host;
use ash::vk;
use brickgi::capi::*;
use std::ffi::{CStr, c_char, c_void};
use std::ptr::null_mut;
use std::sync::Mutex;

/// Edge of the images in pixels.
pub const EDGE: u32 = 32;
/// The camera looks along -z at a wall so many metres away.
pub const WALL: f32 = 2.0;
pub const NEAR: f32 = 0.1;
/// x right, y up, looking along -z.
pub const UPRIGHT: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// Reverse depth, infinitely far, 90 degrees.
pub const REVERSE: [[f32; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, -1.0], [0.0, 0.0, NEAR, 0.0]];
/// What the wall's albedo and direct light are in the images for the composite.
pub const ALBEDO: [f32; 4] = [0.5, 0.25, 0.75, 1.0];
pub const DIRECT: [f32; 4] = [1.0, 2.0, 3.0, 1.0];
/// Places in the stage's images.
pub const OUTPUT: usize = 2;
pub const COMPOSITE: usize = 5;

struct Image {
    raw: vk::Image,
    memory: vk::DeviceMemory,
    view: vk::ImageView,
}

pub struct Stage {
    pub host: Host,
    queue: vk::Queue,
    pool: vk::CommandPool,
    slots: Vec<(vk::CommandBuffer, vk::Fence)>,
    /// Depth, normal, output; albedo, direct, composite.
    images: Vec<Image>,
    buffers: Vec<(vk::Buffer, vk::DeviceMemory)>,
    frames: usize,
}

/// A context with a view, and what it logged.
pub struct Gi {
    pub context: BgiContext,
    pub view: BgiView,
    log: Box<Mutex<Vec<String>>>,
}

unsafe extern "C" fn note(log: *mut c_void, _: BgiLogSeverity, message: *const c_char) {
    // SAFETY: the boxed mutex of a live Gi; the message ends with a zero.
    let (log, text) = unsafe { (&*log.cast::<Mutex<Vec<String>>>(), CStr::from_ptr(message)) };
    log.lock().expect("the log").push(text.to_str().expect("UTF-8").to_owned());
}

impl Gi {
    pub fn update(&self, change: impl FnOnce(&mut BgiMeshUpdate)) {
        let mut update = structure! { BgiMeshUpdate, BGI_STRUCTURE_TYPE_MESH_UPDATE, };
        change(&mut update);
        // SAFETY: as the header says.
        let result = unsafe { bgiUpdateMeshes(self.context, &update) };
        assert_eq!(result, BGI_SUCCESS, "{}", last_error(self.context));
    }

    pub fn stats(&self) -> BgiStats {
        let mut stats = structure! { BgiStats, BGI_STRUCTURE_TYPE_STATS, };
        // SAFETY: as the header says.
        assert_eq!(unsafe { bgiGetStats(self.context, &mut stats) }, BGI_SUCCESS);
        stats
    }

    /// Bytes of the device allocation of this name.
    pub fn resource(&self, name: &str) -> u64 {
        let mut resources = [zeroed::<BgiResourceSize>(); 64];
        let mut stats = structure! { BgiStats, BGI_STRUCTURE_TYPE_STATS,
            resource_count: 64, resources: resources.as_mut_ptr(),
        };
        // SAFETY: as the header says; names end with a zero.
        unsafe {
            assert_eq!(bgiGetStats(self.context, &mut stats), BGI_SUCCESS);
            let is_named = |r: &&BgiResourceSize| CStr::from_ptr(r.name.as_ptr()).to_bytes() == name.as_bytes();
            resources[..stats.resource_count as usize].iter().filter(is_named).map(|r| r.bytes).sum()
        }
    }

    /// Looks along -z at the wall with another projection, and from view space to it.
    pub fn look(&self, view: BgiView, view_rotation: [[f32; 3]; 3], projection: [[f32; 4]; 4]) {
        let camera = structure! { BgiCamera, BGI_STRUCTURE_TYPE_CAMERA,
            view_rotation: view_rotation, projection: projection,
        };
        // SAFETY: as the header says.
        assert_eq!(unsafe { bgiSetCamera(self.context, view, &camera) }, BGI_SUCCESS, "{}", last_error(self.context));
    }

    /// Another view, before the wall as the first one.
    pub fn another_view(&self) -> BgiView {
        let mut view = null_mut();
        let size = structure! { BgiViewCreateInfo, BGI_STRUCTURE_TYPE_VIEW_CREATE_INFO, width: EDGE, height: EDGE, };
        // SAFETY: as the header says.
        assert_eq!(unsafe { bgiCreateView(self.context, &size, &mut view) }, BGI_SUCCESS);
        self.look(view, UPRIGHT, REVERSE);
        view
    }

    /// What has been logged since the last call.
    pub fn log(&self) -> Vec<String> {
        std::mem::take(&mut *self.log.lock().expect("the log"))
    }

    /// Ends the context. The GPU must have finished.
    pub fn end(self) {
        // SAFETY: as the header says.
        assert_eq!(unsafe { bgiDestroyContext(self.context) }, BGI_SUCCESS);
    }
}

impl Stage {
    pub fn new(frames_in_flight: u32) -> Self {
        let host = Host::new();
        // SAFETY (this block and those below): ordinary Vulkan on this thread; every handle is used while it lives.
        let (queue, pool, slots) = unsafe {
            let device = &host.device;
            let flags = vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER;
            let info = vk::CommandPoolCreateInfo::default().queue_family_index(host.family).flags(flags);
            let pool = device.create_command_pool(&info, None).expect("a pool");
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool);
            let commands = device.allocate_command_buffers(&info.command_buffer_count(frames_in_flight));
            let info = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
            let slot = |commands| (commands, device.create_fence(&info, None).expect("a fence"));
            let slots = commands.expect("command buffers").into_iter().map(slot).collect();
            (device.get_device_queue(host.family, 0), pool, slots)
        };
        let mut stage = Self { host, queue, pool, slots, images: Vec::new(), buffers: Vec::new(), frames: 0 };
        let sampled = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let output = vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::TRANSFER_SRC;
        stage.images = vec![
            stage.image(vk::Format::R32_SFLOAT, sampled),
            stage.image(vk::Format::R32G32B32A32_SFLOAT, sampled),
            stage.image(vk::Format::R32G32B32A32_SFLOAT, output),
            stage.image(vk::Format::R32G32B32A32_SFLOAT, sampled),
            stage.image(vk::Format::R32G32B32A32_SFLOAT, sampled),
            stage.image(vk::Format::R32G32B32A32_SFLOAT, output),
        ];
        stage.frame(|stage, commands| {
            let unknown = (vk::ImageLayout::UNDEFINED, vk::AccessFlags::empty());
            let (depth, normal) = ([NEAR / WALL, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]);
            for (index, value) in [(0, depth), (1, normal), (3, ALBEDO), (4, DIRECT)] {
                stage.fill(commands, index, value, unknown);
            }
            let write = (vk::ImageLayout::GENERAL, vk::AccessFlags::SHADER_WRITE);
            [OUTPUT, COMPOSITE].into_iter().for_each(|index| stage.transition(commands, index, unknown, write));
        });
        stage
    }

    /// A context with a view and a camera before the wall.
    pub fn gi(&self, change: impl FnOnce(&mut BgiSettings)) -> Gi {
        let log = Box::new(Mutex::new(Vec::new()));
        let mut settings = settings();
        change(&mut settings);
        let info = structure! { BgiContextCreateInfo, BGI_STRUCTURE_TYPE_CONTEXT_CREATE_INFO,
            abi_version: BGI_ABI_VERSION,
            frames_in_flight: self.slots.len() as u32,
            get_instance_proc_addr: Some(self.host.entry.static_fn().get_instance_proc_addr),
            instance: self.host.instance.handle(),
            physical_device: self.host.physical_device,
            device: self.host.device.handle(),
            settings: &settings,
            log: Some(note),
            log_user_data: std::ptr::from_ref(&*log).cast_mut().cast(),
        };
        let mut gi = Gi { context: null_mut(), view: null_mut(), log };
        let size = structure! { BgiViewCreateInfo, BGI_STRUCTURE_TYPE_VIEW_CREATE_INFO, width: EDGE, height: EDGE, };
        let sky = structure! { BgiLighting, BGI_STRUCTURE_TYPE_LIGHTING, sky_radiance: [0.5, 1.0, 2.0], };
        // SAFETY: as the header says.
        unsafe {
            assert_eq!(bgiCreateContext(&info, &mut gi.context), BGI_SUCCESS, "{}", last_error(null_mut()));
            assert_eq!(bgiCreateView(gi.context, &size, &mut gi.view), BGI_SUCCESS);
            assert_eq!(bgiSetLights(gi.context, &sky), BGI_SUCCESS);
        }
        gi.look(gi.view, UPRIGHT, REVERSE);
        gi
    }

    /// Records and submits a frame; waits for the one `frames_in_flight` before it.
    pub fn frame(&mut self, record: impl FnOnce(&Self, vk::CommandBuffer)) {
        let (commands, fence) = self.slots[self.frames % self.slots.len()];
        let device = &self.host.device;
        // SAFETY: see `new`.
        unsafe {
            device.wait_for_fences(&[fence], true, u64::MAX).expect("a fence");
            device.reset_fences(&[fence]).expect("a fence");
            let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            device.begin_command_buffer(commands, &begin).expect("recording");
            record(self, commands);
            device.end_command_buffer(commands).expect("recorded");
            let commands = [commands];
            let submit = [vk::SubmitInfo::default().command_buffers(&commands)];
            device.queue_submit(self.queue, &submit, fence).expect("submitted");
        }
        self.frames += 1;
    }

    /// A frame of some contexts, one after another into the same image.
    pub fn dispatch(&mut self, contexts: &[&Gi]) {
        self.dispatch_with(contexts, |_, _| ());
    }

    /// The same, what is handed over changed; it may name the stage's images.
    pub fn dispatch_with(&mut self, contexts: &[&Gi], change: impl Fn(&Self, &mut BgiDispatchInfo)) {
        self.frame(|stage, commands| {
            for gi in contexts {
                let write = (vk::ImageLayout::GENERAL, vk::AccessFlags::SHADER_WRITE);
                [OUTPUT, COMPOSITE].into_iter().for_each(|index| stage.transition(commands, index, write, write));
                let [depth, normal, output] = [0, 1, OUTPUT].map(|index| stage.view(index));
                let mut info = structure! { BgiDispatchInfo, BGI_STRUCTURE_TYPE_DISPATCH_INFO,
                    command_buffer: commands, view: gi.view, depth: depth, normal: normal, output: output,
                    output_format: vk::Format::R32G32B32A32_SFLOAT, width: EDGE, height: EDGE,
                };
                change(stage, &mut info);
                // SAFETY: as the header says.
                let result = unsafe { bgiDispatch(gi.context, &info) };
                assert_eq!(result, BGI_SUCCESS, "{}", last_error(gi.context));
            }
        });
    }

    pub fn view(&self, index: usize) -> vk::ImageView {
        self.images[index].view
    }

    /// The bits of the output's pixels, once all frames are done.
    pub fn output(&mut self) -> Vec<u32> {
        self.pixels(OUTPUT)
    }

    /// Those of the output or the composite.
    pub fn pixels(&mut self, index: usize) -> Vec<u32> {
        let bytes = u64::from(EDGE * EDGE * 16);
        let (buffer, memory) = self.allocate(bytes, vk::BufferUsageFlags::TRANSFER_DST, true);
        self.frame(|stage, commands| {
            let write = (vk::ImageLayout::GENERAL, vk::AccessFlags::SHADER_WRITE);
            let copy = (vk::ImageLayout::TRANSFER_SRC_OPTIMAL, vk::AccessFlags::TRANSFER_READ);
            stage.transition(commands, index, write, copy);
            let layers = vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1);
            let extent = vk::Extent3D { width: EDGE, height: EDGE, depth: 1 };
            let region = [vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent)];
            // SAFETY: see `new`.
            unsafe {
                let (device, image) = (&stage.host.device, stage.images[index].raw);
                device.cmd_copy_image_to_buffer(commands, image, copy.0, buffer, &region);
            }
            stage.transition(commands, index, copy, write);
        });
        self.wait();
        self.mapped(memory, bytes as usize, |mapped| bytemuck::pod_collect_to_vec(mapped))
    }

    /// A device-local buffer that holds these bytes; it lives as long as the stage.
    pub fn buffer(&mut self, bytes: &[u8]) -> vk::Buffer {
        let size = bytes.len() as u64;
        let (staging, memory) = self.allocate(size, vk::BufferUsageFlags::TRANSFER_SRC, true);
        self.mapped(memory, bytes.len(), |mapped| mapped.copy_from_slice(bytes));
        let usage = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        let (buffer, _) = self.allocate(size, usage, false);
        self.frame(|stage, commands| {
            // SAFETY: see `new`.
            unsafe {
                let device = &stage.host.device;
                device.cmd_copy_buffer(commands, staging, buffer, &[vk::BufferCopy::default().size(size)]);
                let barrier = [vk::MemoryBarrier::default()
                    .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
                    .dst_access_mask(vk::AccessFlags::TRANSFER_READ)];
                let (transfer, none) = (vk::PipelineStageFlags::TRANSFER, vk::DependencyFlags::empty());
                device.cmd_pipeline_barrier(commands, transfer, transfer, none, &barrier, &[], &[]);
            }
        });
        buffer
    }

    /// Fills the depth image: the wall is everywhere.
    pub fn set_depth(&mut self, depth: f32) {
        self.frame(|stage, commands| {
            let read = (vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL, vk::AccessFlags::SHADER_READ);
            stage.fill(commands, 0, [depth, 0.0, 0.0, 0.0], read);
        });
    }

    /// Fills an image, known before as said, and makes it ready to be read.
    fn fill(
        &self,
        commands: vk::CommandBuffer,
        index: usize,
        float32: [f32; 4],
        before: (vk::ImageLayout, vk::AccessFlags),
    ) {
        let read = (vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL, vk::AccessFlags::SHADER_READ);
        let clear = (vk::ImageLayout::TRANSFER_DST_OPTIMAL, vk::AccessFlags::TRANSFER_WRITE);
        self.transition(commands, index, before, clear);
        let (color, image) = (vk::ClearColorValue { float32 }, self.images[index].raw);
        // SAFETY: see `new`.
        unsafe { self.host.device.cmd_clear_color_image(commands, image, clear.0, &color, &[whole()]) };
        self.transition(commands, index, clear, read);
    }

    pub fn wait(&self) {
        // SAFETY: see `new`.
        unsafe { self.host.device.device_wait_idle() }.expect("idle");
    }

    fn memory_type(&self, bits: u32, wanted: vk::MemoryPropertyFlags) -> u32 {
        // SAFETY: see `new`.
        let all = unsafe { self.host.instance.get_physical_device_memory_properties(self.host.physical_device) };
        let fits =
            |index: &u32| bits >> index & 1 == 1 && all.memory_types[*index as usize].property_flags.contains(wanted);
        (0..all.memory_type_count).find(fits).expect("a memory type")
    }

    fn allocate(&mut self, size: u64, usage: vk::BufferUsageFlags, mappable: bool) -> (vk::Buffer, vk::DeviceMemory) {
        use vk::MemoryPropertyFlags as Flags;
        let wanted = if mappable { Flags::HOST_VISIBLE | Flags::HOST_COHERENT } else { Flags::DEVICE_LOCAL };
        let device = &self.host.device;
        // SAFETY: see `new`.
        let pair = unsafe {
            let info = vk::BufferCreateInfo::default().size(size).usage(usage);
            let buffer = device.create_buffer(&info, None).expect("a buffer");
            let needs = device.get_buffer_memory_requirements(buffer);
            let info = vk::MemoryAllocateInfo::default()
                .allocation_size(needs.size)
                .memory_type_index(self.memory_type(needs.memory_type_bits, wanted));
            let memory = device.allocate_memory(&info, None).expect("memory");
            device.bind_buffer_memory(buffer, memory, 0).expect("bound");
            (buffer, memory)
        };
        self.buffers.push(pair);
        pair
    }

    fn mapped<T>(&self, memory: vk::DeviceMemory, len: usize, with: impl FnOnce(&mut [u8]) -> T) -> T {
        let device = &self.host.device;
        // SAFETY: see `new`; the memory is mappable, as large, and the GPU does not use it now.
        unsafe {
            let address = device.map_memory(memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty()).expect("mapped");
            let result = with(std::slice::from_raw_parts_mut(address.cast(), len));
            device.unmap_memory(memory);
            result
        }
    }

    fn image(&self, format: vk::Format, usage: vk::ImageUsageFlags) -> Image {
        let device = &self.host.device;
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width: EDGE, height: EDGE, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage);
        // SAFETY: see `new`.
        unsafe {
            let raw = device.create_image(&info, None).expect("an image");
            let needs = device.get_image_memory_requirements(raw);
            let memory_type = self.memory_type(needs.memory_type_bits, vk::MemoryPropertyFlags::DEVICE_LOCAL);
            let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(memory_type);
            let memory = device.allocate_memory(&info, None).expect("memory");
            device.bind_image_memory(raw, memory, 0).expect("bound");
            let info = vk::ImageViewCreateInfo::default()
                .image(raw)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(whole());
            Image { raw, memory, view: device.create_image_view(&info, None).expect("a view") }
        }
    }

    fn transition(
        &self,
        commands: vk::CommandBuffer,
        index: usize,
        (old, before): (vk::ImageLayout, vk::AccessFlags),
        (new, after): (vk::ImageLayout, vk::AccessFlags),
    ) {
        let stages = vk::PipelineStageFlags::COMPUTE_SHADER | vk::PipelineStageFlags::TRANSFER;
        let barrier = [vk::ImageMemoryBarrier::default()
            .src_access_mask(before)
            .dst_access_mask(after)
            .old_layout(old)
            .new_layout(new)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(self.images[index].raw)
            .subresource_range(whole())];
        let none = vk::DependencyFlags::empty();
        // SAFETY: see `new`.
        unsafe { self.host.device.cmd_pipeline_barrier(commands, stages, stages, none, &[], &[], &barrier) };
    }
}

fn whole() -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange::default().aspect_mask(vk::ImageAspectFlags::COLOR).level_count(1).layer_count(1)
}

impl Drop for Stage {
    fn drop(&mut self) {
        self.wait();
        let device = &self.host.device;
        // SAFETY: nothing runs any more; the contexts have been ended.
        unsafe {
            for Image { raw, memory, view } in self.images.drain(..) {
                device.destroy_image_view(view, None);
                device.destroy_image(raw, None);
                device.free_memory(memory, None);
            }
            for (buffer, memory) in self.buffers.drain(..) {
                device.destroy_buffer(buffer, None);
                device.free_memory(memory, None);
            }
            self.slots.iter().for_each(|(_, fence)| device.destroy_fence(*fence, None));
            device.destroy_command_pool(self.pool, None);
        }
        if !std::thread::panicking() {
            assert_eq!(self.host.messages(), Vec::<String>::new(), "the validation layer stays silent");
        }
    }
}
