//! Which triangles touch which brick.

mod batch;

pub use batch::{Batch, MAX_TRIANGLES};

use crate::parallel::Workers;
use crate::scene::{Cluster, Instance, Mesh, Scene};
use glam::{DVec3, IVec3, Vec3};
use rustc_hash::{FxHashMap, FxHashSet};

/// Where the voxel grid lies in the world.
#[derive(Clone, Copy, Debug)]
pub struct WorldGrid {
    /// Metres.
    pub voxel_size: f64,
    /// Voxels.
    pub offset: DVec3,
}

impl WorldGrid {
    /// World metres to voxels.
    pub fn to_voxels(self, p: DVec3) -> DVec3 {
        p / self.voxel_size - self.offset
    }

    /// Voxels to world metres.
    pub fn to_world(self, p: DVec3) -> DVec3 {
        (p + self.offset) * self.voxel_size
    }
}

/// Voxels around a brick that also decide about its faces.
const REACH: f64 = 1.02;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Primitive {
    /// Index of the placed instance.
    instance: u32,
    triangle: u32,
}

/// An instance that has been entered.
#[derive(Debug, Default)]
struct Placed {
    id: u64,
    /// Bricks that its bounds reach, wherever the window is.
    first: IVec3,
    last: IVec3,
    /// Those of the window that hold triangles of it.
    bricks: Vec<IVec3>,
    leaving: bool,
}

/// A box of bricks: low corner and size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BrickWindow {
    pub low: IVec3,
    pub size: IVec3,
}

impl BrickWindow {
    fn last(&self) -> IVec3 {
        self.low + self.size - 1
    }

    pub fn holds(&self, brick: IVec3) -> bool {
        brick.cmpge(self.low).all() && brick.cmple(self.last()).all()
    }
}

/// The per-brick primitive lists, of the window's bricks alone: this bounds work and memory. They are in order of ids and
/// triangles: which of two equal surfaces wins does not depend on which came first.
#[derive(Default)]
pub struct PrimitiveIndex {
    window: Option<BrickWindow>,
    bricks: FxHashMap<IVec3, Vec<Primitive>>,
    placed: Vec<Placed>,
    free: Vec<u32>,
    /// Index into `placed` by id.
    index: FxHashMap<u64, u32>,
    /// Corners of everything that has ever been entered, voxels.
    pub bounds: Option<(DVec3, DVec3)>,
    /// Triangles that have been tested against bricks.
    #[cfg(test)]
    tested: u64,
}

impl PrimitiveIndex {
    /// Takes instances out; returns the bricks that held triangles of them, each once.
    pub fn remove(&mut self, instances: &[u64]) -> Vec<IVec3> {
        let mut left = FxHashSet::default();
        let mut leaving = Vec::new();
        for index in instances.iter().filter_map(|id| self.index.remove(id)) {
            let placed = &mut self.placed[index as usize];
            placed.leaving = true;
            left.extend(std::mem::take(&mut placed.bricks));
            leaving.push(index);
        }
        for brick in &left {
            let Some(list) = self.bricks.get_mut(brick) else { continue };
            list.retain(|p| !self.placed[p.instance as usize].leaving);
            if list.is_empty() {
                self.bricks.remove(brick);
            }
        }
        for index in leaving {
            self.placed[index as usize] = Placed::default();
            self.free.push(index);
        }
        left.into_iter().collect()
    }

    /// Enters instances that are not there.
    pub fn insert(&mut self, ids: &[u64], scene: &Scene, grid: &WorldGrid, workers: &Workers) {
        let mut entering = Vec::with_capacity(ids.len());
        for id in ids {
            let index = self.free.pop().unwrap_or(self.placed.len() as u32);
            if index as usize == self.placed.len() {
                self.placed.push(Placed::default());
            }
            self.placed[index as usize].id = *id;
            self.index.insert(*id, index);
            self.measure(index, scene, grid);
            entering.push(index);
        }
        self.register(&entering, None, scene, grid, workers);
    }

    /// Bricks of the window that an instance's triangles touch (or nearly touch).
    pub fn touched(&self, id: u64) -> &[IVec3] {
        self.index.get(&id).map_or(&[], |index| &self.placed[*index as usize].bricks)
    }

