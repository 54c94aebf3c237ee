//! The host's scene, copied and checked.

use super::clusters::Cluster;
use super::simplify::{Simplification, Triangles};
use super::{Light, MeshUpdate, ShadowMap, Sky, sheets};
use crate::error::{Error, Result};
use crate::settings::Settings;
use glam::{DMat3, DVec3, Vec2, Vec3};
use rustc_hash::{FxHashMap, FxHashSet};

/// A registered mesh.
#[derive(Debug, Default)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub triangles: Vec<[u32; 3]>,
    /// Per triangle: both sides are surface (it belongs to no closed body).
    pub two_sided: Vec<bool>,
    /// Of all triangles, once there is an instance.
    pub clusters: Vec<Cluster>,
    pub(super) simplification: Simplification,
}

/// A registered material.
#[derive(Clone, Copy, Debug)]
pub struct Material {
    pub base_color: Vec3,
    pub emission: Vec3,
    pub texture: Option<u64>,
    pub opacity: f32,
    pub texture_alpha: bool,
}

impl Material {
    /// Whether light comes through somewhere.
    pub fn is_translucent(&self) -> bool {
        self.opacity < 1.0 || self.texture_alpha && self.texture.is_some()
    }
}

/// A texture, reduced to what a voxel can see: at most [`Texture::MAX`] texels an edge.
#[derive(Debug)]
pub struct Texture {
    pub width: u32,
    pub height: u32,
    /// Square roots of linear values, and alpha, as RGBA8: squaring the former in the shader gives the linear value.
    pub texels: Vec<u32>,
}

/// A placed mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    pub mesh: u64,
    pub material: u64,
    pub linear: DMat3,
    pub translation: DVec3,
}

/// Everything the host said.
#[derive(Default)]
pub struct Scene {
    pub meshes: FxHashMap<u64, Mesh>,
    pub materials: FxHashMap<u64, Material>,
    pub textures: FxHashMap<u64, Texture>,
    pub instances: FxHashMap<u64, Instance>,
    /// By how much simplification may move surface, in metres; 0: not at all.
    pub tolerance: f64,
    /// Of all meshes.
    pub triangles: Triangles,
    pub lights: Vec<Light>,
    pub shadow_maps: Vec<ShadowMap>,
    pub sky: Sky,
    /// The texels of the sky's image, or none.
    pub sky_map: Vec<u32>,
    /// Of all textures.
    pub texel_bytes: u64,
    emission_max: f32,
    /// Materials and textures changed since the GPU's copy was made.
    pub materials_changed: bool,
}

fn finite<const N: usize>(values: &[f32; N], what: &str) -> Result<Vec3>
where
    [f32; N]: AsRef<[f32]>,
{
    if values.iter().all(|v| v.is_finite()) {
        Ok(Vec3::from_slice(values))
    } else {
        Err(Error::invalid(format!("{what} is not finite")))
    }
}

impl Scene {
    pub fn new(settings: &Settings) -> Self {
        Self { tolerance: f64::from(settings.simplify_voxels) * f64::from(settings.voxel_size), ..Self::default() }
    }

    /// The texels of the sky, if it is an image.
    pub fn sky_texels(&self) -> &[u32] {
        if matches!(self.sky, Sky::Image { .. }) { &self.sky_map } else { &[] }
    }

    /// Largest emission of any material, above zero.
    pub fn emission_max(&self) -> f32 {
        self.emission_max.max(1e-6)
    }

