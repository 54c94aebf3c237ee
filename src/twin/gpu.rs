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
        Self { buffers: HashMap::new(), slot, pipelines, device, pool, host }
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
        let raw = &self.host.device;
        // SAFETY: ordinary recording and submission on this thread; the wait at the end frees everything for reuse.
        unsafe {
            raw.reset_command_pool(self.pool, vk::CommandPoolResetFlags::RELEASE_RESOURCES).expect("reset");
            let info = vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
            let commands = raw.allocate_command_buffers(&info).expect("a command buffer");
            let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            raw.begin_command_buffer(commands[0], &begin).expect("recording");
            let to = Target { device: &self.device, pipelines: &self.pipelines, commands: commands[0] };
            player.play(to, frame, slot, u64::MAX).expect("a frame that can be played");
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
        unsafe { self.host.device.destroy_command_pool(self.pool, None) };
        let messages = self.host.messages();
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "the validation layer said:\n{}", messages.join("\n"));
        }
    }
}
