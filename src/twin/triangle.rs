//! Twin of lib/triangles.wgsl: a triangle of a brick, and its columns.

use super::pack::{axis_u, axis_v};
use super::random::Errors;
use crate::gpu::shared::{MATERIAL_MASK, Material, NO_TEXTURE, TIE_SHIFT, TRANSLUCENT, TWO_SIDED};
use glam::{DVec2, DVec3, DVec4};

/// In brick space (voxels).
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    pub corners: [DVec3; 3],
    pub uvs: [DVec2; 3],
    pub normal: DVec3,
    pub material: usize,
    pub two_sided: bool,
    pub translucent: bool,
    /// What f32 may lose of the normal: slivers lose most.
    normal_error: f64,
}

impl Triangle {
    /// From the words that the shaders read.
    pub fn new(t: &[f32; 16]) -> Self {
        let w = t.map(f64::from);
        let corners = [DVec3::new(w[0], w[1], w[2]), DVec3::new(w[4], w[5], w[6]), DVec3::new(w[8], w[9], w[10])];
        let uvs = [DVec2::new(w[7], w[11]), DVec2::new(w[12], w[13]), DVec2::new(w[14], w[15])];
        let (e1, e2) = (corners[1] - corners[0], corners[2] - corners[0]);
        let cross = e1.cross(e2);
        let reach = 1.0 + corners.iter().map(|c| c.abs().max_element()).fold(0.0, f64::max);
        let lost = reach * (e1.length() + e2.length()) + e1.length() * e2.length();
        Self {
            corners,
            uvs,
            normal: cross.normalize_or_zero(),
            material: (t[3].to_bits() & MATERIAL_MASK) as usize,
            two_sided: t[3].to_bits() & TWO_SIDED != 0,
            translucent: t[3].to_bits() & TRANSLUCENT != 0,
            normal_error: 1e-7 + 2e-7 * lost / cross.length().max(1e-12),
        }
    }

    /// Moved so that `origin` is zero.
    pub fn moved(&self, origin: DVec3) -> Self {
        Self { corners: self.corners.map(|c| c - origin), ..*self }
    }

    /// What f32 may lose of a position.
    fn error(&self) -> f64 {
        2e-7 * (2.0 + self.corners.iter().map(|c| c.abs().max_element()).fold(0.0, f64::max))
    }

    /// Whether it may cross a column of the unit cube.
    pub fn is_near(&self) -> bool {
        let [a, b, c] = self.corners;
        a.min(b).min(c).cmple(DVec3::splat(1.01)).all() && a.max(b).max(c).cmpge(DVec3::splat(-0.01)).all()
    }

    /// Whether its outline along an axis holds a column; borders belong to both sides.
    pub fn holds(&self, axis: usize, column: DVec2, errors: &Errors) -> bool {
        let flat = self.corners.map(|c| DVec2::new(c[axis_u(axis)], c[axis_v(axis)]));
        let sign = if self.normal[axis] > 0.0 { 1.0 } else { -1.0 };
        (0..3).all(|k| {
            let (a, b) = (flat[k], flat[(k + 1) % 3]);
            let length = (b - a).abs().element_sum();
            errors.on((b - a).perp_dot(column - a) * sign, self.error() * length) >= -1e-5 * length
        })
    }

    /// Where it crosses a column.
    pub fn height(&self, axis: usize, column: DVec2, errors: &Errors) -> f64 {
        let n = self.normal;
        let height = (n.dot(self.corners[0]) - n[axis_u(axis)] * column.x - n[axis_v(axis)] * column.y) / n[axis];
        let reach = 1.0 + self.corners[0].abs().max_element();
        errors.on(height, (self.error() + self.normal_error * reach) / n[axis].abs())
    }

    /// Opposing parallel triangles in one plane: the contact of two solids.
    pub fn is_contact(&self, other: &Self, errors: &Errors) -> bool {
        let apart = self.normal.dot(other.corners[0] - self.corners[0]) - 2.0 * f64::from(TIE_SHIFT);
        let error = self.error() + self.normal_error * (other.corners[0] - self.corners[0]).length();
        !self.two_sided
            && !other.two_sided
            && errors.on(self.normal.dot(other.normal), self.normal_error + other.normal_error) < -0.9999
            && errors.on(apart, error).abs() < 5e-4
    }

    /// The material's colour at a point.
    pub fn albedo(&self, p: DVec3, materials: &[Material], texels: &[u32], errors: &Errors) -> DVec3 {
        let material = &materials[self.material];
        let base = DVec3::from(material.base_color.map(f64::from));
        let root = self.texel(p, material, texels, errors).truncate();
        (base * root * root).min(DVec3::splat(f64::from(0.95f32)))
    }

    /// Whether it stops the light of a column (x, y) at a point.
    pub fn stops(&self, [x, y]: [u32; 2], p: DVec3, materials: &[Material], texels: &[u32], errors: &Errors) -> bool {
        let material = &materials[self.material];
        let mut opacity = f64::from(material.opacity);
        if material.texture_alpha == 1 {
            opacity *= self.texel(p, material, texels, errors).w;
        }
        !self.translucent || errors.on(opacity * 256.0, 1e-4) > f64::from(dither_order(x, y, 4)) + 0.5
    }

    /// What the texture holds for a point: square roots of linear values, alpha.
    fn texel(&self, p: DVec3, material: &Material, texels: &[u32], errors: &Errors) -> DVec4 {
        if material.texture == NO_TEXTURE {
            return DVec4::ONE;
        }
        let [a, b, c] = self.corners;
        let n = (b - a).cross(c - a);
        let wb = (p - a).cross(c - a).dot(n) / n.length_squared();
        let wc = (b - a).cross(p - a).dot(n) / n.length_squared();
        let mut uv = self.uvs[0] * (1.0 - wb - wc) + self.uvs[1] * wb + self.uvs[2] * wc;
        let lost = self.error() + self.normal_error;
        uv = DVec2::new(errors.on(uv.x, lost), errors.on(uv.y, lost));
        let size = glam::UVec2::new(material.texture_size & 0xffff, material.texture_size >> 16);
        let texel = ((uv - uv.floor()) * size.as_dvec2()).as_uvec2().min(size - 1);
        let word = texels[(material.texture + texel.y * size.x + texel.x) as usize];
        DVec4::from(std::array::from_fn(|k| f64::from(word >> (8 * k) & 255) / 255.0))
    }
}

/// Of 4^bits places, when (x, y) is taken: the first of them are spread evenly (Bayer 1973).
pub fn dither_order(x: u32, y: u32, bits: u32) -> u32 {
    (0..bits).fold(0, |order, bit| order << 2 | ((x ^ y) >> bit & 1) << 1 | y >> bit & 1)
}
