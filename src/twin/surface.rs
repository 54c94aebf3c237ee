//! Twin of lib/surface.wgsl: the light of a hit on a closed face.

use super::layout::{Face, Voxel};
use super::pack::{Plane, axis_u, axis_v, mask_bit, plane_decode, side_step};
use super::world::World;
use glam::{DVec2, DVec3, IVec3};

/// A lit side: cell and side.
pub type Lit = (IVec3, usize);

impl Voxel {
    /// The plane that a side stores.
    pub fn plane(&self, side: usize) -> Option<Plane> {
        self.faces[side].map(|face: Face| plane_decode(side, face.plane))
    }

    /// Whether a side's plane and that of the opposite side are the two sides of a sheet; `error` as that of a ray.
    pub fn is_sheet(&self, side: usize, plane: Plane, error: DVec3) -> bool {
        let error = error[side >> 1];
        self.plane(side ^ 1).is_some_and(|back| {
            back.normal.dot(plane.normal) + error < -0.98 && (back.offset + plane.offset + error).abs() < 0.05
        })
    }

    /// Whether `p`, on one side of a sheet, lies beyond the edge at which the sheet bends away, in front of which the ray
    /// starts.
    pub fn is_beyond_edge(&self, side: usize, plane: Plane, p: DVec3, start: DVec3, error: DVec3) -> bool {
        let Some(mask) = self.faces[side].map(|face| face.mask).filter(|mask| *mask != 0xffff) else { return false };
        if !self.is_sheet(side, plane, error) {
            return false;
        }
        let middle = on_plane(plane, side >> 1, mask_middle(mask));
        let covers = |other: usize, p: DVec3| {
            self.faces[other].is_some_and(|face| face.mask >> mask_bit(other >> 1, p) & 1 == 1)
        };
        (0..6).filter(|other| other >> 1 != side >> 1).any(|other| {
            let Some(edge) = self.plane(other) else { return false };
            let height = |p: DVec3| edge.height(p) + error[other >> 1];
            let ends = height(p) >= 0.002 && height(middle) <= 0.0 && height(start) > 0.0;
            ends && self.is_sheet(other, edge, error) && (covers(other, p) || covers(other, p + 0.12 * plane.normal))
        })
    }
}

/// A hit on a side without lighting of its own.
pub struct ClosedHit<'a> {
    pub voxel: &'a Voxel,
    pub cell: IVec3,
    pub side: usize,
    pub plane: Plane,
    /// Grid space.
    pub point: DVec3,
    pub direction: DVec3,
    /// As that of the ray.
    pub error: DVec3,
}

impl ClosedHit<'_> {
    /// The nearest in-plane neighbour of the same direction, else the voxel in front, else an own face that has the
    /// point in front, else none.
    pub fn light(&self, world: &World) -> Option<Lit> {
        let front_cell = self.cell + side_step(self.side);
        let front = world.voxel(front_cell);
        front
            .and_then(|front| self.neighbour(world, front, front_cell).or_else(|| self.in_front(front, front_cell)))
            .or_else(|| self.own())
    }

    fn neighbour(&self, world: &World, front: &Voxel, front_cell: IVec3) -> Option<Lit> {
        let lifted = self.point + self.plane.normal * 0.05;
        let local = lifted - self.cell.as_dvec3();
        let mut best = None;
        let mut best_distance = f64::INFINITY;
        for edge in (0..6).filter(|e| e >> 1 != self.side >> 1) {
            let distance = if edge & 1 == 1 { 1.0 - local[edge >> 1] } else { local[edge >> 1] };
            let cell = self.cell + side_step(edge);
            let Some(voxel) = world.voxel(cell).filter(|v| v.is_lit(self.side)) else { continue };
            let Some(plane) = voxel.plane(self.side) else { continue };
            let height = plane.height(self.point - cell.as_dvec3());
            if distance >= best_distance || plane.normal.dot(self.plane.normal) < 0.7 || height.abs() > 0.25 {
                continue;
            }
            let target = middle(plane, cell, self.side >> 1) + plane.normal * 0.05;
            let between = |v: &Voxel, c: IVec3| separated(v, c, self.side >> 1, lifted, target);
            if !between(self.voxel, self.cell) && !between(front, front_cell) {
                best = Some((cell, self.side));
                best_distance = distance;
            }
        }
        best
    }

    fn in_front(&self, front: &Voxel, cell: IVec3) -> Option<Lit> {
        let plane = front.plane(self.side).filter(|_| front.is_lit(self.side))?;
        (plane.height(self.point - cell.as_dvec3()).abs() < 0.25).then_some((cell, self.side))
    }

    fn own(&self) -> Option<Lit> {
        let mut best = None;
        let mut best_cosine = 0.0;
        for side in (0..6).filter(|s| self.voxel.is_lit(*s)) {
            let Some(plane) = self.voxel.plane(side) else { continue };
            let cosine = self.error[side >> 1] - plane.normal.dot(self.direction);
            if plane.height(self.point - self.cell.as_dvec3()) >= -0.1 && cosine > best_cosine {
                best = Some((self.cell, side));
                best_cosine = cosine;
            }
        }
        best
    }
}

/// Whether a wall of a voxel (not of `axis`) stands between two points of grid space.
fn separated(voxel: &Voxel, cell: IVec3, axis: usize, a: DVec3, b: DVec3) -> bool {
    let cell = cell.as_dvec3();
    (0..6)
        .filter(|side| side >> 1 != axis)
        .filter_map(|side| voxel.plane(side))
        .any(|plane| plane.height(a - cell) * plane.height(b - cell) < -1e-4)
}

/// Where a plane stands at the middle of its voxel, grid space.
fn middle(plane: Plane, cell: IVec3, axis: usize) -> DVec3 {
    cell.as_dvec3() + on_plane(plane, axis, DVec2::splat(0.5)).clamp(DVec3::ZERO, DVec3::ONE)
}

/// The point of an axis's plane at a place of the voxel's cross-section.
fn on_plane(plane: Plane, axis: usize, place: DVec2) -> DVec3 {
    let mut p = DVec3::ZERO;
    (p[axis_u(axis)], p[axis_v(axis)]) = (place.x, place.y);
    p[axis] = (plane.offset - plane.normal.dot(p)) / plane.normal[axis];
    p
}

/// Mean place of a mask's set cells.
fn mask_middle(mask: u16) -> DVec2 {
    let set = (0..16).filter(|k| mask >> k & 1 == 1);
    let sum: DVec2 = set.map(|k| DVec2::new(f64::from(k & 3), f64::from(k >> 2)) + 0.5).sum();
    sum * 0.25 / f64::from(mask.count_ones().max(1))
}
