//! What moves: its own light, and what it leaves behind.

use brickgi::Settings;
use brickgi_host::image::luminance;
use brickgi_host::scene::{Instance, Material, Mesh};
use brickgi_host::{Host, HostOptions, Image, Scene};
use std::path::Path;
use std::sync::Arc;

const SIZE: [u32; 2] = [160, 96];
/// Edge of the patches that are compared, pixels.
const PATCH: u32 = 8;
const BOX: [f32; 3] = [0.3, 0.3, 0.2];
const ID: u64 = 1000;
const COLOR: [f32; 3] = [0.61, 0.62, 0.63];

fn scene() -> (Arc<Scene>, Instance) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
    let mut scene = Scene::load(root.join("two_rooms")).expect("the scene ships with the repository");
    let corner = |i: u32| std::array::from_fn(|axis| if i >> axis & 1 == 1 { BOX[axis] } else { -BOX[axis] });
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = |q: [u32; 4]| [q[0], q[1], q[2], q[0], q[2], q[3]];
    let mesh = Mesh {
        positions: (0..8).map(corner).collect(),
        uvs: Vec::new(),
        indices: quads.into_iter().flat_map(triangles).collect(),
    };
    let instance = Instance {
        name: "box".into(),
        mesh: scene.meshes.len(),
        material: scene.materials.len(),
        linear: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };
    scene.meshes.push(mesh);
    scene.materials.push(Material { base_color: COLOR, emission: [0.0; 3], texture: None });
    (Arc::new(scene), instance)
}

struct Show {
    host: Host,
    instance: Instance,
}

impl Show {
    fn new((scene, instance): &(Arc<Scene>, Instance), motion: bool) -> Self {
        let settings = Settings { voxel_size: 0.25, probe_tile: 8, ..Settings::default() };
        let options =
            HostOptions { size: Some(SIZE), settings, motion, validation: true, ..HostOptions::new(scene.clone()) };
        let host = Host::new(options).expect("a device with the validation layer");
        Self { host, instance: instance.clone() }
    }

    fn place(&mut self, translation: [f64; 3]) {
        let placed = Instance { translation, ..self.instance.clone() };
        self.host.update_instances(&[(ID, Some(placed))]).expect("valid");
    }

    fn frames(&mut self, count: u32) {
        (0..count).for_each(|_| self.host.frame().expect("a frame"));
    }

    fn image(&mut self) -> Image {
        assert_eq!(self.host.validation_messages(), Vec::<String>::new());
        self.host.read_indirect().expect("E_ind")
    }

    /// Where the box is seen.
    fn mask(&mut self) -> Vec<bool> {
        let is_box = |p: &[f32; 3]| p.iter().zip(COLOR).all(|(a, b)| (a - b).abs() < 2e-3);
        self.host.read_albedo().expect("albedo").pixels.iter().map(is_box).collect()
    }
}

/// Of each patch with enough pixels of the mask: sum over sum, less one.
fn patches(a: &Image, b: &Image, mask: &[bool]) -> Vec<f64> {
    let mut found = Vec::new();
    for top in (0..SIZE[1]).step_by(PATCH as usize) {
        for left in (0..SIZE[0]).step_by(PATCH as usize) {
            let inside = |k: u32| ((top + k / PATCH) * SIZE[0] + left + k % PATCH) as usize;
            let places: Vec<usize> = (0..PATCH * PATCH).map(inside).filter(|at| mask[*at]).collect();
            if places.len() >= 32 {
                let sum = |image: &Image| places.iter().map(|at| luminance(image.pixels[*at])).sum::<f64>();
                found.push(sum(a) / sum(b) - 1.0);
            }
        }
    }
    found
}

fn summary(values: &[f64]) -> String {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let rms = (values.iter().map(|v| v * v).sum::<f64>() / n).sqrt();
    let (low, high) = values.iter().fold((0f64, 0f64), |(l, h), v| (l.min(*v), h.max(*v)));
    format!("{n} mean {mean:+.4} rms {rms:.4} from {low:+.3} to {high:+.3}")
}

#[test]
fn explore() {
    let scene = scene();
    let at = |step: f64| [4.0, 0.6, 0.9 + 0.1 * step];
    let last = 24;
    let mut fresh = Show::new(&scene, true);
    fresh.place(at(f64::from(last)));
    fresh.frames(256);
    let truth = fresh.image();
    let object = fresh.mask();
    fresh.host.read_depth().unwrap();
    let mut other = Show::new(&scene, true);
    other.place(at(f64::from(last)));
    other.frames(8);
    other.frames(120);
    let again = other.image();
    let all = vec![true; truth.pixels.len()];
    println!("floor: all {}; object {}", summary(&patches(&again, &truth, &all)), summary(&patches(&again, &truth, &object)));
    drop(other);
    for motion in [false, true] {
        let mut show = Show::new(&scene, motion);
        show.place(at(0.0));
        show.frames(150);
        let mut was = vec![false; truth.pixels.len()];
        for step in 1..=last {
            show.place(at(f64::from(step)));
            show.frames(1);
            if step < last - 4 {
                let now = show.mask();
                was.iter_mut().zip(now).for_each(|(w, n)| *w |= n);
            }
        }
        let trail: Vec<bool> = was.iter().zip(&object).map(|(w, o)| *w && !*o).collect();
        let rest: Vec<bool> = was.iter().zip(&object).map(|(w, o)| !*w && !*o).collect();
        for frame in 0..=16 {
            if frame > 0 {
                show.frames(1);
            }
            if ![0, 1, 2, 4, 8, 16].contains(&frame) {
                continue;
            }
            let image = show.image();
            println!(
                "motion {motion} {frame} after: object {}; trail {}; rest {}",
                summary(&patches(&image, &truth, &object)),
                summary(&patches(&image, &truth, &trail)),
                summary(&patches(&image, &truth, &rest)),
            );
            let picture = image::RgbImage::from_fn(SIZE[0], SIZE[1], |x, y| {
                image::Rgb(image.at(x, y).map(|v| (255.0 * (v / 3.0).min(1.0).powf(0.45)) as u8))
            });
            picture.save(format!("/tmp/wt/motion_out/{motion}_{frame}.png")).unwrap();
        }
        let s = show.host.stats();
        println!("{} {} {} {} bricks {}", s.probes_traced, s.probes_carried, s.probe_conflicts, s.probes_rejected, s.bricks);
    }
    let picture = image::RgbImage::from_fn(SIZE[0], SIZE[1], |x, y| {
        image::Rgb(truth.at(x, y).map(|v| (255.0 * (v / 3.0).min(1.0).powf(0.45)) as u8))
    });
    picture.save("/tmp/wt/motion_out/truth.png").unwrap();
}
