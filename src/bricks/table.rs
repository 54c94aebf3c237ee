//! The bricks table: what is resident, what waits, and the memory of both.

use super::{AxisCounts, BrickWindow, ExtentAllocator, Grid, LightBudget, LightQueue, Lit, Viewpoint, unpack};
use crate::gpu::shared::{BrickCopy, BrickResult, LightBrick, LightCarry, LightChange, NONE, PAGE_WORDS};
use glam::{DVec3, IVec3, UVec3};
use rustc_hash::{FxHashMap, FxHashSet};

/// Who gets memory is decided again when the camera has moved this far, in bricks.
const ANCHOR_BRICKS: f64 = 4.0;

/// A resident brick.
#[derive(Clone, Copy, Debug, Default)]
struct Brick {
    /// First page and pages in `world_bricks`; 0 pages: nothing in it.
    page: u32,
    pages: u32,
    /// Faces that have no light because nothing reaches them.
    unreached: u32,
    /// Its turn to be lit, if it has faces.
    turn: Option<u32>,
}

/// A brick to be voxelised.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    /// Frame in which it began to wait.
    since: u64,
    /// Pages that it will take, where an earlier try has told.
    pages: Option<u32>,
}

/// What a brick that is freed leaves behind, until its pages are written again.
#[derive(Clone, Copy, Debug, Default)]
struct Left {
    /// Its first word in `world_bricks`.
    base: u32,
    pages: u32,
    /// Its lit faces, and how often they have been lit since the lights last changed.
    faces: u32,
    updates: u32,
    /// Those that nothing reached.
    unreached: u32,
}

/// What is counted once after a change.
#[derive(Clone, Copy, Debug)]
struct Census {
    missing: u32,
    left_out: u32,
    /// Those of the missing that have been tried, and the pages that they will take.
    tried: u64,
    tried_pages: u64,
}

/// A voxelised brick whose result has arrived.
#[derive(Clone, Copy, Debug)]
pub struct Finished {
    /// World position in bricks.
    pub position: IVec3,
    /// From the GPU.
    pub result: BrickResult,
}

/// What the GPU is to do with bricks that have arrived.
#[derive(Clone, Debug, Default)]
pub struct Arrived {
    /// Light to take over, before anything is copied.
    pub carries: Vec<LightCarry>,
    /// Where they go.
    pub copies: Vec<BrickCopy>,
    /// How many came where no light was.
    pub new: u32,
}

/// All bricks of the world.
///
/// Where memory does not suffice, the nearest bricks get it. *Near* is meant from the anchor, which follows the camera
/// in steps, so that two bricks do not take each other's place for ever. What lies within `reach` of it is voxelised;
/// what lies beyond waits, untouched, until memory has been freed or the anchor moves.
pub struct BrickTable {
    pub grid: Grid,
    /// Pages of `world_bricks`.
    pub pages: ExtentAllocator,
    extent: UVec3,
    /// Low corner of the window, in groups.
    window: Option<IVec3>,
    resident: FxHashMap<IVec3, Brick>,
    /// Resident bricks that take pages, by their places along the axes.
    filled: AxisCounts,
    waiting: FxHashMap<IVec3, Waiting>,
    in_flight: FxHashSet<IVec3>,
    /// Touched again while in flight.
    dirty: FxHashSet<IVec3>,
    /// Their triangles alone need more memory than there is.
    oversized: FxHashSet<IVec3>,
    /// Bricks.
    anchor: DVec3,
    /// Distance from the anchor, squared; infinite while everything fits.
    reach: f64,
    /// Memory has been freed, or the anchor has moved: `reach` may be too short.
    freed: bool,
    /// Bricks beyond `reach` are voxelised once.
    surveys: bool,
    /// Those of them that are in flight.
    surveyed: FxHashSet<IVec3>,
    unreached: u32,
    /// New bricks since everything was there.
    entered: u32,
    /// Frames so far.
    clock: u64,
    lighting: LightQueue,
    /// None: something has changed since it was taken.
    census: Option<Census>,
    /// Nothing has changed since nothing was found to voxelise.
    quiet: bool,
    /// Pages that were in use when bricks last moved together.
    compacted: Option<u32>,
}

