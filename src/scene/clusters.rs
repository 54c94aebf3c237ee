//! Runs of triangles that lie close together: what a window or a box does not touch is passed over as a whole.

use super::store::Mesh;
use glam::Vec3;
use meshopt::VertexDataAdapter;
use std::ops::Range;

/// Triangles of a cluster.
const CLUSTER: usize = 64;
/// Meshes of fewer triangles are one cluster, and keep the host's order.
const LARGE: usize = 4 * CLUSTER;

/// A run of triangles in the box that holds them.
#[derive(Clone, Debug)]
pub struct Cluster {
    pub triangles: Range<u32>,
    pub low: Vec3,
    pub high: Vec3,
}

/// Whether the library that sorts and simplifies can tell positions apart: their extent is a number.
pub(super) fn is_bounded(positions: &[Vec3]) -> bool {
    let (low, high) = positions.iter().fold((Vec3::MAX, Vec3::MIN), |b, p| (b.0.min(*p), b.1.max(*p)));
    (high - low).is_finite()
}

impl Mesh {
    /// Sorts a large mesh's triangles along a space-filling curve and makes its clusters, unless that is done.
    pub(super) fn cluster(&mut self) {
        if !self.clusters.is_empty() {
            return;
        }
        let large = self.triangles.len() >= LARGE && is_bounded(&self.positions);
        if large {
            // A vertex belongs to one body, and a body has one side or two.
            let mut two_sided = vec![false; self.positions.len()];
            for (t, sided) in self.triangles.iter().zip(&self.two_sided) {
                two_sided[t[0] as usize] = *sided;
                two_sided[t[1] as usize] = *sided;
                two_sided[t[2] as usize] = *sided;
            }
            let vertices = VertexDataAdapter::new(bytemuck::cast_slice(&self.positions), size_of::<Vec3>(), 0);
            let indices = self.triangles.as_flattened();
            let sorted = meshopt::spatial_sort_triangles(indices, &vertices.expect("whole vertices"));
            self.triangles = sorted.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
            self.two_sided = self.triangles.iter().map(|t| two_sided[t[0] as usize]).collect();
        }
        let size = if large { CLUSTER } else { self.triangles.len().max(1) };
        let positions = &self.positions;
        let cluster = |(first, run): (usize, &[[u32; 3]])| {
            let corners = run.as_flattened().iter().map(|i| positions[*i as usize]);
            let (low, high) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |b, p| (b.0.min(p), b.1.max(p)));
            let first = first as u32;
            Cluster { triangles: first..first + run.len() as u32, low, high }
        };
        self.clusters = (0..).step_by(size).zip(self.triangles.chunks(size)).map(cluster).collect();
    }
}
