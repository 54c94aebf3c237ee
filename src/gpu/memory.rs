//! Buffers with memory of their own.

use super::Device;
use crate::error::{Error, Result};
use ash::vk;

/// Who uses a buffer's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// The GPU only.
    Device,
    /// Written by the host, read by the GPU.
    Upload,
    /// Written by the GPU, read by the host.
    Readback,
}

/// A buffer; the owner destroys it.
pub struct Buffer {
    pub raw: vk::Buffer,
    pub size: u64,
    memory: vk::DeviceMemory,
    mapped: *mut u8,
    location: Location,
}

// SAFETY: `mapped` is only reached through &self/&mut self methods, and the context is used by one thread at a time.
unsafe impl Send for Buffer {}

impl Buffer {
    /// Creates a buffer of `size` bytes (rounded up to 256, at least 256).
    pub fn new(device: &Device, size: u64, location: Location) -> Result<Self> {
        let size = size.max(1).next_multiple_of(256);
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::UNIFORM_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        // SAFETY: the device is valid for the context's life.
        let raw = unsafe { device.raw.create_buffer(&info, None) }.map_err(Error::vulkan("vkCreateBuffer"))?;
        let mut buffer = Self { raw, size, memory: vk::DeviceMemory::null(), mapped: std::ptr::null_mut(), location };
        match buffer.bind(device) {
            Ok(()) => Ok(buffer),
            Err(error) => {
                buffer.destroy(device);
                Err(error)
            }
        }
    }

    fn bind(&mut self, device: &Device) -> Result<()> {
        // SAFETY: `raw` was created on this device.
        let needs = unsafe { device.raw.get_buffer_memory_requirements(self.raw) };
        let type_index = memory_type(device, needs.memory_type_bits, self.location)
            .ok_or_else(|| Error::OutOfMemory("no memory type for a buffer".to_owned()))?;
        let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(type_index);
        // SAFETY: plain calls on objects of this device; mapping covers the whole allocation.
        unsafe {
            self.memory = device.raw.allocate_memory(&info, None).map_err(Error::vulkan("vkAllocateMemory"))?;
            device.raw.bind_buffer_memory(self.raw, self.memory, 0).map_err(Error::vulkan("vkBindBufferMemory"))?;
            if self.location != Location::Device {
                let flags = vk::MemoryMapFlags::empty();
                self.mapped = device
                    .raw
                    .map_memory(self.memory, 0, vk::WHOLE_SIZE, flags)
                    .map_err(Error::vulkan("vkMapMemory"))?
                    .cast();
            }
        }
        Ok(())
    }

    /// Copies bytes to the start of a buffer that the host sees.
    pub fn write(&mut self, bytes: &[u8]) {
        assert!(!self.mapped.is_null() && bytes.len() as u64 <= self.size, "host memory, large enough");
        // SAFETY: mapped, coherent, and as large as just checked; the GPU has finished with this slot.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), self.mapped, bytes.len()) };
    }

    /// What a readback buffer holds.
    pub fn bytes(&self) -> &[u8] {
        assert!(!self.mapped.is_null(), "a readback buffer");
        // SAFETY: mapped, coherent, and so large; the GPU has finished with this slot.
        unsafe { std::slice::from_raw_parts(self.mapped, self.size as usize) }
    }

    /// The first `count` values of a readback buffer.
    pub fn read<T: bytemuck::Pod>(&self, count: usize) -> Vec<T> {
        self.iter(count).collect()
    }

    /// The first `count` values of a readback buffer, one by one.
    pub fn iter<T: bytemuck::Pod>(&self, count: usize) -> impl Iterator<Item = T> {
        let bytes = &self.bytes()[..count * size_of::<T>()];
        bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned)
    }

    /// Frees buffer and memory; the GPU must have finished with them.
    pub fn destroy(&mut self, device: &Device) {
        // SAFETY: both were made on this device and nothing uses them any more; null handles are ignored.
        unsafe {
            device.raw.destroy_buffer(self.raw, None);
            device.raw.free_memory(self.memory, None);
        }
        self.raw = vk::Buffer::null();
        self.memory = vk::DeviceMemory::null();
    }
}

fn memory_type(device: &Device, allowed: u32, location: Location) -> Option<u32> {
    use vk::MemoryPropertyFlags as Flags;
    let coherent = Flags::HOST_VISIBLE | Flags::HOST_COHERENT;
    let wishes: &[Flags] = match location {
        Location::Device => &[Flags::DEVICE_LOCAL, Flags::empty()],
        Location::Upload => &[coherent],
        Location::Readback => &[Flags::from_raw(coherent.as_raw() | Flags::HOST_CACHED.as_raw()), coherent],
    };
    let types = device.memory.memory_types_as_slice();
    wishes.iter().find_map(|wish| {
        (0..types.len() as u32).find(|i| allowed >> i & 1 == 1 && types[*i as usize].property_flags.contains(*wish))
    })
}
