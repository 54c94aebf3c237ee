//! Twin of passes/voxelize.wgsl: one voxel from the triangles of its brick.

use super::pack::{
    Plane, albedo_encode, axis_u, axis_v, fine_albedo_encode, plane_decode, plane_encode, rgb9e5_encode, side_step,
};
use super::random::{Errors, pcg, unit_float};
use super::triangle::{Triangle, dither_order};
use crate::bricks::Mask;
use crate::gpu::shared::{CONTACT_LIST_MAX, EDGE_MAX, Material};
use glam::{DVec2, DVec3, IVec3, Vec3};

/// Columns of a voxel along an axis: 16 x 16.
const COLUMNS: usize = 16;
const ALL: usize = COLUMNS * COLUMNS;
/// f32 rounding of what is about a voxel.
const ERROR: f64 = 2e-6;

/// What a brick is made of.
pub struct Source<'a> {
    pub triangles: Vec<Triangle>,
    pub materials: &'a [Material],
    pub texels: &'a [u32],
    pub emission_max: f64,
    pub seed: u32,
    /// Cells of the apron that are out of reach.
    pub reach: Option<Mask>,
}

impl Source<'_> {
    pub fn is_unreached(&self, cell: IVec3) -> bool {
        let c = (cell + 1).as_uvec3();
        let bit = c.x + 10 * (c.y + 10 * c.z);
        self.reach.is_some_and(|mask| mask[(bit / 32) as usize] >> (bit % 32) & 1 == 1)
    }
}

/// A side that holds surface.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub plane: u32,
    pub mask: u16,
    pub albedo: u32,
    pub emission: u32,
    pub emits: bool,
}

/// A voxel's sides, and along which axes it holds a thin wall.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cut {
    pub sides: [Option<Surface>; 6],
    pub thin: [bool; 3],
    /// A crossing lets light through.
    pub translucent: bool,
}

/// A side's columns and what its outermost layer adds up to.
struct Layer {
    covered: [bool; ALL],
    count: f64,
    normal: DVec3,
    position: DVec3,
    albedo: DVec3,
    emission: DVec3,
    /// A crossing lets light through.
    translucent: bool,
}

/// A layer and its mean plane as it will be stored.
struct Side {
    layer: Layer,
    word: u32,
    plane: Plane,
}

fn column(index: usize) -> DVec2 {
    (DVec2::new((index % COLUMNS) as f64, (index / COLUMNS) as f64) + 0.5) / COLUMNS as f64
}

fn on_column(axis: usize, column: DVec2, height: f64) -> DVec3 {
    let mut p = DVec3::ZERO;
    p[axis] = height;
    p[axis_u(axis)] = column.x;
    p[axis_v(axis)] = column.y;
    p
}

/// Cuts the voxel `cell` of a brick.
pub fn cut(source: &Source, cell: IVec3, errors: &Errors) -> Cut {
    let near: Vec<Triangle> =
        source.triangles.iter().map(|t| t.moved(cell.as_dvec3())).filter(Triangle::is_near).collect();
    let mut translucent = false;
    let sides: [Option<Side>; 6] = std::array::from_fn(|side| {
        let layer = outermost(source, &near, side, errors);
        translucent |= layer.translucent;
        (layer.count > 0.0).then(|| mean(layer, side, errors))
    });
    let place = (cell.x + 8 * (cell.y + 8 * cell.z)) as u32;
    let seed_of = |side: usize| pcg(source.seed.wrapping_add(place)).wrapping_add(side as u32);
    let coverages: [Option<(u16, u32)>; 6] = std::array::from_fn(|side| {
        let cells = count_cells(&sides, side, sides[side].as_ref()?, errors);
        let is_dithered = translucent || is_edge(source, &sides, side, errors);
        Some(if is_dithered { dithered(&cells, seed_of(side), errors) } else { coverage(&cells) })
    });
    let part_filled = coverages.iter().flatten().any(|(mask, _)| *mask != 0xffff);
    let mut cut = Cut { translucent, ..Cut::default() };
    for side in 0..6 {
        let seed = seed_of(side);
        let seen = |own| coverages[side].map(|covered| surface(source, own, covered, part_filled, seed));
        cut.sides[side] = sides[side].as_ref().and_then(seen);
    }
    cut.thin = std::array::from_fn(|axis| is_thin(&sides, axis, errors));
    cut
}

