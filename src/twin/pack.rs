//! Twin of lib/pack.wgsl.

use crate::gpu::shared::{PLANE_NORMAL_STEPS, PLANE_OFFSET_RANGE, PLANE_OFFSET_STEPS};
use glam::{DVec3, IVec3, Vec3};

const NORMAL_STEPS: f64 = PLANE_NORMAL_STEPS as f64;
const OFFSET_STEPS: f64 = PLANE_OFFSET_STEPS as f64;
/// As f32: the shader's constant is the nearest one to 0.87.
const OFFSET_RANGE: f64 = PLANE_OFFSET_RANGE as f64;

/// First in-plane axis.
pub fn axis_u(axis: usize) -> usize {
    (axis + 1) % 3
}

/// Second in-plane axis.
pub fn axis_v(axis: usize) -> usize {
    (axis + 2) % 3
}

/// -1 or 1.
pub fn side_sign(side: usize) -> f64 {
    if side & 1 == 1 { 1.0 } else { -1.0 }
}

/// Outward, in voxels.
pub fn side_step(side: usize) -> IVec3 {
    IVec3::AXES[side >> 1] * if side & 1 == 1 { 1 } else { -1 }
}

/// A plane in the voxel's unit cube: n.p = offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    pub normal: DVec3,
    pub offset: f64,
}

impl Plane {
    /// Signed distance, positive in front.
    pub fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

/// Hemi-octahedral normal about a side's axis and offset about the voxel's centre, stepped inward where the plane
/// would leave the voxel at `centroid`.
pub fn plane_encode(side: usize, normal: DVec3, centroid: DVec3) -> u32 {
    let axis = side >> 1;
    let sign = side_sign(side);
    let (nu, nv) = (normal[axis_u(axis)], normal[axis_v(axis)]);
    let sum = nu.abs() + nv.abs() + (normal[axis] * sign).max(1e-3);
    let quantise = |x: f64| ((x / sum * NORMAL_STEPS).round_ties_even() + NORMAL_STEPS) as u32;
    let word = quantise(nu + nv) | quantise(nu - nv) << 10;
    let n = plane_normal(side, word);
    let exact = n.dot(centroid - 0.5);
    let mut o = (exact / OFFSET_RANGE * OFFSET_STEPS).round_ties_even();
    for _ in 0..2 {
        let x = centroid[axis] + (o * (OFFSET_RANGE / OFFSET_STEPS) - exact) / n[axis];
        if x > 0.9985 {
            o -= sign;
        } else if x < 0.0015 {
            o += sign;
        }
    }
    word | ((o.clamp(-OFFSET_STEPS, OFFSET_STEPS) + OFFSET_STEPS) as u32) << 20
}

fn plane_normal(side: usize, word: u32) -> DVec3 {
    let axis = side >> 1;
    let p = f64::from(word & 1023) / NORMAL_STEPS - 1.0;
    let q = f64::from(word >> 10 & 1023) / NORMAL_STEPS - 1.0;
    let (u, v) = ((p + q) * 0.5, (p - q) * 0.5);
    let mut n = DVec3::ZERO;
    n[axis] = (1.0 - u.abs() - v.abs()).max(0.02) * side_sign(side);
    n[axis_u(axis)] = u;
    n[axis_v(axis)] = v;
    n.normalize()
}

/// The plane of a word.
pub fn plane_decode(side: usize, word: u32) -> Plane {
    let normal = plane_normal(side, word);
    let offset = (f64::from(word >> 20) - OFFSET_STEPS) * (OFFSET_RANGE / OFFSET_STEPS);
    Plane { normal, offset: offset + 0.5 * normal.element_sum() }
}

/// Bit of the 4 x 4 coverage mask at a point of the unit cube.
pub fn mask_bit(axis: usize, p: DVec3) -> u32 {
    let cell = |x: f64| (x * 4.0).clamp(0.0, 3.0) as u32;
    cell(p[axis_v(axis)]) * 4 + cell(p[axis_u(axis)])
}

/// Shared-exponent RGB. `rounding`: 0.5 for nearest.
pub fn rgb9e5_encode(color: Vec3, rounding: Vec3) -> u32 {
    let c = color.clamp(Vec3::ZERO, Vec3::splat(65408.0));
    let largest = c.max_element();
    if largest.is_nan() || largest <= 1e-9 {
        return 0;
    }
    let mut exponent = ((largest.to_bits() >> 23) as i32 - 111).clamp(0, 31);
    let scale = 2f32.powi(24 - exponent);
    let mut m = (c * scale + rounding).as_uvec3();
    if m.max_element() > 511 && exponent < 31 {
        exponent += 1;
        m = (c * scale * 0.5 + rounding).as_uvec3();
    }
    let m = m.min(glam::UVec3::splat(511));
    m.x | m.y << 9 | m.z << 18 | (exponent as u32) << 27
}

/// The colour of a word: mantissas times 2^(exponent - 24).
pub fn rgb9e5_decode(word: u32) -> Vec3 {
    let scale = 2f32.powi((word >> 27) as i32 - 24);
    Vec3::new((word & 511) as f32, (word >> 9 & 511) as f32, (word >> 18 & 511) as f32) * scale
}

const ALBEDO_LEVELS: [f64; 3] = [31.0, 63.0, 31.0];

/// RGB565 of the square root, rounded up where the linear share of the way exceeds `dither`.
pub fn albedo_encode(albedo: DVec3, dither: DVec3) -> u16 {
    let q: [u16; 3] = std::array::from_fn(|k| {
        let (a, levels) = (albedo[k].clamp(0.0, 1.0), ALBEDO_LEVELS[k]);
        let low = (a.sqrt() * levels).floor().min(levels - 1.0);
        let (low2, high2) = ((low / levels).powi(2), ((low + 1.0) / levels).powi(2));
        let up = (a - low2) / (high2 - low2) > dither[k];
        low as u16 + u16::from(up)
    });
    q[0] | q[1] << 5 | q[2] << 11
}

/// Quantised square roots of a word's channels.
pub fn albedo_levels(word: u16) -> [u16; 3] {
    [word & 31, word >> 5 & 63, word >> 11 & 31]
}

/// The albedo of a word.
pub fn albedo_decode(word: u16) -> DVec3 {
    let q = albedo_levels(word);
    DVec3::from_array(std::array::from_fn(|k| (f64::from(q[k]) / ALBEDO_LEVELS[k]).powi(2)))
}

const FINE_LEVELS: [f64; 3] = [2047.0, 2047.0, 1023.0];

/// RGB 11 11 10 of the square root, to the nearest.
pub fn fine_albedo_encode(albedo: DVec3) -> u32 {
    let q = |k: usize| (albedo[k].clamp(0.0, 1.0).sqrt() * FINE_LEVELS[k]).round_ties_even() as u32;
    q(0) | q(1) << 11 | q(2) << 22
}

/// Quantised square roots of a fine word's channels.
pub fn fine_albedo_levels(word: u32) -> [u32; 3] {
    [word & 2047, word >> 11 & 2047, word >> 22]
}

/// The albedo of a fine word.
pub fn fine_albedo_decode(word: u32) -> DVec3 {
    let q = fine_albedo_levels(word);
    DVec3::from_array(std::array::from_fn(|k| (f64::from(q[k]) / FINE_LEVELS[k]).powi(2)))
}