impl BrickTable {
    /// An empty table over `extent` groups, without pages.
    pub fn new(extent: UVec3) -> Self {
        let (resident, waiting, in_flight, dirty, oversized) = Default::default();
        Self {
            grid: Grid::new(extent),
            pages: ExtentAllocator::new(0),
            extent,
            window: None,
            resident,
            filled: AxisCounts::new(extent * 4),
            waiting,
            in_flight,
            dirty,
            oversized,
            anchor: DVec3::INFINITY,
            reach: f64::INFINITY,
            freed: false,
            surveys: false,
            surveyed: FxHashSet::default(),
            unreached: 0,
            entered: 0,
            clock: 0,
            lighting: LightQueue::default(),
            census: None,
            quiet: false,
            compacted: None,
        }
    }

    /// A frame begins.
    pub fn tick(&mut self) {
        self.clock += 1;
    }

    fn changed(&mut self) {
        self.census = None;
        self.quiet = false;
    }

    fn census(&mut self) -> Census {
        if let Some(census) = self.census {
            return census;
        }
        let absent = |b: &&IVec3| !self.resident.contains_key(*b);
        let missing = self.waiting.keys().chain(&self.in_flight).chain(&self.oversized).filter(absent).count();
        let waits = |b: &&IVec3| self.is_full() && self.distance(**b) >= self.reach;
        let beyond = self.waiting.keys().filter(waits).filter(absent).count();
        let tried = self.waiting.iter().filter(|(b, _)| absent(b)).filter_map(|(_, w)| w.pages);
        let (tried, tried_pages) = tried.fold((0, 0), |(n, sum), pages| (n + 1, sum + u64::from(pages)));
        let left_out = (beyond + self.oversized.iter().filter(absent).count()) as u32;
        let census = Census { missing: missing as u32, left_out, tried, tried_pages };
        *self.census.insert(census)
    }

    /// Low corner of the window, in bricks.
    pub fn window(&self) -> IVec3 {
        self.window.unwrap_or(IVec3::ZERO) * 4
    }

    /// Bricks resident.
    pub fn resident(&self) -> u32 {
        self.resident.len() as u32
    }

    /// Bricks that should be resident and are not.
    pub fn missing(&mut self) -> u32 {
        self.census().missing
    }

    /// Those of the missing bricks that are near and in view, but for what is left out for lack of memory.
    pub fn missing_in_view(&self, viewpoint: &Viewpoint) -> u32 {
        let missing = |b: &&IVec3| viewpoint.sees_near(**b) && !self.resident.contains_key(*b);
        let arriving = self.in_flight.iter().filter(missing).count();
        // Quiet: whatever waits is left out.
        let waiting = if self.quiet {
            0
        } else {
            self.waiting.keys().filter(missing).filter(|b| self.distance(**b) < self.reach).count()
        };
        (arriving + waiting) as u32
    }

    /// Those of the missing bricks that are left out for lack of memory.
    pub fn left_out(&mut self) -> u32 {
        self.census().left_out
    }

    /// Bounds of the resident bricks, in bricks.
    pub fn bounds(&self) -> Option<(IVec3, IVec3)> {
        self.filled.bounds(self.window())
    }

    /// Whether what can be here is here, more than a quarter of it since the last time that this was so.
    pub fn has_loaded(&mut self) -> bool {
        if self.missing() > self.left_out() {
            return false;
        }
        std::mem::take(&mut self.entered) * 4 > self.resident()
    }

    /// Pages that will be in use once these bricks have taken the places of their forerunners.
    pub fn pages_with(&self, arriving: &[Finished]) -> u32 {
        let before: u32 = arriving.iter().filter_map(|f| self.resident.get(&f.position)).map(|b| b.pages).sum();
        let now: u32 = arriving.iter().map(|f| f.result.words.div_ceil(PAGE_WORDS)).sum();
        self.pages.used() - before + now
    }

