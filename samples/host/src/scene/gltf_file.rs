//! glTF: nodes, primitives, materials, punctual lights and cameras.

use super::{Instance, Light, Material, Mesh, Scene, SceneCamera, gltf_texture};
use crate::error::{Error, Result};
use glam::{DMat4, DVec3};
use gltf::{camera::Projection, khr_lights_punctual::Kind, mesh::Mode};
use std::collections::HashMap;
use std::path::Path;

/// Loads a `.glb` or `.gltf` with its buffers and base-colour images.
pub(super) fn load(path: &Path) -> Result<Scene> {
    let bytes = std::fs::read(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&bytes).map_err(|e| Error::scene(path, e))?;
    let base = path.parent();
    let buffers = gltf::import_buffers(&document, base, blob).map_err(|e| Error::scene(path, e))?;
    let stem = path.file_stem().and_then(|s| s.to_str()).unwrap_or("scene");
    let mut loader = Loader { path, buffers: &buffers, scene: Scene::default(), primitives: HashMap::new() };
    loader.scene.name = stem.to_owned();
    loader.materials(&document, base)?;
    let root = document.default_scene().or_else(|| document.scenes().next());
    let root = root.ok_or_else(|| Error::scene(path, "the glTF file has no scene"))?;
    for node in root.nodes() {
        loader.node(&node, DMat4::IDENTITY)?;
    }
    Ok(loader.scene)
}

struct Loader<'a> {
    path: &'a Path,
    buffers: &'a [gltf::buffer::Data],
    scene: Scene,
    /// (glTF mesh, primitive) to the index in `scene.meshes`.
    primitives: HashMap<(usize, usize), usize>,
}

