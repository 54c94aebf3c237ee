//! From linear light to 8-bit sRGB.

use brickgi_host::Image;
use brickgi_host::image::luminance;
use image::{Rgb, RgbImage};

/// Where the log-average luminance of the lit pixels ends up before the curve.
const MIDDLE_GREY: f64 = 0.2;

/// Automatic exposure: the factor that brings the log-average luminance of the lit pixels to middle grey.
pub fn exposure(image: &Image) -> f32 {
    let lit = image.pixels.iter().map(|p| luminance(*p)).filter(|l| *l > 0.0 && l.is_finite());
    let (sum, count) = lit.fold((0.0, 0u32), |(sum, count), l| (sum + l.ln(), count + 1));
    if count == 0 { 1.0 } else { (MIDDLE_GREY / (sum / f64::from(count)).exp()) as f32 }
}

/// Exposes, compresses the highlights and encodes; what is not a number becomes magenta.
pub fn develop(image: &Image, exposure: f32) -> RgbImage {
    RgbImage::from_fn(image.width, image.height, |x, y| {
        let linear = *image.at(x, y);
        if linear.iter().all(|v| v.is_finite()) {
            Rgb(linear.map(|v| encode(1.0 - (-1.3 * exposure * v.max(0.0)).exp())))
        } else {
            Rgb([255, 0, 255])
        }
    })
}

/// Without a curve: 0 to 1 is what is shown.
pub fn plain(image: &Image) -> RgbImage {
    RgbImage::from_fn(image.width, image.height, |x, y| Rgb(image.at(x, y).map(encode)))
}

/// 0 to 1 linear to 8-bit sRGB.
pub fn encode(linear: f32) -> u8 {
    let v = linear.clamp(0.0, 1.0);
    let curve = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (curve * 255.0 + 0.5) as u8
}
