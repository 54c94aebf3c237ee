//! Twin of lib/hdda.wgsl: marches through every voxel on the way, one at a time.

use super::layout::Voxel;
use super::pack::{Plane, mask_bit, side_sign};
use super::surface::{ClosedHit, Lit};
use super::world::World;
use crate::settings::HitModel;
use glam::{BVec3, DVec3, IVec3};

/// A ray in grid space.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub origin: DVec3,
    /// Unit.
    pub direction: DVec3,
    /// Of the surface at the origin, or zero.
    pub normal: DVec3,
    /// How far the origin may be off the surface that the planes describe.
    pub start_error: f64,
    pub t_max: f64,
    /// Added to the offsets and cosines of each axis's planes: zero, or an error whose effect is to be seen.
    pub error: DVec3,
}

/// What a ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    pub t: f64,
    pub cell: IVec3,
    pub side: usize,
    /// Whose radiance it sees; none: black.
    pub light: Option<Lit>,
}

/// A ray on its way through one voxel.
struct Step {
    cell: IVec3,
    /// The ray starts in this voxel.
    first: bool,
    t_in: f64,
    t_out: f64,
    entry_axis: usize,
}

/// The first hit before `t_max`.
pub fn trace(world: &World, model: HitModel, ray: &Ray) -> Option<Hit> {
    let d = ray.direction.to_array().map(|x| if x.abs() < f64::from(1e-7f32) { f64::from(1e-7f32) } else { x });
    let ray = Ray { direction: DVec3::from(d), ..*ray };
    let size = world.size();
    let to_low = -ray.origin / ray.direction;
    let to_high = (size.as_dvec3() - ray.origin) / ray.direction;
    let enter = to_low.min(to_high);
    let t_end = to_low.max(to_high).min_element().min(ray.t_max);
    let t = enter.max_element().max(0.0);
    if t >= t_end {
        return None;
    }
    let entry = (ray.origin + ray.direction * t).floor().as_ivec3().clamp(IVec3::ZERO, size - 1);
    let entry_axis = (0..3).max_by(|a, b| enter[*a].total_cmp(&enter[*b])).unwrap_or(0);
    let mut step = Step { cell: entry, first: t == 0.0, t_in: t, t_out: t, entry_axis };
    let mut passage = Passage::default();
    while step.cell.cmpge(IVec3::ZERO).all() && step.cell.cmplt(size).all() && step.t_in <= t_end {
        let forward = |axis: usize| i32::from(ray.direction[axis] > 0.0);
        let exit = |axis: usize| (f64::from(step.cell[axis] + forward(axis)) - ray.origin[axis]) / ray.direction[axis];
        let exit_axis = (0..3).min_by(|a, b| exit(*a).total_cmp(&exit(*b))).unwrap_or(0);
        step.t_out = exit(exit_axis);
        let hit = match (world.voxel(step.cell), model) {
            (None, _) => {
                passage = Passage::default();
                None
            }
            (Some(voxel), HitModel::Plane) => hit_planes(world, voxel, &ray, &step, &mut passage),
            (Some(_), HitModel::Cube) if step.first => None,
            (Some(voxel), HitModel::Cube) => Some(hit_cube(voxel, &ray, &step)),
        };
        if hit.is_some() {
            return hit;
        }
        step.first = false;
        step.t_in = step.t_out.max(step.t_in);
        step.entry_axis = exit_axis;
        step.cell[exit_axis] += 2 * forward(exit_axis) - 1;
    }
    None
}

/// Side of an axis that faces the ray.
fn facing_side(ray: &Ray, axis: usize) -> usize {
    axis * 2 + usize::from(ray.direction[axis] < 0.0)
}

/// What a ray did in the last occupied voxel, per axis.
#[derive(Clone, Copy, Debug, Default)]
struct Passage {
    /// It left in front of the plane.
    front: BVec3,
    /// It went through the plane, which lets light through.
    through: BVec3,
}

fn hit_planes(world: &World, voxel: &Voxel, ray: &Ray, step: &Step, passage: &mut Passage) -> Option<Hit> {
    let base = step.cell.as_dvec3();
    let at = |t: f64| ray.origin + ray.direction * t - base;
    let mut best: Option<(f64, f64, usize)> = None;
    for axis in 0..3 {
        let side = facing_side(ray, axis);
        let Passage { front, through } = passage;
        let (was, passed) = (front.test(axis), through.test(axis));
        front.set(axis, false);
        through.set(axis, false);
        let (Some(face), Some(mut plane)) = (voxel.faces[side], voxel.plane(side)) else { continue };
        plane.offset += ray.error[axis];
        let facing = plane.normal.dot(ray.direction);
        if facing >= 0.0 {
            continue;
        }
        let (s0, s1) = (plane.height(at(step.t_in)), plane.height(at(step.t_out)));
        front.set(axis, s1 > 0.0);
        if passed && s0 < 0.0 {
            through.set(axis, true);
            continue;
        }
        let nearest = if step.first { 1e-4 } else { -0.05 };
        if s1 > 0.0 || (s0 < nearest && !was) {
            continue;
        }
        let t = step.t_in - s0.max(0.0) / facing;
        if face.mask >> mask_bit(axis, at(t)) & 1 == 0 {
            through.set(axis, voxel.translucent);
            continue;
        }
        let near = step.t_in < 2.0;
        if near
            && (is_behind_start(voxel, side, plane, at(0.0), ray)
                || voxel.is_beyond_edge(side, plane, at(t), at(0.0), ray.error))
        {
            continue;
        }
        // True crossings come before those within the tolerance.
        let order = if s0 < 0.0 && !was { t + 64.0 } else { t };
        if best.is_none_or(|b| order < b.0) {
            best = Some((order, t, side));
        }
    }
    let (_, t, side) = best.filter(|b| b.1 < ray.t_max)?;
    let plane = voxel.plane(side)?;
    let closed = ClosedHit {
        voxel,
        cell: step.cell,
        side,
        plane,
        point: ray.origin + ray.direction * t,
        direction: ray.direction,
        error: ray.error,
    };
    let light = if voxel.is_lit(side) { Some((step.cell, side)) } else { closed.light(world) };
    Some(Hit { t, cell: step.cell, side, light })
}

/// Whether a plane that faces the start (`p`) is the back of the start's own surface.
fn is_behind_start(voxel: &Voxel, side: usize, plane: Plane, p: DVec3, ray: &Ray) -> bool {
    let along = plane.normal.dot(ray.normal) + ray.error[side >> 1];
    let height = plane.height(p);
    if along > -0.1 || height >= 0.25 {
        return false;
    }
    if along < -0.9995 { height < ray.start_error } else { along < -0.9 || voxel.is_sheet(side, plane, ray.error) }
}

/// The entered side if it is lit, else the own side that looks at the ray most.
fn hit_cube(voxel: &Voxel, ray: &Ray, step: &Step) -> Hit {
    let side = facing_side(ray, step.entry_axis);
    let cosine = |s: usize| -side_sign(s) * ray.direction[s >> 1];
    // The first of equals.
    let facing = (0..6).rev().filter(|s| voxel.is_lit(*s) && cosine(*s) > 0.0);
    let most = facing.max_by(|a, b| cosine(*a).total_cmp(&cosine(*b)));
    let light = if voxel.is_lit(side) { Some(side) } else { most };
    Hit { t: step.t_in, cell: step.cell, side, light: light.map(|s| (step.cell, s)) }
}
