//! Where a mesh's vertices and indices lie, and in which format.

use super::guard::Failure;
use super::input;
use super::vk::VkBuffer;
use crate::scene::{BufferAddress, IndexBuffer, IndexType, VertexBuffer, VertexFormat};
use std::borrow::Cow;
use std::ffi::c_void;

/// What the numbers of a vertex attribute are: one of BGI_VERTEX_FORMAT_*. The value is their size in bytes.
pub type BgiVertexFormat = u32;
/// IEEE 754 binary16. VK_FORMAT_R16G16B16A16_SFLOAT is this with a stride of 8: its fourth number is passed over.
pub const BGI_VERTEX_FORMAT_FLOAT16: BgiVertexFormat = 2;
/// IEEE 754 binary32.
pub const BGI_VERTEX_FORMAT_FLOAT32: BgiVertexFormat = 4;

/// What indices are: one of BGI_INDEX_TYPE_*. The value is their size in bytes; VkIndexType has other values.
pub type BgiIndexType = u32;
/// 16-bit unsigned integers.
pub const BGI_INDEX_TYPE_UINT16: BgiIndexType = 2;
/// 32-bit unsigned integers.
pub const BGI_INDEX_TYPE_UINT32: BgiIndexType = 4;

/// An attribute of a mesh's vertices, in host memory or in a buffer.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiVertexData {
    /// Host memory, copied before the call returns; or NULL.
    pub data: *const c_void,
    /// Or a buffer of the context's device, made with VK_BUFFER_USAGE_TRANSFER_SRC_BIT; else VK_NULL_HANDLE. BgiMesh says
    /// when it is read.
    pub buffer: VkBuffer,
    /// Bytes from the start of `data` or `buffer` to the first vertex's first number, which is aligned to the size of a
    /// number.
    pub offset: u64,
    /// Bytes from one vertex to the next, a multiple of the size of a number; 0: nothing lies between them.
    pub stride: u32,
    /// BGI_VERTEX_FORMAT_*
    pub format: BgiVertexFormat,
}

/// A mesh's indices, side by side, in host memory or in a buffer.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiIndexData {
    /// As in BgiVertexData.
    pub data: *const c_void,
    /// As in BgiVertexData.
    pub buffer: VkBuffer,
    /// Bytes from the start of `data` or `buffer` to the first index, which is aligned to the size of an index.
    pub offset: u64,
    /// BGI_INDEX_TYPE_*
    pub index_type: BgiIndexType,
}

impl BgiVertexData {
    fn vertex_format(&self, field: &str) -> Result<VertexFormat, Failure> {
        match self.format {
            BGI_VERTEX_FORMAT_FLOAT16 => Ok(VertexFormat::Float16),
            BGI_VERTEX_FORMAT_FLOAT32 => Ok(VertexFormat::Float32),
            other => Err(Failure::argument(format!("{field}.format: {other} is no BGI_VERTEX_FORMAT_*"))),
        }
    }

    /// `N` numbers a vertex, in host memory.
    ///
    /// # Safety
    /// `data` is NULL, or leads to `count` vertices as the struct says, unchanged for 'a.
    pub(super) unsafe fn read<'a, const N: usize>(
        &self,
        count: u32,
        field: &str,
    ) -> Result<Cow<'a, [[f32; N]]>, Failure> {
        let format = self.vertex_format(field)?;
        let layout = format.layout(N as u32, self.stride);
        let layout = layout.map_err(|text| Failure::argument(format!("{field}.{text}")))?;
        // SAFETY: the caller's promise.
        let bytes = unsafe { input::bytes(self.data, self.offset, layout.span(count), layout.number, field)? };
        Ok(match format {
            VertexFormat::Float32 if layout.stride == layout.element => {
                Cow::Borrowed(bytemuck::cast_slice::<u8, f32>(bytes).as_chunks().0)
            }
            _ => Cow::Owned(format.decode(bytes, layout.stride).collect()),
        })
    }

    /// In a buffer.
    ///
    /// # Safety
    /// As the header says of `buffer`.
    pub(super) unsafe fn in_buffer(&self, field: &str) -> Result<VertexBuffer, Failure> {
        // SAFETY: the caller's promise.
        let address = unsafe { BufferAddress::new(self.buffer, self.offset) };
        Ok(VertexBuffer { address, stride: self.stride, format: self.vertex_format(field)? })
    }
}

impl BgiIndexData {
    fn index_type(&self, field: &str) -> Result<IndexType, Failure> {
        match self.index_type {
            BGI_INDEX_TYPE_UINT16 => Ok(IndexType::Uint16),
            BGI_INDEX_TYPE_UINT32 => Ok(IndexType::Uint32),
            other => Err(Failure::argument(format!("{field}.indexType: {other} is no BGI_INDEX_TYPE_*"))),
        }
    }

    /// Indices in host memory.
    ///
    /// # Safety
    /// `data` is NULL, or leads to `count` indices as the struct says, unchanged for 'a.
    pub(super) unsafe fn read<'a>(&self, count: u32, field: &str) -> Result<Cow<'a, [u32]>, Failure> {
        let index_type = self.index_type(field)?;
        let layout = index_type.layout();
        // SAFETY: the caller's promise.
        let bytes = unsafe { input::bytes(self.data, self.offset, layout.span(count), layout.number, field)? };
        Ok(match index_type {
            IndexType::Uint32 => Cow::Borrowed(bytemuck::cast_slice(bytes)),
            IndexType::Uint16 => Cow::Owned(index_type.decode(bytes).collect()),
        })
    }

    /// In a buffer.
    ///
    /// # Safety
    /// As the header says of `buffer`.
    pub(super) unsafe fn in_buffer(&self, field: &str) -> Result<IndexBuffer, Failure> {
        // SAFETY: the caller's promise.
        let address = unsafe { BufferAddress::new(self.buffer, self.offset) };
        Ok(IndexBuffer { address, index_type: self.index_type(field)? })
    }
}
