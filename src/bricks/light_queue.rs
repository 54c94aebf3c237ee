//! Whose turn it is to be lit.

use crate::gpu::shared::{LightBrick, LightChange};
use glam::{DVec3, IVec3};
use std::collections::BTreeMap;

/// Frames that deadlines may lie apart; bricks so far away are due a little early.
const SPAN: u64 = 1024;
/// Frames after which a brick at the camera is due again.
const PERIOD_MIN: f64 = 8.0;
/// Updates from which on nothing that was known before counts, and all that follow count alike.
const KNOWN: u32 = 768;
/// Updates after which a brick's light has settled: the last has a weight of 1/256.
const SETTLED: u32 = KNOWN + 224;
/// What has settled starts from here when something has changed somewhere: by update 768 its average has
/// forgotten all but (640 / 768)^24, a hundredth, of what it was.
const ROUSED: u32 = 640;
/// What is voxelised again counts as updated so often at most: averages have a weight of a quarter.
const CARRIED: u32 = 4 * FAST;
/// Updates that are watched for changes after something has changed somewhere.
const WATCHED: u32 = 32;
/// Bricks lit in one frame at most: one workgroup each.
const CHOSEN_MAX: usize = 65_535;

/// A brick that waits for its turn.
#[derive(Clone, Copy, Debug)]
struct Turn {
    /// In bricks.
    position: IVec3,
    /// First word in `world_bricks`.
    base: u32,
    faces: u32,
    /// Lighting updates since the lights of `epoch`, up to [`SETTLED`].
    updates: u32,
    epoch: u32,
    /// When it was last looked at, of [`LightQueue::changes`].
    changes: u32,
    /// Tells it from what had its place before.
    serial: u32,
    change: Change,
    due: Due,
    /// Its place in the list of its deadline.
    place: u32,
}

/// What updates say of a brick's light.
#[derive(Clone, Copy, Debug, Default)]
struct Change {
    /// Updates still to be watched.
    watched: u32,
    /// Running averages of [`LightChange::difference`] and of its square.
    mean: f32,
    square: f32,
}

/// A brick that a frame has lit.
#[derive(Clone, Copy, Debug)]
pub struct Lit {
    turn: u32,
    serial: u32,
}

/// When a brick is due.
#[derive(Clone, Copy, Debug)]
enum Due {
    /// At once, for it was never lit: the nearest first. Distance in 1/16 bricks.
    New(u32),
    /// In this frame.
    Frame(u64),
    /// When something changes: its light has settled.
    Never,
}

/// What a frame may light.
#[derive(Clone, Copy, Debug)]
pub struct LightBudget {
    pub faces: u32,
    /// Faces that there is room for: a brick that has more than `faces` is lit alone.
    pub room: u32,
    pub bricks: usize,
    /// Times that each brick is lit.
    pub sweeps: u32,
}

/// Bricks by the frame in which their lighting is due, earliest first: a brick is due as many frames after it was lit as
/// it is bricks away from the camera. What was never lit comes before everything, the nearest first. A brick that is due
/// does not starve, for what is lit goes behind it. A turn costs no search: those of one frame lie in one list.
///
/// Bricks whose light has settled sleep, until bricks come, go or change, or the lights do. Light goes far: that rouses
/// all of them. Those whose light is then found to change are lit again at once, and their averages quickened.
#[derive(Debug, Default)]
pub struct LightQueue {
    turns: Vec<Turn>,
    free: Vec<u32>,
    /// Turns of bricks that were never lit, by distance.
    new: BTreeMap<u32, Vec<u32>>,
    /// The others' by frame, modulo [`SPAN`]: those of `first` up to `first + SPAN`.
    frames: Vec<Vec<u32>>,
    first: u64,
    /// Turns in `frames`.
    waiting: usize,
    asleep: Vec<u32>,
    /// Kept for their memory.
    taken: Vec<u32>,
    chosen: Vec<LightBrick>,
    lit: Vec<Lit>,
    faces: u32,
    /// Sum of faces times updates, of this epoch.
    settled: u64,
    /// Counts the changes of the lights.
    epoch: u32,
    /// Counts the changes of bricks.
    changes: u32,
    /// Bricks that have ever entered.
    entered: u32,
}

