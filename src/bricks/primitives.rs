//! Which triangles touch which brick.

use super::Mask;
use crate::gpu::shared::{BatchBrick, NONE, REACH_WORDS, TIE_SHIFT, TRANSLUCENT, TWO_SIDED};
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

    /// Lists a brick's triangles, and which of its faces may be lit, in `batch`. False if there are more than
    /// [`MAX_TRIANGLES`].
    pub fn triangles(
        &self,
        brick: IVec3,
        mask: Option<Mask>,
        scene: &Scene,
        grid: &WorldGrid,
        materials: &FxHashMap<u64, u32>,
        batch: &mut Batch,
    ) -> bool {
        let (first, group) = (batch.lists.len(), brick >> 2i32);
        let list = self.bricks.get(&brick).map_or(&[][..], Vec::as_slice);
        let looked_at = &list[..list.len().min(MAX_TRIANGLES)];
        for run in looked_at.chunk_by(|a, b| a.instance == b.instance) {
            let instance = &scene.instances[&self.placed[run[0].instance as usize].id];
            let source = Source::new(instance, scene, grid, group, materials);
            for p in run {
                let triangles = &mut batch.triangles;
                let index = *batch.known.entry((group, *p)).or_insert_with(|| {
                    let words = source.triangle(p.triangle)?;
                    triangles.push(words);
                    Some(triangles.len() as u32 - 1)
                });
                batch.lists.extend(index);
            }
        }
        let place = (brick & 3i32).as_uvec3();
        batch.bricks.push(BatchBrick {
            first_triangle: first as u32,
            triangle_count: (batch.lists.len() - first) as u32,
            seed: brick.to_array().iter().fold(0u32, |h, v| (h ^ *v as u32).wrapping_mul(0x9e37_79b1)),
            place: place.x | place.y << 2 | place.z << 4,
            reach: mask.map_or(NONE, |_| batch.masks.len() as u32 * REACH_WORDS),
        });
        batch.masks.extend(mask);
        list.len() <= MAX_TRIANGLES
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

/// Bricks to be voxelised, as `lib/triangles.wgsl` reads them. Bricks of a group share their triangles.
#[derive(Default)]
pub struct Batch {
    pub bricks: Vec<BatchBrick>,
    /// Indices of triangles.
    pub lists: Vec<u32>,
    /// In group space.
    pub triangles: Vec<[f32; 16]>,
    /// Of the bricks that have one.
    pub masks: Vec<Mask>,
    /// Where a group's triangle stands; None: it has no area.
    known: FxHashMap<(IVec3, Primitive), Option<u32>>,
}

impl Batch {
    /// Empties it; its memory stays.
    pub fn clear(&mut self) {
        self.bricks.clear();
        self.lists.clear();
        self.triangles.clear();
        self.masks.clear();
        self.known.clear();
    }

    /// Bytes to upload.
    pub fn bytes(&self) -> u64 {
        let [bricks, lists] = [size_of_val(&self.bricks[..]), size_of_val(&self.lists[..])];
        let [triangles, masks] = [size_of_val(&self.triangles[..]), size_of_val(&self.masks[..])];
        (bricks + lists + triangles + masks) as u64
    }

    /// Takes the last brick out again; `triangles`: how many there were before.
    pub fn drop_last(&mut self, triangles: usize) {
        if let Some(brick) = self.bricks.pop() {
            self.lists.truncate(brick.first_triangle as usize);
            if brick.reach != NONE {
                self.masks.pop();
            }
            self.triangles.truncate(triangles);
            self.known.retain(|_, index| index.is_none_or(|i| (i as usize) < triangles));
        }
    }
}

/// An instance as seen from a group.
struct Source<'a> {
    instance: &'a Instance,
    mesh: &'a Mesh,
    grid: &'a WorldGrid,
    /// The group's low corner in voxels.
    origin: DVec3,
    material: u32,
    mirrored: bool,
}

impl<'a> Source<'a> {
    fn new(
        instance: &'a Instance,
        scene: &'a Scene,
        grid: &'a WorldGrid,
        group: IVec3,
        materials: &FxHashMap<u64, u32>,
    ) -> Self {
        let origin = group.as_dvec3() * 32.0;
        let (mesh, material) = (&scene.meshes[&instance.mesh], &scene.materials[&instance.material]);
        let flag = if material.is_translucent() { TRANSLUCENT } else { 0 };
        let material = materials[&instance.material] | flag;
        Self { instance, mesh, grid, origin, material, mirrored: instance.linear.determinant() < 0.0 }
    }

    /// A triangle in group space, moved into the solid by [`TIE_SHIFT`]: corners; texture coordinates; material and
    /// sidedness. None: it has no area.
    fn triangle(&self, triangle: u32) -> Option<[f32; 16]> {
        let corners = self.mesh.triangles[triangle as usize].map(|i| self.mesh.positions[i as usize]);
        let [a, b, c] = corners.map(|p| place(p, self.instance, self.grid) - self.origin);
        // A mirrored instance keeps its outside.
        let [a, b, c] = if self.mirrored { [a, c, b] } else { [a, b, c] };
        let normal = (b - a).cross(c - a).normalize_or_zero();
        if normal == DVec3::ZERO {
            return None;
        }
        let shift = normal * f64::from(TIE_SHIFT);
        let [a, b, c] = [a, b, c].map(|v| (v - shift).as_vec3());
        let two_sided = self.mesh.two_sided[triangle as usize];
        let uv = triangle_uvs(self.mesh, triangle);
        let m = f32::from_bits(self.material | if two_sided { TWO_SIDED } else { 0 });
        Some([a.x, a.y, a.z, m, b.x, b.y, b.z, uv[0], c.x, c.y, c.z, uv[1], uv[2], uv[3], uv[4], uv[5]])
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

/// Triangles of one brick that are looked at; voxelisation packs their index into 16 bits.
pub const MAX_TRIANGLES: usize = 32_768;

fn triangle_uvs(mesh: &Mesh, triangle: u32) -> [f32; 6] {
    if mesh.uvs.is_empty() {
        return [0.0; 6];
    }
    let [a, b, c] = mesh.triangles[triangle as usize].map(|i| mesh.uvs[i as usize]);
    // Repeats are the same anywhere: near zero, floats are finest.
    let base = a.min(b).min(c).floor();
    let [a, b, c] = [a, b, c].map(|v| v - base);
    [a.x, a.y, b.x, b.y, c.x, c.y]
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
