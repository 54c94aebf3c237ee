//! A world of many small boxes on a square lattice, in a host that draws next to nothing: what is measured is the world.

use anyhow::Result;
use brickgi::scene::{InstanceDesc, MaterialDesc, MeshDesc, MeshUpdate};
use brickgi::{Settings, Stats};
use brickgi_host::{Host, HostOptions, Scene, SceneCamera, scene};
use std::time::{Duration, Instant};

/// Half the edge of a box in metres.
const HALF: f32 = 0.3;
/// Ids of what the field adds; the host's own scene counts from 0.
const FIRST: u64 = 1000;
/// Instances handed over in one call while the field is made.
const CHUNK: usize = 10_000;

/// Boxes by index, each at its place or a little beside it.
pub struct Field {
    pub host: Host,
    boxes: usize,
    spacing: f64,
    /// Whether each box stands beside its place.
    moved: Vec<bool>,
}

/// CPU time of a step.
#[derive(Clone, Copy, Default)]
pub struct Cost {
    /// In `update_meshes`.
    pub update: Duration,
    /// In `dispatch`.
    pub dispatch: Duration,
}

impl Field {
    /// Loads `boxes` boxes, `spacing` metres apart, until nothing is missing. Returns what that cost in all.
    pub fn new(boxes: usize, spacing: f64, settings: Settings) -> Result<(Self, Cost)> {
        let options = HostOptions { settings, size: Some([16, 16]), ..HostOptions::new(stage()) };
        let mut field = Self { host: Host::new(options)?, boxes, spacing, moved: vec![true; boxes] };
        // The window exists before the boxes come.
        field.frame()?;
        let scene::Mesh { positions, indices, .. } = cube();
        field.host.context_mut().update_meshes(&MeshUpdate {
            materials: &[MaterialDesc { id: FIRST, base_color: [0.5; 3], ..MaterialDesc::default() }],
            meshes: &[MeshDesc { id: FIRST, positions: &positions, uvs: &[], indices: &indices }],
            ..MeshUpdate::default()
        })?;
        let all: Vec<usize> = (0..boxes).collect();
        let mut cost = Cost::default();
        for chunk in all.chunks(CHUNK) {
            cost.update += field.place(chunk)?;
        }
        let mut quiet = 0;
        while quiet < 8 {
            cost.dispatch += field.frame()?;
            quiet = if field.stats().bricks_missing == field.stats().bricks_left_out { quiet + 1 } else { 0 };
        }
        Ok((field, cost))
    }

    /// Moves the first `count` boxes a little, evenly spread over the field, and makes a frame.
    pub fn step(&mut self, count: usize) -> Result<Cost> {
        let chosen: Vec<usize> = (0..count).map(|i| i * self.boxes / count).collect();
        Ok(Cost { update: self.place(&chosen)?, dispatch: self.frame()? })
    }

    /// A frame; the CPU time of its `dispatch`.
    pub fn frame(&mut self) -> Result<Duration> {
        self.host.frame()?;
        Ok(Duration::from_secs_f64(self.stats().cpu_ms * 1e-3))
    }

    pub fn stats(&self) -> &Stats {
        self.host.stats()
    }

    fn place(&mut self, chosen: &[usize]) -> Result<Duration> {
        let edge = (self.boxes as f64).sqrt().ceil() as usize;
        let middle = edge as f64 / 2.0;
        chosen.iter().for_each(|i| self.moved[*i] = !self.moved[*i]);
        let instance = |index: &usize| {
            let shift = if self.moved[*index] { 0.25 } else { 0.0 };
            let cell = [index % edge, index / edge].map(|i| (i as f64 + 0.5 - middle) * self.spacing + shift);
            InstanceDesc {
                id: FIRST + *index as u64,
                mesh: FIRST,
                material: FIRST,
                linear: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                translation: [cell[0], 2.0, cell[1]],
            }
        };
        let instances: Vec<_> = chosen.iter().map(instance).collect();
        let start = Instant::now();
        self.host.context_mut().update_meshes(&MeshUpdate { instances: &instances, ..MeshUpdate::default() })?;
        Ok(start.elapsed())
    }
}

fn cube() -> scene::Mesh {
    scene::Mesh::cuboid([-HALF; 3], [HALF; 3])
}

/// One box far below, which nobody sees, and a camera in the middle of the field.
fn stage() -> Scene {
    Scene {
        name: "field".into(),
        meshes: vec![cube()],
        materials: vec![scene::Material { base_color: [0.5; 3], emission: [0.0; 3], texture: None }],
        instances: vec![scene::Instance::at(0, 0, [0.0, -8.0, 0.0])],
        sky: scene::Sky::Constant { radiance: [1.0; 3] },
        cameras: vec![SceneCamera {
            name: "middle".into(),
            position: [0.0, 4.0, 0.0],
            target: [1.0, 4.0, 0.0],
            up: [0.0, 1.0, 0.0],
            vfov_deg: 60.0,
            near: 0.1,
            width: 16,
            height: 16,
        }],
        ..Scene::default()
    }
}
