//! How vertices and indices lie in memory, and how they are read.

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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
