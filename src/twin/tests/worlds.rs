//! Random worlds and rays for tracing.

use crate::twin::layout::{Face, Voxel};
use crate::twin::pack::{plane_encode, side_sign, side_step};
use crate::twin::random::Random;
use crate::twin::trace::Ray;
use crate::twin::world::World;
use glam::{DVec3, IVec3, UVec3};

/// A voxel with random planes on random sides, some part-filled, some closed, some the
/// two sides of a sheet.
fn random_voxel(random: &mut Random, part_filled: f64, closed: f64) -> Voxel {
    let mut voxel = Voxel { translucent: random.chance(0.3), ..Voxel::default() };
    let sure = random.below(6) as usize;
    let sheet = random.chance(0.2);
    for side in 0..6 {
        if side != sure && random.chance(0.5) {
            continue;
        }
        let tilt = random.unit();
        let normal = (side_step(side).as_dvec3() + random.direction() * tilt * 0.95).normalize();
        let point = random.point();
        let mut put = |side: usize, normal: DVec3| {
            voxel.faces[side] = Some(Face {
                plane: plane_encode(side, normal, point),
                mask: if random.chance(part_filled) { (random.below(0xffff) + 1) as u16 } else { 0xffff },
                lit: !random.chance(closed),
                albedo: random.next() as u32,
                emission: if random.chance(0.1) { random.next() as u32 } else { 0 },
            });
        };
        put(side, normal);
        if side & 1 == 1 && sheet {
            put(side ^ 1, -normal);
        }
    }
    voxel
}

/// Voxels with nothing to do with each other, in some of the bricks; a third repeat the one before.
pub fn noise(random: &mut Random, world: &mut World, bricks: f64, voxels: f64, part_filled: f64, closed: f64) {
    let size = world.size() / 8;
    for index in 0..size.x * size.y * size.z {
        if !random.chance(bricks) {
            continue;
        }
        let brick = IVec3::new(index % size.x, index / size.x % size.y, index / (size.x * size.y)) * 8;
        let mut voxel = random_voxel(random, part_filled, closed);
        for cell in 0..512 {
            if random.chance(voxels) {
                if !random.chance(0.3) {
                    voxel = random_voxel(random, part_filled, closed);
                }
                world.insert(brick + IVec3::new(cell % 8, cell / 8 % 8, cell / 64), voxel);
            }
        }
    }
}

/// A surface through the world: where its distance is zero, and which way it looks.
type Surface = Box<dyn Fn(DVec3) -> (f64, DVec3)>;

fn surfaces(random: &mut Random, size: DVec3) -> Vec<Surface> {
    let mut all: Vec<Surface> = Vec::new();
    for _ in 0..12 {
        let (center, radius) = (random.point() * size, random.between(3.0, 14.0));
        let inward = random.chance(0.5);
        all.push(Box::new(move |p| {
            let n = (p - center).normalize_or(DVec3::X);
            ((p - center).length() - radius, if inward { -n } else { n })
        }));
    }
    for axis in 0..3 {
        let at = random.between(0.2, 0.8) * size[axis];
        all.push(Box::new(move |p| (p[axis] - at, DVec3::AXES[axis])));
    }
    let normal = random.direction();
    let at = normal.dot(size * 0.5);
    all.push(Box::new(move |p| (normal.dot(p) - at, normal)));
    all
}

/// Balls, walls and a slope, conservatively: closed sides where a neighbour is occupied; walls are thin.
pub fn shapes(random: &mut Random, world: &mut World) {
    let size = world.size();
    let shapes = surfaces(random, size.as_dvec3());
    for index in 0..size.x * size.y * size.z {
        let cell = IVec3::new(index % size.x, index / size.x % size.y, index / (size.x * size.y));
        let center = cell.as_dvec3() + 0.5;
        let mut voxel = Voxel::default();
        for shape in &shapes {
            let (distance, n) = shape(center);
            if distance.abs() > 0.5 * n.abs().element_sum() {
                continue;
            }
            for axis in (0..3).filter(|a| n[*a].abs() > 0.2) {
                let side = axis * 2 + usize::from(n[axis] > 0.0);
                let centroid = DVec3::splat(0.5) - n * n.dot(center - shape_point(shape, center));
                // Sides that hold the very same plane would leave the choice between them to rounding.
                let n = (n + random.direction() * 0.03).normalize();
                put(&mut voxel, side, n, centroid);
                if axis == 1 {
                    put(&mut voxel, side ^ 1, -n, centroid - n * 0.1);
                }
            }
        }
        if voxel != Voxel::default() {
            world.insert(cell, voxel);
        }
    }
    close(random, world);
}

