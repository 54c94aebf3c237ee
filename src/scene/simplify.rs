//! Fewer triangles where voxels cannot tell.
//!
//! Edge collapses with quadric errors (Garland and Heckbert 1997, by meshoptimizer), to a tolerance in voxels. What must
//! not move does not: open borders, where meshes meet; corners of texture seams and of creases; vertices between more
//! than two sheets. Seams and creases shorten along themselves. Solids keep their thickness: where the two sides of a
//! wall came together, neither would be left.

use super::clusters::is_bounded;
use super::sheets::{self, Sets};
use super::store::{Mesh, Scene};
use glam::{DMat3, DVec3, Vec2, Vec3};
use meshopt::{SimplifyOptions, VertexDataAdapter};
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// Meshes of fewer triangles, and parts of meshes, stay as they are.
const DENSE: usize = 64;
/// A simplification that leaves more than this share is not worth a second copy of the mesh.
const WORTHWHILE: f64 = 0.75;
/// Of a solid's thickness, the tolerance is at most this share.
const THICKNESS_SHARE: f64 = 1.0 / 16.0;
/// Cosine between the normals of two triangles at a crease.
const CREASE: f32 = 0.5;
/// Length in tolerances along which a texture may shift by one.
const TEXTURE_REACH: f64 = 4.0;

/// How far a mesh has been simplified.
#[derive(Debug, Default)]
pub struct Simplification {
    /// Largest scale of an instance that it will do for; 0: none has come yet.
    scale: f64,
    /// What the host handed over, where fewer triangles are kept.
    original: Option<Box<Geometry>>,
}

#[derive(Debug, Default)]
struct Geometry {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
    two_sided: Vec<bool>,
}

/// Triangles of all meshes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Triangles {
    /// Handed over by the host.
    pub given: u64,
    /// Left by simplification.
    pub kept: u64,
}

impl Triangles {
    pub fn add(&mut self, mesh: &Mesh) {
        self.given += mesh.given() as u64;
        self.kept += mesh.triangles.len() as u64;
    }

    pub fn subtract(&mut self, mesh: &Mesh) {
        self.given -= mesh.given() as u64;
        self.kept -= mesh.triangles.len() as u64;
    }
}

impl Scene {
    /// Simplifies the meshes of changed instances to what their scales allow, and makes their clusters. Returns the
    /// instances of the meshes that have become others.
    pub(super) fn prepare(&mut self, changed: &[u64]) -> Vec<u64> {
        let mut scales = FxHashMap::<u64, f64>::default();
        for instance in changed.iter().filter_map(|id| self.instances.get(id)) {
            let scale = scales.entry(instance.mesh).or_default();
            *scale = scale.max(largest_scale(&instance.linear));
        }
        scales.retain(|id, scale| {
            let Some(mesh) = self.meshes.get_mut(id) else { return false };
            let mut redone = false;
            if self.tolerance > 0.0 && mesh.simplification.scale < *scale {
                self.triangles.subtract(mesh);
                redone = mesh.simplify(*scale, self.tolerance);
                self.triangles.add(mesh);
            }
            mesh.cluster();
            redone
        });
        if scales.is_empty() {
            return Vec::new();
        }
        self.instances.iter().filter(|(_, i)| scales.contains_key(&i.mesh)).map(|(id, _)| *id).collect()
    }
}

/// A bound of the largest singular value, exact for rotations and uniform scales: the root of the norm of A^T A.
fn largest_scale(linear: &DMat3) -> f64 {
    let square = linear.transpose() * *linear;
    // A turned instance has the scale of one that is not.
    let rounding = 1.0 - 1e-6;
    square.to_cols_array_2d().iter().map(|c| c.iter().map(|v| v.abs()).sum()).fold(0.0, f64::max).sqrt() * rounding
}

impl Mesh {
    /// Triangles that the host handed over.
    fn given(&self) -> usize {
        self.simplification.original.as_ref().map_or(self.triangles.len(), |o| o.triangles.len())
    }

