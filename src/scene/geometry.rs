//! How vertices and indices lie in memory and in the host's buffers, and how they are read.

use crate::error::Error;
use ash::vk;
use half::f16;

/// What the numbers of a vertex attribute are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexFormat {
    /// IEEE 754 binary16, 2 bytes.
    Float16,
    /// IEEE 754 binary32, 4 bytes.
    Float32,
}

/// What indices are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IndexType {
    /// 2 bytes.
    Uint16,
    /// 4 bytes.
    Uint32,
}

/// Where the elements of an array lie. Bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Of one of an element's numbers: what addresses are aligned to.
    pub number: u32,
    /// Of an element.
    pub element: u32,
    /// From one element to the next; at least an element.
    pub stride: u32,
}

impl VertexFormat {
    /// Attributes of so many numbers, `stride` bytes apart (0: tight). The error says what is wrong with the stride.
    pub(crate) fn layout(self, numbers: u32, stride: u32) -> Result<Layout, String> {
        let number = match self {
            Self::Float16 => 2,
            Self::Float32 => 4,
        };
        let element = numbers * number;
        if stride != 0 && stride < element {
            return Err(format!("stride is {stride}; an element has {element} bytes"));
        }
        if !stride.is_multiple_of(number) {
            return Err(format!("stride is {stride}; it must be a multiple of {number}"));
        }
        Ok(Layout { number, element, stride: if stride == 0 { element } else { stride } })
    }

    /// Reads the attributes of `N` numbers that `bytes` holds, from the first one's first byte to the last one's last.
    pub(crate) fn decode<const N: usize>(self, bytes: &[u8], stride: u32) -> impl Iterator<Item = [f32; N]> {
        let float32 = |b: &[u8]| f32::from_ne_bytes([b[0], b[1], b[2], b[3]]);
        let float16 = |b: &[u8]| f16::from_ne_bytes([b[0], b[1]]).to_f32();
        bytes.chunks(stride as usize).map(move |element| match self {
            Self::Float16 => std::array::from_fn(|i| float16(&element[2 * i..])),
            Self::Float32 => std::array::from_fn(|i| float32(&element[4 * i..])),
        })
    }
}

impl IndexType {
    /// Indices lie side by side.
    pub(crate) fn layout(self) -> Layout {
        let bytes = match self {
            Self::Uint16 => 2,
            Self::Uint32 => 4,
        };
        Layout { number: bytes, element: bytes, stride: bytes }
    }

    /// Reads all indices that `bytes` holds.
    pub(crate) fn decode(self, bytes: &[u8]) -> impl Iterator<Item = u32> {
        bytes.chunks_exact(self.layout().element as usize).map(move |b| match self {
            Self::Uint16 => u32::from(u16::from_ne_bytes([b[0], b[1]])),
            Self::Uint32 => u32::from_ne_bytes([b[0], b[1], b[2], b[3]]),
        })
    }
}

impl Layout {
    /// Bytes from the first element's first to the last one's last; of at least one element.
    pub fn span(self, count: u32) -> u64 {
        u64::from(count - 1) * u64::from(self.stride) + u64::from(self.element)
    }

    /// Elements that so many bytes hold.
    pub fn fitting(self, bytes: u64) -> u32 {
        let behind_first = bytes.checked_sub(u64::from(self.element)).map(|rest| rest / u64::from(self.stride));
        behind_first.map_or(0, |n| u32::try_from(n + 1).unwrap_or(u32::MAX))
    }
}

/// A place in one of the host's buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferAddress {
    buffer: vk::Buffer,
    offset: u64,
}

impl BufferAddress {
    /// `offset` bytes from the start of `buffer`, which was created with `VK_BUFFER_USAGE_TRANSFER_SRC_BIT` on the
    /// context's device.
    ///
    /// # Safety
    /// `buffer` is such a buffer, or null. From the update that names it until its mesh is no longer pending it neither
    /// changes nor goes, and whenever a command buffer executes into which `dispatch` recorded meanwhile, its contents are
    /// complete, visible to transfer reads, and owned by the queue's family. If the mesh is removed or replaced before, the
    /// buffer lives until the GPU has finished with those command buffers.
    pub unsafe fn new(buffer: vk::Buffer, offset: u64) -> Self {
        Self { buffer, offset }
    }
}

/// An attribute of vertices in a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VertexBuffer {
    /// The first vertex's first number; aligned to a number.
    pub address: BufferAddress,
    /// Bytes from one vertex to the next, a multiple of a number's; 0: nothing lies between them.
    pub stride: u32,
    /// The numbers.
    pub format: VertexFormat,
}

/// Indices in a buffer, side by side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IndexBuffer {
    /// The first index; aligned to an index.
    pub address: BufferAddress,
    /// The indices.
    pub index_type: IndexType,
}

/// A triangle mesh in the host's buffers. The following dispatches copy it to the CPU; until then, instances of it are not
/// there yet ([`Stats::meshes_pending`](crate::Stats::meshes_pending)), or have the mesh of this id that was there before.
/// If a number turns out not to be finite, or an index to be out of range, the mesh counts as empty, and a warning says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferMeshDesc {
    /// Chosen by the host.
    pub id: u64,
    /// At least 1.
    pub vertex_count: u32,
    /// Three per triangle, at least 3.
    pub index_count: u32,
    /// x, y, z in object space, metres.
    pub positions: VertexBuffer,
    /// u, v. (0, 0) is the texture's first texel; repeats.
    pub uvs: Option<VertexBuffer>,
    /// Each below `vertex_count`; counter-clockwise seen from the front.
    pub indices: IndexBuffer,
}

