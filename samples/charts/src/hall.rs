//! A hall of pillars under many lamps: what direct light costs against their number, and how far off it is.

use crate::measure::{Table, settle};
use anyhow::Result;
use brickgi::{DebugView, Settings};
use brickgi_host::scene::{Instance, Light, Material, Mesh, Sky};
use brickgi_host::{Host, HostOptions, Image, Scene, SceneCamera, image::luminance};
use std::f64::consts::PI;
use std::sync::Arc;

/// Width and depth of the hall, and its height, metres.
const EDGE: f64 = 24.0;
const HEIGHT: f64 = 4.0;
/// Lamps that reach a place in the mean, unless there are fewer.
const OVERLAP: f64 = 16.0;
/// Frames after which light is compared.
const FRAMES: u32 = 64;

/// Nanoseconds of GPU time that a face's direct light takes in an update, and the error of that light (relative, of the
/// radiance of the faces in view, after 64 frames) in percent, both against 1 to 4 096 lamps: with 4 of them asked in each sample,
/// with 16, and, cost alone, with all.
pub fn lights() -> Result<[Table; 2]> {
    let columns = |asked: &[&'static str]| [&["lights"], asked].concat();
    let title = "Direct light of a face, ns, against lights";
    let mut cost = Table { title, columns: columns(&["ask_4", "ask_16", "ask_all"]), rows: Vec::new() };
    let title = "Relative error of the faces' direct light, %, against lights";
    let mut error = Table { title, columns: columns(&["ask_4", "ask_16"]), rows: Vec::new() };
    let counts = [1, 16, 256, 4096];
    let base = Settings {
        voxel_size: 0.5,
        light_faces_per_frame: 16_384,
        coverage_groups: [4, 2, 4],
        bounce_rays: 0,
        ..Settings::default()
    };
    let asking = |direct_lights| Settings { direct_lights, ..base.clone() };
    for count in counts {
        let scene = Arc::new(hall(count, 16, 9));
        let mut row = vec![f64::from(count)];
        for asked in [4, 16, count] {
            row.push(nanoseconds(&scene, asking(asked))?);
        }
        println!("{row:.1?} ns");
        cost.rows.push(row);
    }
    for count in counts {
        let scene = Arc::new(hall(count, 96, 54));
        // Of so many lamps that a world of faces that ask all is out of reach, the truth asks 64.
        let truth = Settings { direct_samples: 16, ..asking(count.min(64)) };
        let truth = light(&mut open(&scene, truth)?, 2 * FRAMES)?;
        let mut row = vec![f64::from(count)];
        for asked in [4, 16] {
            row.push(relative_error(&light(&mut open(&scene, asking(asked))?, FRAMES)?, &truth));
        }
        println!("{row:.3?} %");
        error.rows.push(row);
    }
    Ok([cost, error])
}

fn open(scene: &Arc<Scene>, settings: Settings) -> Result<Host> {
    let mut host = Host::new(HostOptions { settings, ..HostOptions::new(scene.clone()) })?;
    settle(&mut host)?;
    Ok(host)
}

/// Light of the faces in view.
fn light(host: &mut Host, frames: u32) -> Result<Image> {
    (0..frames).try_for_each(|_| host.frame())?;
    host.show(Some(DebugView::Radiance));
    host.frame()?;
    Ok(host.read_indirect()?)
}

/// Of 100 frames, the cheapest: what all of them have to do is the same.
fn nanoseconds(scene: &Arc<Scene>, settings: Settings) -> Result<f64> {
    // Few faces, lit once a frame, yet a whole brick.
    let faces = (4096 / settings.direct_lights).clamp(512, 1024);
    let settings = Settings { light_faces_per_frame: faces, ..settings };
    let mut host = open(scene, settings)?;
    let mut least = f64::INFINITY;
    for _ in 0..100 {
        host.frame()?;
        let ms =
            |name: &str| host.stats().passes.iter().filter(|p| p.name.starts_with(name)).map(|p| p.ms).sum::<f64>();
        let direct = ms("light_direct");
        if direct > 0.0 {
            least = least.min(direct);
        }
    }
    Ok(least * 1e6 / f64::from(faces))
}

/// Mean absolute difference in luminance over a pixel's own and a tenth of the mean, percent: a face beside a lamp, a
/// hundred times as bright as others, counts as much as these, and few faces at the edges of shadows not for all.
fn relative_error(found: &Image, truth: &Image) -> f64 {
    let count = truth.pixels.len() as f64;
    let floor = 0.1 * truth.pixels.iter().map(|p| luminance(*p)).sum::<f64>() / count;
    let pairs = found.pixels.iter().zip(&truth.pixels).map(|(a, b)| (luminance(*a), luminance(*b)));
    100.0 * pairs.map(|(a, b)| (a - b).abs() / (b + floor)).sum::<f64>() / count
}

/// The hall with its lamps, which reach as far as makes [`OVERLAP`] of them overlap, and shine the brighter; seen in so many pixels.
fn hall(lamps: u32, width: u32, height: u32) -> Scene {
    let slab = |low: [f64; 3], high: [f64; 3]| Mesh::cuboid(low.map(|v| v as f32), high.map(|v| v as f32));
    let (half, top) = (EDGE / 2.0, HEIGHT);
    let mut meshes = vec![
        slab([-half, -0.5, -half], [half, 0.0, half]),
        slab([-half, top, -half], [half, top + 0.5, half]),
        slab([-half - 0.5, 0.0, -half], [-half, top, half]),
        slab([half, 0.0, -half], [half + 0.5, top, half]),
        slab([-half, 0.0, -half - 0.5], [half, top, -half]),
        slab([-half, 0.0, half], [half, top, half + 0.5]),
    ];
    let pillars: [[f64; 2]; 16] = std::array::from_fn(|i| [(i % 4) as f64, (i / 4) as f64].map(|v| 6.0 * v - 9.0));
    meshes.extend(pillars.map(|[x, z]| slab([x - 0.4, 0.0, z - 0.4], [x + 0.4, top, z + 0.4])));
    let volume = EDGE * EDGE * HEIGHT;
    let range = (OVERLAP * volume * 3.0 / (4.0 * PI * f64::from(lamps))).cbrt().min(EDGE);
    // A lamp that touches something lights one spot of it more than all others do the hall.
    let is_free = |[x, _, z]: &[f64; 3]| pillars.iter().all(|p| (x - p[0]).abs().max((z - p[1]).abs()) > 0.7);
    let light = |index: u32| {
        // The plastic number's sequence in three dimensions (Roberts 2018).
        let place = |step: f64| (0.5 + f64::from(index) * step).fract();
        let [x, y, z] = [0.819_172_5, 0.671_043_6, 0.549_700_5].map(place);
        let position = [(x - 0.5) * (EDGE - 0.6), 0.3 + y * (HEIGHT - 0.6), (z - 0.5) * (EDGE - 0.6)];
        let strength = (range * range * (0.1 + 2.0 * place(0.347_296_4).powi(4))) as f32;
        is_free(&position).then_some(Light::Point {
            position,
            intensity: [strength, 0.9 * strength, 0.7 * strength],
            range: range as f32,
        })
    };
    Scene {
        name: "hall".into(),
        instances: (0..meshes.len()).map(|mesh| Instance::at(mesh, 0, [0.0; 3])).collect(),
        meshes,
        materials: vec![Material { base_color: [0.6; 3], emission: [0.0; 3], texture: None }],
        lights: (0..).filter_map(light).take(lamps as usize).collect(),
        sky: Sky::Constant { radiance: [0.0; 3] },
        cameras: vec![SceneCamera {
            name: "end".into(),
            position: [-half + 1.0, 1.7, -half + 1.5],
            target: [2.0, 1.2, 3.0],
            up: [0.0, 1.0, 0.0],
            vfov_deg: 65.0,
            near: 0.1,
            width,
            height,
        }],
        ..Scene::default()
    }
}