    /// Moves the window: what leaves it is forgotten, and the bricks that enter it get their triangles.
    pub fn follow(&mut self, window: BrickWindow, scene: &Scene, grid: &WorldGrid, workers: &Workers) {
        let before = self.window.replace(window);
        self.bricks.retain(|brick, _| window.holds(*brick));
        let mut entering = Vec::new();
        for (index, placed) in (0..).zip(&mut self.placed) {
            placed.bricks.retain(|brick| window.holds(*brick));
            let known = before.is_some_and(|w| w.holds(placed.first) && w.holds(placed.last));
            let meets = placed.first.cmple(window.last()).all() && placed.last.cmpge(window.low).all();
            if meets && !known && self.index.get(&placed.id) == Some(&index) {
                entering.push((placed.id, index));
            }
        }
        entering.sort_unstable();
        let entering: Vec<u32> = entering.into_iter().map(|(_, index)| index).collect();
        self.register(&entering, before, scene, grid, workers);
    }

    /// Takes in an instance's bounds.
    fn measure(&mut self, index: u32, scene: &Scene, grid: &WorldGrid) {
        let own = &mut self.placed[index as usize];
        let Some(instance) = scene.instances.get(&own.id) else { return };
        let Some(mesh) = scene.meshes.get(&instance.mesh).filter(|m| !m.positions.is_empty()) else { return };
        let vertices = mesh.positions.iter().map(|p| place(*p, instance, grid));
        let corners = vertices.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |b, v| (b.0.min(v), b.1.max(v)));
        let (low, high) = self.bounds.unwrap_or(corners);
        self.bounds = Some((low.min(corners.0), high.max(corners.1)));
        (own.first, own.last) = (brick_of(corners.0 - REACH), brick_of(corners.1 + REACH));
    }

    /// Enters instances' triangles in the window's bricks that are not in `known`: workers find them, and they are entered
    /// in the order of the instances.
    fn register(
        &mut self,
        entering: &[u32],
        known: Option<BrickWindow>,
        scene: &Scene,
        grid: &WorldGrid,
        workers: &Workers,
    ) {
        let Some(window) = self.window else { return };
        let (mut tasks, mut triangles) = (vec![Vec::new()], 0);
        for index in entering {
            let Some(instance) = scene.instances.get(&self.placed[*index as usize].id) else { continue };
            let Some(mesh) = scene.meshes.get(&instance.mesh) else { continue };
            for cluster in &mesh.clusters {
                if triangles >= TASK_TRIANGLES {
                    tasks.push(Vec::new());
                    triangles = 0;
                }
                triangles += cluster.triangles.len();
                tasks.last_mut().expect("there is one").push((*index, instance, mesh, cluster));
            }
        }
        let mut unsorted = Vec::new();
        for round in tasks.chunks(ROUND_TASKS) {
            let found = workers.map(round.len(), |task| {
                let mut hits = Hits::default();
                for (index, instance, mesh, cluster) in &round[task] {
                    hits.find(*index, instance, mesh, cluster, grid, &window, known.as_ref());
                }
                hits
            });
            for hits in found {
                self.enter(&hits, &mut unsorted);
            }
        }
        let id_of = |p: &Primitive| self.placed[p.instance as usize].id;
        for brick in unsorted {
            self.bricks.entry(brick).and_modify(|list| list.sort_by_key(|p| (id_of(p), p.triangle)));
        }
    }

    /// Enters what has been found; lists in which it stands too late are added to `unsorted`.
    fn enter(&mut self, hits: &Hits, unsorted: &mut Vec<IVec3>) {
        #[cfg(test)]
        (self.tested += hits.tested);
        for (brick, primitive) in &hits.found {
            let list = self.bricks.entry(*brick).or_default();
            if list.last().is_none_or(|p| p.instance != primitive.instance) {
                let id_of = |p: &Primitive| self.placed[p.instance as usize].id;
                unsorted.extend(list.last().filter(|p| id_of(p) > id_of(primitive)).map(|_| *brick));
                self.placed[primitive.instance as usize].bricks.push(*brick);
            }
            list.push(*primitive);
        }
    }

    /// Whether a brick holds triangles.
    pub fn holds(&self, brick: IVec3) -> bool {
        self.bricks.contains_key(&brick)
    }

    /// Bricks that hold triangles.
    pub fn bricks(&self) -> impl Iterator<Item = IVec3> {
        self.bricks.keys().copied()
    }

    /// Instance and triangle of what each brick holds.
    #[cfg(test)]
    pub fn lists(&self) -> FxHashMap<IVec3, Vec<(u64, u32)>> {
        let pair = |p: &Primitive| (self.placed[p.instance as usize].id, p.triangle);
        self.bricks.iter().map(|(brick, list)| (*brick, list.iter().map(pair).collect())).collect()
    }
}

/// Triangles that a task tests, about.
const TASK_TRIANGLES: usize = 1024;
/// Tasks whose hits are held at once.
const ROUND_TASKS: usize = 64;

