//! What of the empty space is connected, from brick to brick.
//!
//! Two levels, both bit-parallel: cells in bricks that hold surface, bricks without surface in their group.

use super::cells::{Cells, side_step};
use glam::{IVec3, UVec3};
use rustc_hash::FxHashMap;

/// Group of a brick, and its bit there: x + 4 y + 16 z.
fn place(brick: IVec3) -> (IVec3, u32) {
    let child = (brick & 3i32).as_uvec3();
    (brick >> 2i32, child.x + 4 * child.y + 16 * child.z)
}

/// Of a group's bricks, the first and the last layer along each axis.
const FIRST: [u64; 3] = [0x1111_1111_1111_1111, 0x000f_000f_000f_000f, 0xffff];
const LAST: [u64; 3] = [FIRST[0] << 3, FIRST[1] << 12, FIRST[2] << 48];

/// Bricks of a group, moved by one towards a side; what leaves the group is lost.
fn shifted(bricks: u64, side: usize) -> u64 {
    let axis = side >> 1;
    if side & 1 == 1 {
        (bricks & !LAST[axis]) << (1 << (2 * axis))
    } else {
        (bricks & !FIRST[axis]) >> (1 << (2 * axis))
    }
}

/// Of the group beyond a side, the bricks that touch these.
fn across(bricks: u64, side: usize) -> u64 {
    let axis = side >> 1;
    if side & 1 == 1 { (bricks & LAST[axis]) >> (3 << (2 * axis)) } else { (bricks & FIRST[axis]) << (3 << (2 * axis)) }
}

fn flood(bricks: u64, within: u64) -> u64 {
    let mut reached = bricks & within;
    loop {
        let grown = (0..6).fold(reached, |grown, side| grown | shifted(reached, side)) & within;
        if grown == reached {
            return reached;
        }
        reached = grown;
    }
}

fn bits(mask: u64) -> impl Iterator<Item = u32> {
    (0..64).filter(move |bit| mask >> bit & 1 == 1)
}

/// Which cells hold surface, as far as that is known.
#[derive(Default)]
pub struct Space {
    bricks: FxHashMap<IVec3, Cells>,
    /// Of each group, the bricks that hold surface.
    groups: FxHashMap<IVec3, u64>,
}

impl Space {
    /// Cells of a brick that hold surface; all others are empty, or nothing is known of them.
    pub fn occupied(&self, brick: IVec3) -> Cells {
        self.bricks.get(&brick).copied().unwrap_or(Cells::NONE)
    }

    /// Whether a brick is known to hold surface.
    pub fn holds(&self, brick: IVec3) -> bool {
        self.bricks.contains_key(&brick)
    }

    /// Bricks that hold surface.
    pub fn bricks(&self) -> impl Iterator<Item = IVec3> {
        self.bricks.keys().copied()
    }

    /// Says what a brick holds.
    pub fn set(&mut self, brick: IVec3, occupied: Cells) {
        let (group, bit) = place(brick);
        if occupied.is_empty() {
            if self.bricks.remove(&brick).is_some()
                && let Some(mask) = self.groups.get_mut(&group)
            {
                *mask &= !(1 << bit);
                if *mask == 0 {
                    self.groups.remove(&group);
                }
            }
        } else {
            self.bricks.insert(brick, occupied);
            *self.groups.entry(group).or_default() |= 1 << bit;
        }
    }

    fn holding(&self, group: IVec3) -> u64 {
        self.groups.get(&group).copied().unwrap_or(0)
    }
}

/// Where a flood is about to go on.
#[derive(Clone, Copy)]
enum Front {
    /// Cells of a brick.
    Cells(IVec3, Cells),
    /// Bricks of a group, each through this side of its own.
    Bricks(IVec3, usize, u64),
}

/// What can be reached through empty cells from outside of all surface and from other cells. It follows changes: what
/// opens is flooded; what closes is only seen by a new flood.
pub struct Flood {
    /// Corner and size, in groups, of what holds surface. Everything beyond is reached.
    low: IVec3,
    size: IVec3,
    /// Of each group, the reached ones of the bricks without surface.
    groups: Vec<u64>,
    /// Reached cells of the bricks with surface.
    bricks: FxHashMap<IVec3, Cells>,
    frontier: Vec<Front>,
    /// Bricks with surface that reached cells have come to lie in or beside.
    opened: Vec<IVec3>,
}

