//! What the regions say, held against a flood from cell to cell.

use super::*;
use crate::twin::random::Random;
use rustc_hash::FxHashSet;
use std::collections::HashMap;

/// Bricks of a test world along an axis.
const BRICKS: i32 = 6;
const VOXELS: i32 = 8 * BRICKS;

/// Occupied cells, by position; what lies beyond is empty.
struct Model {
    low: IVec3,
    cells: Vec<bool>,
}

impl Model {
    /// Somewhere about a corner of groups, below zero too.
    fn new(random: &mut Random) -> Self {
        let low = IVec3::from_array(std::array::from_fn(|_| random.below(12) as i32 - 8));
        Self { low, cells: vec![false; VOXELS.pow(3) as usize] }
    }

    fn index(&self, cell: IVec3) -> Option<usize> {
        let p = cell - self.low * 8;
        let inside = p.cmpge(IVec3::ZERO).all() && p.cmplt(IVec3::splat(VOXELS)).all();
        inside.then(|| (p.x + VOXELS * (p.y + VOXELS * p.z)) as usize)
    }

    fn put(&mut self, cell: IVec3, occupied: bool) {
        if let Some(index) = self.index(cell) {
            self.cells[index] = occupied;
        }
    }

    fn is_occupied(&self, cell: IVec3) -> bool {
        self.index(cell).is_some_and(|index| self.cells[index])
    }

    fn random_cell(&self, random: &mut Random) -> IVec3 {
        self.low * 8 + IVec3::from_array(std::array::from_fn(|_| random.below(VOXELS as u32) as i32))
    }

    /// The walls of a box, or nothing where it had been.
    fn put_box(&mut self, random: &mut Random, occupied: bool) {
        let corner = self.random_cell(random);
        let size = IVec3::from_array(std::array::from_fn(|_| random.below(20) as i32 + 1));
        for z in 0..=size.z {
            for y in 0..=size.y {
                for x in 0..=size.x {
                    let p = IVec3::new(x, y, z);
                    if p.cmpeq(IVec3::ZERO).any() || p.cmpeq(size).any() {
                        self.put(corner + p, occupied);
                    }
                }
            }
        }
    }

    fn bricks(&self) -> impl Iterator<Item = IVec3> + use<> {
        let low = self.low;
        (0..BRICKS.pow(3)).map(move |i| low + IVec3::new(i % BRICKS, i / BRICKS % BRICKS, i / BRICKS.pow(2)))
    }

    fn brick(&self, brick: IVec3) -> Cells {
        let occupied = Cells::ALL.iter().filter(|p| self.is_occupied(brick * 8 + p.as_ivec3()));
        occupied.fold(Cells::NONE, |cells, p| cells | Cells::cell(p))
    }

    /// Cell by cell, what is reached from outside and from some cells.
    fn reached(&self, seeds: &[IVec3]) -> FxHashSet<IVec3> {
        let (low, high) = (self.low * 8 - 1, self.low * 8 + VOXELS + 1);
        let mut stack = vec![low];
        stack.extend(seeds.iter().filter(|s| !self.is_occupied(**s)));
        let mut reached: FxHashSet<IVec3> = stack.iter().copied().collect();
        while let Some(cell) = stack.pop() {
            for next in (0..6).map(|side| cell + side_step(side)) {
                let inside = next.cmpge(low).all() && next.cmplt(high).all();
                if inside && !self.is_occupied(next) && reached.insert(next) {
                    stack.push(next);
                }
            }
        }
        reached
    }

    fn tell(&self, regions: &mut Regions) {
        self.bricks().for_each(|b| regions.set(b, self.brick(b)));
    }
}

/// Frames until there is no more to do.
fn settle(regions: &mut Regions) {
    let mut quiet = 0;
    for frame in 0.. {
        let bricks = regions.update(true);
        quiet = if bricks.is_empty() && regions.next.is_none() && regions.checks.is_empty() { quiet + 1 } else { 0 };
        if quiet > 2 {
            break;
        }
        assert!(frame < 1000, "there is always more to do");
    }
}

/// Which empty cells in and beside a brick are not reached; corners do not count.
fn expected_mask(model: &Model, reached: &FxHashSet<IVec3>, brick: IVec3) -> Mask {
    let mut mask = Mask::default();
    for (bit, p) in (0..1000).map(|i| (i, IVec3::new(i % 10, i / 10 % 10, i / 100) - 1)) {
        let outside = (p & 7i32).cmpne(p);
        let cell = brick * 8 + p;
        if u32::from(outside.x) + u32::from(outside.y) + u32::from(outside.z) < 2
            && !model.is_occupied(cell)
            && model.index(cell).is_some()
            && !reached.contains(&cell)
        {
            mask[bit as usize / 32] |= 1 << (bit % 32);
        }
    }
    mask
}

