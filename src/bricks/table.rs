//! The bricks table: what is resident, what waits, and the memory of both.

use super::{ExtentAllocator, Grid};
use crate::gpu::shared::{BrickCopy, BrickResult, LightBrick, NONE, PAGE_WORDS};
use glam::{DVec3, IVec3, UVec3};
use std::collections::{HashMap, HashSet};

/// Bricks that found no memory are tried again when the camera has moved this far.
const RETRY_VOXELS: f64 = 64.0;

/// Bricks lit in one frame at most: one workgroup each.
const CHOSEN_MAX: usize = 65_535;

/// A resident brick.
#[derive(Clone, Copy, Debug, Default)]
struct Brick {
    /// First page and pages in `world_bricks`; 0 pages: nothing in it.
    page: u32,
    pages: u32,
    faces: u32,
    /// Lighting updates so far.
    updates: u32,
    /// Frame of the last one.
    lit_frame: u32,
}

/// A voxelised brick whose result has arrived.
#[derive(Clone, Copy, Debug)]
pub struct Finished {
    /// World position in bricks.
    pub position: IVec3,
    /// From the GPU.
    pub result: BrickResult,
}

/// All bricks of the world.
pub struct BrickTable {
    pub grid: Grid,
    /// Pages of `world_bricks`.
    pub pages: ExtentAllocator,
    extent: UVec3,
    /// Low corner of the window, in groups.
    window: Option<IVec3>,
    resident: HashMap<IVec3, Brick>,
    waiting: HashSet<IVec3>,
    in_flight: HashSet<IVec3>,
    /// Touched again while in flight.
    dirty: HashSet<IVec3>,
    /// No memory for these.
    refused: HashSet<IVec3>,
    /// Where the camera was (voxels) when they were last tried.
    refused_from: DVec3,
    faces: u32,
}

