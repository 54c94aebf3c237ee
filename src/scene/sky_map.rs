//! A sky's image, reduced to what diffuse light needs: an octahedral map (Cigolle et al., A Survey of Efficient
//! Representations for Independent Unit Vectors, JCGT 2014) of mean radiances, read without interpolation. What lies
//! between the middles of four texels is shared among them, so that the map has the image's energy and its direction:
//! without, a sun near a surface's horizon brings several per cent too much or too little.

use crate::error::{Error, Result};
use crate::gpu::shared::SKY_EDGE;
use glam::{DVec2, DVec3};
use half::f16;
use std::f64::consts::{PI, TAU};

/// How a sky's image covers the directions. Rows from the top.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkyLayout {
    /// Equirectangular. The top row is +y, the middle of the image -z, and +x is to the right of it.
    LatLong,
    /// Six square faces, one after another: +x, -x, +y, -y, +z, -z, each as Vulkan lays out a cube map.
    Cube,
}

/// Texels of a sky's image, in the order of rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkyFormat {
    /// 8 bytes, `VK_FORMAT_R16G16B16A16_SFLOAT`; alpha is passed over.
    Rgba16Float,
    /// 16 bytes, `VK_FORMAT_R32G32B32A32_SFLOAT`; alpha is passed over.
    Rgba32Float,
    /// 4 bytes, `VK_FORMAT_B10G11R11_UFLOAT_PACK32`.
    B10G11R11,
}

/// A sky's image: radiance, linear Rec.709. What is negative or not a number counts as 0, what is infinite as 65504.
#[derive(Clone, Copy, Debug)]
pub struct SkyImage<'a> {
    /// Lat-long or cube.
    pub layout: SkyLayout,
    /// Of the texels.
    pub format: SkyFormat,
    /// Texels per row, 1 to 16384.
    pub width: u32,
    /// Rows (of a face), 1 to 16384; of a cube, as many as `width`.
    pub height: u32,
    /// `width * height` texels, of a cube six times as many; no padding.
    pub texels: &'a [u8],
}

/// Distance of samples in radians: an eighth of the smallest texel of the map.
const SPACING: f64 = 0.0046;
const EDGE: usize = SKY_EDGE as usize;

impl SkyFormat {
    fn bytes(self) -> usize {
        match self {
            Self::Rgba16Float => 8,
            Self::Rgba32Float => 16,
            Self::B10G11R11 => 4,
        }
    }

    fn decode(self, texel: &[u8]) -> DVec3 {
        let half = |bits: u16| f16::from_bits(bits).to_f32();
        let rgb = match self {
            Self::Rgba16Float => [0, 2, 4].map(|i| half(u16::from_le_bytes([texel[i], texel[i + 1]]))),
            Self::Rgba32Float => [0, 4, 8].map(|i| f32::from_le_bytes(texel[i..i + 4].try_into().expect("four bytes"))),
            Self::B10G11R11 => {
                // A half without sign and with fewer bits of mantissa.
                let word = u32::from_le_bytes(texel.try_into().expect("four bytes"));
                [(word & 0x7ff) << 4, (word >> 11 & 0x7ff) << 4, (word >> 22) << 5].map(|bits| half(bits as u16))
            }
        };
        let usable = |v: f32| if v == f32::INFINITY { 65504.0 } else { f64::from(v).max(0.0) };
        DVec3::from(rgb.map(usable))
    }
}

