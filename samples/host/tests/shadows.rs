//! Shadow maps that the host draws, against rays through the bricks and against the truth.

use brickgi::{DebugView, Settings};
use brickgi_host::image::luminance;
use brickgi_host::{Host, HostOptions, Image, Reference, Scene};
use std::path::Path;
use std::sync::Arc;

const FRAMES: u32 = 32;

fn scene(name: &str) -> Arc<Scene> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
    Arc::new(Scene::load(root.join(name)).expect("the scene ships with the repository"))
}

fn settings() -> Settings {
    Settings {
        voxel_size: 0.25,
        grid_offset: [0.37, 0.61, 0.23],
        bounce_rays: 2,
        direct_samples: 1,
        ..Settings::default()
    }
}

/// E_ind, and what the faces in view send out, with shadow maps of so many texels along the edge, or with rays; the pass
/// that made the direct light is seen to be the right one.
fn render(
    scene: &Arc<Scene>,
    camera: &str,
    size: Option<[u32; 2]>,
    settings: Settings,
    shadow_maps: u32,
) -> (Image, Image) {
    let camera = Some(camera.into());
    let options =
        HostOptions { camera, size, settings, validation: true, shadow_maps, ..HostOptions::new(scene.clone()) };
    let mut host = Host::new(options).expect("a device with the validation layer");
    (0..4).for_each(|_| host.frame().expect("a frame"));
    // The maps are made anew.
    host.set_lights(scene.lights.clone(), scene.sky).expect("valid lights");
    (4..FRAMES).for_each(|_| host.frame().expect("a frame"));
    let direct = if shadow_maps > 0 { "light_direct_maps" } else { "light_direct" };
    let passes = &host.stats().passes;
    if let Some(pass) = passes.iter().find(|pass| pass.name.starts_with("light_direct")) {
        assert_eq!(pass.name, direct);
        println!("{} {}: {direct} {:.1} ms", scene.name, host.camera().name, pass.ms);
    }
    let image = host.read_indirect().expect("E_ind");
    host.show(Some(DebugView::Radiance));
    host.frame().expect("a frame");
    let faces = host.read_indirect().expect("the faces' light");
    assert_eq!(host.validation_messages(), Vec::<String>::new());
    (image, faces)
}

fn mean(image: &Image) -> f64 {
    image.pixels.iter().map(|p| luminance(*p)).sum::<f64>() / image.pixels.len() as f64
}

/// Deviation of luminance over its mean.
fn nrmse(image: &Image, other: &Image) -> f64 {
    let pairs = image.pixels.iter().zip(&other.pixels);
    let square = pairs.map(|(a, b)| (luminance(*a) - luminance(*b)).powi(2)).sum::<f64>() / image.pixels.len() as f64;
    square.sqrt() / mean(other)
}

/// A cube about the lamp: the lit room as with rays, and no light in the other room.
#[test]
fn rooms_lit_by_a_cube_map_are_as_with_rays() {
    let scene = scene("two_rooms");
    let size = Some([96, 54]);
    let [(rays, faces), (maps, faces_by_maps)] = [0, 512].map(|edge| render(&scene, "a", size, settings(), edge));
    // Of the light in the cache: which way probes send rays, and so their noise, follows from the smallest difference.
    let apart = nrmse(&faces_by_maps, &faces);
    let brighter = mean(&maps) / mean(&rays) - 1.0;
    println!("NRMSE of faces {:.2} %, E_ind {:+.2} % brighter", 100.0 * apart, 100.0 * brighter);
    assert!(apart < 0.03 && brighter.abs() < 0.01, "NRMSE {apart}, {brighter}");
    let dark = mean(&render(&scene, "b", size, settings(), 512).0) / mean(&maps);
    println!("the dark room has {:.5} % of the lit one", 100.0 * dark);
    assert!(dark < 1e-3, "{dark}");
}

/// Slats and rails thinner than a voxel: the map knows where their shadows fall, of which the bricks keep how much they
/// cover. Gathered by rays of each pixel, as probes' noise would hide it. With voxels of a quarter of a metre the bricks
/// are as near (NRMSE .155, by maps .162, where 768 rays a pixel leave little noise), with half a metre the map is nearer
/// (.278, .242); what is left of the map's bias there is the voxels' (ambient light).
#[test]
fn a_suns_map_is_nearer_to_the_truth_than_rays() {
    let scene = scene("stairs");
    let truth = Reference::beside(&scene, "a").expect("readable").expect("the truth ships with the scene");
    let score = |settings, edge| {
        let (image, _) = render(&scene, "a", None, settings, edge);
        let score = truth.score(&image).expect("an image of the truth's size");
        println!("{edge} texels: {score:.4?}");
        (score.nrmse.expect("light"), score.bias.expect("light").abs())
    };
    let [rays, maps] = [0, 4096].map(|edge| score(Settings { voxel_size: 0.5, pixel_rays: 8, ..settings() }, edge).0);
    assert!(maps < 0.95 * rays, "NRMSE {maps}, with rays {rays}");
    let (_, bias) = score(settings(), 4096);
    assert!(bias < 0.03, "bias {bias}");
}
