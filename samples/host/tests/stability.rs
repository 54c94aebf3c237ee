//! What the eye follows: an image at rest, and the first frames after a camera has cut to another place.

use brickgi::Settings;
use brickgi_host::image::luminance;
use brickgi_host::{Host, HostOptions, Image, Reference, Scene};
use std::path::Path;
use std::sync::Arc;

fn scene(folder: &str) -> Arc<Scene> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    Arc::new(Scene::load(root.join(folder)).expect("the scene ships with the repository"))
}

fn host(scene: &Arc<Scene>, camera: &str, size: Option<[u32; 2]>, frames: u32) -> Host {
    let settings = Settings { voxel_size: 0.25, grid_offset: [0.37, 0.61, 0.23], ..Settings::default() };
    let options = HostOptions {
        camera: Some(camera.into()),
        size,
        settings,
        validation: true,
        ..HostOptions::new(scene.clone())
    };
    let mut host = Host::new(options).expect("a device with the validation layer");
    (0..frames).for_each(|_| host.frame().expect("a frame"));
    host
}

fn next(host: &mut Host) -> Vec<f64> {
    host.frame().expect("a frame");
    luminances(&host.read_indirect().expect("E_ind"))
}

fn luminances(image: &Image) -> Vec<f64> {
    image.pixels.iter().map(|p| luminance(*p)).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn an_image_at_rest_stands_still() {
    let mut host = host(&scene("tests/data/two_rooms"), "a", Some([96, 54]), 192);
    let frames: Vec<Vec<f64>> = (0..32).map(|_| next(&mut host)).collect();
    let change = |pair: &[Vec<f64>]| {
        let apart: Vec<f64> = pair[0].iter().zip(&pair[1]).map(|(a, b)| (a - b).abs()).collect();
        mean(&apart) / mean(&pair[1])
    };
    let most = frames.windows(2).map(change).fold(0.0, f64::max);
    let restless = (0..frames[0].len()).filter(|i| {
        let values: Vec<f64> = frames.iter().map(|frame| frame[*i]).collect();
        let average = mean(&values);
        let squares: Vec<f64> = values.iter().map(|v| (v - average).powi(2)).collect();
        mean(&squares).sqrt() > 0.05 * average
    });
    let restless = restless.count();
    println!(
        "{:.3} % from frame to frame at most; {restless} of {} pixels deviate by over 5 %",
        100.0 * most,
        frames[0].len()
    );
    // None is the goal; single pixels come and go with the noise.
    assert!(most < 0.005 && restless * 1000 < frames[0].len(), "{most}, {restless}");
    assert_eq!(host.validation_messages(), Vec::<String>::new());
}

#[test]
fn a_camera_that_cuts_shows_no_trace_of_where_it_was() {
    let scene = scene("samples/scenes/cornell");
    let truth = Reference::beside(&scene, "a").expect("readable").expect("the truth ships with the scene");
    let expected = luminances(&truth.indirect());
    let dim = mean(&expected) * 0.2;
    let mut host = host(&scene, "b", None, 48);
    host.set_camera(scene.camera(Some("a")).expect("camera a").clone()).expect("a valid camera");
    for frame in 1..=8 {
        let image = next(&mut host);
        let black =
            image.iter().zip(&expected).filter(|(found, truth)| **truth > dim && **found < 0.01 * *truth).count();
        let score = truth.score(&host.read_indirect().expect("E_ind")).expect("an image of the truth's size");
        let error = score.rel_mse.expect("light");
        println!("frame {frame}: relMSE {error:.4}, {black} black pixels");
        assert!(error < if frame < 8 { 0.4 } else { 0.12 }, "frame {frame}: {error}");
        assert_eq!(black, 0, "frame {frame}");
    }
    assert_eq!(host.validation_messages(), Vec::<String>::new());
}
