//! GPU times by timestamps, read without waiting.

use super::Device;
use crate::error::{Error, Result};
use ash::vk;

const QUERIES: u32 = 512;

/// One frame slot's timestamps.
pub struct Timing {
    pool: vk::QueryPool,
    marks: Vec<&'static str>,
    recorded: bool,
}

impl Timing {
    /// A pool, or none where the device has no timestamps.
    pub fn new(device: &Device) -> Result<Self> {
        let mut pool = vk::QueryPool::null();
        if device.timestamp_bits > 0 {
            let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(QUERIES);
            // SAFETY: valid device.
            pool = unsafe { device.raw.create_query_pool(&info, None) }.map_err(Error::vulkan("vkCreateQueryPool"))?;
        }
        Ok(Self { pool, marks: Vec::new(), recorded: false })
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

    /// Milliseconds since the previous mark of every mark, in order; empty when not available.
    pub fn read(&self, device: &Device) -> Vec<(&'static str, f64)> {
        if !self.recorded || self.marks.len() < 2 {
            return Vec::new();
        }
        let mut ticks = vec![0u64; self.marks.len()];
        // SAFETY: as many queries as marks were written; no wait flag, so this cannot block.
        let read =
            unsafe { device.raw.get_query_pool_results(self.pool, 0, &mut ticks, vk::QueryResultFlags::TYPE_64) };
        if read.is_err() {
            return Vec::new();
        }
        let mask = u64::MAX >> (64 - device.timestamp_bits.clamp(1, 64));
        let milliseconds = f64::from(device.limits.timestamp_period) * 1e-6;
        let times = ticks.windows(2).map(|t| (t[1].wrapping_sub(t[0]) & mask) as f64 * milliseconds);
        self.marks[1..].iter().copied().zip(times).collect()
    }

    /// The GPU must have finished with it.
    pub fn destroy(&mut self, device: &Device) {
        // SAFETY: made on this device, no longer in use; null is ignored.
        unsafe { device.raw.destroy_query_pool(self.pool, None) };
        self.pool = vk::QueryPool::null();
    }
}
