//! How fast an image converges once the camera has cut to another place, in worlds whose light has settled.

use crate::measure::{Table, settle};
use anyhow::{Context as _, Result};
use brickgi::Settings;
use brickgi_host::{Host, HostOptions, Reference, Scene};
use std::path::Path;
use std::sync::Arc;

/// Folders of scenes, edge of a voxel in metres, the camera before the cut and the one after it.
const CUTS: [(&str, f32, &str, &str); 5] = [
    ("samples/scenes/cornell", 0.25, "b", "a"),
    ("tests/data/two_rooms_door", 0.25, "a", "b"),
    ("tests/data/stairs", 0.25, "b", "a"),
    ("tests/data/emissive_small", 0.125, "b", "a"),
    ("tests/data/corridor", 0.5, "a", "b"),
];
/// Frames of the camera before the cut.
const SETTLED: u32 = 96;
/// Frames after it.
const FRAMES: u32 = 128;

/// relMSE against frames since a cut, grids shifted by (.37, .61, .23) voxel, default preset.
pub fn error() -> Result<Table> {
    let columns = vec!["frames_since_cut", "cornell", "two_rooms_door", "stairs", "emissive_small", "corridor"];
    let mut table = Table { title: "relMSE against frames since a camera cut", columns, rows: Vec::new() };
    for (column, (folder, voxel_size, before, after)) in (1..).zip(CUTS) {
        let scene = Arc::new(Scene::load(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder))?);
        let truth = Reference::beside(&scene, after)?.context("a scene that ships has its truth beside it")?;
        let settings = Settings { voxel_size, grid_offset: [0.37, 0.61, 0.23], ..Settings::default() };
        let options = HostOptions { camera: Some(before.into()), settings, ..HostOptions::new(scene.clone()) };
        let mut host = Host::new(options)?;
        settle(&mut host)?;
        (0..SETTLED).try_for_each(|_| host.frame())?;
        host.set_camera(scene.camera(Some(after))?.clone())?;
        for frame in 1..=FRAMES {
            host.frame()?;
            if frame.is_power_of_two() {
                let score = truth.score(&host.read_indirect()?).context("an image of the truth's size")?;
                let error = score.rel_mse.context("there is light")?;
                println!("{} {before} to {after}, frame {frame}: relMSE {error:.4}", scene.name);
                table.put(f64::from(frame), column, error);
            }
        }
    }
    Ok(table)
}