    /// Whether all of these find holes that are large enough, as [`Self::finish`] looks for them.
    pub fn fits(&self, arriving: &[Finished]) -> bool {
        let taken = || arriving.iter().filter(|f| self.takes(f));
        let lengths = || taken().map(|f| f.result.words.div_ceil(PAGE_WORDS)).filter(|pages| *pages > 0);
        if lengths().sum::<u32>() <= self.pages.longest_hole() {
            return true;
        }
        let mut pages = self.pages.clone();
        let before = taken().filter_map(|f| self.resident.get(&f.position));
        before.filter(|b| b.pages > 0).for_each(|b| pages.free(b.page, b.pages));
        lengths().all(|length| pages.allocate(length).is_some())
    }

    /// Pages for everything: what is resident, what arrives, what has been tried, and the rest of what is missing, each of
    /// which counts as the mean of the others.
    pub fn demand(&mut self, arriving: &[Finished]) -> u32 {
        let new = arriving.iter().filter(|f| !self.resident.contains_key(&f.position)).count() as u64;
        let Census { tried, tried_pages, .. } = self.census();
        // What arrives is still in flight, and so among the missing.
        let known = self.resident.len() as u64 + new + tried;
        let unknown = u64::from(self.missing()) - new - tried;
        let pages = u64::from(self.pages_with(arriving)) + tried_pages;
        u32::try_from(pages + (pages * unknown).div_ceil(known.max(1))).unwrap_or(u32::MAX)
    }

    /// Lit faces resident.
    pub fn faces(&self) -> u32 {
        self.lighting.faces()
    }

    /// Faces resident that have no light because nothing reaches them.
    pub fn unreached(&self) -> u32 {
        self.unreached
    }

    /// Whether a brick is resident.
    pub fn holds(&self, brick: IVec3) -> bool {
        self.resident.contains_key(&brick)
    }

    /// Whether anything is in flight.
    pub fn busy(&self) -> bool {
        !self.in_flight.is_empty()
    }

    /// Whether nothing is to be voxelised, or under way.
    pub fn is_idle(&self) -> bool {
        self.quiet && !self.busy()
    }

    /// Whether bricks have been refused for lack of memory.
    pub fn is_full(&self) -> bool {
        self.reach < f64::INFINITY
    }

    /// Bricks whose triangles did not fit into memory are tried again.
    pub fn retry_oversized(&mut self) {
        if !self.oversized.is_empty() {
            self.changed();
        }
        let since = self.clock;
        self.waiting.extend(self.oversized.drain().map(|brick| (brick, Waiting { since, pages: None })));
    }

    /// Whether bricks for which there is no memory are voxelised once all the same: which of their voxels are occupied says
    /// what the others need.
    pub fn survey(&mut self, surveys: bool) {
        if surveys != self.surveys {
            self.surveys = surveys;
            self.changed();
        }
    }

    /// From the anchor, squared, in bricks.
    fn distance(&self, brick: IVec3) -> f64 {
        (brick.as_dvec3() + 0.5 - self.anchor).length_squared()
    }

    /// Whether a brick, voxelised, is to be shown: it is in the window and fitted into the payload. What has changed since
    /// is shown, too: where something moves about, all else is older still.
    pub fn takes(&self, finished: &Finished) -> bool {
        let Finished { position, result } = finished;
        self.covers(*position) && result.offset != NONE
    }

    /// Whether a brick lies in the window.
    pub fn covers(&self, brick: IVec3) -> bool {
        let relative = brick - self.window();
        relative.cmpge(IVec3::ZERO).all() && relative.cmplt((self.extent * 4).as_ivec3()).all()
    }