impl LightQueue {
    /// A brick with faces that have never been lit, `distance` bricks from the camera; the others have the light of as many
    /// `updates`. Returns its turn, by which it leaves.
    pub fn enter(&mut self, position: IVec3, base: u32, faces: u32, distance: f64, updates: u32) -> u32 {
        let due = Due::New((distance * 16.0) as u32);
        self.entered = self.entered.wrapping_add(1);
        let turn = Turn {
            position,
            base,
            faces,
            updates: updates.min(CARRIED),
            epoch: self.epoch,
            changes: self.changes,
            serial: self.entered,
            change: Change { watched: WATCHED, ..Change::default() },
            due,
            place: 0,
        };
        let index = self.free.pop().unwrap_or(self.turns.len() as u32);
        if index as usize == self.turns.len() {
            self.turns.push(turn);
        } else {
            self.turns[index as usize] = turn;
        }
        self.faces += faces;
        self.settled += u64::from(turn.updates * faces);
        self.put(index, due);
        index
    }

    /// Takes a brick out. Returns its faces, and their updates since the lights last changed.
    pub fn leave(&mut self, index: u32) -> (u32, u32) {
        let Turn { faces, updates, epoch, .. } = self.turns[index as usize];
        let updates = if epoch == self.epoch { updates } else { 0 };
        self.settled -= u64::from(updates * faces);
        self.take_out(index);
        self.turns[index as usize].serial = 0;
        self.faces -= faces;
        self.free.push(index);
        (faces, updates)
    }

    fn take_out(&mut self, index: u32) {
        let Turn { due, place, .. } = self.turns[index as usize];
        let list = self.list(due);
        list.swap_remove(place as usize);
        let (moved, is_empty) = (list.get(place as usize).copied(), list.is_empty());
        if let Some(moved) = moved {
            self.turns[moved as usize].place = place;
        }
        match due {
            Due::New(distance) if is_empty => drop(self.new.remove(&distance)),
            Due::New(_) | Due::Never => {}
            Due::Frame(_) => self.waiting -= 1,
        }
    }

    fn list(&mut self, due: Due) -> &mut Vec<u32> {
        match due {
            Due::New(distance) => self.new.entry(distance).or_default(),
            Due::Frame(frame) => {
                self.frames.resize(SPAN as usize, Vec::new());
                &mut self.frames[(frame % SPAN) as usize]
            }
            Due::Never => &mut self.asleep,
        }
    }

    /// A brick lies elsewhere in `world_bricks` now.
    pub fn relocate(&mut self, index: u32, base: u32) {
        self.turns[index as usize].base = base;
    }

    /// Faces of all bricks.
    pub fn faces(&self) -> u32 {
        self.faces
    }

    /// All light is to converge anew. Whose turn it is stays: lights that change every frame keep no brick from being lit.
    pub fn invalidate(&mut self) {
        self.epoch = self.epoch.wrapping_add(1);
        self.settled = 0;
        self.rouse();
    }

    /// Something has changed that light may come from, pass or be reflected by.
    pub fn rouse(&mut self) {
        self.changes = self.changes.wrapping_add(1);
    }

    /// How far light has settled, 0 (nothing has been lit) to 1 (all has settled).
    pub fn convergence(&self) -> f64 {
        if self.faces == 0 { 1.0 } else { self.settled as f64 / (f64::from(self.faces) * f64::from(SETTLED)) }
    }

    /// Takes bricks whose turn it is, as many as the budget allows, in frame `clock`. Positions count from `window`,
    /// distances from `camera` (bricks). Returns them with the number of their faces.
    pub fn choose(
        &mut self,
        budget: &LightBudget,
        clock: u64,
        window: IVec3,
        camera: DVec3,
    ) -> (&mut [LightBrick], u32) {
        self.wake(clock, camera);
        let most = budget.bricks.min(CHOSEN_MAX);
        let (mut taken, mut faces) = (std::mem::take(&mut self.taken), 0);
        while let Some(mut list) = self.take_first() {
            // Who comes first must not depend on history. What was lit together is in order already.
            list.1.sort_by_key(|i| self.turns[*i as usize].position.to_array());
            let fits = |i: &&u32| {
                let turn = &self.turns[**i as usize];
                let fits = faces + turn.faces <= if faces == 0 { budget.room } else { budget.faces };
                faces += if fits { turn.faces } else { 0 };
                fits
            };
            let count = list.1.iter().take(most - taken.len()).take_while(fits).count();
            taken.extend(list.1.drain(..count));
            let is_done = list.1.is_empty();
            self.put_back(list);
            if !is_done {
                break;
            }
        }
        let mut first_face = 0;
        self.lit.clear();
        self.lit.extend(taken.iter().map(|turn| Lit { turn: *turn, serial: self.turns[*turn as usize].serial }));
        self.chosen.clear();
        self.chosen.extend(taken.iter().map(|index| {
            let turn = &mut self.turns[*index as usize];
            self.settled -= turn.look(self.epoch, self.changes);
            let p = (turn.position - window).as_uvec3();
            let (base, position, alpha) = (turn.base, p.x | p.y << 10 | p.z << 20, alpha(turn.updates));
            turn.updates = (turn.updates + budget.sweeps).min(SETTLED);
            self.settled += u64::from(turn.updates * turn.faces);
            first_face += turn.faces;
            LightBrick { base, position, first_face: first_face - turn.faces, alpha }
        }));
        for index in taken.drain(..) {
            if self.turns[index as usize].updates == SETTLED {
                self.put(index, Due::Never);
            } else {
                self.put_after(index, clock, camera);
            }
        }
        self.taken = taken;
        (&mut self.chosen, faces)
    }