impl SkyImage<'_> {
    fn check(&self) -> Result<()> {
        let sides = [self.width, self.height];
        if sides.iter().any(|side| !(1..=16_384).contains(side)) {
            return Err(Error::invalid("sky image: sides must be 1 to 16384"));
        }
        if self.layout == SkyLayout::Cube && self.width != self.height {
            return Err(Error::invalid("sky image: the faces of a cube must be square"));
        }
        let faces = if self.layout == SkyLayout::Cube { 6 } else { 1 };
        let bytes = faces * u64::from(self.width) * u64::from(self.height) * self.format.bytes() as u64;
        if self.texels.len() as u64 != bytes {
            let text = format!("sky image: {bytes} bytes of texels are needed, {} are given", self.texels.len());
            return Err(Error::invalid(text));
        }
        Ok(())
    }

    fn texel(&self, index: usize) -> DVec3 {
        let bytes = self.format.bytes();
        self.format.decode(&self.texels[index * bytes..][..bytes])
    }

    /// Calls with places all over the sphere: direction, solid angle, radiance.
    fn samples(&self, mut add: impl FnMut(DVec3, f64, DVec3)) {
        match self.layout {
            SkyLayout::LatLong => self.lat_long_samples(&mut add),
            SkyLayout::Cube => (0..6).for_each(|face| self.face_samples(face, &mut add)),
        }
    }

    fn lat_long_samples(&self, add: &mut impl FnMut(DVec3, f64, DVec3)) {
        let [width, height] = [self.width, self.height].map(f64::from);
        let [across, down] = [TAU / width, PI / height].map(|texel| (texel / SPACING).ceil());
        let columns = self.width * across as u32;
        let azimuth = |column: u32| ((f64::from(column) + 0.5) / f64::from(columns) - 0.5) * TAU;
        let around: Vec<(f64, f64)> = (0..columns).map(|column| azimuth(column).sin_cos()).collect();
        for row in 0..self.height * down as u32 {
            let [top, middle, bottom] = [0.0, 0.5, 1.0].map(|part| (f64::from(row) + part) / (height * down) * PI);
            let angle = (top.cos() - bottom.cos()) * TAU / f64::from(columns);
            let (sine, cosine) = middle.sin_cos();
            let first = (row / down as u32 * self.width) as usize;
            for (places, column) in around.chunks(across as usize).zip(0..) {
                let radiance = self.texel(first + column);
                for (x, z) in places {
                    add(DVec3::new(sine * x, cosine, -sine * z), angle, radiance);
                }
            }
        }
    }

    fn face_samples(&self, face: usize, add: &mut impl FnMut(DVec3, f64, DVec3)) {
        let edge = self.width;
        let parts = (2.0 / f64::from(edge) / SPACING).ceil() as u32;
        let count = edge * parts;
        // Area on the sphere of the face's part up to a corner.
        let corner = |x: f64, y: f64| (x * y).atan2((x * x + y * y + 1.0).sqrt());
        let at = |step: u32, part: f64| (f64::from(step) + part) / f64::from(count) * 2.0 - 1.0;
        for row in 0..count {
            let (top, t, bottom) = (at(row, 0.0), at(row, 0.5), at(row, 1.0));
            for column in 0..count {
                let (left, s, right) = (at(column, 0.0), at(column, 0.5), at(column, 1.0));
                let angle = corner(right, bottom) - corner(left, bottom) - corner(right, top) + corner(left, top);
                let index = (face * edge as usize + (row / parts) as usize) * edge as usize + (column / parts) as usize;
                add(cube_direction(face, s, t).normalize(), angle, self.texel(index));
            }
        }
    }

    /// The map's texels, RGB9E5, row by row.
    pub(crate) fn reduce(&self) -> Result<Vec<u32>> {
        self.check()?;
        let mut sums = vec![(DVec3::ZERO, 0.0); EDGE * EDGE];
        let mut flux = DVec3::ZERO;
        self.samples(|direction, angle, radiance| {
            flux += radiance * angle;
            for (texel, share) in texels_about(direction) {
                sums[texel].0 += radiance * (angle * share);
                sums[texel].1 += angle * share;
            }
        });
        let means: Vec<DVec3> = sums.iter().map(|(sum, angle)| *sum / angle.max(1e-12)).collect();
        // Texels have a few more samples or a few less than are due to them: what that takes or gives is given back.
        let kept: DVec3 = means.iter().enumerate().map(|(index, mean)| *mean * texel_angle(index)).sum();
        let scale = DVec3::select(kept.cmpgt(DVec3::ZERO), flux / kept, DVec3::ONE);
        Ok(means.into_iter().map(|mean| rgb9e5(mean * scale)).collect())
    }
}