    /// Moves the window so that `center` (voxels) is within a group of its middle, or, along axes where the scene's end is nearer
    /// than the window's, so that it holds as much of the scene as it can; frees what leaves it. `scene`: corners of the
    /// scene, voxels. Whether it moved: then what the new window holds is to be told to [`Self::enter`].
    pub fn follow(&mut self, center: DVec3, scene: Option<(DVec3, DVec3)>) -> bool {
        let camera = center / 8.0;
        if camera.distance_squared(self.anchor) > ANCHOR_BRICKS * ANCHOR_BRICKS {
            self.anchor = camera;
            self.freed = true;
            self.changed();
        }
        let half = self.extent.as_ivec3() / 2;
        let centered = (center / 32.0).round().as_ivec3() - half;
        let (least, most) = scene.map_or((centered, centered), |(low, high)| self.window_range(low, high));
        let within = |w: IVec3| if scene.is_some() { w.clamp(least, most) } else { w };
        let wanted = within(centered);
        if self.window.is_some_and(|w| (w - wanted).abs().cmple(IVec3::ONE).all() && within(w) == w) {
            return false;
        }
        self.window = Some(wanted);
        let leaving: Vec<IVec3> = self.resident.keys().copied().filter(|b| !self.covers(*b)).collect();
        for brick in leaving {
            self.evict(brick);
        }
        // While these are outside nobody tells that they change.
        let outside: Vec<IVec3> = self.in_flight.iter().copied().filter(|b| !self.covers(*b)).collect();
        self.dirty.extend(outside);
        // What is resident and has changed is still to be redone.
        self.waiting.retain(|b, _| self.resident.contains_key(b));
        self.oversized.clear();
        self.freed = true;
        self.changed();
        true
    }

    /// Least and greatest low corners (groups) of a window that holds a scene with these corners (voxels), or nothing else
    /// along axes where the scene is the larger.
    fn window_range(&self, low: DVec3, high: DVec3) -> (IVec3, IVec3) {
        // Far beyond anything that a grid can address; keeps the arithmetic from overflowing.
        let group = |p: DVec3| (p / 32.0).floor().clamp(DVec3::splat(-1e8), DVec3::splat(1e8)).as_ivec3();
        // A voxel around the scene also decides about its faces.
        let (first, end) = (group(low - 2.0), group(high + 2.0) + 1 - self.extent.as_ivec3());
        (first.min(end), first.max(end))
    }

    /// Queues what a moved window holds and is not yet resident.
    pub fn enter(&mut self, bricks: impl Iterator<Item = IVec3>) {
        let entering: Vec<IVec3> = bricks.filter(|b| !self.resident.contains_key(b)).collect();
        self.touch(&entering);
    }

    /// The bricks of the window; none before the first camera.
    pub fn window_bricks(&self) -> Option<BrickWindow> {
        self.window.map(|w| BrickWindow { low: w * 4, size: (self.extent * 4).as_ivec3() })
    }

    /// Queues bricks whose triangles changed.
    pub fn touch(&mut self, bricks: &[IVec3]) {
        for brick in bricks.iter().copied() {
            if self.window.is_none() || !self.covers(brick) {
                continue;
            }
            self.changed();
            self.oversized.remove(&brick);
            if self.in_flight.contains(&brick) {
                self.dirty.insert(brick);
            } else {
                self.wait(brick, None);
            }
        }
    }

    /// Queues bricks that other faces of are to be lit than were: what they take will differ.
    pub fn touch_reach(&mut self, bricks: &[IVec3]) {
        self.touch(bricks);
        self.freed |= !bricks.is_empty();
    }

    /// A brick that waits already keeps its turn.
    fn wait(&mut self, brick: IVec3, pages: Option<u32>) {
        let since = self.clock;
        self.waiting.entry(brick).or_insert(Waiting { since, pages }).pages = pages;
    }

    /// A brick has lost all its triangles: unless it must still be seen to vanish, there is nothing to wait for, nor to
    /// keep.
    pub fn forget(&mut self, brick: IVec3) {
        if self.resident.get(&brick).is_none_or(|b| b.pages == 0) {
            self.resident.remove(&brick);
            self.waiting.remove(&brick);
            self.changed();
        }
    }

