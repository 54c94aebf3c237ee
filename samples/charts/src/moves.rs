//! How well images follow a camera that moves, in a world whose light has settled.

use crate::measure::{Table, settle};
use anyhow::Result;
use brickgi::Settings;
use brickgi_host::{Host, HostOptions, Image, Scene, SceneCamera};
use std::path::Path;
use std::sync::Arc;

const FOLDER: &str = "tests/data/two_rooms_door";
const VOXEL_SIZE: f32 = 0.25;
/// Tiles of 16 x 16 pixels in its camera's image.
const TILES: u32 = 20 * 12;
/// Frames of a camera at rest before it moves, and after which an image counts as converged.
const SETTLED: u32 = 96;
/// Rays of each pixel and frame, and frames, of the truth.
const TRUTH: (u32, u32) = (32, 16);
/// Frames of a turn by 180 degrees.
const TURN: u32 = 12;
/// Of a flight out of the lit room, through the door and into the dark one, and where it leads (metres).
const FLIGHT: u32 = 96;
const WAY: [[f64; 3]; 3] = [[0.8, 1.6, 4.4], [6.3, 1.6, 1.1], [11.0, 1.5, 3.6]];
/// Frames in which both are looked at; the camera rests once it has arrived.
const TURN_FRAMES: [u32; 9] = [1, 2, 4, 6, 9, 12, 13, 16, 20];
const FLIGHT_FRAMES: [u32; 9] = [2, 12, 24, 36, 48, 60, 72, 84, 96];
/// Screen probes that may look in a frame.
const PROBES: [u32; 3] = [0, TILES / 2, TILES / 4];

/// relMSE of frames of a moving camera over that of an image that has converged in the same place, both against brute
/// force in the same world; default preset, and as fewer probes may look.
pub fn error() -> Result<[Table; 2]> {
    let scene = Arc::new(Scene::load(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(FOLDER))?);
    let start = scene.camera(Some("a"))?.clone();
    let turned = |frame: u32| {
        let angle = std::f64::consts::PI * f64::from(frame.min(TURN)) / f64::from(TURN);
        let ahead = [0, 1, 2].map(|axis| start.target[axis] - start.position[axis]);
        let (sin, cos) = angle.sin_cos();
        let aside = [ahead[0] * cos + ahead[2] * sin, ahead[1], ahead[2] * cos - ahead[0] * sin];
        SceneCamera { target: [0, 1, 2].map(|axis| start.position[axis] + aside[axis]), ..start.clone() }
    };
    let flown = |frame: u32| {
        let at = f64::from(frame.min(FLIGHT)) / f64::from(FLIGHT);
        SceneCamera { position: along(at), target: along(at + 0.2), ..start.clone() }
    };
    let turn = follow(&scene, "relMSE of a turning camera over converged", &turned, &TURN_FRAMES)?;
    let flight = follow(&scene, "relMSE of a flying camera over converged", &flown, &FLIGHT_FRAMES)?;
    Ok([turn, flight])
}

/// The way at 0 to 1, smooth (a parabola through its corners' middles), and straight on behind it.
fn along(at: f64) -> [f64; 3] {
    let inside = at.min(1.0);
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    [0, 1, 2].map(|axis| {
        let [a, b, c] = WAY.map(|point| point[axis]);
        let (from, to) = (mix(a, b, inside), mix(b, c, inside));
        mix(from, to, inside) + 2.0 * (c - b) * (at - inside)
    })
}

fn follow(scene: &Arc<Scene>, title: &'static str, path: &dyn Fn(u32) -> SceneCamera, frames: &[u32]) -> Result<Table> {
    let columns = vec!["frame", "all_probes", "half", "quarter"];
    let mut table = Table { title, columns, rows: Vec::new() };
    let rays = |pixel_rays, temporal_frames| Settings { pixel_rays, temporal_frames, ..Settings::default() };
    let mut truth = host(scene, rays(TRUTH.0, 1024), path(0))?;
    let mut rested = host(scene, Settings::default(), path(0))?;
    let mut fresh = Vec::new();
    for frame in frames {
        let truth = image_at(&mut truth, path(*frame), TRUTH.1)?;
        let converged = error_of(&image_at(&mut rested, path(*frame), SETTLED)?, &truth);
        println!("{title}: frame {frame}, converged: relMSE {converged:.4}");
        fresh.push((truth, converged));
    }
    for (column, probes_per_frame) in (1..).zip(PROBES) {
        let mut moving = host(scene, Settings { probes_per_frame, ..Settings::default() }, path(0))?;
        let mut looked = 0;
        for frame in 1..=frames.iter().copied().max().unwrap_or(0) {
            moving.set_camera(path(frame))?;
            moving.frame()?;
            looked += moving.stats().probes_traced;
            if let Some(at) = frames.iter().position(|f| *f == frame) {
                let (truth, converged) = &fresh[at];
                let error = error_of(&moving.read_indirect()?, truth);
                println!("{title}: at most {probes_per_frame} probes, frame {frame}: {error:.4}, {looked} so far");
                table.put(f64::from(frame), column, error / converged);
            }
        }
    }
    Ok(table)
}

/// In a world whose light has settled, with an image that has.
fn host(scene: &Arc<Scene>, settings: Settings, camera: SceneCamera) -> Result<Host> {
    let settings = Settings { voxel_size: VOXEL_SIZE, grid_offset: [0.37, 0.61, 0.23], ..settings };
    let mut host =
        Host::new(HostOptions { camera: Some(camera.name.clone()), settings, ..HostOptions::new(scene.clone()) })?;
    host.set_camera(camera)?;
    settle(&mut host)?;
    (0..SETTLED).try_for_each(|_| host.frame())?;
    Ok(host)
}

/// After so many frames from another place, where nothing of it was seen.
fn image_at(host: &mut Host, camera: SceneCamera, frames: u32) -> Result<Image> {
    let away = [0, 1, 2].map(|axis| 2.0 * camera.position[axis] - camera.target[axis]);
    host.set_camera(SceneCamera { target: away, ..camera.clone() })?;
    host.frame()?;
    host.set_camera(camera)?;
    (0..frames).try_for_each(|_| host.frame())?;
    Ok(host.read_indirect()?)
}

/// Mean of squared differences over the squared truth and a hundredth of its mean's square.
fn error_of(image: &Image, truth: &Image) -> f64 {
    let values = || truth.pixels.iter().flatten().map(|v| f64::from(*v));
    let count = values().count() as f64;
    let floor = 0.01 * (values().sum::<f64>() / count).powi(2);
    let found = image.pixels.iter().flatten().map(|v| f64::from(*v));
    found.zip(values()).map(|(x, m)| (x - m).powi(2) / (m * m + floor)).sum::<f64>() / count
}
