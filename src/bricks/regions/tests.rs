//! What the regions say, held against a flood from cell to cell.

use super::*;
use crate::twin::random::Random;
use std::collections::{HashMap, HashSet};

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
    fn reached(&self, seeds: &[IVec3]) -> HashSet<IVec3> {
        let (low, high) = (self.low * 8 - 1, self.low * 8 + VOXELS + 1);
        let mut stack = vec![low];
        stack.extend(seeds.iter().filter(|s| !self.is_occupied(**s)));
        let mut reached: HashSet<IVec3> = stack.iter().copied().collect();
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

/// Frames until there is no more to do; the bricks to be voxelised again.
fn settle(regions: &mut Regions) -> HashSet<IVec3> {
    let mut again = HashSet::new();
    let mut quiet = 0;
    for frame in 0.. {
        let bricks = regions.update(true);
        quiet = if bricks.is_empty() && regions.next.is_none() && regions.checks.is_empty() { quiet + 1 } else { 0 };
        again.extend(bricks);
        if quiet > 2 {
            return again;
        }
        assert!(frame < 1000, "there is always more to do");
    }
    again
}

/// Which empty cells in and beside a brick are not reached; corners do not count.
fn expected_mask(model: &Model, reached: &HashSet<IVec3>, brick: IVec3) -> Mask {
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
fn needs_mask(model: &Model, reached: &HashSet<IVec3>, brick: IVec3) -> bool {
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
        regions.follow(&[eye.as_dvec3() + 0.5]);
        model.tell(&mut regions);
        settle(&mut regions);
        let around: Vec<IVec3> = if model.is_occupied(eye) {
            (0..27).map(|i| eye + IVec3::new(i % 3, i / 3 % 3, i / 9) - 1).collect()
        } else {
            vec![eye]
        };
        assert_exact(&model, &regions, &around, &format!("world {world}"));
        masked += model.bricks().filter(|b| regions.mask(*b).is_some()).count();
    }
    assert!(masked > 1000, "{masked} masks: most worlds are meant to have closed rooms");
}

/// Whatever changes, nothing that is reached stays masked for longer than the flood needs, and in the end all is exact.
#[test]
fn what_opens_is_voxelised_again_and_what_closes_too() {
    let mut random = Random::new(62);
    let (mut opened, mut closed) = (0, 0);
    for world in 0..20 {
        let mut model = random_world(&mut random);
        let mut regions = Regions::default();
        model.tell(&mut regions);
        settle(&mut regions);
        let mut masks: HashMap<IVec3, Option<Mask>> = HashMap::new();
        for brick in model.bricks() {
            masks.insert(brick, regions.mask(brick));
            regions.start(brick, masks[&brick].is_some());
        }
        for change in 0..8 {
            let occupied = random.chance(0.4);
            (0..3).for_each(|_| model.put_box(&mut random, occupied));
            // In two parts, with a frame between them: a flood is on its way when the second comes.
            let split = random.below(BRICKS.pow(3) as u32) as usize;
            let mut again = HashSet::new();
            model.bricks().take(split).for_each(|b| regions.set(b, model.brick(b)));
            again.extend(regions.update(true));
            model.bricks().skip(split).for_each(|b| regions.set(b, model.brick(b)));
            if random.chance(0.3) {
                let corner = model.random_cell(&mut random) & !1i32;
                regions.take_requests([(corner, 100)].into_iter(), 10_000);
            }
            again.extend(settle(&mut regions));
            let asked = regions.asked.iter().map(|cell| IVec3::from(*cell));
            let seeds: Vec<IVec3> = asked
                .flat_map(|s| {
                    let around = (0..27).map(move |i| s + IVec3::new(i % 3, i / 3 % 3, i / 9) - 1);
                    around.filter(|c| *c == s || model.is_occupied(s)).collect::<Vec<_>>()
                })
                .collect();
            assert_exact(&model, &regions, &seeds, &format!("world {world}, change {change}"));
            let reached = model.reached(&seeds);
            for brick in model.bricks() {
                if again.contains(&brick) {
                    let mask = regions.mask(brick);
                    let bits = |m: Option<Mask>| m.iter().flatten().map(|w| w.count_ones()).sum::<u32>();
                    opened += usize::from(bits(mask) < bits(masks[&brick]));
                    closed += usize::from(bits(mask) > bits(masks[&brick]));
                    masks.insert(brick, mask);
                    regions.start(brick, mask.is_some());
                }
                for p in masks[&brick].iter().flat_map(|mask| looked_at(&model, mask, brick)) {
                    assert!(
                        !reached.contains(&p),
                        "world {world}, change {change}: {p} is reached, and masked in {brick}"
                    );
                }
            }
        }
    }
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
