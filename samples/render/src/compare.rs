//! Ours, the truth, and the signed relative error between them, side by side.

use crate::tonemap;
use brickgi_host::image::luminance;
use brickgi_host::{Image, Reference};
use image::{Rgb, RgbImage, imageops};

/// Pixels between the panels.
const GAP: u32 = 4;
/// Height of the legend under the error, with its numbers.
const LEGEND: u32 = 20;

/// E_ind of both at the truth's exposure, then (ours - truth) / sqrt(truth^2 + (mean / 10)^2): blue is too dark,
/// red too bright, the ends of the scale are -100 % and +100 %.
pub fn panels(ours: &Image, reference: &Reference) -> RgbImage {
    let truth = reference.indirect();
    let exposure = tonemap::exposure(if truth.pixels.iter().flatten().any(|v| *v > 0.0) { &truth } else { ours });
    let (width, height) = (ours.width, ours.height);
    let mut sheet = RgbImage::from_pixel(3 * width + 2 * GAP, height + LEGEND, Rgb([24; 3]));
    let error = relative_error(ours, &truth, &reference.hit);
    let columns = [tonemap::develop(ours, exposure), tonemap::develop(&truth, exposure), error];
    for (x, panel) in (0u32..).map(|i| i * (width + GAP)).zip(&columns) {
        imageops::replace(&mut sheet, panel, i64::from(x), 0);
    }
    legend(&mut sheet, 2 * (width + GAP), height, width);
    sheet
}

fn relative_error(ours: &Image, truth: &Image, hit: &Image<bool>) -> RgbImage {
    let lit: Vec<f64> = hit.pixels.iter().zip(&truth.pixels).filter(|(h, _)| **h).map(|(_, p)| luminance(*p)).collect();
    let mean = lit.iter().sum::<f64>() / lit.len().max(1) as f64;
    RgbImage::from_fn(ours.width, ours.height, |x, y| {
        if !*hit.at(x, y) {
            return Rgb([24; 3]);
        }
        let (x_ours, x_truth) = (luminance(*ours.at(x, y)), luminance(*truth.at(x, y)));
        let scale = x_truth.hypot(mean / 10.0).max(1e-9);
        diverging(((x_ours - x_truth) / scale) as f32)
    })
}

/// -1 blue, 0 white, 1 red; beyond the ends and for what is not a number: saturated, magenta.
fn diverging(value: f32) -> Rgb<u8> {
    if !value.is_finite() {
        return Rgb([255, 0, 255]);
    }
    let end = if value < 0.0 { [0.02, 0.12, 0.6] } else { [0.6, 0.03, 0.02] };
    let blend = value.abs().min(1.0).sqrt();
    Rgb(end.map(|channel: f32| tonemap::encode(0.9 + (channel - 0.9) * blend)))
}

fn legend(sheet: &mut RgbImage, left: u32, top: u32, width: u32) {
    for x in 0..width {
        let value = 2.0 * (x as f32 + 0.5) / width as f32 - 1.0;
        for y in top + 3..top + 10 {
            sheet.put_pixel(left + x, y, diverging(value));
        }
    }
    let centered = |text: &str, at: f32| {
        let wide = text.len() as u32 * 4;
        let x = (width as f32 * at) as i64 - i64::from(wide / 2);
        x.clamp(0, i64::from(width.saturating_sub(wide))) as u32
    };
    for (text, at) in [("-100%", 0.0), ("-50%", 0.25), ("0", 0.5), ("+50%", 0.75), ("+100%", 1.0)] {
        write(sheet, text, left + centered(text, at), top + 13);
    }
}

/// Writes with 3 x 5 pixel letters; characters without a letter are blank.
fn write(sheet: &mut RgbImage, text: &str, left: u32, top: u32) {
    for (column, rows) in (0u32..).zip(text.chars().map(glyph)) {
        for (y, row) in (0u32..).zip(rows) {
            for x in (0u32..3).filter(|x| row >> (2 - x) & 1 == 1) {
                if let Some(pixel) = sheet.get_pixel_mut_checked(left + column * 4 + x, top + y) {
                    *pixel = Rgb([220; 3]);
                }
            }
        }
    }
}

/// Rows from the top, three bits each.
fn glyph(letter: char) -> [u8; 5] {
    match letter {
        '0' => [7, 5, 5, 5, 7],
        '1' => [2, 6, 2, 2, 7],
        '5' => [7, 4, 7, 1, 7],
        '+' => [0, 2, 7, 2, 0],
        '-' => [0, 0, 7, 0, 0],
        '%' => [5, 1, 2, 4, 5],
        _ => [0; 5],
    }
}
