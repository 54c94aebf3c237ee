//! What lies behind the output: the voxels' albedo, normals and light against the G-buffer's.

use brickgi::{DebugView, Settings};
use brickgi_host::image::luminance;
use brickgi_host::{Host, HostOptions, Image, Scene};
use std::f64::consts::PI;
use std::path::Path;

fn host() -> Host {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
    let scene = Scene::load(root.join("two_rooms")).expect("the scene ships with the repository");
    let options = HostOptions {
        size: Some([96, 54]),
        settings: Settings { voxel_size: 0.25, ..Settings::default() },
        validation: true,
        ..HostOptions::new(scene)
    };
    let mut host = Host::new(options).expect("a device with the validation layer");
    (0..48).for_each(|_| host.frame().expect("a frame"));
    host
}

fn shown(host: &mut Host, view: DebugView) -> Image {
    host.show(Some(view));
    host.frame().expect("a frame");
    host.show(None);
    host.read_indirect().expect("the output")
}

/// Share of the pixels in which no channel is off by more than `most`.
fn agreeing(a: &Image, b: &Image, most: f32) -> f64 {
    let close = |(a, b): &(&[f32; 3], &[f32; 3])| a.iter().zip(*b).all(|(a, b)| (a - b).abs() <= most);
    a.pixels.iter().zip(&b.pixels).filter(close).count() as f64 / a.pixels.len() as f64
}

#[test]
fn rays_of_the_camera_find_what_it_sees() {
    let mut host = host();
    let albedo = agreeing(&shown(&mut host, DebugView::Albedo), &host.read_albedo().expect("albedo"), 0.01);
    let halved =
        |image: Image| Image { pixels: image.pixels.iter().map(|n| n.map(|v| v * 0.5 + 0.5)).collect(), ..image };
    let normals = halved(host.read_normal().expect("normals"));
    let normals = agreeing(&shown(&mut host, DebugView::Normals), &normals, 0.01);
    println!("albedo {albedo:.4}, normals {normals:.4} of the pixels");
    assert!(albedo > 0.95 && normals > 0.95, "{albedo} {normals}");

    // What a surface sends out is its albedo's share of what arrives.
    host.frame().expect("a frame");
    let indirect = host.read_indirect().expect("E_ind");
    let (direct, albedo) = (host.direct().expect("E_direct"), host.read_albedo().expect("albedo"));
    let emission = host.read_emission().expect("emission");
    let [radiance, irradiance] = [DebugView::Radiance, DebugView::Irradiance].map(|view| shown(&mut host, view));
    let pixels = (0..radiance.pixels.len()).filter(|i| emission.pixels[*i] == [0.0; 3]);
    let (mut found, mut expected) = ([0.0; 2], [0.0; 2]);
    for i in pixels {
        let arrives: [f32; 3] = std::array::from_fn(|c| direct.pixels[i][c] + indirect.pixels[i][c]);
        let sent = std::array::from_fn(|c| albedo.pixels[i][c] * arrives[c]);
        expected = [expected[0] + luminance(sent) / PI, expected[1] + luminance(arrives)];
        found = [found[0] + luminance(radiance.pixels[i]), found[1] + luminance(irradiance.pixels[i])];
    }
    println!("radiance and irradiance {found:.3?}, {expected:.3?} expected");
    assert!(found.iter().zip(expected).all(|(found, expected)| (found / expected - 1.0).abs() < 0.03));
    assert_eq!(host.validation_messages(), Vec::<String>::new());
}

#[test]
fn other_views_show_something_and_disturb_nothing() {
    let mut host = host();
    let before = host.read_indirect().expect("E_ind");
    let bricks = shown(&mut host, DebugView::Bricks);
    let mut colors = bricks.pixels.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>();
    colors.sort_unstable();
    colors.dedup();
    assert!(colors.len() > 100, "{} colours of voxels", colors.len());
    for view in [DebugView::Steps, DebugView::History] {
        let image = shown(&mut host, view);
        assert!(image.pixels.iter().flatten().all(|v| (0.0..=1.0).contains(v)), "{view:?}");
        let mean = image.pixels.iter().map(|p| f64::from(p[2])).sum::<f64>() / image.pixels.len() as f64;
        println!("{view:?}: {mean:.3}");
        assert!(mean > 0.05, "{view:?}: {mean}");
    }
    // New where nothing has been seen for long, else carried along, or new in its turn.
    let probes = shown(&mut host, DebugView::Probes);
    let kinds = [0, 1, 2].map(|k| probes.pixels.iter().filter(|p| p[k] == 1.0 && p.iter().sum::<f32>() == 1.0).count());
    println!("probes: {kinds:?} of {} pixels", probes.pixels.len());
    assert!(kinds[0] > 0 && kinds.iter().sum::<usize>() == probes.pixels.len(), "{kinds:?}");
    // The mean of squares is more than the mean that makes the irradiance, and not much more in a room like this; but what
    // is near, which pixels see for themselves, is left out.
    let maps = shown(&mut host, DebugView::ProbeRadiance);
    let (mut sum, mut weights) = (0.0, 0.0);
    for (x, y) in (0..48).flat_map(|y| (0..96).map(move |x| (x, y))) {
        let square = [x % 16, y % 16].map(|v| f64::from(v / 2) / 4.0 - 0.875);
        let [u, v] = [square[0] + square[1], square[0] - square[1]].map(|sum| sum / 2.0);
        let z = 1.0 - f64::abs(u) - f64::abs(v);
        let weight = z / (u * u + v * v + z * z).powi(2);
        sum += weight * f64::from(maps.at(x, y)[0]);
        weights += weight;
    }
    let mean = before.pixels.iter().map(|p| luminance(*p)).sum::<f64>() / before.pixels.len() as f64;
    let ratio = sum / weights / (mean / PI);
    println!("probes' radiance is {ratio:.3} of what makes the irradiance");
    assert!((0.8..1.3).contains(&ratio), "{ratio}");
    // Few pixels are without probes, also in strips beside the boxes that are narrower than a tile.
    let fallback = shown(&mut host, DebugView::Fallback);
    let red = fallback.pixels.iter().filter(|p| **p == [1.0, 0.0, 0.0]).count();
    let green = fallback.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / fallback.pixels.len() as f64;
    println!("{red} pixels without probes, weight {green:.3}");
    assert!(red * 20 < fallback.pixels.len() && green > 0.1, "{red}, {green}");
    host.frame().expect("a frame");
    let after = host.read_indirect().expect("E_ind");
    let sum = |image: &Image| image.pixels.iter().map(|p| luminance(*p)).sum::<f64>();
    assert!((sum(&after) / sum(&before) - 1.0).abs() < 0.01, "E_ind goes on");
    assert_eq!(host.validation_messages(), Vec::<String>::new());
}