impl BrickTable {
    /// An empty table over `extent` groups, with room for `pages` pages.
    pub fn new(extent: UVec3, pages: u32) -> Self {
        let (resident, waiting, in_flight, dirty, refused) = Default::default();
        let grid = Grid::new(extent);
        let pages = ExtentAllocator::new(pages);
        Self {
            grid,
            pages,
            extent,
            window: None,
            resident,
            waiting,
            in_flight,
            dirty,
            refused,
            refused_from: DVec3::ZERO,
            faces: 0,
        }
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
    pub fn missing(&self) -> u32 {
        let waiting = self.waiting.union(&self.in_flight).filter(|b| !self.resident.contains_key(*b)).count();
        (waiting + self.refused.len()) as u32
    }

    /// Lit faces resident.
    pub fn faces(&self) -> u32 {
        self.faces
    }

    /// Whether anything waits or is in flight.
    pub fn busy(&self) -> bool {
        !self.waiting.is_empty() || !self.in_flight.is_empty()
    }

    fn covers(&self, brick: IVec3) -> bool {
        let relative = brick - self.window();
        relative.cmpge(IVec3::ZERO).all() && relative.cmplt((self.extent * 4).as_ivec3()).all()
    }

    /// Moves the window so that `center` (voxels) is in its middle third, and frees what leaves it. Whether it moved: then
    /// what the new window holds is to be told to [`Self::enter`].
    pub fn follow(&mut self, center: DVec3) -> bool {
        if center.distance_squared(self.refused_from) > RETRY_VOXELS * RETRY_VOXELS {
            self.refused_from = center;
            let again: Vec<IVec3> = self.refused.drain().collect();
            self.touch(&again);
        }
        let half = self.extent.as_ivec3() / 2;
        let wanted = (center / 32.0).round().as_ivec3() - half;
        let slack = (self.extent.as_ivec3() / 6).max(IVec3::ONE);
        if self.window.is_some_and(|w| (w - wanted).abs().cmple(slack).all()) {
            return false;
        }
        self.window = Some(wanted);
        let leaving: Vec<IVec3> = self.resident.keys().copied().filter(|b| !self.covers(*b)).collect();
        for brick in leaving {
            self.evict(brick);
        }
        self.waiting.clear();
        self.refused.clear();
        true
    }

    /// Queues what a moved window holds and is not yet resident.
    pub fn enter(&mut self, bricks: impl Iterator<Item = IVec3>) {
        let entering: Vec<IVec3> = bricks.filter(|b| !self.resident.contains_key(b)).collect();
        self.touch(&entering);
    }

    /// The bricks of the window, low corner and size; none before the first camera.
    pub fn window_bricks(&self) -> Option<(IVec3, IVec3)> {
        self.window.map(|w| (w * 4, (self.extent * 4).as_ivec3()))
    }

    /// Queues bricks whose triangles changed.
    pub fn touch(&mut self, bricks: &[IVec3]) {
        for brick in bricks.iter().copied() {
            if self.window.is_none() || !self.covers(brick) {
                continue;
            }
            self.refused.remove(&brick);
            if self.in_flight.contains(&brick) {
                self.dirty.insert(brick);
            } else {
                self.waiting.insert(brick);
            }
        }
    }

    /// Up to `count` bricks to voxelise now, nearest to `camera` (bricks) first.
    pub fn next(&mut self, count: usize, camera: DVec3) -> Vec<IVec3> {
        let mut queue: Vec<IVec3> = self.waiting.iter().copied().collect();
        let key = |b: &IVec3| {
            let distance = (b.as_dvec3() + 0.5 - camera).length_squared();
            ((distance * 16.0) as u64, b.to_array())
        };
        if queue.len() > count {
            queue.select_nth_unstable_by_key(count, key);
            queue.truncate(count);
        }
        queue.sort_unstable_by_key(key);
        queue
    }

    /// Marks a brick as handed to the GPU.
    pub fn start(&mut self, brick: IVec3) {
        self.waiting.remove(&brick);
        self.in_flight.insert(brick);
    }

    /// Takes in voxelised bricks: finds them a place (evicting farther ones when full) and returns what to copy.
    /// `payload` words stand in this frame slot's payload.
    pub fn finish(&mut self, finished: &[Finished], camera: DVec3) -> Vec<BrickCopy> {
        let mut copies = Vec::new();
        for Finished { position, result } in finished {
            self.in_flight.remove(position);
            if self.dirty.remove(position) || result.offset == NONE {
                self.waiting.insert(*position);
                continue;
            }
            if !self.covers(*position) {
                continue;
            }
            self.evict(*position);
            let pages = result.words.div_ceil(PAGE_WORDS);
            if pages == 0 {
                self.resident.insert(*position, Brick::default());
                continue;
            }
            let Some(page) = self.place(pages, *position, camera) else {
                self.refused.insert(*position);
                continue;
            };
            let brick = Brick { page, pages, faces: result.faces, ..Brick::default() };
            self.resident.insert(*position, brick);
            self.faces += result.faces;
            self.grid.insert(*position, page * PAGE_WORDS);
            let target_word = page * PAGE_WORDS;
            copies.push((*position, BrickCopy { source: result.offset, target_word, words: result.words, unused: 0 }));
        }
        // A brick may have lost its place to a nearer one of the same batch.
        copies.retain(|(p, c)| self.resident.get(p).is_some_and(|b| b.page * PAGE_WORDS == c.target_word));
        copies.into_iter().map(|(_, copy)| copy).collect()
    }

    /// Frees a resident brick.
    fn evict(&mut self, brick: IVec3) {
        if let Some(old) = self.resident.remove(&brick)
            && old.pages > 0
        {
            self.pages.free(old.page, old.pages);
            self.grid.remove(brick);
            self.faces -= old.faces;
        }
    }

    fn place(&mut self, pages: u32, position: IVec3, camera: DVec3) -> Option<u32> {
        let distance = |b: IVec3| (b.as_dvec3() + 0.5 - camera).length_squared();
        loop {
            if let Some(page) = self.pages.allocate(pages) {
                return Some(page);
            }
            let (far, far_distance) = self
                .resident
                .iter()
                .filter(|(_, b)| b.pages > 0)
                .map(|(p, _)| (*p, distance(*p)))
                .max_by(|a, b| a.1.total_cmp(&b.1).then_with(|| a.0.to_array().cmp(&b.0.to_array())))?;
            if far_distance <= distance(position) {
                return None;
            }
            self.evict(far);
            self.refused.insert(far);
        }
    }

    /// Chooses bricks for lighting: least recently and least often lit first, nearer ones sooner, up to `budget` faces,
    /// each to be lit `sweeps` times. Returns them with the number of their faces.
    pub fn choose_for_light(&mut self, budget: u32, sweeps: u32, frame: u32, camera: DVec3) -> (Vec<LightBrick>, u32) {
        let mut candidates: Vec<(f64, IVec3)> = self
            .resident
            .iter()
            .filter(|(_, b)| b.faces > 0)
            .map(|(p, b)| {
                let age = f64::from(frame.wrapping_sub(b.lit_frame));
                let distance = 8.0 + (p.as_dvec3() + 0.5 - camera).length();
                (if b.updates == 0 { -1e12 / distance } else { -age / distance }, *p)
            })
            .collect();
        let key =
            |a: &(f64, IVec3), b: &(f64, IVec3)| a.0.total_cmp(&b.0).then_with(|| a.1.to_array().cmp(&b.1.to_array()));
        candidates.sort_unstable_by(key);
        let window = self.window();
        let (mut chosen, mut faces) = (Vec::new(), 0);
        for (_, position) in candidates {
            let brick = self.resident.get_mut(&position).expect("a candidate is resident");
            if faces + brick.faces > budget || chosen.len() == CHOSEN_MAX {
                break;
            }
            let p = (position - window).as_uvec3();
            chosen.push(LightBrick {
                base: brick.page * PAGE_WORDS,
                position: p.x | p.y << 10 | p.z << 20,
                first_face: faces,
                alpha: alpha(brick.updates),
            });
            faces += brick.faces;
            brick.updates += sweeps;
            brick.lit_frame = frame;
        }
        (chosen, faces)
    }

    /// Bounds of the resident bricks, in bricks.
    pub fn bounds(&self) -> Option<(IVec3, IVec3)> {
        let mut filled = self.resident.iter().filter(|(_, b)| b.pages > 0).map(|(p, _)| *p);
        let first = filled.next()?;
        let (low, high) = filled.fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
        Some((low, high + 1))
    }

    /// Forgets what lighting has settled: everything converges anew.
    pub fn invalidate_lighting(&mut self) {
        self.resident.values_mut().for_each(|b| b.updates = 0);
    }
}

/// Weight of a brick's next lighting update: whole at first, so that light travels a bounce an update, then an average
/// over ever more updates.
fn alpha(updates: u32) -> f32 {
    1.0 / (1.0 + (updates.min(768).saturating_sub(24) as f32) / 24.0)
}