    /// Checks a whole batch before anything of it is applied.
    pub fn check(&self, update: &MeshUpdate) -> Result<()> {
        let given = Given::new(update);
        for id in update.removed_instances {
            self.instances.get(id).ok_or_else(|| Error::UnknownId(format!("instance {id}")))?;
        }
        for id in update.removed_meshes {
            self.meshes.get(id).ok_or_else(|| Error::UnknownId(format!("mesh {id}")))?;
        }
        if !update.removed_meshes.is_empty() {
            let removed: FxHashSet<u64> = update.removed_instances.iter().copied().collect();
            let mut left = self.instances.iter().filter(|(id, _)| !removed.contains(id));
            if let Some((user, Instance { mesh, .. })) = left.find(|(_, i)| given.removed_meshes.contains(&i.mesh)) {
                return Err(Error::invalid(format!("mesh {mesh} is still used by instance {user}")));
            }
        }
        for t in update.textures {
            if !(1..=16_384).contains(&t.width) || !(1..=16_384).contains(&t.height) {
                return Err(Error::invalid(format!("texture {}: sides must be 1 to 16384", t.id)));
            }
            if t.rgba8.len() as u64 != u64::from(t.width) * u64::from(t.height) * 4 {
                return Err(Error::invalid(format!("texture {}: rgba8 must hold width * height * 4 bytes", t.id)));
            }
        }
        for m in update.materials {
            finite(&m.base_color, &format!("material {}: base_color", m.id))?;
            let emission = finite(&m.emission, &format!("material {}: emission", m.id))?;
            if emission.min_element() < 0.0 || m.base_color.iter().any(|c| *c < 0.0) {
                return Err(Error::invalid(format!("material {}: colours must not be negative", m.id)));
            }
            if !(0.0..=1.0).contains(&m.transmittance) {
                return Err(Error::invalid(format!("material {}: transmittance must be 0 to 1", m.id)));
            }
            if let Some(t) = m.base_color_texture {
                let known = self.textures.contains_key(&t) || given.textures.contains(&t);
                known.then_some(()).ok_or_else(|| Error::UnknownId(format!("texture {t} of material {}", m.id)))?;
            }
        }
        update.meshes.iter().try_for_each(check_mesh)?;
        for m in update.buffer_meshes {
            m.arrays()?;
            if given.meshes.contains(&m.id) {
                return Err(Error::invalid(format!("mesh {} is given twice, in host memory and in buffers", m.id)));
            }
        }
        for i in update.instances {
            let mesh = self.meshes.contains_key(&i.mesh) && !given.removed_meshes.contains(&i.mesh)
                || given.meshes.contains(&i.mesh)
                || given.buffer_meshes.contains(&i.mesh);
            mesh.then_some(()).ok_or_else(|| Error::UnknownId(format!("mesh {} of instance {}", i.mesh, i.id)))?;
            let material = self.materials.contains_key(&i.material) || given.materials.contains(&i.material);
            material
                .then_some(())
                .ok_or_else(|| Error::UnknownId(format!("material {} of instance {}", i.material, i.id)))?;
            if !i.linear.iter().flatten().all(|v| v.is_finite()) || !i.translation.iter().all(|v| v.is_finite()) {
                return Err(Error::invalid(format!("instance {}: the transform is not finite", i.id)));
            }
        }
        Ok(())
    }

    /// Applies a checked batch. Returns the instances whose surface changed or went, by id, each once and in order.
    pub fn apply(&mut self, update: &MeshUpdate) -> Vec<u64> {
        let given = Given::new(update);
        let mut changed = update.removed_instances.to_vec();
        for id in update.removed_instances {
            self.instances.remove(id);
        }
        for id in update.removed_meshes {
            let gone = self.meshes.remove(id);
            gone.iter().for_each(|m| self.triangles.subtract(m));
        }
        for t in update.textures {
            self.textures.insert(t.id, Texture::reduced(t));
        }
        for m in update.materials {
            let material = Material {
                base_color: Vec3::from(m.base_color).clamp(Vec3::ZERO, Vec3::ONE),
                emission: Vec3::from(m.emission),
                texture: m.base_color_texture,
                opacity: 1.0 - m.transmittance,
                texture_alpha: m.texture_alpha,
            };
            self.materials.insert(m.id, material);
        }
        if !update.textures.is_empty() || !update.materials.is_empty() {
            self.materials_changed = true;
            self.texel_bytes = self.textures.values().map(|t| size_of_val(t.texels.as_slice()) as u64).sum();
            self.emission_max = self.materials.values().map(|m| m.emission.max_element()).fold(0.0, f32::max);
        }
        for m in update.meshes {
            let positions: Vec<Vec3> = m.positions.iter().map(|p| Vec3::from(*p)).collect();
            let triangles: Vec<[u32; 3]> = m.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
            let two_sided = sheets::two_sided(&positions, &triangles);
            let uvs = m.uvs.iter().map(|p| Vec2::from(*p)).collect();
            let mesh = Mesh { positions, uvs, triangles, two_sided, ..Mesh::default() };
            self.triangles.add(&mesh);
            let replaced = self.meshes.insert(m.id, mesh);
            replaced.iter().for_each(|m| self.triangles.subtract(m));
        }
        // Nothing until it has been read; what was there before stays so long.
        for m in update.buffer_meshes {
            self.meshes.entry(m.id).or_default();
        }
        for i in update.instances {
            let column = |k: usize| Vec3::from(i.linear[k]).as_dvec3();
            let instance = Instance {
                mesh: i.mesh,
                material: i.material,
                linear: DMat3::from_cols(column(0), column(1), column(2)),
                translation: DVec3::from(i.translation),
            };
            // What stays where it was costs nothing.
            if self.instances.insert(i.id, instance) != Some(instance) {
                changed.push(i.id);
            }
        }
        if !given.nothing_but_instances() {
            let textured =
                |m: &u64| self.materials.get(m).and_then(|m| m.texture).is_some_and(|t| given.textures.contains(&t));
            let touched = |i: &Instance| {
                given.meshes.contains(&i.mesh) || given.materials.contains(&i.material) || textured(&i.material)
            };
            changed.extend(self.instances.iter().filter(|(_, i)| touched(i)).map(|(id, _)| *id));
        }
        changed.extend(self.prepare(&changed));
        changed.sort_unstable();
        changed.dedup();
        changed
    }
}