/// Which triangles touch which bricks.
#[derive(Default)]
struct Hits {
    found: Vec<(IVec3, Primitive)>,
    #[cfg(test)]
    tested: u64,
}

impl Hits {
    /// Adds a cluster's triangles in the window's bricks that are not in `known`.
    #[expect(clippy::too_many_arguments, reason = "a cluster, where it is, and where it is looked for")]
    fn find(
        &mut self,
        index: u32,
        instance: &Instance,
        mesh: &Mesh,
        cluster: &Cluster,
        grid: &WorldGrid,
        window: &BrickWindow,
        known: Option<&BrickWindow>,
    ) {
        let (first, last) = bricks_of(cluster, instance, grid);
        let (first, last) = (first.max(window.low), last.min(window.last()));
        if first.cmpgt(last).any() || known.is_some_and(|w| w.holds(first) && w.holds(last)) {
            return;
        }
        for triangle in cluster.triangles.clone() {
            #[cfg(test)]
            (self.tested += 1);
            let corners = mesh.triangles[triangle as usize].map(|i| place(mesh.positions[i as usize], instance, grid));
            bricks_near(corners, window, |brick| {
                if known.is_none_or(|w| !w.holds(brick)) {
                    self.found.push((brick, Primitive { instance: index, triangle }));
                }
            });
        }
    }
}

/// A vertex in voxels.
fn place(p: Vec3, instance: &Instance, grid: &WorldGrid) -> DVec3 {
    grid.to_voxels(instance.linear * p.as_dvec3() + instance.translation)
}

/// Bricks that a cluster's bounds reach.
fn bricks_of(cluster: &Cluster, instance: &Instance, grid: &WorldGrid) -> (IVec3, IVec3) {
    let [low, high] = [cluster.low, cluster.high].map(Vec3::as_dvec3);
    let middle = grid.to_voxels(instance.linear * ((low + high) / 2.0) + instance.translation);
    let half = instance.linear.abs() * ((high - low) / 2.0) / grid.voxel_size;
    // More than rounding takes.
    let reach = half + REACH + 1e-4;
    (brick_of(middle - reach), brick_of(middle + reach))
}

fn brick_of(p: DVec3) -> IVec3 {
    (p / 8.0).floor().as_ivec3()
}

/// Calls `enter` with each brick of the window that a triangle touches or nearly touches; corners in voxels.
fn bricks_near(corners: [DVec3; 3], window: &BrickWindow, mut enter: impl FnMut(IVec3)) {
    let low = corners[0].min(corners[1]).min(corners[2]) - REACH;
    let high = corners[0].max(corners[1]).max(corners[2]) + REACH;
    let (first, last) = (brick_of(low), brick_of(high));
    if first == last {
        if window.holds(first) {
            enter(first);
        }
        return;
    }
    let test = CubeTest::new(corners, 4.0 + REACH);
    let (first, last) = (first.max(window.low), last.min(window.last()));
    for z in first.z..=last.z {
        for y in first.y..=last.y {
            for x in first.x..=last.x {
                let brick = IVec3::new(x, y, z);
                if test.meets(brick.as_dvec3() * 8.0 + 4.0) {
                    enter(brick);
                }
            }
        }
    }
}

/// Separating axes of a triangle and cubes of one size (Akenine-Moller 2001), but for the cube's own: those the
/// triangle's bounds tell.
pub struct CubeTest {
    /// Axis, and the range of it in which the centres of cubes lie that it does not separate.
    axes: [(DVec3, f64, f64); 10],
}

impl CubeTest {
    /// `half`: half the edge of the cubes.
    pub fn new(corners: [DVec3; 3], half: f64) -> Self {
        let [a, b, c] = corners;
        let edges = [b - a, c - b, a - c];
        let axis = |k: usize| match k {
            9 => edges[0].cross(edges[1]),
            _ => DVec3::AXES[k % 3].cross(edges[k / 3]),
        };
        let range = |axis: DVec3| {
            let (p, q, r) = (axis.dot(a), axis.dot(b), axis.dot(c));
            let reach = half * axis.abs().element_sum();
            (axis, p.min(q).min(r) - reach, p.max(q).max(r) + reach)
        };
        Self { axes: std::array::from_fn(|k| range(axis(k))) }
    }

    pub fn meets(&self, center: DVec3) -> bool {
        self.axes.iter().all(|(axis, low, high)| (*low..=*high).contains(&axis.dot(center)))
    }
}

#[cfg(test)]
mod tests;