    /// Simplifies it for instances of at most `scale`; `tolerance` in world metres. False: it stays as it is. A mesh that
    /// has been simplified before is done anew for twice the scale at least, so that a growing instance costs few turns.
    fn simplify(&mut self, scale: f64, tolerance: f64) -> bool {
        let before = self.simplification.scale;
        let again = self.simplification.original.is_some();
        self.simplification.scale = f64::INFINITY;
        if self.given() < DENSE || !is_bounded(&self.positions) {
            return false;
        }
        let original = match self.simplification.original.take() {
            Some(original) => *original,
            None => Geometry {
                positions: std::mem::take(&mut self.positions),
                uvs: std::mem::take(&mut self.uvs),
                triangles: std::mem::take(&mut self.triangles),
                two_sided: std::mem::take(&mut self.two_sided),
            },
        };
        let scale = if again { scale.max(2.0 * before) } else { scale };
        let simplified = original.simplified(tolerance / scale);
        let worthwhile = (simplified.triangles.len() as f64) < WORTHWHILE * original.triangles.len() as f64;
        let Geometry { positions, uvs, triangles, two_sided } = if worthwhile {
            self.simplification = Simplification { scale, original: Some(Box::new(original)) };
            simplified
        } else {
            original
        };
        let simplification = std::mem::take(&mut self.simplification);
        *self = Self { positions, uvs, triangles, two_sided, clusters: Vec::new(), simplification };
        worthwhile || again
    }
}

impl Geometry {
    /// Simplified to a tolerance in the mesh's own units.
    fn simplified(&self, tolerance: f64) -> Self {
        let welded = sheets::weld(&self.positions);
        let mut parts = BTreeMap::<_, Vec<u32>>::new();
        for (triangle, halvings) in (0..).zip(self.halvings(&welded, tolerance)) {
            parts.entry((self.two_sided[triangle as usize], halvings)).or_default().push(triangle);
        }
        let wedges = self.wedges(&welded);
        let (mut triangles, mut two_sided) = (Vec::new(), Vec::new());
        for ((sheet, halvings), part) in parts {
            match halvings {
                Some(halvings) if part.len() >= DENSE => {
                    let tolerance = tolerance * (-f64::from(halvings)).exp2();
                    triangles.extend(self.simplified_part(&part, &wedges, tolerance));
                }
                _ => triangles.extend(part.iter().map(|t| self.triangles[*t as usize])),
            }
            two_sided.resize(triangles.len(), sheet);
        }
        self.with(triangles, two_sided)
    }

    /// How often the tolerance must be halved for each triangle, so that its solid keeps its thickness. None: it has none.
    fn halvings(&self, welded: &[u32], tolerance: f64) -> Vec<Option<u32>> {
        let bodies = sheets::bodies(welded, &self.triangles);
        // Twice the area and six times the volume.
        let mut sizes = FxHashMap::<u32, (f64, f64, DVec3)>::default();
        for (triangle, body) in self.triangles.iter().zip(&bodies) {
            let [a, b, c] = triangle.map(|i| self.positions[i as usize].as_dvec3());
            let size = sizes.entry(*body).or_insert((0.0, 0.0, a));
            size.0 += (b - a).cross(c - a).length();
            size.1 += (a - size.2).dot((b - size.2).cross(c - size.2));
        }
        let halvings = |(body, two_sided): (u32, bool)| {
            let (area2, volume6, _) = sizes[&body];
            // A plate's: twice its volume over its area.
            let thickness = if two_sided { f64::INFINITY } else { (2.0 / 3.0) * volume6.abs() / area2 };
            let limit = THICKNESS_SHARE * thickness;
            (limit > 1e-6 * tolerance).then(|| (tolerance / limit).log2().ceil().max(0.0) as u32)
        };
        bodies.into_iter().zip(self.two_sided.iter().copied()).map(halvings).collect()
    }

