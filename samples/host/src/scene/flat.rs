//! The instances as world-space triangles: what the shadow rays see.

use super::{Instance, Mesh};
use glam::DVec3;

/// Every triangle with an area, in world space (metres), in the order of the instances.
pub fn flatten<'a>(meshes: &[Mesh], instances: impl IntoIterator<Item = &'a Instance>) -> Vec<[[f32; 3]; 3]> {
    let triangles = |instance: &'a Instance| {
        let mesh = &meshes[instance.mesh];
        let corner = |index: &u32| DVec3::from(instance.to_world(mesh.positions[*index as usize]));
        let triangle = |corners: &[u32]| [corner(&corners[0]), corner(&corners[1]), corner(&corners[2])];
        mesh.indices.chunks_exact(3).map(triangle).filter(|t| face_normal(*t).is_some()).collect::<Vec<_>>()
    };
    let flat = instances.into_iter().flat_map(triangles);
    flat.map(|triangle| triangle.map(|corner| corner.as_vec3().to_array())).collect()
}

/// Unit normal of a triangle whose corners run counter-clockwise seen from its front; `None` without an area.
pub(crate) fn face_normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    (b - a).cross(c - a).try_normalize()
}