    /// Up to `count` bricks to voxelise now, with their pages where they are known. Each has a deadline: the frame in which
    /// it began to wait and [`Viewpoint::patience`]. So what is in view comes first, then what is near, and nothing
    /// starves. What is resident and has changed is redone wherever it lies, what has never been tried where that is asked
    /// for ([`Self::survey`]).
    pub fn next(&mut self, count: usize, viewpoint: &Viewpoint) -> Vec<(IVec3, Option<u32>)> {
        if self.quiet {
            return Vec::new();
        }
        let within = |b: &IVec3| self.distance(*b) < self.reach || self.resident.contains_key(b);
        let deadline = |b: IVec3, w: &Waiting| (w.since as f64 + viewpoint.patience(b), b.to_array());
        let waiting = self.waiting.iter().filter(|(b, w)| within(b) || self.surveys && w.pages.is_none());
        let mut queue: Vec<_> = waiting.map(|(b, w)| (deadline(*b, w), *b, w.pages)).collect();
        let earlier = |a: &((f64, [i32; 3]), IVec3, Option<u32>), b: &((f64, [i32; 3]), IVec3, Option<u32>)| {
            a.0.0.total_cmp(&b.0.0).then_with(|| a.0.1.cmp(&b.0.1))
        };
        if queue.len() > count {
            queue.select_nth_unstable_by(count, earlier);
            queue.truncate(count);
        }
        queue.sort_unstable_by(earlier);
        self.quiet = queue.is_empty();
        queue.into_iter().map(|(_, b, pages)| (b, pages)).collect()
    }

    /// Where memory has been freed or the anchor has moved, decides again how far it reaches: the nearest bricks, with
    /// what they take or took when they were last tried, into the pages that there are.
    pub fn share_out(&mut self) {
        if !std::mem::take(&mut self.freed) {
            return;
        }
        self.retry_oversized();
        if !self.is_full() {
            return;
        }
        self.changed();
        let mean = self.pages.used().div_ceil((self.resident.len() as u32).max(1));
        let resident = self.resident.iter().filter(|(b, _)| !self.waiting.contains_key(*b)).map(|(b, r)| (*b, r.pages));
        let waiting = self.waiting.iter().map(|(b, w)| (*b, w.pages.unwrap_or(mean)));
        let arriving = self.in_flight.iter().filter(|b| !self.resident.contains_key(*b)).map(|b| (*b, mean));
        let mut all: Vec<(f64, u32)> =
            resident.chain(waiting).chain(arriving).map(|(b, pages)| (self.distance(b), pages)).collect();
        // Holes between bricks are not all of use.
        self.reach = first_beyond(&mut all, self.pages.capacity() - self.pages.capacity() / 32);
    }

    /// Marks a brick as handed to the GPU.
    pub fn start(&mut self, brick: IVec3) {
        let unknown = self.waiting.remove(&brick).is_some_and(|w| w.pages.is_none());
        if unknown && self.distance(brick) >= self.reach && !self.resident.contains_key(&brick) {
            self.surveyed.insert(brick);
        }
        self.in_flight.insert(brick);
        self.changed();
    }

    /// Leaves a waiting brick out because its triangles do not fit into memory, until some is freed.
    pub fn leave_out(&mut self, brick: IVec3) {
        self.waiting.remove(&brick);
        self.evict(brick);
        self.oversized.insert(brick);
        self.changed();
    }

    /// Takes in voxelised bricks: finds them a place (evicting farther ones when full).
    pub fn finish(&mut self, finished: &[Finished]) -> Arrived {
        let (mut copies, mut carries, mut new) = (Vec::new(), Vec::new(), 0);
        let mut farthest = None;
        if !finished.is_empty() {
            self.changed();
        }
        // All give back first what they had: the holes of neighbours join.
        let accepted: Vec<_> = finished.iter().filter_map(|f| Some((f, self.accept(f)?))).collect();
        for (Finished { position, result }, old) in accepted {
            let pages = result.words.div_ceil(PAGE_WORDS);
            if pages == 0 {
                self.grid.remove(*position);
                self.resident.insert(*position, Brick::default());
                continue;
            }
            let Some(page) = self.place(pages, *position, &mut farthest) else {
                self.grid.remove(*position);
                self.reach = self.reach.min(self.distance(*position));
                self.wait(*position, Some(pages));
                continue;
            };
            let (distance, target_word) = (self.distance(*position).sqrt(), page * PAGE_WORDS);
            let BrickResult { words, offset, faces, unreached, .. } = *result;
            let Left { base, faces: before, unreached: hidden, updates, .. } = old;
            new += u32::from(before == 0);
            if before > 0 && faces > 0 {
                carries.push(LightCarry { base, source: offset });
            }
            // With many more faces, or others that are reached, it is as good as new.
            let updates = if faces * 4 <= before * 5 && unreached == hidden { updates } else { 0 };
            let enter = || self.lighting.enter(*position, target_word, faces, distance, updates);
            let turn = (faces > 0).then(enter);
            self.resident.insert(*position, Brick { page, pages, unreached, turn });
            self.filled.add(*position);
            self.unreached += unreached;
            copies.push((*position, BrickCopy { source: offset, target_word, words, unused: 0 }));
        }
        if !finished.is_empty() {
            self.lighting.rouse();
        }
        // A brick may have lost its place to a nearer one of the same batch.
        copies.retain(|(p, c)| self.resident.get(p).is_some_and(|b| b.page * PAGE_WORDS == c.target_word));
        Arrived { carries, copies: copies.into_iter().map(|(_, copy)| copy).collect(), new }
    }

