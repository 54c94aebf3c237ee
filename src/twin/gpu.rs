//! Runs passes on a device with the validation layer on.

use super::vulkan::Host;
use crate::context::DeviceHandles;
use crate::frame::Frame;
use crate::gpu::shaders::{SHADERS, TEST_SHADERS};
use crate::gpu::{Bound, Buffer, Device, Location, Pipelines, Player, Slot, Target};
use ash::vk;
use std::collections::HashMap;

/// A device with the pipelines of some passes and buffers by name. Fails when dropped if the validation layer spoke.
pub struct Gpu {
    buffers: HashMap<&'static str, Buffer>,
    images: Vec<(vk::Image, vk::DeviceMemory, vk::ImageView)>,
    /// None while it is in use.
    slot: Option<Slot>,
    pipelines: Pipelines,
    pub device: Device,
    pool: vk::CommandPool,
    host: Host,
}

impl Gpu {
    pub fn new(passes: &[&str]) -> Self {
        let host = Host::new();
        let handles = DeviceHandles {
            get_instance_proc_addr: host.entry.static_fn().get_instance_proc_addr,
            instance: host.instance.handle(),
            physical_device: host.physical_device,
            device: host.device.handle(),
        };
        // SAFETY: the host's handles outlive the value.
        let device = unsafe { Device::new(&handles) }.expect("a device that will do");
        let shaders = SHADERS.iter().chain(TEST_SHADERS).filter(|s| passes.contains(&s.name));
        let pipelines = Pipelines::of(&device, shaders).expect("pipelines");
        let slot = Slot::new(&device).ok();
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(host.family);
        // SAFETY: the family is the device's.
        let pool = unsafe { host.device.create_command_pool(&info, None) }.expect("a command pool");
        Self { buffers: HashMap::new(), images: Vec::new(), slot, pipelines, device, pool, host }
    }

    /// Makes, or makes anew, a buffer that the passes find by this name.
    pub fn buffer(&mut self, name: &'static str, bytes: usize, location: Location) {
        let new = Buffer::new(&self.device, bytes as u64, location).expect("a buffer");
        if let Some(mut old) = self.buffers.insert(name, new) {
            old.destroy(&self.device);
        }
    }

    /// Writes to the start of a readback buffer.
    pub fn write<T: bytemuck::Pod>(&mut self, name: &str, values: &[T]) {
        self.buffers.get_mut(name).expect("a buffer").write(bytemuck::cast_slice(values));
    }

    /// What a readback buffer holds.
    pub fn read<T: bytemuck::Pod>(&self, name: &str, count: usize) -> Vec<T> {
        self.buffers[name].read(count)
    }

