//! What is uploaded of bricks that are to be voxelised.

use super::{Primitive, PrimitiveIndex, WorldGrid, place};
use crate::bricks::Mask;
use crate::gpu::shared::{BatchBrick, NONE, REACH_WORDS, TIE_SHIFT, TRANSLUCENT, TWO_SIDED};
use crate::scene::{Instance, Mesh, Scene};
use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;

/// Triangles of one brick that are looked at; voxelisation packs their index into 16 bits.
pub const MAX_TRIANGLES: usize = 32_768;

/// Bricks to be voxelised, as `lib/triangles.wgsl` reads them. Bricks of a group share their triangles.
#[derive(Default)]
pub struct Batch {
    pub bricks: Vec<BatchBrick>,
    /// Indices of triangles.
    pub lists: Vec<u32>,
    /// In group space.
    pub triangles: Vec<[f32; 16]>,
    /// Of the bricks that have one.
    pub masks: Vec<Mask>,
    /// Where a group's triangle stands; None: it has no area.
    known: FxHashMap<(IVec3, Primitive), Option<u32>>,
}

impl Batch {
    /// Empties it; its memory stays.
    pub fn clear(&mut self) {
        self.bricks.clear();
        self.lists.clear();
        self.triangles.clear();
        self.masks.clear();
        self.known.clear();
    }

    /// Bytes to upload.
    pub fn bytes(&self) -> u64 {
        let [bricks, lists] = [size_of_val(&self.bricks[..]), size_of_val(&self.lists[..])];
        let [triangles, masks] = [size_of_val(&self.triangles[..]), size_of_val(&self.masks[..])];
        (bricks + lists + triangles + masks) as u64
    }

    /// Takes the last brick out again; `triangles`: how many there were before.
    pub fn drop_last(&mut self, triangles: usize) {
        if let Some(brick) = self.bricks.pop() {
            self.lists.truncate(brick.first_triangle as usize);
            if brick.reach != NONE {
                self.masks.pop();
            }
            self.triangles.truncate(triangles);
            self.known.retain(|_, index| index.is_none_or(|i| (i as usize) < triangles));
        }
    }
}

/// An instance as seen from a group.
struct Source<'a> {
    instance: &'a Instance,
    mesh: &'a Mesh,
    grid: &'a WorldGrid,
    /// The group's low corner in voxels.
    origin: DVec3,
    material: u32,
    mirrored: bool,
}

impl<'a> Source<'a> {
    fn new(
        instance: &'a Instance,
        scene: &'a Scene,
        grid: &'a WorldGrid,
        group: IVec3,
        materials: &FxHashMap<u64, u32>,
    ) -> Self {
        let origin = group.as_dvec3() * 32.0;
        let (mesh, material) = (&scene.meshes[&instance.mesh], &scene.materials[&instance.material]);
        let flag = if material.is_translucent() { TRANSLUCENT } else { 0 };
        let material = materials[&instance.material] | flag;
        Self { instance, mesh, grid, origin, material, mirrored: instance.linear.determinant() < 0.0 }
    }

    /// A triangle in group space, moved into the solid by [`TIE_SHIFT`]: corners; texture coordinates; material and
    /// sidedness. None: it has no area.
    fn triangle(&self, triangle: u32) -> Option<[f32; 16]> {
        let corners = self.mesh.triangles[triangle as usize].map(|i| self.mesh.positions[i as usize]);
        let [a, b, c] = corners.map(|p| place(p, self.instance, self.grid) - self.origin);
        // A mirrored instance keeps its outside.
        let [a, b, c] = if self.mirrored { [a, c, b] } else { [a, b, c] };
        let normal = (b - a).cross(c - a).normalize_or_zero();
        if normal == DVec3::ZERO {
            return None;
        }
        let shift = normal * f64::from(TIE_SHIFT);
        let [a, b, c] = [a, b, c].map(|v| (v - shift).as_vec3());
        let two_sided = self.mesh.two_sided[triangle as usize];
        let uv = triangle_uvs(self.mesh, triangle);
        let m = f32::from_bits(self.material | if two_sided { TWO_SIDED } else { 0 });
        Some([a.x, a.y, a.z, m, b.x, b.y, b.z, uv[0], c.x, c.y, c.z, uv[1], uv[2], uv[3], uv[4], uv[5]])
    }
}

impl PrimitiveIndex {
    /// Lists a brick's triangles, and which of its faces may be lit, in `batch`. False if there are more than
    /// [`MAX_TRIANGLES`].
    pub fn triangles(
        &self,
        brick: IVec3,
        mask: Option<Mask>,
        scene: &Scene,
        grid: &WorldGrid,
        materials: &FxHashMap<u64, u32>,
        batch: &mut Batch,
    ) -> bool {
        let (first, group) = (batch.lists.len(), brick >> 2i32);
        let list = self.bricks.get(&brick).map_or(&[][..], Vec::as_slice);
        let looked_at = &list[..list.len().min(MAX_TRIANGLES)];
        for run in looked_at.chunk_by(|a, b| a.instance == b.instance) {
            let instance = &scene.instances[&self.placed[run[0].instance as usize].id];
            let source = Source::new(instance, scene, grid, group, materials);
            for p in run {
                let triangles = &mut batch.triangles;
                let index = *batch.known.entry((group, *p)).or_insert_with(|| {
                    let words = source.triangle(p.triangle)?;
                    triangles.push(words);
                    Some(triangles.len() as u32 - 1)
                });
                batch.lists.extend(index);
            }
        }
        let place = (brick & 3i32).as_uvec3();
        batch.bricks.push(BatchBrick {
            first_triangle: first as u32,
            triangle_count: (batch.lists.len() - first) as u32,
            seed: brick.to_array().iter().fold(0u32, |h, v| (h ^ *v as u32).wrapping_mul(0x9e37_79b1)),
            place: place.x | place.y << 2 | place.z << 4,
            reach: mask.map_or(NONE, |_| batch.masks.len() as u32 * REACH_WORDS),
        });
        batch.masks.extend(mask);
        list.len() <= MAX_TRIANGLES
    }
}

fn triangle_uvs(mesh: &Mesh, triangle: u32) -> [f32; 6] {
    if mesh.uvs.is_empty() {
        return [0.0; 6];
    }
    let [a, b, c] = mesh.triangles[triangle as usize].map(|i| mesh.uvs[i as usize]);
    // Repeats are the same anywhere: near zero, floats are finest.
    let base = a.min(b).min(c).floor();
    let [a, b, c] = [a, b, c].map(|v| v - base);
    [a.x, a.y, b.x, b.y, c.x, c.y]
}