    /// The bricks that were chosen last.
    pub fn lit(&self) -> &[Lit] {
        &self.lit
    }

    /// What came of lighting a brick, in frame `clock`.
    pub fn note(&mut self, lit: Lit, found: LightChange, clock: u64) {
        let epoch = self.epoch;
        let turn = &mut self.turns[lit.turn as usize];
        if turn.serial != lit.serial || turn.epoch != epoch {
            return;
        }
        let Some(alpha) = turn.change.note(&found) else { return };
        let updates = turn.updates.min((FAST as f32 / alpha) as u32);
        self.settled -= u64::from((turn.updates - updates) * turn.faces);
        turn.updates = updates;
        self.take_out(lit.turn);
        self.first = if self.waiting == 0 { clock } else { self.first.min(clock) };
        self.put(lit.turn, Due::Frame(clock.min(self.first + SPAN - 1)));
        self.waiting += 1;
    }

    /// If anything has changed, gives those that sleep their turns.
    fn wake(&mut self, clock: u64, camera: DVec3) {
        let stale = |index: &u32| self.turns[*index as usize].changes != self.changes;
        if !self.asleep.last().is_some_and(stale) {
            return;
        }
        for index in std::mem::take(&mut self.asleep) {
            let (turn, epoch) = (&mut self.turns[index as usize], self.epoch);
            self.settled -= turn.look(epoch, self.changes);
            self.settled += u64::from(turn.updates * turn.faces);
            self.put_after(index, clock, camera);
        }
    }

    /// Puts what is lit in frame `clock` where it is due again.
    fn put_after(&mut self, index: u32, clock: u64, camera: DVec3) {
        let distance = (self.turns[index as usize].position.as_dvec3() + 0.5 - camera).length();
        let due = clock + (PERIOD_MIN + distance) as u64;
        self.first = if self.waiting == 0 { due } else { self.first.min(due) };
        self.put(index, Due::Frame(due.min(self.first + SPAN - 1)));
        self.waiting += 1;
    }

    /// Takes the list of the earliest deadline out; an empty one does not come.
    fn take_first(&mut self) -> Option<(Due, Vec<u32>)> {
        if let Some((distance, list)) = self.new.pop_first() {
            return Some((Due::New(distance), list));
        }
        if self.waiting == 0 {
            return None;
        }
        while self.list(Due::Frame(self.first)).is_empty() {
            self.first += 1;
        }
        let due = Due::Frame(self.first);
        let list = std::mem::take(self.list(due));
        self.waiting -= list.len();
        Some((due, list))
    }

    /// Puts what is left of a list back, and an empty one for its memory.
    fn put_back(&mut self, (due, list): (Due, Vec<u32>)) {
        (0..).zip(&list).for_each(|(place, i)| self.turns[*i as usize].place = place);
        match due {
            Due::New(_) if list.is_empty() => return,
            Due::New(_) | Due::Never => {}
            Due::Frame(_) => self.waiting += list.len(),
        }
        *self.list(due) = list;
    }

    fn put(&mut self, index: u32, due: Due) {
        let list = self.list(due);
        let place = list.len() as u32;
        list.push(index);
        let turn = &mut self.turns[index as usize];
        (turn.due, turn.place) = (due, place);
    }
}

impl Turn {
    /// Takes in what has changed since it was last looked at. Returns what it has counted for so far in this epoch: faces
    /// times updates.
    fn look(&mut self, epoch: u32, changes: u32) -> u64 {
        if self.epoch != epoch {
            (self.epoch, self.changes, self.updates) = (epoch, changes, 0);
            self.change = Change::default();
            return 0;
        }
        let counted = u64::from(self.updates * self.faces);
        if self.changes != changes {
            (self.changes, self.updates) = (changes, self.updates.min(ROUSED));
            (self.change.watched, self.change.mean) = (WATCHED, 0.0);
        }
        counted
    }
}