/// An array of a mesh in a buffer.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Array {
    name: &'static str,
    pub buffer: vk::Buffer,
    /// Of the first element.
    pub offset: u64,
    pub layout: Layout,
    pub count: u32,
}

impl Array {
    fn new(name: &'static str, address: BufferAddress, layout: Layout, count: u32) -> Result<Self, String> {
        let BufferAddress { buffer, offset } = address;
        if buffer == vk::Buffer::null() {
            return Err(format!("{name}.buffer is VK_NULL_HANDLE"));
        }
        if !offset.is_multiple_of(u64::from(layout.number)) {
            return Err(format!("{name}.offset is {offset}; it must be a multiple of {}", layout.number));
        }
        Ok(Self { name, buffer, offset, layout, count })
    }

    /// Refuses elements beyond the end of the buffer.
    fn check_end(&self, buffer_bytes: u64) -> Result<(), String> {
        let Self { name, offset, .. } = self;
        let bytes = self.layout.span(self.count);
        if offset.checked_add(bytes).is_none_or(|end| end > buffer_bytes) {
            return Err(format!("{name}: {bytes} bytes from offset {offset} on; the buffer has {buffer_bytes}"));
        }
        Ok(())
    }
}

impl BufferMeshDesc {
    /// Positions, texture coordinates (or no elements) and indices. The error says what is wrong with them.
    pub(crate) fn arrays(&self) -> Result<[Array; 3], Error> {
        self.try_arrays().map_err(|text| self.wrong(text))
    }

    fn try_arrays(&self) -> Result<[Array; 3], String> {
        if self.vertex_count == 0 {
            return Err("vertex_count is 0".to_owned());
        }
        if self.index_count == 0 || !self.index_count.is_multiple_of(3) {
            return Err("indices must be three per triangle".to_owned());
        }
        let vertices = |name, numbers, from: VertexBuffer| {
            let layout = from.format.layout(numbers, from.stride).map_err(|text| format!("{name}.{text}"))?;
            Array::new(name, from.address, layout, self.vertex_count)
        };
        let indices = self.indices;
        Ok([
            vertices("positions", 3, self.positions)?,
            self.uvs.map_or(Ok(Array::default()), |uvs| vertices("uvs", 2, uvs))?,
            Array::new("indices", indices.address, indices.index_type.layout(), self.index_count)?,
        ])
    }

    /// Refuses arrays that reach beyond the end of their buffers; `buffer_bytes` says how large a buffer is.
    pub(crate) fn check_ends(&self, buffer_bytes: impl Fn(vk::Buffer) -> u64) -> Result<(), Error> {
        let arrays = self.arrays()?;
        let mut arrays = arrays.iter().filter(|array| array.count > 0);
        arrays.try_for_each(|array| array.check_end(buffer_bytes(array.buffer))).map_err(|text| self.wrong(text))
    }

    fn wrong(&self, text: String) -> Error {
        Error::invalid(format!("mesh {}: {text}", self.id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_half_is_read_as_its_value() {
        let all: Vec<u8> = (0..=u16::MAX).flat_map(u16::to_ne_bytes).collect();
        let read: Vec<[f32; 1]> = VertexFormat::Float16.decode(&all, 2).collect();
        assert_eq!(read.len(), 1 << 16);
        for (bits, [value]) in (0..=u16::MAX).zip(read) {
            let (sign, exponent, fraction) = (bits >> 15, i32::from(bits >> 10 & 31), f64::from(bits & 1023));
            let magnitude = match exponent {
                0 => fraction * 2f64.powi(-24),
                31 if fraction == 0.0 => f64::INFINITY,
                31 => f64::NAN,
                _ => (1024.0 + fraction) * 2f64.powi(exponent - 25),
            };
            let expected = if sign == 1 { -magnitude } else { magnitude };
            let same = f64::from(value) == expected || value.is_nan() && expected.is_nan();
            assert!(same && value.is_sign_negative() == (sign == 1), "{bits:#06x}: {value}, {expected}");
        }
    }

    #[test]
    fn strides_pass_over_what_lies_between() {
        let bytes: Vec<u8> = [1.0f32, 2.0, 3.0, -1.0, 4.0, 5.0, 6.0].iter().flat_map(|v| v.to_ne_bytes()).collect();
        let layout = VertexFormat::Float32.layout(3, 16).expect("a valid stride");
        assert_eq!(layout.span(2), bytes.len() as u64);
        assert_eq!([11, 12, 27, 28, 44].map(|bytes| layout.fitting(bytes)), [0, 1, 1, 2, 3]);
        let read: Vec<[f32; 3]> = VertexFormat::Float32.decode(&bytes, layout.stride).collect();
        assert_eq!(read, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        let bytes: Vec<u8> = [7u16, 0xffff].iter().flat_map(|v| v.to_ne_bytes()).collect();
        assert_eq!(IndexType::Uint16.decode(&bytes).collect::<Vec<_>>(), [7, 65_535]);
        assert_eq!(IndexType::Uint32.decode(&0x1234_5678u32.to_ne_bytes()).collect::<Vec<_>>(), [0x1234_5678]);
    }

    #[test]
    fn strides_that_cut_elements_are_refused() {
        let refused = |format: VertexFormat, stride| format.layout(3, stride).expect_err("refused");
        assert_eq!(refused(VertexFormat::Float32, 8), "stride is 8; an element has 12 bytes");
        assert_eq!(refused(VertexFormat::Float32, 14), "stride is 14; it must be a multiple of 4");
        assert_eq!(refused(VertexFormat::Float16, 7), "stride is 7; it must be a multiple of 2");
        assert_eq!(VertexFormat::Float16.layout(3, 0), Ok(Layout { number: 2, element: 6, stride: 6 }));
    }
}
