//! The scene as world-space triangles with exact face normals: what the rasteriser and the shadow rays see.

use super::{Instance, Mesh, Scene};
use glam::{DVec3, Mat3};

/// A world-space triangle.
#[derive(Clone, Copy, Debug)]
pub struct FlatTriangle {
    /// Metres.
    pub positions: [[f32; 3]; 3],
    /// Unit face normal; the front side.
    pub normal: [f32; 3],
    /// Texture coordinates.
    pub uvs: [[f32; 2]; 3],
    /// Index into [`Scene::materials`].
    pub material: u32,
}

/// Every triangle with an area, in the order of the instances.
pub fn flatten(scene: &Scene) -> Vec<FlatTriangle> {
    let mut triangles = Vec::with_capacity(scene.triangle_count());
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh];
        let mirrored = Mat3::from_cols_array_2d(&instance.linear).determinant() < 0.0;
        triangles.extend(mesh.indices.chunks_exact(3).filter_map(|corner| flat(instance, mesh, corner, mirrored)));
    }
    triangles
}

fn flat(instance: &Instance, mesh: &Mesh, corner: &[u32], mirrored: bool) -> Option<FlatTriangle> {
    let corner: [usize; 3] = std::array::from_fn(|i| corner[i] as usize);
    let world = corner.map(|i| DVec3::from(instance.to_world(mesh.positions[i])));
    let normal = (world[1] - world[0]).cross(world[2] - world[0]).try_normalize()?;
    let front = if mirrored { -normal } else { normal };
    Some(FlatTriangle {
        positions: world.map(|p| p.as_vec3().to_array()),
        normal: front.as_vec3().to_array(),
        uvs: corner.map(|i| mesh.uvs.get(i).copied().unwrap_or_default()),
        material: instance.material as u32,
    })
}
