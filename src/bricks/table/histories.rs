//! After any history the table, its memory and what the GPU finds there agree, and nothing that has changed is left as
//! it was.

use super::*;
use crate::twin::random::Random;
use crate::twin::world::find_brick;
use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};

/// What a page of `world_bricks` holds: a brick's version, and which of its pages.
type Page = Option<(IVec3, u32, u32)>;

/// Results on their way, each with the version of the brick that was voxelised.
type Flight = Vec<(Finished, u32)>;

/// A host and a GPU around a table, as `world/` is; of a brick's triangles there is but a version.
struct History {
    table: BrickTable,
    random: Random,
    /// Voxels.
    camera: DVec3,
    /// Bricks that hold triangles, within [`History::size`].
    scene: BTreeMap<[i32; 3], u32>,
    /// Bricks.
    size: IVec3,
    flights: VecDeque<Flight>,
    /// What the GPU has been told.
    world_grid: Vec<u32>,
    world_bricks: Vec<Page>,
    /// Of the resident bricks.
    versions: HashMap<IVec3, u32>,
    next_version: u32,
    /// How often everything that arrived was to fit.
    fitted: u32,
}

/// Words of a brick, always the same: often nothing, else what bricks take.
fn words_of(brick: IVec3, version: u32) -> u32 {
    let hash = brick.to_array().iter().fold(version, |h, v| (h ^ *v as u32).wrapping_mul(0x9e37_79b1).rotate_left(13));
    if version == 0 || hash.is_multiple_of(8) { 0 } else { 33 + (hash >> 8) % 448 }
}

fn faces_of(words: u32) -> u32 {
    words / 10 * (words & 1)
}

fn unreached_of(words: u32) -> u32 {
    words / 20
}

impl History {
    fn new(seed: u64, extent: UVec3, filled: f64, pages: u32) -> Self {
        let mut table = BrickTable::new(extent);
        table.grow(pages);
        let world_grid = vec![0; table.grid.words() as usize];
        let size = (extent * 4).as_ivec3() * IVec3::new(3, 1, 3);
        let mut history = Self {
            table,
            random: Random::new(seed),
            camera: size.as_dvec3() * 4.0,
            scene: BTreeMap::new(),
            size,
            flights: VecDeque::from(vec![Flight::new(); 3]),
            world_grid,
            world_bricks: vec![None; pages as usize],
            versions: HashMap::new(),
            next_version: 1,
            fitted: 0,
        };
        let bricks = (0..size.element_product()).map(|i| [i % size.x, i / size.x % size.y, i / (size.x * size.y)]);
        history.scene = bricks.filter(|_| history.random.chance(filled)).map(|brick| (brick, 1)).collect();
        history
    }

    fn version(&self, brick: IVec3) -> u32 {
        self.scene.get(&brick.to_array()).copied().unwrap_or(0)
    }

    /// Voxels.
    fn home(&self) -> DVec3 {
        (self.size * 4).as_dvec3()
    }

    /// An instance comes or goes, near the camera or where that soon returns to.
    fn edit(&mut self) {
        let near = if self.random.chance(0.5) { self.camera } else { self.home() } / 8.0;
        let window = (self.table.extent * 4).as_dvec3();
        let low = (near + (self.random.point() - 0.5) * window).floor().as_ivec3();
        let extent = 1 + self.random.below(4) as i32;
        let leaves = self.random.chance(0.5);
        self.next_version += 1;
        let cells = (0..extent.pow(3)).map(|i| low + IVec3::new(i % extent, i / extent % extent, i / extent.pow(2)));
        let within = |b: &IVec3| b.cmpge(IVec3::ZERO).all() && b.cmplt(self.size).all();
        let bricks: Vec<IVec3> = cells.filter(within).collect();
        for brick in &bricks {
            if leaves {
                self.scene.remove(&brick.to_array())
            } else {
                self.scene.insert(brick.to_array(), self.next_version)
            };
        }
        self.table.touch(&bricks);
        if leaves {
            bricks.into_iter().for_each(|b| self.table.forget(b));
        }
    }

    /// A step, many, or somewhere else; often back before anything has arrived.
    fn walk(&mut self) {
        self.camera += match self.random.below(16) {
            0 => self.random.point() * self.home() * 4.0 - self.home() - self.camera,
            1..5 => self.home() - self.camera,
            5..8 => self.random.direction() * 64.0,
            _ => self.random.direction() * 3.0,
        };
    }

