//! Linear float images on the CPU and their OpenEXR files.

use crate::error::{Error, Result};
use exr::prelude as exr;
use std::path::Path;

/// A row-major image; row 0 is the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image<T = [f32; 3]> {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` pixels, rows from the top.
    pub pixels: Vec<T>,
}

impl<T: Clone> Image<T> {
    /// An image of one value.
    pub fn filled(width: u32, height: u32, value: T) -> Self {
        Self { width, height, pixels: vec![value; width as usize * height as usize] }
    }

    /// The pixel at column `x`, row `y`; both must be inside.
    pub fn at(&self, x: u32, y: u32) -> &T {
        &self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// An image of the same size with every pixel mapped.
    pub fn map<U>(&self, f: impl Fn(&T) -> U) -> Image<U> {
        Image { width: self.width, height: self.height, pixels: self.pixels.iter().map(f).collect() }
    }
}

impl Image<[f32; 3]> {
    /// Reads the R, G and B channels (half or float) of an OpenEXR file.
    pub fn read_exr(path: &Path) -> Result<Self> {
        if let Err(source) = std::fs::metadata(path) {
            return Err(Error::Io { path: path.to_owned(), source });
        }
        let read = exr::read_first_rgba_layer_from_file(
            path,
            |size, _| Self::filled(size.width() as u32, size.height() as u32, [0.0; 3]),
            |image, at, (r, g, b, _): (f32, f32, f32, f32)| {
                image.pixels[at.y() * image.width as usize + at.x()] = [r, g, b];
            },
        );
        Ok(read.map_err(Error::image(path))?.layer_data.channel_data.pixels)
    }

    /// Writes R, G and B as 32-bit floats.
    pub fn write_exr(&self, path: &Path) -> Result<()> {
        exr::write_rgb_file(path, self.width as usize, self.height as usize, |x, y| {
            let [r, g, b] = *self.at(x as u32, y as u32);
            (r, g, b)
        })
        .map_err(Error::image(path))
    }

    /// Whether every value is a number.
    pub fn is_finite(&self) -> bool {
        self.pixels.iter().flatten().all(|v| v.is_finite())
    }
}

/// Rec.709 luminance.
pub fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}