/// Where a cube map's face has its point (s, t), each -1 to 1 (Vulkan, Cube Map Face Selection).
fn cube_direction(face: usize, s: f64, t: f64) -> DVec3 {
    match face {
        0 => DVec3::new(1.0, -t, -s),
        1 => DVec3::new(-1.0, -t, s),
        2 => DVec3::new(s, 1.0, t),
        3 => DVec3::new(s, -1.0, -t),
        4 => DVec3::new(s, -t, 1.0),
        _ => DVec3::new(-s, -t, -1.0),
    }
}

/// Where in the map a direction lies, in texels.
fn place_of(direction: DVec3) -> DVec2 {
    let d = direction / direction.abs().element_sum();
    let folded = (1.0 - DVec2::new(d.y, d.x).abs()) * DVec2::new(1f64.copysign(d.x), 1f64.copysign(d.y));
    let square = if d.z < 0.0 { folded } else { d.truncate() };
    (square * 0.5 + 0.5) * EDGE as f64
}

/// The four texels whose middles are about a direction, and its bilinear weights.
fn texels_about(direction: DVec3) -> [(usize, f64); 4] {
    let place = place_of(direction) - 0.5;
    let (low, part) = (place.floor(), place - place.floor());
    [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| {
        let weight = |step: f64, part: f64| if step > 0.0 { part } else { 1.0 - part };
        (texel(low + DVec2::new(x, y)), weight(x, part.x) * weight(y, part.y))
    })
}

/// A texel by column and row; beyond an edge the map goes on turned by half about that edge's middle.
fn texel(place: DVec2) -> usize {
    let last = EDGE as f64 - 1.0;
    let DVec2 { mut x, mut y } = place;
    if !(0.0..=last).contains(&x) {
        (x, y) = (x.clamp(0.0, last), last - y);
    }
    if !(0.0..=last).contains(&y) {
        (x, y) = (last - x, y.clamp(0.0, last));
    }
    x as usize + EDGE * y as usize
}

/// The point of the octahedron |x| + |y| + |z| = 1 that a place of the square, -1 to 1, stands for.
fn octahedron(place: DVec2) -> DVec3 {
    let z = 1.0 - place.abs().element_sum();
    let folded =
        (1.0 - DVec2::new(place.y, place.x).abs()) * DVec2::new(1f64.copysign(place.x), 1f64.copysign(place.y));
    if z < 0.0 { folded.extend(z) } else { place.extend(z) }
}

/// Solid angle of a texel: two triangles, split as the octahedron is folded.
fn texel_angle(index: usize) -> f64 {
    let low = DVec2::new((index % EDGE) as f64, (index / EDGE) as f64) * 2.0 / EDGE as f64 - 1.0;
    let step = 2.0 / EDGE as f64;
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let [a, b, c, d] = corners.map(|(x, y)| octahedron(low + DVec2::new(x, y) * step).normalize());
    let middle = low + 0.5 * step;
    if middle.x * middle.y > 0.0 {
        triangle(a, b, d) + triangle(b, c, d)
    } else {
        triangle(a, b, c) + triangle(a, c, d)
    }
}

/// Solid angle of a triangle of unit vectors (van Oosterom and Strackee, The Solid Angle of a Plane Triangle, 1983).
fn triangle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// Shared-exponent RGB, rounded to nearest (EXT_texture_shared_exponent).
fn rgb9e5(color: DVec3) -> u32 {
    let color = color.min(DVec3::splat(65408.0));
    let largest = color.max_element().max(2f64.powi(-16));
    // The largest channel rounds to less than 512.
    let exponent = (largest * 512.0 / 511.5).log2().floor() as i32 + 1;
    let [r, g, b] = (color * 2f64.powi(9 - exponent)).round().to_array().map(|v| v as u32);
    r | g << 9 | b << 18 | ((exponent + 15) as u32) << 27
}

#[cfg(test)]
mod tests;
