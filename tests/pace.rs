//! Voxelisation keeps to a time. Alone in its binary: tests run beside each other, and each would see the others' time.

use brickgi::Settings;
use brickgi_host::{Host, HostOptions, Scene};
use std::path::Path;

/// As soon as it is known what a brick takes, as many are voxelised as fit into the time.
#[test]
fn voxelisation_keeps_to_its_time() {
    let settings = Settings { voxel_size: 0.1, voxelize_ms: 40.0, light_faces_per_frame: 64, ..Settings::default() };
    let limit = f64::from(settings.voxelize_ms);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let stairs = Scene::load(root.join("tests/data/stairs")).expect("the scene ships with the repository");
    let options = HostOptions { size: Some([32, 32]), validation: true, settings, ..HostOptions::new(stairs) };
    let mut host = Host::new(options).expect("a device with the validation layer");
    let mut times = Vec::new();
    while times.len() < 30 {
        host.frame().expect("a frame");
        let passes = host.stats().passes.iter().filter(|p| p.name.starts_with("vox") || p.name == "face_resolve");
        times.push(passes.map(|p| p.ms).sum::<f64>());
        assert!(host.stats().bricks_missing > 100, "there is always more to do: {:?}", host.stats().bricks_missing);
    }
    println!("limit {limit} ms: {times:.1?}");
    assert_eq!(host.validation_messages(), Vec::<String>::new());
    let mut settled = times.split_off(10);
    settled.sort_unstable_by(f64::total_cmp);
    let (median, ninth) = (settled[10], settled[17]);
    assert!(median > 0.4 * limit && median < 1.25 * limit, "median {median:.1} ms, limit {limit}");
    assert!(ninth < 2.0 * limit, "nine tenths of the frames stay below {ninth:.1} ms, limit {limit}");
}
