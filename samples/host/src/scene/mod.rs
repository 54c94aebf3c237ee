//! What the host draws: loaded from a reference's `scene.json` or from any glTF file.

mod camera;
mod description;
mod flat;
mod gltf_file;
mod gltf_texture;

pub use brickgi::scene::{Light, Sky, SkyLayout};
pub use camera::SceneCamera;
pub(crate) use flat::face_normal;
pub use flat::flatten;

use crate::error::{Error, Result};
use std::path::{Path, PathBuf};

/// A triangle mesh of one material, in object space.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Metres.
    pub positions: Vec<[f32; 3]>,
    /// One per position, or empty.
    pub uvs: Vec<[f32; 2]>,
    /// Three per triangle.
    pub indices: Vec<u32>,
}

/// A two-sided Lambertian material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Linear Rec.709 factor of the albedo.
    pub base_color: [f32; 3],
    /// Radiance of the front side.
    pub emission: [f32; 3],
    /// Index into [`Scene::textures`]; multiplies `base_color`.
    pub texture: Option<usize>,
}

/// An sRGB-encoded colour texture, repeated.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// RGBA, rows from the top.
    pub rgba8: Vec<u8>,
}

/// The image of a sky: radiance, linear Rec.709.
#[derive(Clone, Debug)]
pub struct SkyPicture {
    /// How it covers the directions.
    pub layout: SkyLayout,
    /// Texels per row.
    pub width: u32,
    /// Rows, of a cube those of a face.
    pub height: u32,
    /// RGBA, rows from the top; six faces of a cube one after another.
    pub rgba32: Vec<[f32; 4]>,
}

/// A mesh with a material, placed in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// The glTF node's name, else the mesh's; several instances may share it, and it may be empty.
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Columns of the linear part of object to world.
    pub linear: [[f32; 3]; 3],
    /// World position of the object's origin in metres.
    pub translation: [f64; 3],
}

/// A scene as the host keeps it.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The name in `scene.json`, else the file's stem.
    pub name: String,
    /// Folder of the scene file; references lie here.
    pub directory: PathBuf,
    /// Meshes, shared by instances.
    pub meshes: Vec<Mesh>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Base-colour textures.
    pub textures: Vec<Texture>,
    /// What stands where.
    pub instances: Vec<Instance>,
    /// Lights that are not surfaces.
    pub lights: Vec<Light>,
    /// Light from beyond the scene.
    pub sky: Sky,
    /// The image that [`Sky::Image`] means.
    pub sky_picture: Option<SkyPicture>,
    /// At least one.
    pub cameras: Vec<SceneCamera>,
    /// What the file asked for and the host does not do, one line each.
    pub warnings: Vec<String>,
}

impl Scene {
    /// Loads `scene.json`, the folder that holds one, or a `.glb`/`.gltf`.
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let given = path.as_ref();
        let path = if given.is_dir() { given.join("scene.json") } else { given.to_owned() };
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        let mut scene = match extension.as_str() {
            "json" => description::load(&path)?,
            "glb" | "gltf" => gltf_file::load(&path)?.with_defaults(),
            _ => return Err(Error::scene(&path, "expected scene.json, .glb, .gltf or a folder with scene.json")),
        };
        scene.directory = path.parent().unwrap_or(Path::new(".")).to_owned();
        scene.check(&path)?;
        Ok(scene)
    }

    /// The camera of that name, or the first one.
    pub fn camera(&self, name: Option<&str>) -> Result<&SceneCamera> {
        let wanted = name.unwrap_or_default();
        let found = match name {
            Some(name) => self.cameras.iter().find(|c| c.name == name),
            None => self.cameras.first(),
        };
        found.ok_or_else(|| Error::UnknownCamera {
            wanted: wanted.to_owned(),
            known: self.cameras.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", "),
        })
    }

    /// Triangles over all instances.
    pub fn triangle_count(&self) -> usize {
        self.instances.iter().map(|i| self.meshes[i.mesh].indices.len() / 3).sum()
    }

    /// World bounds in metres, or `None` for an empty scene.
    pub fn bounds(&self) -> Option<[[f64; 3]; 2]> {
        let mut bounds: Option<[[f64; 3]; 2]> = None;
        for instance in &self.instances {
            for position in &self.meshes[instance.mesh].positions {
                let world = instance.to_world(*position);
                let [low, high] = bounds.get_or_insert([world; 2]);
                for axis in 0..3 {
                    low[axis] = low[axis].min(world[axis]);
                    high[axis] = high[axis].max(world[axis]);
                }
            }
        }
        bounds
    }

    /// A camera, a sun and a sky for a file that brings none.
    fn with_defaults(mut self) -> Self {
        if self.cameras.is_empty() {
            self.cameras.extend(self.bounds().map(SceneCamera::framing));
        }
        let emits = self.materials.iter().any(|m| m.emission != [0.0; 3]);
        if self.lights.is_empty() && !emits {
            let sun = Light::Directional { direction: [0.35, -0.85, -0.4], irradiance: [14.0, 13.0, 11.5] };
            self.lights.push(sun);
            self.sky = Sky::Constant { radiance: [0.9, 1.15, 1.5] };
        }
        self
    }

    fn check(&self, path: &Path) -> Result<()> {
        let fail = |reason: String| Err(Error::scene(path, reason));
        if self.triangle_count() == 0 {
            return fail("the scene has no triangles".into());
        }
        for (id, mesh) in self.meshes.iter().enumerate() {
            if !mesh.positions.iter().flatten().chain(mesh.uvs.iter().flatten()).all(|v| v.is_finite()) {
                return fail(format!("mesh {id} holds a position or texture coordinate that is not a number"));
            }
            if let Some(index) = mesh.indices.iter().find(|i| **i as usize >= mesh.positions.len()) {
                return fail(format!("mesh {id}: index {index} of {} vertices", mesh.positions.len()));
            }
        }
        for (id, instance) in self.instances.iter().enumerate() {
            let linear = instance.linear.iter().flatten().all(|v| v.is_finite());
            if !linear || !instance.translation.iter().all(|v| v.is_finite()) {
                return fail(format!("instance {id} has a transform that is not a number"));
            }
        }
        match self.cameras.iter().find(|c| !c.is_usable()) {
            Some(camera) => fail(format!("camera {:?} is degenerate", camera.name)),
            None if self.cameras.is_empty() => fail("the scene has no camera".into()),
            None => Ok(()),
        }
    }
}

impl Mesh {
    /// A closed box, counter-clockwise seen from outside; its vertices are its own eight corners.
    pub fn cuboid(low: [f32; 3], high: [f32; 3]) -> Self {
        // A corner's bits are its sides of x, y and z.
        let corner = |i: usize| std::array::from_fn(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] });
        let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let indices = sides.iter().flat_map(|[a, b, c, d]| [*a, *b, *c, *a, *c, *d]).collect();
        Self { positions: (0..8).map(corner).collect(), uvs: Vec::new(), indices }
    }
}

impl Instance {
    /// Neither turned nor scaled, and without a name.
    pub fn at(mesh: usize, material: usize, translation: [f64; 3]) -> Self {
        let linear = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Self { name: String::new(), mesh, material, linear, translation }
    }

    /// Object to world in double precision.
    pub fn to_world(&self, p: [f32; 3]) -> [f64; 3] {
        std::array::from_fn(|row| {
            let linear: f64 = (0..3).map(|col| f64::from(self.linear[col][row]) * f64::from(p[col])).sum();
            linear + self.translation[row]
        })
    }
}