/// The ids of an update.
struct Given {
    removed_meshes: FxHashSet<u64>,
    textures: FxHashSet<u64>,
    materials: FxHashSet<u64>,
    meshes: FxHashSet<u64>,
    buffer_meshes: FxHashSet<u64>,
}

impl Given {
    fn new(update: &MeshUpdate) -> Self {
        Self {
            removed_meshes: update.removed_meshes.iter().copied().collect(),
            textures: update.textures.iter().map(|t| t.id).collect(),
            materials: update.materials.iter().map(|m| m.id).collect(),
            meshes: update.meshes.iter().map(|m| m.id).collect(),
            buffer_meshes: update.buffer_meshes.iter().map(|m| m.id).collect(),
        }
    }

    fn nothing_but_instances(&self) -> bool {
        self.textures.is_empty() && self.materials.is_empty() && self.meshes.is_empty()
    }
}

fn check_mesh(m: &super::MeshDesc) -> Result<()> {
    let name = |text: &str| Error::invalid(format!("mesh {}: {text}", m.id));
    if !m.indices.len().is_multiple_of(3) {
        return Err(name("indices must be three per triangle"));
    }
    if !m.uvs.is_empty() && m.uvs.len() != m.positions.len() {
        return Err(name("uvs must be empty or one per position"));
    }
    if m.indices.iter().any(|i| *i as usize >= m.positions.len()) {
        return Err(name("an index is out of range"));
    }
    if !m.positions.iter().flatten().all(|v| v.is_finite()) {
        return Err(name("a position is not finite"));
    }
    if !m.uvs.iter().flatten().all(|v| v.is_finite()) {
        return Err(name("a texture coordinate is not finite"));
    }
    Ok(())
}

impl Texture {
    /// Texels an edge that a voxel can tell apart at most.
    pub const MAX: u32 = 64;

    fn reduced(t: &super::TextureDesc) -> Self {
        let (width, height) = (t.width.min(Self::MAX), t.height.min(Self::MAX));
        let linear: Vec<f32> = (0..=255u8).map(srgb_to_linear).collect();
        let span = |i: u32, of: u32, n: u32| (u64::from(i) * u64::from(of) / u64::from(n)) as u32;
        let mut texels = Vec::with_capacity((width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                let (mut sum, mut alpha, mut count) = (Vec3::ZERO, 0.0, 0.0);
                for v in span(y, t.height, height)..span(y + 1, t.height, height) {
                    for u in span(x, t.width, width)..span(x + 1, t.width, width) {
                        let at = (v as usize * t.width as usize + u as usize) * 4;
                        sum += Vec3::from_array([0, 1, 2].map(|c| linear[t.rgba8[at + c] as usize]));
                        alpha += f32::from(t.rgba8[at + 3]);
                        count += 1.0;
                    }
                }
                let [r, g, b] = (sum / count).to_array().map(|v| (v.sqrt() * 255.0).round() as u32);
                texels.push(r | g << 8 | b << 16 | ((alpha / count).round() as u32) << 24);
            }
        }
        Self { width, height, texels }
    }
}

fn srgb_to_linear(value: u8) -> f32 {
    let v = f32::from(value) / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{InstanceDesc, MaterialDesc, MeshDesc};

    fn instance(id: u64, x: f64) -> InstanceDesc {
        let linear = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        InstanceDesc { id, mesh: id % 2, material: id % 3, linear, translation: [x, 0.0, 0.0] }
    }

    #[test]
    fn only_what_changes_counts() {
        let mut scene = Scene::default();
        let mesh = |id| MeshDesc { id, positions: &[[0.0; 3]], uvs: &[], indices: &[0, 0, 0] };
        let material = |id| MaterialDesc { id, base_color: [0.5; 3], ..MaterialDesc::default() };
        let instances: Vec<_> = (0..6).rev().map(|id| instance(id, 0.0)).collect();
        let (meshes, materials) = ([0, 1].map(mesh), [0, 1, 2].map(material));
        let all = MeshUpdate { meshes: &meshes, materials: &materials, instances: &instances, ..MeshUpdate::default() };
        assert_eq!(scene.apply(&all), [0, 1, 2, 3, 4, 5]);
        let same = MeshUpdate { instances: &instances, ..MeshUpdate::default() };
        assert_eq!(scene.apply(&same), [0; 0], "what is where it was has not changed");
        let moved = [instance(4, 0.0), instance(2, 1.0), instance(5, 0.0)];
        assert_eq!(scene.apply(&MeshUpdate { instances: &moved, removed_instances: &[5, 1], ..same }), [1, 2, 5]);
        assert_eq!(scene.apply(&MeshUpdate { meshes: &meshes[..1], ..MeshUpdate::default() }), [0, 2, 4]);
        assert_eq!(scene.apply(&MeshUpdate { materials: &materials[2..], ..MeshUpdate::default() }), [2, 5]);
    }
}