    /// For each corner the first one of its wedge: of those about a vertex that are joined across edges which are
    /// neither creases nor seams.
    fn wedges(&self, at: &[u32]) -> Vec<u32> {
        let normal = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| self.positions[i as usize]);
            (b - a).cross(c - a).normalize_or_zero()
        };
        let normals: Vec<Vec3> = self.triangles.iter().map(normal).collect();
        // Each edge with the corner where it starts.
        let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * self.triangles.len());
        for (first, t) in (0..).step_by(3).zip(&self.triangles) {
            for k in 0..3 {
                let (from, to) = (at[t[k] as usize], at[t[(k + 1) % 3] as usize]);
                edges.push(([from.min(to), from.max(to)], first + k as u32));
            }
        }
        edges.sort_unstable();
        let mut wedges = Sets::new(edges.len());
        let vertex = |corner: u32| self.triangles[corner as usize / 3][corner as usize % 3] as usize;
        let next = |corner: u32| if corner % 3 == 2 { corner - 2 } else { corner + 1 };
        let uv = |corner: u32| self.uvs.get(vertex(corner)).map(|uv| uv.to_array().map(f32::to_bits));
        for shared in edges.chunk_by(|a, b| a.0 == b.0) {
            let &[(_, a), (_, b)] = shared else { continue };
            let opposed = at[vertex(a)] != at[vertex(b)];
            if opposed && normals[a as usize / 3].dot(normals[b as usize / 3]) > CREASE {
                for (p, q) in [(a, next(b)), (next(a), b)] {
                    if uv(p) == uv(q) {
                        wedges.join(p, q);
                    }
                }
            }
        }
        (0..edges.len() as u32).map(|corner| wedges.root(corner)).collect()
    }

    /// Some of the triangles, simplified.
    fn simplified_part(&self, part: &[u32], wedges: &[u32], tolerance: f64) -> Vec<[u32; 3]> {
        let (mut place, mut vertices, mut indices) = (FxHashMap::default(), Vec::new(), Vec::new());
        for corner in part.iter().flat_map(|t| 3 * t..3 * t + 3) {
            indices.push(*place.entry(wedges[corner as usize]).or_insert_with(|| {
                vertices.push(self.triangles[corner as usize / 3][corner as usize % 3]);
                vertices.len() as u32 - 1
            }));
        }
        let positions: Vec<Vec3> = vertices.iter().map(|v| self.positions[*v as usize]).collect();
        let uvs: Vec<Vec2> = vertices.iter().filter_map(|v| self.uvs.get(*v as usize)).copied().collect();
        let weight = self.texture_weight(part, tolerance);
        let weights = if uvs.is_empty() { &[][..] } else { &[weight; 2] };
        let adapter = VertexDataAdapter::new(bytemuck::cast_slice(&positions), size_of::<Vec3>(), 0);
        let kept = meshopt::simplify_with_attributes_and_locks(
            &indices,
            &adapter.expect("whole vertices"),
            bytemuck::cast_slice(&uvs),
            weights,
            size_of_val(weights),
            &vec![false; positions.len()],
            0,
            tolerance as f32,
            SimplifyOptions::LockBorder | SimplifyOptions::ErrorAbsolute,
            None,
        );
        kept.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|i| vertices[i as usize])).collect()
    }

    /// Weight at which a texture's shift by the tolerance, along [`TEXTURE_REACH`] of it, counts as the tolerance.
    fn texture_weight(&self, part: &[u32], tolerance: f64) -> f32 {
        let (mut area, mut uv_area) = (0.0, 0.0);
        for t in part.iter().map(|t| self.triangles[*t as usize]).filter(|_| !self.uvs.is_empty()) {
            let [a, b, c] = t.map(|i| self.positions[i as usize].as_dvec3());
            let [p, q, r] = t.map(|i| self.uvs[i as usize].as_dvec2());
            area += (b - a).cross(c - a).length();
            uv_area += (q - p).perp_dot(r - p).abs();
        }
        let uv_per_unit = (uv_area / area).sqrt();
        let weight = 1.0 / (TEXTURE_REACH * tolerance * uv_per_unit);
        if weight.is_finite() { weight as f32 } else { 0.0 }
    }

    /// Other triangles over the same vertices; those that none uses are left out.
    fn with(&self, mut triangles: Vec<[u32; 3]>, two_sided: Vec<bool>) -> Self {
        let (mut place, mut kept) = (vec![u32::MAX; self.positions.len()], Vec::new());
        for index in triangles.iter_mut().flatten() {
            let place = &mut place[*index as usize];
            if *place == u32::MAX {
                *place = kept.len() as u32;
                kept.push(*index as usize);
            }
            *index = *place;
        }
        let positions = kept.iter().map(|v| self.positions[*v]).collect();
        let uvs = kept.iter().filter_map(|v| self.uvs.get(*v)).copied().collect();
        Self { positions, uvs, triangles, two_sided }
    }
}

#[cfg(test)]
mod tests;
