//! A window of bricks in plain words, and packed as the shaders read it.

use super::layout::{self, Brick, Voxel};
use crate::bricks::Grid;
use crate::gpu::shared::{BRICK_VOXELS, Frame, GROUP_VOXELS, GROUP_WORDS, PAGE_WORDS};
use glam::{IVec3, UVec3};
use std::collections::HashMap;

const BRICK: i32 = BRICK_VOXELS as i32;

/// Voxels in a window; positions are those of grid space.
pub struct World {
    /// In groups.
    pub extent: UVec3,
    /// Low corner in groups.
    pub window: IVec3,
    voxels: Vec<Voxel>,
    /// Place in `voxels` of every cell of the window, or `u32::MAX`.
    cells: Vec<u32>,
}

/// What the shaders see of a world.
pub struct Packed {
    pub grid: Vec<u32>,
    pub bricks: Vec<u32>,
    /// `extent`, `torus` and bounds; the rest is zero.
    pub frame: Frame,
    /// Word of a lit side's radiance: cell and side.
    pub lights: HashMap<(IVec3, usize), u32>,
}

impl World {
    pub fn new(extent: UVec3, window: IVec3) -> Self {
        let cells = extent * GROUP_VOXELS;
        Self { extent, window, voxels: Vec::new(), cells: vec![u32::MAX; (cells.x * cells.y * cells.z) as usize] }
    }

    /// In voxels.
    pub fn size(&self) -> IVec3 {
        (self.extent * GROUP_VOXELS).as_ivec3()
    }

    fn index(&self, cell: IVec3) -> Option<usize> {
        let size = self.size();
        let inside = cell.cmpge(IVec3::ZERO).all() && cell.cmplt(size).all();
        inside.then(|| (cell.x + size.x * (cell.y + size.y * cell.z)) as usize)
    }

    pub fn insert(&mut self, cell: IVec3, voxel: Voxel) {
        let index = self.index(cell).expect("inside the window");
        self.cells[index] = self.voxels.len() as u32;
        self.voxels.push(voxel);
    }

    pub fn voxel(&self, cell: IVec3) -> Option<&Voxel> {
        self.voxels.get(self.cells[self.index(cell)?] as usize)
    }

    /// Occupied cells in order.
    pub fn occupied(&self) -> Vec<IVec3> {
        let size = self.size();
        let filled = (0..self.cells.len() as i32).filter(|i| self.cells[*i as usize] != u32::MAX);
        filled.map(|i| IVec3::new(i % size.x, i / size.x % size.y, i / (size.x * size.y))).collect()
    }

    /// Packs everything. Bricks enter the grid in an order that is not theirs.
    pub fn pack(&self) -> Packed {
        let mut bricks: HashMap<IVec3, Brick> = HashMap::new();
        for cell in self.occupied() {
            let brick = bricks.entry(cell / BRICK).or_default();
            brick.insert(cell % BRICK, *self.voxel(cell).expect("occupied"));
        }
        let mut order: Vec<IVec3> = bricks.keys().copied().collect();
        order.sort_unstable_by_key(|b| (b.x * 7 + b.y * 5 + b.z * 3) % 11 * 4096 + b.x * 256 + b.y * 16 + b.z);
        let mut grid = Grid::new(self.extent);
        let (mut words, mut lights) = (Vec::new(), HashMap::new());
        for position in &order {
            let first = (words.len() as u32).next_multiple_of(PAGE_WORDS);
            words.resize(first as usize, 0xdead_beef);
            let (packed, brick_lights) = layout::encode(&bricks[position]);
            words.extend(packed);
            let light = |((cell, side), word)| ((*position * BRICK + cell, side), first + word);
            lights.extend(brick_lights.into_iter().map(light));
            grid.insert(*position + self.window * 4, first);
        }
        let mut memory = vec![0; grid.words() as usize];
        grid.take_writes().into_iter().for_each(|[at, word]| memory[at as usize] = word);
        let low = order.iter().fold(IVec3::MAX, |low, b| low.min(*b)) * BRICK;
        let high = order.iter().fold(IVec3::MIN, |high, b| high.max(*b + 1)) * BRICK;
        let frame = Frame {
            extent: self.extent.to_array(),
            torus: (self.window.as_uvec3() & (self.extent - 1)).to_array(),
            bounds_min: low.as_vec3().to_array(),
            bounds_max: high.as_vec3().to_array(),
            voxel_size: 1.0,
            emission_max: 1.0,
            ..Frame::default()
        };
        Packed { grid: memory, bricks: words, frame, lights }
    }
}

/// Twin of lib/world.wgsl `find_brick`: the first word of a brick at a place in a window of `extent` groups whose low
/// corner is `window` (bricks).
pub fn find_brick(world_grid: &[u32], extent: UVec3, window: IVec3, brick: UVec3) -> Option<u32> {
    let torus = (window >> 2i32).as_uvec3() & (extent - 1);
    let g = ((brick >> 2u32) + torus) & (extent - 1);
    let group = ((g.x + extent.x * (g.y + extent.y * g.z)) * GROUP_WORDS) as usize;
    let bit = (brick.x & 3) | (brick.y & 3) << 2 | (brick.z & 3) << 4;
    let mask = u64::from(world_grid[group]) | u64::from(world_grid[group + 1]) << 32;
    let rank = (mask & ((1 << bit) - 1)).count_ones();
    (mask >> bit & 1 == 1).then(|| world_grid[(world_grid[group + 2] + rank) as usize])
}