    /// Takes a voxelised brick off the GPU's hands and frees what it had, which the grid still shows. None: it is not what
    /// is to be shown.
    fn accept(&mut self, finished: &Finished) -> Option<Left> {
        let Finished { position, result } = finished;
        let taken = self.takes(finished);
        self.in_flight.remove(position);
        let dirty = self.dirty.remove(position);
        // What it takes may be less than was thought.
        self.freed |= self.surveyed.remove(position);
        let pages = result.words.div_ceil(PAGE_WORDS);
        if self.covers(*position) && (dirty || !taken) {
            self.wait(*position, (!dirty).then_some(pages));
        }
        if !taken {
            return None;
        }
        self.entered += u32::from(!self.resident.contains_key(position));
        let left = self.vacate(*position);
        self.freed |= pages < left.pages;
        Some(left)
    }

    /// Frees a resident brick; the pages that it had.
    fn evict(&mut self, brick: IVec3) -> u32 {
        let Left { pages, .. } = self.vacate(brick);
        if pages > 0 {
            self.grid.remove(brick);
        }
        pages
    }

    /// Frees a resident brick, which the grid still shows.
    fn vacate(&mut self, brick: IVec3) -> Left {
        let Some(old) = self.resident.remove(&brick) else { return Left::default() };
        if old.pages > 0 {
            self.lighting.rouse();
            self.pages.free(old.page, old.pages);
            self.filled.remove(brick);
            self.unreached -= old.unreached;
        }
        let (faces, updates) = old.turn.map_or((0, 0), |turn| self.lighting.leave(turn));
        Left { base: old.page * PAGE_WORDS, pages: old.pages, faces, updates, unreached: old.unreached }
    }

    /// The first of so many pages for a brick, which the grid then shows there; farther bricks give way. `farthest`:
    /// resident ones by distance, made when first needed.
    fn place(&mut self, pages: u32, position: IVec3, farthest: &mut Option<Vec<IVec3>>) -> Option<u32> {
        let own = self.distance(position);
        loop {
            if let Some(page) = self.pages.allocate(pages) {
                if self.grid.insert(position, page * PAGE_WORDS) {
                    return Some(page);
                }
                self.pages.free(page, pages);
            }
            let far = farthest.get_or_insert_with(|| self.by_distance()).pop()?;
            if self.distance(far) <= own {
                farthest.as_mut()?.push(far);
                return None;
            }
            // Not so if it has been redone, and refused, meanwhile.
            let freed = self.evict(far);
            if freed > 0 {
                self.reach = self.reach.min(self.distance(far));
                self.wait_again(far, freed);
            }
        }
    }

    /// A brick that has lost its place: what it waits for already counts for more, and what is under way will come.
    fn wait_again(&mut self, brick: IVec3, pages: u32) {
        let since = self.clock;
        if !self.in_flight.contains(&brick) {
            self.waiting.entry(brick).or_insert(Waiting { since, pages: Some(pages) });
        }
    }