/// The crossings that no other one of the same column lies in front of. Equal heights: the later triangle.
fn outermost(source: &Source, near: &[Triangle], side: usize, errors: &Errors) -> Layer {
    let (axis, high) = (side >> 1, side & 1 == 1);
    let zero = DVec3::ZERO;
    let mut layer = Layer {
        covered: [false; ALL],
        count: 0.0,
        normal: zero,
        position: zero,
        albedo: zero,
        emission: zero,
        translucent: false,
    };
    for index in 0..ALL {
        let c = column(index);
        let mut best: Option<(i32, f64, &Triangle)> = None;
        for t in near {
            if errors.on(t.normal[axis].abs(), 1e-7) <= 1e-4 || !(t.two_sided || (t.normal[axis] > 0.0) == high) {
                continue;
            }
            let height = t.height(axis, c, errors);
            if !(0.0..1.0).contains(&height) || !t.holds(axis, c, errors) || is_closed(t, near, axis, c, errors) {
                continue;
            }
            layer.translucent |= t.translucent;
            let at = [index % COLUMNS, index / COLUMNS].map(|v| v as u32);
            if !t.stops(at, on_column(axis, c, height), source.materials, source.texels, errors) {
                continue;
            }
            let level = (height * 65534.0) as i32 * if high { 1 } else { -1 };
            if best.is_none_or(|b| level >= b.0) {
                best = Some((level, height, t));
            }
        }
        let Some((_, height, t)) = best else { continue };
        let outward = (t.normal[axis] > 0.0) == high;
        let p = on_column(axis, c, height);
        layer.covered[index] = true;
        layer.count += 1.0;
        layer.normal += if outward { t.normal } else { -t.normal };
        layer.position += p;
        layer.albedo += t.albedo(p, source.materials, source.texels, errors);
        if outward {
            layer.emission += DVec3::from(source.materials[t.material].emission.map(f64::from));
        }
    }
    layer
}

/// Whether another solid's face covers the triangle here.
fn is_closed(t: &Triangle, near: &[Triangle], axis: usize, column: DVec2, errors: &Errors) -> bool {
    near.len() <= CONTACT_LIST_MAX as usize
        && near.iter().any(|other| t.is_contact(other, errors) && other.holds(axis, column, errors))
}

fn mean(layer: Layer, side: usize, errors: &Errors) -> Side {
    let sum = layer.normal;
    let flat = side_step(side).as_dvec3();
    let normal = if errors.on(sum.length_squared(), ERROR) > 1e-6 { sum.normalize() } else { flat };
    let centroid = errors.on3(layer.position / layer.count, ERROR);
    let word = plane_encode(side, errors.on3(normal, ERROR), centroid);
    Side { layer, word, plane: plane_decode(side, word) }
}

fn covers(side: &Side, axis: usize, p: DVec3, errors: &Errors) -> bool {
    let place = |x: f64| errors.on(x * COLUMNS as f64, 16.0 * ERROR).clamp(0.0, COLUMNS as f64 - 1.0) as usize;
    side.layer.covered[place(p[axis_v(axis)]) * COLUMNS + place(p[axis_u(axis)])]
}

/// Whether a point lies behind another side's covered plane, and not in front of that plane's covered opposite.
fn is_hidden(sides: &[Option<Side>; 6], side: usize, p: DVec3, errors: &Errors) -> bool {
    (0..6).filter(|k| *k != side).any(|k| {
        let Some(other) = &sides[k] else { return false };
        let axis = k >> 1;
        let behind = errors.on(other.plane.height(p), ERROR) < 0.016 && covers(other, axis, p, errors);
        let before_back = sides[k ^ 1]
            .as_ref()
            .is_some_and(|back| covers(back, axis, p, errors) && errors.on(back.plane.height(p), ERROR) > 0.0);
        behind && !before_back
    })
}

/// Covered and open columns of each sixteenth of a side.
fn count_cells(sides: &[Option<Side>; 6], side: usize, own: &Side, errors: &Errors) -> [(u32, u32); 16] {
    let axis = side >> 1;
    let n = own.plane.normal;
    let mut cells = [(0, 0); 16];
    for index in 0..ALL {
        let cell = &mut cells[index / COLUMNS / 4 * 4 + index % COLUMNS / 4];
        if own.layer.covered[index] {
            cell.0 += 1;
            continue;
        }
        let c = column(index);
        let flat = on_column(axis, c, 0.0);
        let height = errors.on((own.plane.offset - n.dot(flat)) / n[axis], ERROR / n[axis].abs());
        if height > -0.02 && height < 1.02 && !is_hidden(sides, side, on_column(axis, c, height) + n * 0.02, errors) {
            cell.1 += 1;
        }
    }
    cells
}