fn shape_point(shape: &Surface, p: DVec3) -> DVec3 {
    let (distance, n) = shape(p);
    let step = p - n * distance;
    // The sign of an inward normal is not that of the distance.
    if shape(step).0.abs() <= distance.abs() { step } else { p + n * distance }
}

fn put(voxel: &mut Voxel, side: usize, normal: DVec3, centroid: DVec3) {
    let centroid = centroid.clamp(DVec3::splat(0.002), DVec3::splat(0.998));
    let plane = plane_encode(side, normal, centroid);
    voxel.faces[side] = Some(Face { plane, mask: 0xffff, lit: true, albedo: 0x7bef_7bef, emission: 0 });
}

/// Most sides before an occupied voxel are closed.
fn close(random: &mut Random, world: &mut World) {
    for cell in world.occupied() {
        let mut voxel = *world.voxel(cell).expect("occupied");
        for side in 0..6 {
            let closed = world.voxel(cell + side_step(side)).is_some() && random.chance(0.8);
            if let Some(face) = &mut voxel.faces[side] {
                face.lit = !closed;
            }
        }
        world.insert(cell, voxel);
    }
}

/// A path of floor along the diagonal of the window's lowest layer, with a wall before its end.
pub fn floor_to_a_wall(world: &mut World) {
    let size = world.size();
    for x in 0..size.x {
        for z in (x - 8).max(0)..(x + 8).min(size.z) {
            let mut voxel = Voxel::default();
            put(&mut voxel, 3, DVec3::Y, DVec3::splat(0.5));
            world.insert(IVec3::new(x, 0, z), voxel);
        }
    }
    for cell in 0..64 {
        let mut voxel = Voxel::default();
        put(&mut voxel, 0, DVec3::NEG_X, DVec3::splat(0.5));
        world.insert(IVec3::new(size.x - 4, cell % 4, size.z - 17 + cell / 4), voxel);
    }
}

fn rounded(v: DVec3) -> DVec3 {
    v.as_vec3().as_dvec3()
}

fn random_direction(random: &mut Random) -> DVec3 {
    if random.chance(0.1) {
        let side = random.below(6) as usize;
        return DVec3::AXES[side >> 1] * side_sign(side);
    }
    random.direction()
}

/// Rays from anywhere, towards voxels, and from surfaces; exact in f32.
pub fn rays(random: &mut Random, world: &World, count: usize) -> Vec<Ray> {
    let occupied = world.occupied();
    let size = world.size().as_dvec3();
    (0..count)
        .map(|index| {
            let anywhere = random.point() * (size + 8.0) - 4.0;
            let cell = occupied[random.below(occupied.len() as u32) as usize];
            let inside = cell.as_dvec3() + random.point();
            let direction = random_direction(random);
            let mut ray = Ray {
                origin: anywhere,
                direction,
                normal: DVec3::ZERO,
                start_error: 0.25,
                t_max: 1e30,
                error: DVec3::ZERO,
            };
            if index % 3 == 1 {
                ray.direction = (inside - anywhere).normalize();
            }
            if index % 3 == 2 {
                let voxel = world.voxel(cell).expect("occupied");
                let side = (0..6).find(|s| voxel.faces[*s].is_some()).expect("a side");
                let plane = voxel.plane(side).expect("stored");
                let on = inside - plane.normal * plane.height(inside - cell.as_dvec3());
                ray.origin = on + plane.normal * random.between(0.01, 0.3);
                ray.normal = plane.normal;
            }
            if random.chance(0.3) {
                ray.t_max = random.between(0.5, 40.0);
            }
            Ray {
                origin: rounded(ray.origin),
                direction: rounded(ray.direction),
                normal: rounded(ray.normal),
                start_error: f64::from(if index % 2 == 0 { 0.02f32 } else { 0.25 }),
                t_max: f64::from(ray.t_max as f32),
                ..ray
            }
        })
        .collect()
}

/// An empty window somewhere in the world.
pub fn window(extent: [u32; 3], low: [i32; 3]) -> World {
    World::new(UVec3::from(extent), IVec3::from(low))
}