/// Whether a voxel of the brick looks at an empty cell that is not reached.
fn needs_mask(model: &Model, reached: &FxHashSet<IVec3>, brick: IVec3) -> bool {
    let occupied = model.brick(brick);
    occupied.iter().any(|p| {
        (0..6)
            .map(|side| brick * 8 + p.as_ivec3() + side_step(side))
            .any(|c| !model.is_occupied(c) && !reached.contains(&c))
    })
}

fn random_world(random: &mut Random) -> Model {
    let mut model = Model::new(random);
    for _ in 0..random.below(40) {
        model.put_box(random, true);
    }
    for _ in 0..random.below(20_000) {
        let cell = model.random_cell(random);
        model.put(cell, true);
    }
    model
}

fn assert_exact(model: &Model, regions: &Regions, seeds: &[IVec3], what: &str) {
    let reached = model.reached(seeds);
    for brick in model.bricks() {
        let expected = needs_mask(model, &reached, brick).then(|| expected_mask(model, &reached, brick));
        assert_eq!(regions.mask(brick), expected, "{what}, brick {brick}");
    }
}

#[test]
fn masks_are_what_a_flood_from_cell_to_cell_leaves() {
    let mut random = Random::new(61);
    let mut masked = 0;
    for world in 0..60 {
        let model = random_world(&mut random);
        let mut regions = Regions::default();
        let eye = model.random_cell(&mut random);
        regions.follow([eye].into_iter());
        model.tell(&mut regions);
        settle(&mut regions);
        assert_exact(&model, &regions, &around(&model, eye), &format!("world {world}"));
        masked += model.bricks().filter(|b| regions.mask(*b).is_some()).count();
    }
    assert!(masked > 1000, "{masked} masks: most worlds are meant to have closed rooms");
}

/// Regions, what they have been told, and what has been voxelised with which mask.
struct History {
    random: Random,
    model: Model,
    /// Of the model, what the regions know.
    known: Model,
    regions: Regions,
    masks: HashMap<IVec3, Option<Mask>>,
    opened: usize,
    closed: usize,
}

impl History {
    fn new(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let model = random_world(&mut random);
        let known = Model { low: model.low, cells: vec![false; model.cells.len()] };
        let (regions, masks) = Default::default();
        let mut history = Self { random, model, known, regions, masks, opened: 0, closed: 0 };
        history.voxelize(history.model.bricks().collect());
        history
    }

    /// As the world does: with the mask of the moment.
    fn voxelize(&mut self, bricks: Vec<IVec3>) {
        for brick in bricks {
            let mask = self.regions.mask(brick);
            self.regions.start(brick, mask.is_some());
            let bits = |m: Option<Mask>| m.iter().flatten().map(|w| w.count_ones()).sum::<u32>();
            let before = self.masks.insert(brick, mask).map_or(0, bits);
            self.opened += usize::from(bits(mask) < before);
            self.closed += usize::from(bits(mask) > before);
            self.know(brick, true);
            self.regions.arrive(brick, self.model.brick(brick));
        }
    }

    fn know(&mut self, brick: IVec3, known: bool) {
        for cell in Cells::ALL.iter().map(|p| brick * 8 + p.as_ivec3()) {
            self.known.put(cell, known && self.model.is_occupied(cell));
        }
    }

    fn forget(&mut self, bricks: Vec<IVec3>) {
        for brick in bricks {
            self.masks.remove(&brick);
            self.know(brick, false);
        }
    }

    fn frame(&mut self, short: bool) -> bool {
        let again = self.regions.update(short);
        let quiet = again.is_empty() && self.regions.next.is_none() && self.regions.checks.is_empty();
        self.voxelize(again);
        quiet
    }

    fn bricks(&mut self, share: f64) -> Vec<IVec3> {
        self.model.bricks().filter(|_| self.random.chance(share)).collect()
    }

