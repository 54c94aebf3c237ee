//! Dense meshes.

use std::f32::consts::{PI, TAU};

/// Positions and indices.
pub type Shape = (Vec<[f32; 3]>, Vec<u32>);

/// A sphere with waves, closed; `2 * segments * (rings - 1)` triangles.
pub fn bumpy_sphere(radius: f32, rings: u32, segments: u32) -> Shape {
    let point = |ring: u32, segment: u32| {
        let (up, around) = (PI * ring as f32 / rings as f32, TAU * (segment % segments) as f32 / segments as f32);
        let r = radius * (1.0 + 0.1 * (3.0 * around).sin() * up.sin().powi(3) + 0.02 * (14.0 * up).cos());
        [r * up.sin() * around.cos(), r * up.cos(), r * up.sin() * around.sin()]
    };
    let mut positions = vec![point(0, 0), point(rings, 0)];
    positions.extend((1..rings).flat_map(|ring| (0..segments).map(move |segment| point(ring, segment))));
    let at = |ring: u32, segment: u32| match ring {
        0 => 0,
        ring if ring == rings => 1,
        ring => 2 + (ring - 1) * segments + segment % segments,
    };
    let mut indices = Vec::new();
    for (ring, segment) in (0..rings).flat_map(|ring| (0..segments).map(move |segment| (ring, segment))) {
        let [a, b] = [at(ring, segment), at(ring, segment + 1)];
        let [c, d] = [at(ring + 1, segment), at(ring + 1, segment + 1)];
        if ring > 0 {
            indices.extend([a, b, d]);
        }
        if ring + 1 < rings {
            indices.extend([a, d, c]);
        }
    }
    (positions, indices)
}

/// Hills on a square about the origin, open; `2 * cells * cells` triangles.
pub fn terrain(edge: f32, cells: u32) -> Shape {
    let at = |i: u32| edge * (i as f32 / cells as f32 - 0.5);
    let height = |x: f32, z: f32| {
        1.5 * (0.4 * x).sin() * (0.3 * z + 1.0).cos()
            + 0.2 * (1.7 * x + 0.9 * z).sin()
            + 0.02 * (9.0 * x).sin() * (8.0 * z).sin()
    };
    let point = |i: u32| {
        let (x, z) = (at(i % (cells + 1)), at(i / (cells + 1)));
        [x, height(x, z), z]
    };
    let positions = (0..(cells + 1) * (cells + 1)).map(point).collect();
    let cell = |i: u32| {
        let a = i / cells * (cells + 1) + i % cells;
        [a, a + cells + 1, a + 1, a + 1, a + cells + 1, a + cells + 2]
    };
    (positions, (0..cells * cells).flat_map(cell).collect())
}

/// A box of square cells.
pub fn plate(size: [u32; 3], cell: f32) -> Shape {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for side in 0..6 {
        let (axis, high) = (side / 2, side % 2 == 1);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for (i, j) in (0..size[u]).flat_map(|i| (0..size[v]).map(move |j| (i, j))) {
            let first = positions.len() as u32;
            for (a, b) in [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)] {
                let mut p = [0.0; 3];
                p[axis] = if high { size[axis] as f32 * cell } else { 0.0 };
                (p[u], p[v]) = (a as f32 * cell, b as f32 * cell);
                positions.push(p);
            }
            let turned = if high { [0, 1, 2, 0, 2, 3] } else { [0, 2, 1, 0, 3, 2] };
            indices.extend(turned.map(|k| first + k));
        }
    }
    (positions, indices)
}