impl Flood {
    /// Begins from outside; [`Self::go_on`] does the work.
    pub fn new(space: &Space) -> Self {
        let corners = space.groups.keys().map(|g| (*g, *g + 1)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (low, high) = corners.unwrap_or_default();
        let size = high - low;
        let mut frontier = Vec::new();
        for side in 0..6 {
            let axis = side >> 1;
            let mut first = low;
            let mut layer = size;
            layer[axis] = layer[axis].min(1);
            if side & 1 == 1 {
                first[axis] = high[axis] - layer[axis];
            }
            let mask = if side & 1 == 1 { LAST[axis] } else { FIRST[axis] };
            let count = layer.x * layer.y * layer.z;
            frontier.extend((0..count).map(|i| {
                let place = IVec3::new(i % layer.x, i / layer.x % layer.y, i / (layer.x * layer.y));
                Front::Bricks(first + place, side, mask)
            }));
        }
        let (bricks, opened) = Default::default();
        Self { low, size, groups: vec![0; (size.x * size.y * size.z) as usize], bricks, frontier, opened }
    }

    fn index(&self, group: IVec3) -> Option<usize> {
        let p = group - self.low;
        let inside = p.cmpge(IVec3::ZERO).all() && p.cmplt(self.size).all();
        inside.then(|| (p.x + self.size.x * (p.y + self.size.y * p.z)) as usize)
    }

    /// Reached cells of a brick.
    pub fn reached(&self, space: &Space, brick: IVec3) -> Cells {
        let (group, bit) = place(brick);
        match self.index(group) {
            None => !space.occupied(brick),
            Some(_) if space.holds(brick) => self.bricks.get(&brick).copied().unwrap_or(Cells::NONE),
            Some(index) if self.groups[index] >> bit & 1 == 1 => Cells::ALL,
            Some(_) => Cells::NONE,
        }
    }

    /// Of a brick's cells, those beside a reached one of another brick.
    fn entered(&self, space: &Space, brick: IVec3) -> Cells {
        let from = |side: usize| self.reached(space, brick + side_step(side)).across(side ^ 1);
        (0..6).fold(Cells::NONE, |cells, side| cells | from(side))
    }

    /// Goes on from a cell. Whether it had not been reached, and is empty.
    pub fn seed(&mut self, space: &Space, brick: IVec3, cell: UVec3) -> bool {
        let cells = Cells::cell(cell);
        let new = (cells & !space.occupied(brick) & !self.reached(space, brick)) == cells;
        if new {
            self.frontier.push(Front::Cells(brick, cells));
        }
        new
    }

    /// A brick now holds other surface, which `space` already has; `was`: its reached cells before.
    pub fn changed(&mut self, space: &Space, brick: IVec3, was: Cells) {
        let (group, bit) = place(brick);
        let Some(index) = self.index(group) else { return };
        let entered = self.entered(space, brick);
        if space.holds(brick) {
            self.groups[index] &= !(1 << bit);
            self.bricks.insert(brick, was & !space.occupied(brick));
            self.fill(space, brick, was.grown() | entered);
        } else {
            self.bricks.remove(&brick);
            if !(was | entered).is_empty() {
                self.enter(space, group, 0, 1 << bit);
            }
        }
    }

    /// Does up to `steps` steps. Whether nothing is left to do.
    pub fn go_on(&mut self, space: &Space, steps: usize) -> bool {
        for _ in 0..steps {
            match self.frontier.pop() {
                None => return true,
                Some(Front::Bricks(group, side, mask)) => self.enter(space, group, side, mask),
                Some(Front::Cells(brick, _)) if self.index(brick >> 2i32).is_none() => {}
                Some(Front::Cells(brick, cells)) if space.holds(brick) => {
                    self.opened.push(brick);
                    self.fill(space, brick, cells);
                }
                Some(Front::Cells(brick, _)) => {
                    let (group, bit) = place(brick);
                    self.enter(space, group, 0, 1 << bit);
                }
            }
        }
        self.is_done()
    }

    /// Whether nothing is left to do.
    pub fn is_done(&self) -> bool {
        self.frontier.is_empty()
    }

    /// The bricks that it has come to since the last call; some more than once.
    pub fn take_opened(&mut self) -> Vec<IVec3> {
        std::mem::take(&mut self.opened)
    }

    /// Enters cells of a brick that holds surface.
    fn fill(&mut self, space: &Space, brick: IVec3, cells: Cells) {
        let reached = self.bricks.entry(brick).or_default();
        let free = !space.occupied(brick) & !*reached;
        let new = cells.flood(free);
        if new.is_empty() {
            return;
        }
        *reached |= new;
        self.opened.push(brick);
        for side in 0..6 {
            let out = new.across(side);
            if !out.is_empty() {
                self.frontier.push(Front::Cells(brick + side_step(side), out));
            }
        }
    }

    /// Enters bricks of a group through their side `through`.
    fn enter(&mut self, space: &Space, group: IVec3, through: usize, mask: u64) {
        let Some(index) = self.index(group) else { return };
        let holding = space.holding(group);
        let mut cells = |group: IVec3, mask: u64, through: usize| {
            let layer = Cells::layer(through);
            let brick = |bit: u32| (group << 2i32) + (UVec3::new(bit, bit >> 2, bit >> 4) & 3u32).as_ivec3();
            self.frontier.extend(bits(mask).map(|bit| Front::Cells(brick(bit), layer)));
        };
        cells(group, mask & holding, through);
        let new = flood(mask, !holding & !self.groups[index]);
        if new == 0 {
            return;
        }
        for side in 0..6 {
            cells(group, shifted(new, side) & holding, side ^ 1);
        }
        self.groups[index] |= new;
        for side in 0..6 {
            let out = across(new, side);
            if out != 0 {
                self.frontier.push(Front::Bricks(group + side_step(side), side ^ 1, out));
            }
        }
    }
}
