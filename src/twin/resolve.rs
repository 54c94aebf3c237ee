//! Twin of passes/face_resolve.wgsl: what of a brick's voxels is stored, and what is lit.

use super::layout::{Brick, Face, Voxel};
use super::pack::{plane_encode, side_step};
use super::random::Errors;
use super::voxelize::{Cut, Source, Surface, cut};
use crate::settings::HitModel;
use glam::{DVec3, IVec3};
use std::collections::HashMap;

/// A whole brick.
pub fn voxelize(source: &Source, model: HitModel, errors: &Errors) -> Brick {
    let cells = (-1..9).flat_map(|z| (-1..9).flat_map(move |y| (-1..9).map(move |x| IVec3::new(x, y, z))));
    let cuts: HashMap<IVec3, Cut> = cells.map(|cell| (cell, cut(source, cell, errors))).collect();
    let inner = cuts
        .iter()
        .filter(|(cell, cut)| cell.cmpge(IVec3::ZERO).all() && cell.cmplt(IVec3::splat(8)).all() && is_occupied(cut));
    inner.map(|(cell, cut)| (*cell, voxel(&cuts, *cell, cut, model))).collect()
}

fn is_occupied(cut: &Cut) -> bool {
    cut.sides.iter().any(Option::is_some)
}

fn voxel(cuts: &HashMap<IVec3, Cut>, cell: IVec3, cut: &Cut, model: HitModel) -> Voxel {
    let mut voxel = Voxel { translucent: cut.translucent, ..Voxel::default() };
    for side in 0..6 {
        let front = &cuts[&(cell + side_step(side))];
        let open = !is_occupied(front);
        let own = cut.sides[side];
        // Cube hits need every open side: without surface it borrows another side's albedo (hole repair).
        let borrowed = (model == HitModel::Cube && open).then(|| outer_wall(cut, side));
        let Some(surface) = own.or(borrowed) else { continue };
        let thin_wall = (0..3).any(|a| a != side >> 1 && (cut.thin[a] || front.thin[a]));
        let lit = open || (model == HitModel::Plane && (surface.emits || !thin_wall));
        voxel.faces[side] = Some(Face {
            plane: surface.plane,
            mask: surface.mask,
            lit,
            albedo: surface.albedo,
            emission: if lit { surface.emission } else { 0 },
        });
    }
    voxel
}

fn outer_wall(cut: &Cut, side: usize) -> Surface {
    let like = cut.sides.iter().flatten().next().expect("an occupied voxel");
    let n = side_step(side).as_dvec3();
    let plane = plane_encode(side, n, DVec3::splat(0.5) + n * 0.49);
    Surface { plane, emission: 0, emits: false, ..*like }
}
