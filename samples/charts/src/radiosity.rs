//! How fast the light of faces settles, by the rays that it takes.

use crate::measure::Table;
use anyhow::Result;
use brickgi::{DebugView, Settings};
use brickgi_host::image::luminance;
use brickgi_host::{Host, HostOptions, Scene};
use std::path::Path;
use std::sync::Arc;

/// Rays of a face and update that are compared.
const RAYS: [u32; 4] = [1, 4, 16, 64];
/// Rays of a face until which light is watched.
const RAYS_MAX: u32 = 4096;
/// Updates of the truth's [`TRUTH_RAYS`], after some that only let light go round: 10 240 rays a face.
const TRUTH_UPDATES: u32 = 160;
const TRUTH_RAYS: u32 = 64;
const LIGHT_PASSES: [&str; 3] = ["face_compact", "light_bounce", "light_store"];

/// Mean squared error of the faces' radiance, over its squared mean, against rays that each face has shot since it was
/// black, and against microseconds of GPU time that it has cost: 1, 4, 16 or 64 rays in an update. The truth is what
/// 10 240 rays a face say in a world whose light has settled. Cornell box, voxels of .25 m; each pixel of camera a stands
/// for the face that it sees, but for the lamp.
pub fn error() -> Result<[Table; 2]> {
    let scene = Arc::new(Scene::load(Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/cornell"))?);
    let columns = |across| vec![across, "rays_1", "rays_4", "rays_16", "rays_64"];
    let title = "Mean squared error of the faces' light, against rays a face";
    let mut by_rays = Table { title, columns: columns("rays"), rows: Vec::new() };
    let title = "Mean squared error of the faces' light, against GPU time a face";
    let mut by_time = Table { title, columns: columns("microseconds"), rows: Vec::new() };
    let mut truth = Light::new(&scene, TRUTH_RAYS)?;
    let mut sum = Vec::new();
    for update in 0..32 + TRUTH_UPDATES {
        if update % 16 == 0 {
            // Each update is to count in full: its noise is its own, and the mean of many has little.
            truth.host.context_mut().invalidate_lighting();
        }
        let found = truth.update()?;
        sum.resize(found.len(), 0.0);
        if update >= 32 {
            sum.iter_mut().zip(found).for_each(|(sum, found)| *sum += found / f64::from(TRUTH_UPDATES));
        }
    }
    let mean = sum.iter().sum::<f64>() / sum.len() as f64;
    for (column, rays) in (1..).zip(RAYS) {
        let mut light = Light::new(&scene, rays)?;
        for update in 1..=RAYS_MAX / rays {
            let found = light.update()?;
            if update.is_power_of_two() {
                let squares = found.iter().zip(&sum).map(|(found, truth)| (found - truth).powi(2));
                let error = squares.sum::<f64>() / sum.len() as f64 / (mean * mean);
                by_rays.put(f64::from(update * rays), column, error);
                if light.microseconds > 0.0 {
                    by_time.put(light.microseconds, column, error);
                }
                println!("{rays} rays an update, {update} updates, {:.1} us: {error:.3e}", light.microseconds);
            }
        }
    }
    Ok([by_rays, by_time])
}

/// A world whose faces are all lit once a frame.
struct Light {
    host: Host,
    /// Which pixels count.
    seen: Vec<bool>,
    /// That a face has cost.
    microseconds: f64,
}

impl Light {
    /// Loaded, and still black.
    fn new(scene: &Arc<Scene>, bounce_rays: u32) -> Result<Self> {
        let settings = Settings { voxel_size: 0.25, light_faces_per_frame: 8192, bounce_rays, ..Settings::default() };
        let camera = Some("a".into());
        let options = HostOptions { camera, size: Some([96, 54]), settings, ..HostOptions::new(scene.clone()) };
        let mut host = Host::new(options)?;
        // One frame voxelises all of it.
        host.frame()?;
        host.show(Some(DebugView::Radiance));
        let seen = host.read_emission()?.pixels.iter().map(|e| *e == [0.0; 3]).collect();
        Ok(Self { host, seen, microseconds: 0.0 })
    }

    /// One update of all faces.
    fn update(&mut self) -> Result<Vec<f64>> {
        self.host.frame()?;
        while self.host.stats().faces == 0 {
            self.host.frame()?;
        }
        let stats = self.host.stats();
        let lighting = stats.passes.iter().filter(|p| LIGHT_PASSES.contains(&p.name)).map(|p| p.ms);
        self.microseconds += 1e3 * lighting.sum::<f64>() / f64::from(stats.faces);
        let image = self.host.read_indirect()?;
        let seen = image.pixels.iter().zip(&self.seen).filter(|(_, seen)| **seen);
        Ok(seen.map(|(pixel, _)| luminance(*pixel)).collect())
    }
}