    fn follow(&mut self) {
        if self.table.follow(self.camera, None) {
            let window = self.table.window_bricks().expect("it has moved");
            let within = |b: &IVec3| window.holds(*b);
            let bricks: Vec<IVec3> = self.scene.keys().copied().map(IVec3::from).filter(within).collect();
            self.table.enter(bricks.into_iter());
        }
    }

    fn grow(&mut self, pages: u32) {
        self.table.grow(pages);
        self.world_bricks.resize(self.table.pages.capacity() as usize, None);
        let bricks = self.table.resident() + self.table.missing();
        let entries = self.table.grid.entries_for(bricks);
        self.table.grid.grow(entries);
    }

    /// As `World::fit_pages` may: more pages, or fewer.
    fn fit(&mut self) {
        let capacity = self.table.pages.capacity();
        if self.random.chance(0.8) {
            let pages = capacity + capacity / 8 + self.random.below(200);
            self.grow(pages);
        } else {
            let pages = capacity / 2 + self.random.below(capacity / 2);
            let kept = self.table.shrink(pages);
            let old = std::mem::replace(&mut self.world_bricks, vec![None; pages as usize]);
            for [from, to, count] in kept {
                let (from, to, count) = (from as usize, to as usize, count as usize);
                self.world_bricks[to..to + count].copy_from_slice(&old[from..from + count]);
            }
            let table = &self.table;
            self.versions.retain(|b, _| table.resident.contains_key(b));
        }
    }

    /// As `BrickTable::compact`, at any time.
    fn close_gaps(&mut self) {
        let pages = self.random.below(self.table.pages.capacity());
        for run in self.table.close_gaps(pages) {
            let [from, to, count] = [run.source, run.target_word, run.words].map(|words| (words / PAGE_WORDS) as usize);
            assert!(to < from, "bricks move towards the start");
            self.world_bricks.copy_within(from..from + count, to);
        }
    }

    /// As `World::commit`.
    fn commit(&mut self) {
        let arrived = self.flights.pop_front().expect("a flight");
        let finished: Vec<Finished> = arrived.iter().map(|a| a.0).collect();
        if self.random.chance(0.02) {
            self.fit();
        }
        if self.random.chance(0.1) {
            self.close_gaps();
        }
        let demand = self.table.demand(&finished);
        assert!(demand < 1 << 24, "{demand} pages asked for");
        self.table.share_out();
        let takes: Vec<bool> = finished.iter().map(|f| self.table.takes(f)).collect();
        let bricks = self.table.resident() + finished.len() as u32;
        let has_entries = self.table.grid.entries_for(bricks) <= self.table.grid.capacity();
        let fits = has_entries && self.table.fits(&finished);
        let stays: Vec<IVec3> = self.table.resident.keys().copied().collect();
        let Arrived { copies, .. } = self.table.finish(&finished);
        if fits {
            self.fitted += u32::from(!finished.is_empty());
            assert!(stays.iter().all(|b| self.table.holds(*b)), "none gives way to what fits");
            let taken = finished.iter().zip(&takes).filter(|(_, takes)| **takes);
            taken.for_each(|(f, _)| assert!(self.table.holds(f.position), "what fits is taken in"));
        }
        let mut written: HashSet<u32> = HashSet::new();
        for copy in copies {
            let (Finished { position, .. }, version) = arrived[copy.source as usize];
            assert_eq!(copy.words, words_of(position, version));
            for page in 0..copy.words.div_ceil(PAGE_WORDS) {
                let at = copy.target_word / PAGE_WORDS + page;
                assert!(written.insert(at), "two bricks are copied to one page");
                self.world_bricks[at as usize] = Some((position, version, page));
            }
        }
        for ((Finished { position, .. }, version), takes) in arrived.into_iter().zip(takes) {
            if takes {
                self.versions.insert(position, version);
            }
            if self.version(position) == 0 {
                self.table.forget(position);
            }
        }
        let table = &self.table;
        self.versions.retain(|b, _| table.resident.contains_key(b));
        self.world_grid.resize(self.table.grid.words() as usize, 0);
        for [at, word] in self.table.grid.take_writes() {
            self.world_grid[at as usize] = word;
        }
    }

