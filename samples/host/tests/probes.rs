//! Screen probes that last: what they save, and that nothing shows of it.

use brickgi::{Settings, Stats};
use brickgi_host::image::luminance;
use brickgi_host::{Host, HostOptions, Image, Scene, SceneCamera};
use std::path::Path;

const SIZE: [u32; 2] = [96, 64];
/// Tiles of 8 pixels.
const TILES: u32 = SIZE[0] / 8 * SIZE[1] / 8;

fn host(gather_interval: u32) -> Host {
    host_with(|settings| settings.gather_interval = gather_interval)
}

fn host_with(change: impl FnOnce(&mut Settings)) -> Host {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
    let scene = Scene::load(root.join("two_rooms")).expect("the scene ships with the repository");
    let mut settings = Settings { voxel_size: 0.25, probe_tile: 8, bounce_rays: 1, ..Settings::default() };
    change(&mut settings);
    let options = HostOptions { size: Some(SIZE), settings, validation: true, ..HostOptions::new(scene) };
    Host::new(options).expect("a device with the validation layer")
}

fn frames(host: &mut Host, count: u32) -> Vec<Stats> {
    let next = |_| {
        host.frame().expect("a frame");
        host.stats().clone()
    };
    (0..count).map(next).collect()
}

fn image(host: &mut Host) -> Image {
    assert_eq!(host.validation_messages(), Vec::<String>::new());
    host.read_indirect().expect("E_ind")
}

fn luminances(image: &Image) -> Vec<f64> {
    image.pixels.iter().map(|p| luminance(*p)).collect()
}

/// Root of the mean square difference over the root of the mean square, and of the means.
fn apart(a: &Image, b: &Image) -> [f64; 2] {
    let (a, b) = (luminances(a), luminances(b));
    let squares = |values: Vec<f64>| values.iter().map(|v| v * v).sum::<f64>();
    let difference = squares(a.iter().zip(&b).map(|(a, b)| a - b).collect());
    [(difference / squares(b.clone())).sqrt(), a.iter().sum::<f64>() / b.iter().sum::<f64>() - 1.0]
}

/// A camera `moved` metres to its right.
fn beside(camera: &SceneCamera, moved: f64) -> SceneCamera {
    let mut camera = camera.clone();
    camera.position[0] += moved;
    camera
}

#[test]
fn settled_probes_look_in_turn_and_the_image_is_the_same() {
    let [every, quarter] = [1, 4].map(|interval| {
        let mut host = host(interval);
        frames(&mut host, 192);
        let traced = frames(&mut host, 8).iter().map(|s| s.probes_traced).sum::<u32>();
        (f64::from(traced) / f64::from(8 * TILES), image(&mut host))
    });
    let apart = apart(&quarter.1, &every.1);
    println!("{:.3} probes a tile look in a frame, {:.3} in turn; NRMSE, mean: {apart:.4?}", every.0, quarter.0);
    assert!(every.0 > 0.99 && quarter.0 < 0.3 * every.0, "{} {}", every.0, quarter.0);
    assert!(apart[0] < 0.05 && apart[1].abs() < 0.005, "{apart:?}");
}

#[test]
fn probes_go_along_with_a_camera_that_moves() {
    let mut moving = host(4);
    frames(&mut moving, 128);
    let camera = moving.camera().clone();
    let mut seen = Vec::new();
    for step in 1..=24 {
        moving.set_camera(beside(&camera, 0.02 * f64::from(step))).expect("a valid camera");
        seen.extend(frames(&mut moving, 1));
    }
    let share = |count: fn(&Stats) -> u32| {
        let counts = seen[4..].iter().map(|stats| f64::from(count(stats)));
        counts.sum::<f64>() / f64::from(TILES) / (seen.len() - 4) as f64
    };
    let [carried, conflicts, rejected, traced] = [
        share(|s| s.probes_carried),
        share(|s| s.probe_conflicts),
        share(|s| s.probes_rejected),
        share(|s| s.probes_traced),
    ];
    let moved = image(&mut moving);
    let mut still = host(4);
    still.set_camera(beside(&camera, 0.48)).expect("a valid camera");
    frames(&mut still, 152);
    let apart = apart(&moved, &image(&mut still));
    println!(
        "of the tiles: {carried:.3} carried, {conflicts:.3} conflicts, {rejected:.3} rejected, {traced:.3} looked; \
         NRMSE, mean: {apart:.4?}"
    );
    assert!(carried > 0.85 && traced < 0.6, "{carried} {traced}");
    assert!(apart[0] < 0.08 && apart[1].abs() < 0.02, "{apart:?}");

    // A cut leaves nothing: what comes by chance is another surface.
    let other = moving.scene().cameras[1].clone();
    moving.set_camera(other).expect("camera b");
    let cut = frames(&mut moving, 3).pop().expect("frames");
    assert!(cut.probes_traced > TILES / 10 * 9, "{} of {TILES} look at once", cut.probes_traced);
}

#[test]
fn without_a_near_field_pixels_take_what_probes_say() {
    let [near, far] = [true, false].map(|near_field| {
        let mut host = host_with(|settings| settings.near_field = near_field);
        frames(&mut host, 24);
        let passes = host.stats().passes.iter().map(|pass| pass.name).collect::<Vec<_>>();
        assert_eq!(passes.contains(&"resolve_float32"), near_field, "{passes:?}");
        assert_eq!(passes.contains(&"resolve_far_float32"), !near_field, "{passes:?}");
        image(&mut host)
    });
    let apart = apart(&far, &near);
    println!("NRMSE, mean: {apart:.4?}");
    assert!(apart[0] > 0.01 && apart[0] < 0.3 && apart[1].abs() < 0.05, "{apart:?}");
}

#[test]
fn a_limit_of_probes_holds_and_leaves_nothing_black() {
    let most = TILES / 4;
    let [all, few] = [0, most].map(|probes_per_frame| {
        let mut host = host_with(|settings| settings.probes_per_frame = probes_per_frame);
        frames(&mut host, 64);
        let camera = host.camera().clone();
        let behind = [0, 1, 2].map(|axis| 2.0 * camera.position[axis] - camera.target[axis]);
        host.set_camera(SceneCamera { target: behind, ..camera }).expect("a valid camera");
        let cut = frames(&mut host, 1).pop().expect("a frame");
        let first = image(&mut host);
        let depth = host.read_depth().expect("depth");
        let darkest = luminances(&first)
            .iter()
            .zip(&depth.pixels)
            .filter(|(_, d)| **d > 0.0)
            .map(|(l, _)| *l)
            .fold(f64::MAX, f64::min);
        let mean = luminances(&first).iter().sum::<f64>() / f64::from(SIZE[0] * SIZE[1]);
        assert!(darkest > 0.02 * mean, "{darkest} of {mean}");
        let later = frames(&mut host, 63);
        let looked = later.iter().chain([&cut]).map(|stats| stats.probes_traced).max().expect("frames");
        (looked, first, image(&mut host))
    });
    println!("at most {} probes look, of {} that want to", few.0, all.0);
    // Those of one rank look together.
    assert!(all.0 > TILES && few.0 <= most + TILES.div_ceil(64), "{} {}", all.0, few.0);
    let [first, last] = [apart(&few.1, &all.2), apart(&few.2, &all.2)];
    println!("NRMSE, mean: {first:.4?} in the first frame, {last:.4?} after 64");
    assert!(first[0] < 0.15 && first[1].abs() < 0.05 && last[0] < 0.04 && last[1].abs() < 0.02, "{first:?} {last:?}");
}
