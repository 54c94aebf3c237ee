//! GPU times by timestamps, read without waiting.

use super::{Buffer, Device, Location};
use crate::error::{Error, Result};
use ash::vk;

const QUERIES: u32 = 512;

/// One frame slot's timestamps.
pub struct Timing {
    pool: vk::QueryPool,
    /// Where the GPU copies the ticks: reading them never waits.
    ticks: Option<Buffer>,
    marks: Vec<&'static str>,
    recorded: bool,
}

impl Timing {
    /// A pool, or none where the device has no timestamps.
    pub fn new(device: &Device) -> Result<Self> {
        let mut timing = Self { pool: vk::QueryPool::null(), ticks: None, marks: Vec::new(), recorded: false };
        if device.timestamp_bits > 0 {
            let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(QUERIES);
            timing.ticks = Some(Buffer::new(device, u64::from(QUERIES) * 8, Location::Readback)?);
            // SAFETY: valid device.
            match unsafe { device.raw.create_query_pool(&info, None) } {
                Ok(pool) => timing.pool = pool,
                Err(result) => {
                    timing.destroy(device);
                    return Err(Error::Vulkan { call: "vkCreateQueryPool", result });
                }
            }
        }
        Ok(timing)
    }

    /// Starts a frame.
    pub fn begin(&mut self, device: &Device, commands: vk::CommandBuffer) {
        self.marks.clear();
        self.recorded = self.pool != vk::QueryPool::null();
        if self.recorded {
            // SAFETY: the slot's last frame is done; the command buffer is recording.
            unsafe { device.raw.cmd_reset_query_pool(commands, self.pool, 0, QUERIES) };
        }
        self.mark(device, commands, "");
    }

    /// Marks the end of a pass's work; consecutive work of one name shares a mark's name.
    pub fn mark(&mut self, device: &Device, commands: vk::CommandBuffer, name: &'static str) {
        if !self.recorded || self.marks.len() as u32 >= QUERIES {
            return;
        }
        let query = self.marks.len() as u32;
        let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        // SAFETY: the query is within the pool and was reset in this command buffer.
        unsafe { device.raw.cmd_write_timestamp(commands, stage, self.pool, query) };
        self.marks.push(name);
    }

    /// Ends a frame: the ticks go where the host can read them.
    pub fn end(&self, device: &Device, commands: vk::CommandBuffer) {
        let Some(buffer) = self.ticks.as_ref().filter(|_| self.recorded) else { return };
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        let count = self.marks.len() as u32;
        // SAFETY: recording; as many queries as marks were written, and the buffer holds them all.
        unsafe { device.raw.cmd_copy_query_pool_results(commands, self.pool, 0, count, buffer.raw, 0, 8, flags) };
    }

    /// Whether the slot's last frame was timed.
    pub fn has_times(&self) -> bool {
        self.ticks.is_some() && self.recorded && self.marks.len() > 1
    }

    /// Calls `take` with every mark, in order, and the milliseconds since the previous one.
    pub fn read(&self, device: &Device, mut take: impl FnMut(&'static str, f64)) {
        let Some(buffer) = self.ticks.as_ref().filter(|_| self.has_times()) else { return };
        let mask = u64::MAX >> (64 - device.timestamp_bits.clamp(1, 64));
        let milliseconds = f64::from(device.limits.timestamp_period) * 1e-6;
        let mut before = None;
        for (mark, ticks) in self.marks.iter().zip(buffer.iter::<u64>(self.marks.len())) {
            if let Some(before) = before.replace(ticks) {
                take(mark, (ticks.wrapping_sub(before) & mask) as f64 * milliseconds);
            }
        }
    }

    /// The GPU must have finished with it.
    pub fn destroy(&mut self, device: &Device) {
        if let Some(mut buffer) = self.ticks.take() {
            buffer.destroy(device);
        }
        // SAFETY: made on this device, no longer in use; null is ignored.
        unsafe { device.raw.destroy_query_pool(self.pool, None) };
        self.pool = vk::QueryPool::null();
    }
}