    /// Resident bricks that take pages, nearest to the anchor first.
    fn by_distance(&self) -> Vec<IVec3> {
        let mut bricks: Vec<IVec3> = self.resident.iter().filter(|(_, b)| b.pages > 0).map(|(p, _)| *p).collect();
        bricks.sort_unstable_by(|a, b| {
            self.distance(*a).total_cmp(&self.distance(*b)).then_with(|| a.to_array().cmp(&b.to_array()))
        });
        bricks
    }

    /// Makes room for more pages; nothing moves.
    pub fn grow(&mut self, pages: u32) {
        self.pages.grow(pages);
        self.freed = true;
    }

    /// Makes do with fewer pages: the nearest bricks that fit move to the start, the others wait again. Returns what is
    /// kept: first page before, first page now, pages.
    pub fn shrink(&mut self, pages: u32) -> Vec<[u32; 3]> {
        self.changed();
        let mut moves = Vec::new();
        let mut next = 0;
        for position in self.by_distance() {
            let brick = self.resident[&position];
            if next + brick.pages > pages {
                self.evict(position);
                self.wait_again(position, brick.pages);
                continue;
            }
            moves.push([brick.page, next, brick.pages]);
            self.resident.insert(position, Brick { page: next, ..brick });
            if let Some(turn) = brick.turn {
                self.lighting.relocate(turn, next * PAGE_WORDS);
            }
            let shown = self.grid.insert(position, next * PAGE_WORDS);
            debug_assert!(shown, "its entry is only replaced");
            next += brick.pages;
        }
        self.pages = ExtentAllocator::new(pages);
        self.pages.allocate(next);
        moves
    }

    /// Chooses bricks for lighting, those that are due first. Returns them with the number of their faces.
    pub fn choose_for_light(&mut self, budget: &LightBudget, camera: DVec3) -> (&mut [LightBrick], u32) {
        let window = self.window();
        let (chosen, faces) = self.lighting.choose(budget, self.clock, window, camera);
        debug_assert!(chosen.iter().all(|b| self.grid.find(window + unpack(b.position)) == Some(b.base)));
        (chosen, faces)
    }

    /// The bricks that were chosen last.
    pub fn lit(&self) -> &[Lit] {
        self.lighting.lit()
    }

    /// What came of lighting bricks: [`LightQueue::note`].
    pub fn note_light(&mut self, found: impl Iterator<Item = (Lit, LightChange)>) {
        found.for_each(|(lit, found)| self.lighting.note(lit, found, self.clock));
    }

    /// How far lighting has settled, 0 to 1, times the share of the bricks that could be here and are.
    pub fn convergence(&mut self) -> f64 {
        let (resident, missing) = (f64::from(self.resident()), f64::from(self.missing() - self.left_out()));
        self.lighting.convergence() * if missing > 0.0 { resident / (resident + missing) } else { 1.0 }
    }

    /// Nothing sleeps: everything is lit as if something had just changed.
    pub fn rouse_lighting(&mut self) {
        self.lighting.rouse();
    }

    /// Forgets what lighting has settled: everything converges anew.
    pub fn invalidate_lighting(&mut self) {
        self.lighting.invalidate();
    }
}

/// The distance of the first brick, nearest first, that so many pages do not suffice for; infinite if all have theirs.
/// `bricks`: distance and pages; left in any order.
fn first_beyond(mut bricks: &mut [(f64, u32)], pages: u32) -> f64 {
    let mut left = u64::from(pages);
    while !bricks.is_empty() {
        let half = bricks.len() / 2;
        let (nearer, at, farther) =
            std::mem::take(&mut bricks).select_nth_unstable_by(half, |a, b| a.0.total_cmp(&b.0));
        let before: u64 = nearer.iter().map(|(_, pages)| u64::from(*pages)).sum();
        if before > left {
            bricks = nearer;
        } else if before + u64::from(at.1) > left {
            return at.0;
        } else {
            left -= before + u64::from(at.1);
            bricks = farther;
        }
    }
    f64::INFINITY
}

mod compact;
#[cfg(test)]
mod histories;
#[cfg(test)]
mod tests;