    /// As `World::voxelize`; a payload may be too small, and triangles too many.
    fn voxelize(&mut self, bricks: usize) {
        let mut flight = Flight::new();
        for (position, _) in self.table.next(bricks, &Viewpoint::all_round(self.camera / 8.0)) {
            if !self.table.busy() && self.random.chance(0.3) {
                self.table.leave_out(position);
                self.versions.remove(&position);
                continue;
            }
            let version = self.version(position);
            let words = words_of(position, version);
            let offset = if self.random.chance(0.03) { NONE } else { flight.len() as u32 };
            let (faces, unreached) = (faces_of(words), unreached_of(words));
            let result = BrickResult { words, offset, faces, unreached, ..BrickResult::default() };
            self.table.start(position);
            flight.push((Finished { position, result }, version));
        }
        if flight.is_empty() && self.random.chance(0.2) {
            self.table.retry_oversized();
        }
        self.flights.push_back(flight);
    }

    /// Up to `bricks` are voxelised; `checked` between what changes the GPU's view and what asks for more.
    fn frame(&mut self, bricks: usize, checked: bool) {
        self.table.tick();
        self.follow();
        self.commit();
        if checked {
            self.check();
        }
        self.voxelize(bricks);
        let budget = 50 + self.random.below(2000);
        let camera = self.camera / 8.0;
        let budget = LightBudget { faces: budget, room: budget, bricks: 100, sweeps: 1 };
        for lit in self.table.choose_for_light(&budget, camera).0.to_vec() {
            let position = unpack(lit.position).as_uvec3();
            assert_eq!(self.find(position), Some(lit.base), "what is lit is what rays find");
        }
    }

    /// As the GPU finds it; `brick` in the window.
    fn find(&self, brick: UVec3) -> Option<u32> {
        find_brick(&self.world_grid, self.table.extent, self.table.window(), brick)
    }

    /// What can be seen at a glance.
    fn check_sums(&self) {
        let table = &self.table;
        let sums = table.resident.iter().fold((0, 0, 0), |(pages, faces, unreached), (position, brick)| {
            let words = words_of(*position, self.versions[position]);
            (pages + brick.pages, faces + faces_of(words), unreached + unreached_of(words))
        });
        assert_eq!((table.pages.used(), table.faces(), table.unreached()), sums);
        let in_flight: Vec<IVec3> = self.flights.iter().flatten().map(|f| f.0.position).collect();
        assert_eq!(in_flight.len(), table.in_flight.len(), "a brick is voxelised twice at a time");
        assert!(in_flight.iter().all(|b| table.in_flight.contains(b)));
        assert!(table.dirty.is_subset(&table.in_flight));
        assert!(table.waiting.keys().all(|b| !table.in_flight.contains(b)), "a brick waits for what is under way");
        let idle = |b: &IVec3| ![table.waiting.contains_key(b), table.resident.contains_key(b)].contains(&true);
        assert!(table.oversized.iter().all(|b| idle(b) && !table.in_flight.contains(b)));
    }

    /// Everything else.
    fn check(&mut self) {
        self.check_extents();
        self.check_window();
        self.check_contents();
        self.check_census();
    }

    fn check_extents(&self) {
        let filled = self.table.resident.values().filter(|b| b.pages > 0);
        let mut extents: Vec<(u32, u32)> = filled.map(|b| (b.page, b.page + b.pages)).collect();
        extents.sort_unstable();
        assert!(extents.windows(2).all(|e| e[0].1 <= e[1].0), "two bricks share a page");
        assert!(extents.last().is_none_or(|e| e.1 <= self.table.pages.capacity()));
        assert_eq!(self.world_bricks.len(), self.table.pages.capacity() as usize);
    }

    /// Every brick of the window is where the GPU looks for it, the whole of it, and nothing else is found.
    fn check_window(&self) {
        let table = &self.table;
        let Some(BrickWindow { low, size }) = table.window_bricks() else { return };
        for i in 0..size.element_product() {
            let place = IVec3::new(i % size.x, i / size.x % size.y, i / (size.x * size.y));
            let position = low + place;
            let found = self.find(place.as_uvec3());
            let Some(brick) = table.resident.get(&position).filter(|b| b.pages > 0) else {
                assert_eq!(found, None, "{position} is not there");
                continue;
            };
            assert_eq!(found, Some(brick.page * PAGE_WORDS), "{position}");
            let version = self.versions[&position];
            let pages = self.world_bricks[brick.page as usize..][..brick.pages as usize].iter();
            let whole = pages.zip(0..).all(|(page, i)| *page == Some((position, version, i)));
            assert!(whole, "{position} is not what was voxelised last");
        }
    }