    /// An array of images of one float a texel, for passes to read, and a view of it; they live as long as the value.
    pub fn image(&mut self, [width, height]: [u32; 2], layers: &[Vec<f32>]) -> vk::ImageView {
        let texels = layers.concat();
        assert_eq!(texels.len(), (width * height) as usize * layers.len());
        let mut staging = Buffer::new(&self.device, 4 * texels.len() as u64, Location::Upload).expect("a buffer");
        staging.write(bytemuck::cast_slice(&texels));
        let extent = vk::Extent3D { width, height, depth: 1 };
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(vk::Format::R32_SFLOAT)
            .extent(extent)
            .mip_levels(1)
            .array_layers(layers.len() as u32)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST);
        let whole = vk::ImageSubresourceRange::default()
            .aspect_mask(vk::ImageAspectFlags::COLOR)
            .level_count(1)
            .layer_count(layers.len() as u32);
        let raw = &self.host.device;
        // SAFETY: plain calls on objects of this device, which `drop` destroys.
        let (image, memory, view) = unsafe {
            let image = raw.create_image(&info, None).expect("an image");
            let needs = raw.get_image_memory_requirements(image);
            let info = vk::MemoryAllocateInfo::default()
                .allocation_size(needs.size)
                .memory_type_index(needs.memory_type_bits.trailing_zeros());
            let memory = raw.allocate_memory(&info, None).expect("memory");
            raw.bind_image_memory(image, memory, 0).expect("bound");
            let info = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D_ARRAY)
                .format(vk::Format::R32_SFLOAT)
                .subresource_range(whole);
            (image, memory, raw.create_image_view(&info, None).expect("a view"))
        };
        self.images.push((image, memory, view));
        self.submit(|commands| {
            use vk::{AccessFlags as Access, ImageLayout as Layout, PipelineStageFlags as Stage};
            let barrier = |from: (Stage, Access, Layout), to: (Stage, Access, Layout)| {
                let barrier = vk::ImageMemoryBarrier::default()
                    .src_access_mask(from.1)
                    .dst_access_mask(to.1)
                    .old_layout(from.2)
                    .new_layout(to.2)
                    .image(image)
                    .subresource_range(whole);
                // SAFETY: recording, outside a render pass.
                unsafe {
                    let none = vk::DependencyFlags::empty();
                    raw.cmd_pipeline_barrier(commands, from.0, to.0, none, &[], &[], &[barrier]);
                }
            };
            let target = (Stage::TRANSFER, Access::TRANSFER_WRITE, Layout::TRANSFER_DST_OPTIMAL);
            barrier((Stage::TOP_OF_PIPE, Access::empty(), Layout::UNDEFINED), target);
            let layers = vk::ImageSubresourceLayers::default()
                .aspect_mask(vk::ImageAspectFlags::COLOR)
                .layer_count(whole.layer_count);
            let region = vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent);
            // SAFETY: recording; the region covers the image, and the buffer holds as much.
            unsafe { raw.cmd_copy_buffer_to_image(commands, staging.raw, image, target.2, &[region]) };
            barrier(target, (Stage::COMPUTE_SHADER, Access::SHADER_READ, Layout::SHADER_READ_ONLY_OPTIMAL));
        });
        staging.destroy(&self.device);
        view
    }

    /// Records the list, submits it and waits.
    pub fn run(&mut self, frame: &Frame) {
        let mut slot = self.slot.take().expect("a slot");
        slot.recycle(&self.device);
        let whole = |(name, b): (&&'static str, &Buffer)| (*name, Bound::Buffer(b.raw, 0, b.size));
        let mut player = Player::default();
        player.bound.extend(self.buffers.iter().map(whole));
        self.play(frame, player, &mut slot);
        self.slot = Some(slot);
    }

    /// Milliseconds of the last run's passes, where the device has timestamps.
    pub fn times(&self) -> Vec<(&'static str, f64)> {
        let mut times = Vec::new();
        let slot = self.slot.as_ref().expect("a slot");
        slot.timing.read(&self.device, |name, ms| times.push((name, ms)));
        times
    }

    /// The same with resources that the caller names.
    pub fn play(&self, frame: &Frame, mut player: Player, slot: &mut Slot) {
        self.submit(|commands| {
            let to = Target { device: &self.device, pipelines: &self.pipelines, commands };
            player.play(to, frame, slot, u64::MAX).expect("a frame that can be played");
        });
    }

    fn submit(&self, record: impl FnOnce(vk::CommandBuffer)) {
        let raw = &self.host.device;
        // SAFETY: ordinary recording and submission on this thread; the wait at the end frees everything for reuse.
        unsafe {
            raw.reset_command_pool(self.pool, vk::CommandPoolResetFlags::RELEASE_RESOURCES).expect("reset");
            let info = vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
            let commands = raw.allocate_command_buffers(&info).expect("a command buffer");
            let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            raw.begin_command_buffer(commands[0], &begin).expect("recording");
            record(commands[0]);
            raw.end_command_buffer(commands[0]).expect("recorded");
            let queue = raw.get_device_queue(self.host.family, 0);
            let submit = [vk::SubmitInfo::default().command_buffers(&commands)];
            raw.queue_submit(queue, &submit, vk::Fence::null()).expect("submitted");
            raw.queue_wait_idle(queue).expect("done");
            raw.free_command_buffers(self.pool, &commands);
        }
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        self.buffers.drain().for_each(|(_, mut b)| b.destroy(&self.device));
        self.slot.take().into_iter().for_each(|mut s| s.destroy(&self.device));
        self.pipelines.destroy(&self.device);
        // SAFETY: nothing runs any more.
        unsafe {
            for (image, memory, view) in self.images.drain(..) {
                self.host.device.destroy_image_view(view, None);
                self.host.device.destroy_image(image, None);
                self.host.device.free_memory(memory, None);
            }
            self.host.device.destroy_command_pool(self.pool, None);
        }
        let messages = self.host.messages();
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "the validation layer said:\n{}", messages.join("\n"));
        }
    }
}