impl Change {
    /// Takes in an update. Where it tells a change from noise: the weight that the next updates should have.
    fn note(&mut self, found: &LightChange) -> Option<f32> {
        let LightChange { difference, radiance, deviation } = *found;
        let noise = self.square.max(deviation * deviation);
        self.square += (difference * difference - self.square) / 32.0;
        if self.watched == 0 {
            return None;
        }
        self.watched -= 1;
        self.mean += (difference - self.mean) / 4.0;
        let change = self.mean.abs();
        // An average of a quarter each has a seventh of the variance; four deviations are no accident.
        let is_one = change > 0.02 * radiance && change * change > noise * (16.0 / 7.0);
        is_one.then(|| {
            self.mean = 0.0;
            (4.0 * change / radiance).min(1.0)
        })
    }
}

/// Updates of weight 1.
const FAST: u32 = 24;

/// Weight of a brick's next lighting update: whole at first, so that light travels a bounce an update; then an average over
/// ever more updates, which forgets the early ones, for light was still on its way then; at last one that all count in.
fn alpha(updates: u32) -> f32 {
    let fading = updates.min(KNOWN).saturating_sub(FAST) as f32 / FAST as f32;
    1.0 / (1.0 + fading + updates.saturating_sub(KNOWN) as f32)
}

#[cfg(test)]
mod tests {
    use super::super::unpack;
    use super::*;
    use std::collections::{BTreeSet, HashMap};

    /// Deadlines of bricks that were never lit lie below this.
    const LIT: u64 = 1 << 32;

    /// The queue takes, in every frame, the bricks that a sorted set of deadlines would give, whoever comes and goes.
    #[test]
    fn the_earliest_deadlines_come_first() {
        let mut queue = LightQueue::default();
        let mut sorted: BTreeSet<(u64, [i32; 3])> = BTreeSet::new();
        let mut bricks: HashMap<[i32; 3], (u32, u64)> = HashMap::new();
        let mut random = 1u32;
        for clock in 0..2000 {
            for _ in 0..4 {
                random = random.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
                let [x, y, z] = [24, 20, 16].map(|shift| (random >> shift & 15) as i32);
                if let Some((turn, due)) = bricks.remove(&[x, y, z]) {
                    queue.leave(turn);
                    assert!(sorted.remove(&(due, [x, y, z])));
                } else {
                    let brick = IVec3::new(x, y, z);
                    let due = (brick.as_dvec3().length() * 16.0) as u64;
                    let faces = 1 + (random >> 8) % 50;
                    let turn = queue.enter(brick, faces, faces, brick.as_dvec3().length(), 0);
                    bricks.insert([x, y, z], (turn, due));
                    sorted.insert((due, [x, y, z]));
                }
            }
            let budget = LightBudget { faces: 900, room: 900, bricks: 30, sweeps: 1 };
            let (chosen, faces) = queue.choose(&budget, clock, IVec3::ZERO, DVec3::ZERO);
            let chosen = chosen.to_vec();
            let mut expected = Vec::new();
            let mut left = 900;
            for (due, brick) in sorted.iter().copied().take(30) {
                let own = queue.turns[bricks[&brick].0 as usize].faces;
                if own > left {
                    break;
                }
                left -= own;
                expected.push((due, brick));
            }
            assert_eq!(faces, 900 - left);
            let found: Vec<_> = chosen.iter().map(|b| unpack(b.position).to_array()).collect();
            assert_eq!(found, expected.iter().map(|e| e.1).collect::<Vec<_>>());
            for (due, brick) in expected {
                sorted.remove(&(due, brick));
                let p = IVec3::from(brick).as_dvec3() + 0.5;
                let again = LIT + clock + (PERIOD_MIN + p.length()) as u64;
                sorted.insert((again, brick));
                bricks.get_mut(&brick).expect("it is there").1 = again;
            }
        }
        assert_eq!(queue.faces(), bricks.values().map(|b| queue.turns[b.0 as usize].faces).sum::<u32>());
    }

    #[test]
    fn a_brick_larger_than_the_budget_is_lit_alone() {
        let mut queue = LightQueue::default();
        for (x, faces) in [(0, 20), (1, 300), (2, 20)] {
            queue.enter(IVec3::X * x, 0, faces, f64::from(x), 0);
        }
        let mut choose = |room: u32| {
            let budget = LightBudget { faces: 64, room, bricks: 30, sweeps: 1 };
            queue.choose(&budget, 0, IVec3::ZERO, DVec3::ZERO).1
        };
        assert_eq!([choose(3072), choose(299), choose(3072), choose(3072)], [20, 0, 300, 40]);
    }
}
