//! Which triangles are sheets, seen from both sides, and which bound a solid.
//!
//! A connected body whose every edge is shared by equally many triangles in both directions bounds a solid: one side of
//! its faces is never seen, and one side is kept. (Turned inside out it bounds a room in a solid: what is in the room
//! meets its front.) Everything else, open shells and loose triangles, keeps both sides.

use glam::Vec3;
use rustc_hash::FxHashMap;

/// For each triangle: whether both of its sides are surface.
pub fn two_sided(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<bool> {
    let vertex = weld(positions);
    let mut bodies = connected(&vertex, triangles);
    let mut edges: FxHashMap<(u32, u32), i32> = FxHashMap::default();
    for t in triangles {
        let [a, b, c] = t.map(|i| vertex[i as usize]);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if from != to {
                *edges.entry((from.min(to), from.max(to))).or_insert(0) += if from < to { 1 } else { -1 };
            }
        }
    }
    let mut open = vec![false; vertex.len()];
    for ((from, _), balance) in edges {
        open[bodies.root(from) as usize] |= balance != 0;
    }
    triangles.iter().map(|t| open[bodies.root(vertex[t[0] as usize]) as usize]).collect()
}

/// For each triangle the connected body that it belongs to; `vertex`: the welded positions.
pub fn bodies(vertex: &[u32], triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut bodies = connected(vertex, triangles);
    triangles.iter().map(|t| bodies.root(vertex[t[0] as usize])).collect()
}

/// For each vertex a number that it shares with all at the same position.
pub fn weld(positions: &[Vec3]) -> Vec<u32> {
    let mut welded = FxHashMap::default();
    let number = |p: &Vec3| {
        let next = welded.len() as u32;
        // + 0.0 turns -0.0 into 0.0.
        *welded.entry((*p + Vec3::ZERO).to_array().map(f32::to_bits)).or_insert(next)
    };
    positions.iter().map(number).collect()
}

fn connected(vertex: &[u32], triangles: &[[u32; 3]]) -> Sets {
    let mut bodies = Sets::new(vertex.len());
    for t in triangles {
        let [a, b, c] = t.map(|i| vertex[i as usize]);
        bodies.join(a, b);
        bodies.join(a, c);
    }
    bodies
}

/// Disjoint sets of numbers.
pub struct Sets(Vec<u32>);

impl Sets {
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    pub fn root(&mut self, mut v: u32) -> u32 {
        while self.0[v as usize] != v {
            self.0[v as usize] = self.0[self.0[v as usize] as usize];
            v = self.0[v as usize];
        }
        v
    }

    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let p = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        (p, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    }

    #[test]
    fn a_closed_body_has_one_side() {
        let (p, t) = tetrahedron();
        assert_eq!(two_sided(&p, &t), [false; 4]);
    }

    #[test]
    fn an_open_body_has_two() {
        let (p, t) = tetrahedron();
        assert_eq!(two_sided(&p, &t[..3]), [true; 3]);
    }
}