    /// What is there and is not to be redone is as the scene has it; what is not there is to come.
    fn check_contents(&self) {
        let table = &self.table;
        let expected =
            |b: &IVec3| table.waiting.contains_key(b) || table.in_flight.contains(b) || table.oversized.contains(b);
        for position in table.resident.keys().chain(table.waiting.keys()).chain(&table.oversized) {
            assert!(table.covers(*position), "{position} is outside of the window");
        }
        for (position, brick) in &table.resident {
            assert_eq!(brick.pages, words_of(*position, self.versions[position]).div_ceil(PAGE_WORDS));
            let (seen, now) = (self.versions[position], self.version(*position));
            assert!(seen == now || expected(position), "{position} has changed and is not redone");
            assert!(now > 0 || expected(position), "{position} is kept for nothing");
        }
        if table.window.is_some() {
            let bricks = self.scene.keys().copied().map(IVec3::from).filter(|b| table.covers(*b));
            let lost = bricks.filter(|b| !table.resident.contains_key(b) && !expected(b)).count();
            assert_eq!(lost, 0, "bricks are neither there nor to come");
        }
    }

    /// What has been counted or decided still holds.
    fn check_census(&mut self) {
        let table = &mut self.table;
        let found = (table.missing(), table.left_out());
        table.census = None;
        assert_eq!((table.missing(), table.left_out()), found);
        let filled = table.resident.iter().filter(|(_, b)| b.pages > 0).map(|(p, _)| (*p, *p + 1));
        assert_eq!(table.bounds(), filled.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))));
        if std::mem::take(&mut table.quiet) {
            assert!(table.next(1, &Viewpoint::all_round(DVec3::ZERO)).is_empty());
        }
    }

    /// Frames without a change until nothing is to be done.
    fn settle(&mut self) {
        for frame in 0.. {
            self.table.share_out();
            self.frame(500, true);
            self.check_sums();
            if self.flights.iter().all(Vec::is_empty)
                && self.table.waiting.is_empty()
                && self.table.oversized.is_empty()
            {
                break;
            }
            self.table.retry_oversized();
            self.grow(400_000);
            assert!(frame < 2000, "there is no end to it");
        }
    }
}

/// Random frames, edits and walks; then everything settles, and everything goes.
fn live(seed: u64, extent: UVec3, filled: f64, pages: u32, operations: usize) {
    let mut history = History::new(seed, extent, filled, pages);
    for operation in 0..operations {
        match history.random.below(8) {
            0..2 => history.edit(),
            2..4 => history.walk(),
            _ => {
                let bricks = 1 + history.random.below(80) as usize;
                history.frame(bricks, operation % 8 == 0);
                history.check_sums();
            }
        }
    }
    assert!(history.fitted > 100, "{} times all that arrived fitted", history.fitted);
    history.camera = history.home();
    history.settle();
    let table = &history.table;
    let scene = history.scene.keys().copied().map(IVec3::from).filter(|b| table.covers(*b)).count();
    assert_eq!(table.resident() as usize, scene, "as if the scene had always been so");
    history
        .scene
        .keys()
        .copied()
        .map(IVec3::from)
        .collect::<Vec<_>>()
        .chunks(64)
        .for_each(|all| history.table.touch(all));
    history.scene.clear();
    history.settle();
    let table = &mut history.table;
    assert_eq!(
        (table.resident(), table.faces(), table.unreached(), table.pages.used()),
        (0, 0, 0, 0),
        "nothing is left"
    );
    assert!(table.grid.is_empty());
    let capacity = table.pages.capacity();
    assert_eq!(table.pages.allocate(capacity), Some(0), "the memory is whole again");
}

#[test]
fn after_any_history_the_gpu_finds_what_the_host_says() {
    live(1, UVec3::new(4, 1, 4), 0.4, 8, 20_000);
    live(2, UVec3::new(2, 2, 2), 0.9, 8, 20_000);
    live(3, UVec3::new(1, 1, 1), 0.5, 8, 20_000);
}

/// More entries than the grid has at first.
#[test]
fn a_crowded_grid_loses_nothing() {
    live(4, UVec3::new(8, 2, 8), 0.9, 100_000, 10_000);
}
