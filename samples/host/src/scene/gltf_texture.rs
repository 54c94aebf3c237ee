//! Base-colour images of a glTF file as 8-bit RGBA.

use super::Texture;
use gltf::image::{Data, Format};
use image::{DynamicImage, imageops::FilterType};

/// Longest edge the host keeps; larger images are shrunk.
const MAX_EDGE: u32 = 1024;

/// Decodes whatever the loader produced; an error names what is unsupported.
pub(super) fn texture(data: Data) -> Result<Texture, String> {
    let (width, height, format) = (data.width, data.height, data.format);
    let image = decode(data).ok_or_else(|| format!("unsupported image: {width} x {height}, {format:?}"))?;
    let image =
        if width.max(height) > MAX_EDGE { image.resize(MAX_EDGE, MAX_EDGE, FilterType::Triangle) } else { image };
    let rgba = image.into_rgba8();
    Ok(Texture { width: rgba.width(), height: rgba.height(), rgba8: rgba.into_raw() })
}

fn decode(data: Data) -> Option<DynamicImage> {
    let (width, height, bytes) = (data.width, data.height, data.pixels);
    let words = |bytes: &[u8]| bytes.chunks_exact(2).map(|b| u16::from_ne_bytes([b[0], b[1]])).collect();
    Some(match data.format {
        Format::R8 => DynamicImage::ImageLuma8(image::ImageBuffer::from_raw(width, height, bytes)?),
        Format::R8G8 => DynamicImage::ImageLumaA8(image::ImageBuffer::from_raw(width, height, bytes)?),
        Format::R8G8B8 => DynamicImage::ImageRgb8(image::ImageBuffer::from_raw(width, height, bytes)?),
        Format::R8G8B8A8 => DynamicImage::ImageRgba8(image::ImageBuffer::from_raw(width, height, bytes)?),
        Format::R16 => DynamicImage::ImageLuma16(image::ImageBuffer::from_raw(width, height, words(&bytes))?),
        Format::R16G16 => DynamicImage::ImageLumaA16(image::ImageBuffer::from_raw(width, height, words(&bytes))?),
        Format::R16G16B16 => DynamicImage::ImageRgb16(image::ImageBuffer::from_raw(width, height, words(&bytes))?),
        Format::R16G16B16A16 => DynamicImage::ImageRgba16(image::ImageBuffer::from_raw(width, height, words(&bytes))?),
        _ => return None,
    })
}
