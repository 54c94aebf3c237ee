//! The host's own images against the references: if these differ, no score of E_ind means anything.

use brickgi_host::{Host, HostOptions, Image, Scene, reference};
use std::path::PathBuf;

/// Share of the pixels that may differ: edges, where the rasteriser and the path tracer round differently.
const TOLERATED: f64 = 0.005;

fn scenes() -> Vec<PathBuf> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let named = |name: &&str| root.join("tests/data").join(name);
    let small = ["two_rooms", "two_rooms_door", "furnace_50", "floor_sky", "emissive_small", "stairs", "corridor"];
    let mut scenes: Vec<PathBuf> = small.iter().map(named).collect();
    scenes.push(root.join("samples/scenes/cornell"));
    // More scenes than the repository holds, one folder each.
    if let Some(extra) = std::env::var_os("BRICKGI_REFERENCES") {
        let folders = std::fs::read_dir(extra).expect("BRICKGI_REFERENCES is a folder");
        scenes.extend(folders.flatten().map(|f| f.path()).filter(|f| f.join("scene.json").is_file()));
    }
    scenes
}

/// Share of pixels of which any channel differs by more than `relative` of the truth plus `absolute`.
fn differing(ours: &Image, truth: &Image, relative: f32, absolute: f32) -> f64 {
    assert_eq!([ours.width, ours.height], [truth.width, truth.height]);
    let far = |(a, b): (&f32, &f32)| (a - b).abs() > relative * b.abs() + absolute;
    let differs = |(a, b): &(&[f32; 3], &[f32; 3])| a.iter().zip(b.iter()).any(far);
    ours.pixels.iter().zip(&truth.pixels).filter(differs).count() as f64 / ours.pixels.len() as f64
}

#[test]
fn gbuffer_and_direct_light_equal_the_references() {
    let mut failures = Vec::new();
    for path in scenes() {
        let scene = std::sync::Arc::new(Scene::load(&path).expect("a reference scene loads"));
        for camera in &scene.cameras {
            let options = HostOptions { camera: Some(camera.name.clone()), ..HostOptions::new(scene.clone()) };
            let mut host = Host::new(options).expect("a host");
            host.frame().expect("a frame");
            let truth = |kind| {
                Image::read_exr(&reference::file(&scene.directory, &scene.name, &camera.name, kind)).expect("truth")
            };
            let depth = host.read_depth().unwrap().map(|d| [*d, 0.0, 0.0]);
            let shares = [
                ("depth", differing(&depth, &truth("depth").map(|d| [d[0], 0.0, 0.0]), 1e-3, 1e-4)),
                ("normal", differing(&host.read_normal().unwrap(), &truth("normal"), 0.0, 2e-3)),
                ("albedo", differing(&host.read_albedo().unwrap(), &truth("albedo"), 1e-2, 2e-3)),
                ("direct", differing(&host.direct().unwrap(), &truth("direct"), 1e-2, 1e-3)),
            ];
            println!("{} {}: {shares:.6?}", scene.name, camera.name);
            let bad = shares.iter().filter(|(_, share)| *share > TOLERATED);
            failures.extend(bad.map(|(kind, share)| format!("{} {} {kind}: {share:.4}", scene.name, camera.name)));
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}
