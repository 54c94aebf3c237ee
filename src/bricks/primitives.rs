//! Which triangles touch which brick.

use super::Mask;
use crate::gpu::shared::{BatchBrick, NONE, REACH_WORDS, TIE_SHIFT, TWO_SIDED};
use crate::scene::{Instance, Mesh, Scene};
use glam::{DVec3, IVec3, Vec3};
use std::collections::{HashMap, HashSet};

/// Where the voxel grid lies in the world.
#[derive(Clone, Copy, Debug)]
pub struct WorldGrid {
    /// Metres.
    pub voxel_size: f64,
    /// Voxels.
    pub offset: DVec3,
}

impl WorldGrid {
    /// World metres to voxels.
    pub fn to_voxels(self, p: DVec3) -> DVec3 {
        p / self.voxel_size - self.offset
    }

    /// Voxels to world metres.
    pub fn to_world(self, p: DVec3) -> DVec3 {
        (p + self.offset) * self.voxel_size
    }
}

/// Voxels around a brick that also decide about its faces.
const REACH: f64 = 1.02;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Primitive {
    instance: u64,
    triangle: u32,
}

/// The per-brick primitive lists.
#[derive(Default)]
pub struct PrimitiveIndex {
    bricks: HashMap<IVec3, Vec<Primitive>>,
    touched: HashMap<u64, Vec<IVec3>>,
}

impl PrimitiveIndex {
    /// Takes an instance's triangles out; returns the bricks that held some.
    pub fn remove(&mut self, instance: u64) -> Vec<IVec3> {
        let bricks = self.touched.remove(&instance).unwrap_or_default();
        for brick in &bricks {
            if let Some(list) = self.bricks.get_mut(brick) {
                list.retain(|p| p.instance != instance);
                if list.is_empty() {
                    self.bricks.remove(brick);
                }
            }
        }
        bricks
    }

    /// Enters an instance's triangles; returns the bricks that they touch (or nearly touch).
    /// Only those inside the window (low corner and size, in bricks) count, which bounds work and memory.
    pub fn insert(&mut self, id: u64, scene: &Scene, grid: &WorldGrid, window: (IVec3, IVec3)) -> Vec<IVec3> {
        let Some(instance) = scene.instances.get(&id) else { return Vec::new() };
        let Some(mesh) = scene.meshes.get(&instance.mesh) else { return Vec::new() };
        let mut touched = HashSet::new();
        for triangle in 0..mesh.triangles.len() as u32 {
            let corners = voxel_corners(scene, instance, triangle, grid);
            let low = corners[0].min(corners[1]).min(corners[2]) - REACH;
            let high = corners[0].max(corners[1]).max(corners[2]) + REACH;
            let first = (low / 8.0).floor().as_ivec3().max(window.0);
            let last = (high / 8.0).floor().as_ivec3().min(window.0 + window.1 - 1);
            for z in first.z..=last.z {
                for y in first.y..=last.y {
                    for x in first.x..=last.x {
                        let brick = IVec3::new(x, y, z);
                        let center = brick.as_dvec3() * 8.0 + 4.0;
                        if overlaps_cube(corners.map(|c| (c - center).as_vec3()), (4.0 + REACH) as f32) {
                            self.bricks.entry(brick).or_default().push(Primitive { instance: id, triangle });
                            touched.insert(brick);
                        }
                    }
                }
            }
        }
        let touched: Vec<IVec3> = touched.into_iter().collect();
        self.touched.insert(id, touched.clone());
        touched
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.bricks.clear();
        self.touched.clear();
    }

    /// Whether a brick holds triangles.
    pub fn holds(&self, brick: IVec3) -> bool {
        self.bricks.contains_key(&brick)
    }

    /// Bricks that hold triangles.
    pub fn bricks(&self) -> impl Iterator<Item = IVec3> {
        self.bricks.keys().copied()
    }

    /// Lists a brick's triangles, and which of its faces may be lit, in `batch`. False if there are more than
    /// [`MAX_TRIANGLES`].
    pub fn triangles(
        &self,
        brick: IVec3,
        mask: Option<Mask>,
        scene: &Scene,
        grid: &WorldGrid,
        materials: &HashMap<u64, u32>,
        batch: &mut Batch,
    ) -> bool {
        let (first, group) = (batch.lists.len(), brick >> 2i32);
        let list = self.bricks.get(&brick).map_or(&[][..], Vec::as_slice);
        for p in list.iter().take(MAX_TRIANGLES) {
            let triangles = &mut batch.triangles;
            let index = *batch.known.entry((group, *p)).or_insert_with(|| {
                let words = group_triangle(p, group, scene, grid, materials)?;
                triangles.push(words);
                Some(triangles.len() as u32 - 1)
            });
            batch.lists.extend(index);
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
    known: HashMap<(IVec3, Primitive), Option<u32>>,
}

impl Batch {
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

/// A triangle in group space, moved into the solid by [`TIE_SHIFT`]: corners; texture coordinates; material and
/// sidedness. None: it has no area.
fn group_triangle(
    p: &Primitive,
    group: IVec3,
    scene: &Scene,
    grid: &WorldGrid,
    materials: &HashMap<u64, u32>,
) -> Option<[f32; 16]> {
    let instance = &scene.instances[&p.instance];
    let mesh = &scene.meshes[&instance.mesh];
    let origin = group.as_dvec3() * 32.0;
    let [a, b, c] = voxel_corners(scene, instance, p.triangle, grid).map(|c| c - origin);
    let normal = (b - a).cross(c - a).normalize_or_zero();
    if normal == DVec3::ZERO {
        return None;
    }
    let shift = normal * f64::from(TIE_SHIFT);
    let [a, b, c] = [a, b, c].map(|v| (v - shift).as_vec3());
    let two_sided = mesh.two_sided[p.triangle as usize];
    let material = materials[&instance.material] | if two_sided { TWO_SIDED } else { 0 };
    let uv = triangle_uvs(mesh, p.triangle);
    let m = f32::from_bits(material);
    Some([a.x, a.y, a.z, m, b.x, b.y, b.z, uv[0], c.x, c.y, c.z, uv[1], uv[2], uv[3], uv[4], uv[5]])
}

/// Triangles of one brick that are looked at; voxelisation packs their index into 16 bits.
pub const MAX_TRIANGLES: usize = 32_768;

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

fn voxel_corners(scene: &Scene, instance: &Instance, triangle: u32, grid: &WorldGrid) -> [DVec3; 3] {
    let mesh = &scene.meshes[&instance.mesh];
    let corners = mesh.triangles[triangle as usize].map(|i| mesh.positions[i as usize].as_dvec3());
    let placed = corners.map(|p| grid.to_voxels(instance.linear * p + instance.translation));
    // A mirrored instance keeps its outside.
    if instance.linear.determinant() < 0.0 { [placed[0], placed[2], placed[1]] } else { placed }
}

/// Separating axes of a triangle and a cube about the origin (Akenine-Moller 2001).
pub fn overlaps_cube(corners: [Vec3; 3], half: f32) -> bool {
    let [a, b, c] = corners;
    let separated = |axis: Vec3| {
        let (p, q, r) = (axis.dot(a), axis.dot(b), axis.dot(c));
        let reach = half * axis.abs().element_sum();
        p.min(q).min(r) > reach || p.max(q).max(r) < -reach
    };
    let edges = [b - a, c - b, a - c];
    let normal = edges[0].cross(edges[1]);
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    !(axes.into_iter().any(separated)
        || separated(normal)
        || edges.into_iter().any(|e| axes.into_iter().any(|x| separated(x.cross(e)))))
}