/// Cells at least half covered of what is not hidden; wholly hidden ones only beside a covered one; else the fullest.
/// With the number of columns that they stand for.
fn coverage(cells: &[(u32, u32); 16]) -> (u16, u32) {
    let total: u32 = cells.iter().map(|c| c.0).sum();
    if total >= 252 {
        return (0xffff, total);
    }
    let is_set = |k: usize| {
        let (covered, open) = cells[k];
        if covered + open == 0 { beside_covered(cells, k) } else { covered >= open }
    };
    let set: Vec<usize> = (0..16).filter(|k| is_set(*k)).collect();
    if set.is_empty() {
        let fullest = (0..16).rev().max_by_key(|k| cells[*k].0).unwrap_or(0);
        return (1 << fullest, cells[fullest].0 + cells[fullest].1);
    }
    let mask = set.iter().fold(0, |mask, k| mask | 1 << k);
    (mask, set.iter().map(|k| cells[*k].0 + cells[*k].1).sum())
}

fn beside_covered(cells: &[(u32, u32); 16], k: usize) -> bool {
    let near = |a: usize, b: usize| a.abs_diff(b) <= 1;
    (0..16).any(|j| near(j % 4, k % 4) && near(j / 4, k / 4) && cells[j].0 > 0)
}

/// Where light comes through, and on thin edges: as many cells as are covered on average over voxels.
fn dithered(cells: &[(u32, u32); 16], seed: u32, errors: &Errors) -> (u16, u32) {
    let total: u32 = cells.iter().map(|c| c.0).sum();
    if total >= 252 {
        return (0xffff, total);
    }
    let random = pcg(seed.wrapping_add(3));
    let is_set = |k: &usize| {
        let (covered, open) = cells[*k];
        let order = dither_order(*k as u32 & 3 ^ random & 3, *k as u32 >> 2 ^ random >> 2 & 3, 2);
        let threshold = (f64::from(order) + unit_float(random)) / 16.0;
        let of = f64::from(covered + open);
        if of == 0.0 { beside_covered(cells, *k) } else { errors.on(f64::from(covered), 1e-5) > threshold * of }
    };
    let set = (0..16).filter(is_set);
    set.fold((0, 0), |(mask, area), k| (mask | 1 << k, area + cells[k].0 + cells[k].1))
}

fn surface(source: &Source, own: &Side, (mask, area): (u16, u32), part_filled: bool, seed: u32) -> Surface {
    let dither = DVec3::from(std::array::from_fn(|k| unit_float(pcg(seed.wrapping_add(k as u32)))));
    let albedo = own.layer.albedo / own.layer.count;
    let share = (f64::from(area) / 256.0).max(1e-3);
    let emission: Vec3 = (own.layer.emission / 256.0 / share).as_vec3();
    Surface {
        plane: own.word,
        mask,
        albedo: if part_filled { albedo_encode(albedo, dither).into() } else { fine_albedo_encode(albedo) },
        emission: rgb9e5_encode(emission, Vec3::splat(0.5)),
        emits: emits(source, own),
    }
}

fn emits(source: &Source, own: &Side) -> bool {
    own.layer.emission.element_sum() / source.emission_max > 1e-6
}

/// Both sides of an axis, apart, and neither on the voxel's border.
fn is_thin(sides: &[Option<Side>; 6], axis: usize, errors: &Errors) -> bool {
    thickness(sides, axis, errors).is_some_and(|(low, high)| high > low && high < 0.995 && low > 0.005)
}

/// Whether a side is the edge of a board or rod that cells are too coarse for, and does not emit.
fn is_edge(source: &Source, sides: &[Option<Side>; 6], side: usize, errors: &Errors) -> bool {
    let limit = f64::from(EDGE_MAX);
    let is_thin = |axis| thickness(sides, axis, errors).is_some_and(|(low, high)| high > low && high - low < limit);
    !sides[side].as_ref().is_some_and(|own| emits(source, own)) && (0..3).any(|axis| axis != side >> 1 && is_thin(axis))
}

/// Mean places of an axis's two sides.
fn thickness(sides: &[Option<Side>; 6], axis: usize, errors: &Errors) -> Option<(f64, f64)> {
    let (Some(low), Some(high)) = (&sides[axis * 2], &sides[axis * 2 + 1]) else { return None };
    let at = |side: &Side| errors.on(side.layer.position[axis] / side.layer.count, ERROR);
    (low.layer.count.min(high.layer.count) >= 5.0).then(|| (at(low), at(high)))
}