impl Loader<'_> {
    /// All materials in the file's order, then the default one; textures are shared by image.
    fn materials(&mut self, document: &gltf::Document, base: Option<&Path>) -> Result<()> {
        let mut images = HashMap::new();
        for material in document.materials() {
            let pbr = material.pbr_metallic_roughness();
            let texture = match pbr.base_color_texture() {
                Some(info) => Some(self.texture(&info.texture().source(), base, &mut images)?),
                None => None,
            };
            let [r, g, b, _] = pbr.base_color_factor();
            let strength = material.emissive_strength().unwrap_or(1.0);
            let emission = material.emissive_factor().map(|v| v * strength);
            if material.alpha_mode() != gltf::material::AlphaMode::Opaque {
                self.scene.warnings.push(format!("material {:?} is drawn opaque", material.name().unwrap_or("")));
            }
            self.scene.materials.push(Material { base_color: [r, g, b], emission, texture });
        }
        self.scene.materials.push(Material { base_color: [0.8; 3], emission: [0.0; 3], texture: None });
        Ok(())
    }

    fn texture(
        &mut self,
        image: &gltf::Image<'_>,
        base: Option<&Path>,
        seen: &mut HashMap<usize, usize>,
    ) -> Result<usize> {
        if let Some(texture) = seen.get(&image.index()) {
            return Ok(*texture);
        }
        let data = gltf::image::Data::from_source(image.source(), base, self.buffers);
        let data = data.map_err(|e| Error::scene(self.path, format!("image {}: {e}", image.index())))?;
        let texture = gltf_texture::texture(data).map_err(|e| Error::scene(self.path, e))?;
        self.scene.textures.push(texture);
        seen.insert(image.index(), self.scene.textures.len() - 1);
        Ok(self.scene.textures.len() - 1)
    }

    fn node(&mut self, node: &gltf::Node<'_>, parent: DMat4) -> Result<()> {
        let local = DMat4::from_cols_array_2d(&node.transform().matrix().map(|column| column.map(f64::from)));
        let world = parent * local;
        if let Some(mesh) = node.mesh() {
            let name = node.name().or(mesh.name()).unwrap_or_default();
            self.mesh(&mesh, name, world)?;
        }
        if let Some(light) = node.light() {
            self.light(&light, world);
        }
        if let Some(camera) = node.camera() {
            self.camera(&camera, node.name(), world);
        }
        for child in node.children() {
            self.node(&child, world)?;
        }
        Ok(())
    }

    fn mesh(&mut self, mesh: &gltf::Mesh<'_>, name: &str, world: DMat4) -> Result<()> {
        for primitive in mesh.primitives() {
            let key = (mesh.index(), primitive.index());
            let index = match self.primitives.get(&key) {
                Some(index) => *index,
                None => match self.primitive(&primitive)? {
                    Some(loaded) => {
                        self.scene.meshes.push(loaded);
                        self.primitives.insert(key, self.scene.meshes.len() - 1);
                        self.scene.meshes.len() - 1
                    }
                    None => continue,
                },
            };
            let linear = [world.x_axis, world.y_axis, world.z_axis].map(|c| c.truncate().as_vec3().to_array());
            let material = primitive.material().index().unwrap_or(self.scene.materials.len() - 1);
            let translation = world.w_axis.truncate().to_array();
            let name = name.to_owned();
            self.scene.instances.push(Instance { name, mesh: index, material, linear, translation });
        }
        Ok(())
    }

    /// `None` for points and lines, which the host does not draw.
    fn primitive(&mut self, primitive: &gltf::Primitive<'_>) -> Result<Option<Mesh>> {
        let fail = |reason: &str| Error::scene(self.path, format!("primitive {}: {reason}", primitive.index()));
        let mode = primitive.mode();
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            self.scene.warnings.push(format!("a primitive of mode {mode:?} is left out"));
            return Ok(None);
        }
        let reader = primitive.reader(|buffer| self.buffers.get(buffer.index()).map(|data| &data.0[..]));
        let positions: Vec<_> = reader.read_positions().ok_or_else(|| fail("no readable POSITION"))?.collect();
        let set = primitive.material().pbr_metallic_roughness().base_color_texture().map_or(0, |t| t.tex_coord());
        let uvs: Vec<_> = reader.read_tex_coords(set).map_or_else(Vec::new, |uvs| uvs.into_f32().collect());
        if !uvs.is_empty() && uvs.len() != positions.len() {
            return Err(fail("TEXCOORD and POSITION differ in length"));
        }
        let order: Vec<u32> = match (reader.read_indices(), primitive.indices()) {
            (Some(indices), _) => indices.into_u32().collect(),
            (None, Some(_)) => return Err(fail("unreadable indices")),
            (None, None) => (0..positions.len() as u32).collect(),
        };
        Ok(Some(Mesh { positions, uvs, indices: triangle_list(mode, order) }))
    }

    fn light(&mut self, light: &gltf::khr_lights_punctual::Light<'_>, world: DMat4) {
        let color = light.color().map(|c| c * light.intensity());
        let position = world.w_axis.truncate().to_array();
        let direction = (-world.z_axis.truncate()).normalize_or(DVec3::NEG_Z).as_vec3().to_array();
        let range = light.range().unwrap_or(0.0);
        match light.kind() {
            Kind::Directional => self.scene.lights.push(Light::Directional { direction, irradiance: color }),
            Kind::Point => self.scene.lights.push(Light::Point { position, intensity: color, range }),
            Kind::Spot { inner_cone_angle: inner_angle, outer_cone_angle: outer_angle } => self
                .scene
                .lights
                .push(Light::Spot { position, direction, intensity: color, inner_angle, outer_angle, range }),
        }
    }

    fn camera(&mut self, camera: &gltf::Camera<'_>, node: Option<&str>, world: DMat4) {
        let Projection::Perspective(lens) = camera.projection() else {
            self.scene.warnings.push("an orthographic camera is left out".into());
            return;
        };
        let position = world.w_axis.truncate();
        let fallback = camera.index().to_string();
        self.scene.cameras.push(SceneCamera {
            name: camera.name().or(node).unwrap_or(&fallback).to_owned(),
            position: position.to_array(),
            target: (position - world.z_axis.truncate()).to_array(),
            up: world.y_axis.truncate().to_array(),
            vfov_deg: f64::from(lens.yfov()).to_degrees(),
            near: f64::from(lens.znear()),
            width: 1280,
            height: 720,
        });
    }
}

/// Strips and fans as a list; an incomplete last triangle is dropped.
fn triangle_list(mode: Mode, order: Vec<u32>) -> Vec<u32> {
    let mut list = match mode {
        Mode::TriangleStrip => order
            .windows(3)
            .enumerate()
            .flat_map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
            .collect(),
        Mode::TriangleFan if order.len() > 2 => order[1..].windows(2).flat_map(|w| [order[0], w[0], w[1]]).collect(),
        Mode::TriangleFan => Vec::new(),
        _ => order,
    };
    list.truncate(list.len() / 3 * 3);
    list
}