    /// Something comes or goes, what is out of sight is forgotten or seen again, rays ask, or the camera moves.
    fn operate(&mut self) {
        match self.random.below(8) {
            0..3 => {
                let occupied = self.random.chance(0.4);
                self.model.put_box(&mut self.random, occupied);
                let changed = |b: &IVec3| self.model.brick(*b) != self.known.brick(*b);
                let changed = self.model.bricks().filter(changed).collect();
                self.voxelize(changed);
            }
            3 => {
                let bricks = self.bricks(0.05);
                bricks.iter().for_each(|b| self.regions.forget(*b));
                self.forget(bricks);
            }
            4 => {
                let window = self.model.low + IVec3::new(self.random.below(BRICKS as u32) as i32, 0, 0);
                let leaving = self.model.bricks().filter(|b| b.cmplt(window).any()).collect();
                self.regions.retain(|brick| brick.cmpge(window).all());
                self.forget(leaving);
            }
            5 => {
                let bricks = self.bricks(0.5);
                self.voxelize(bricks);
            }
            6 => {
                let corner = self.model.random_cell(&mut self.random) & !1i32;
                self.regions.take_requests([(corner, 100)].into_iter(), 10_000, 1e-4);
            }
            _ => {
                let eye = self.model.random_cell(&mut self.random);
                self.regions.follow([eye].into_iter());
            }
        }
    }

    /// Frames until there is no more to do.
    fn settle(&mut self) {
        let mut quiet = 0;
        for frame in 0.. {
            quiet = if self.frame(true) { quiet + 1 } else { 0 };
            if quiet > 2 {
                break;
            }
            assert!(frame < 1000, "there is always more to do");
        }
    }

    fn check(&self, what: &str) {
        let asked = self.regions.asked.iter().map(|cell| IVec3::from(*cell));
        let seeds: Vec<IVec3> =
            asked.chain(self.regions.eyes.iter().copied()).flat_map(|s| around(&self.known, s)).collect();
        assert_exact(&self.known, &self.regions, &seeds, what);
        let reached = self.known.reached(&seeds);
        for (brick, mask) in &self.masks {
            let looked_at = mask.iter().flat_map(|mask| looked_at(&self.known, mask, *brick));
            looked_at.for_each(|p| assert!(!reached.contains(&p), "{what}: {p} is reached, and masked in {brick}"));
            let sides = self.regions.unreached_sides(*brick);
            let before = self.regions.masked.get(brick).copied().unwrap_or(0);
            assert!(sides < before + GAIN_MIN, "{what}: {brick} might save {sides} and saves {before}");
        }
    }
}

/// A cell, or those around it where it is occupied.
fn around(model: &Model, cell: IVec3) -> Vec<IVec3> {
    if model.is_occupied(cell) {
        (0..27).map(|i| cell + IVec3::new(i % 3, i / 3 % 3, i / 9) - 1).collect()
    } else {
        vec![cell]
    }
}

/// Whatever happens, memory short or not, in the end nothing that is reached is masked, and all is as if it had been so
/// from the start.
#[test]
fn after_any_history_what_is_reached_is_what_a_new_flood_reaches() {
    let (mut opened, mut closed) = (0, 0);
    for world in 0..20 {
        let mut history = History::new(62 + world);
        for round in 0..8 {
            for _ in 0..history.random.below(12) {
                history.operate();
                let short = history.random.chance(0.95);
                history.frame(short);
            }
            history.settle();
            history.check(&format!("world {world}, round {round}"));
        }
        history.frame(false);
        assert!(!history.regions.any_masked() && history.masks.values().all(Option::is_none));
        (opened, closed) = (opened + history.opened, closed + history.closed);
    }
    println!("{opened} bricks opened, {closed} closed");
    assert!(opened > 100 && closed > 100, "{opened} bricks opened, {closed} closed");
}

/// Masked empty cells that a voxel of the brick looks at.
fn looked_at(model: &Model, mask: &Mask, brick: IVec3) -> Vec<IVec3> {
    let masked = |p: IVec3| {
        let c = p + 1;
        let bit = c.x + 10 * (c.y + 10 * c.z);
        mask[bit as usize / 32] >> (bit % 32) & 1 == 1
    };
    let occupied: Vec<IVec3> = model.brick(brick).iter().map(|p| p.as_ivec3()).collect();
    let fronts = occupied.into_iter().flat_map(|p| (0..6).map(move |side| p + side_step(side)));
    fronts.filter(|p| masked(*p)).map(|p| brick * 8 + p).filter(|c| !model.is_occupied(*c)).collect()
}

#[test]
fn nothing_is_done_while_nothing_is_wanted() {
    let mut random = Random::new(63);
    let model = random_world(&mut random);
    let mut regions = Regions::default();
    model.tell(&mut regions);
    assert!(regions.update(false).is_empty());
    assert!(regions.reached.is_none() && regions.next.is_none());
    assert!(model.bricks().all(|b| regions.mask(b).is_none()));
    settle(&mut regions);
    assert!(regions.reached.is_some());
    assert!(!regions.stale && regions.update(true).is_empty() && regions.next.is_none(), "nothing has changed");
}
