//! What moves: the light on it goes along, and what it leaves behind.

use brickgi::Settings;
use brickgi_host::image::luminance;
use brickgi_host::scene::{Instance, Material, Mesh};
use brickgi_host::{Host, HostOptions, Image, Scene, SceneCamera};
use std::path::Path;
use std::sync::Arc;

const SIZE: [u32; 2] = [160, 96];
/// Edge of the patches that are compared, pixels, and of how many pixels they have at least: the noise of one counts little.
const PATCH: u32 = 16;
const PATCH_PIXELS: usize = 96;
/// The id of what moves, and its albedo, which nothing else has.
const ID: u64 = 1000;
const COLOR: [f32; 3] = [0.61, 0.62, 0.63];
/// Frames in which it moves.
const STEPS: u32 = 24;

/// What moves, from where, and how far a frame: metres.
struct Mover {
    /// Middles and half edges of its boxes.
    boxes: &'static [([f32; 3], [f32; 3])],
    start: [f64; 3],
    step: f64,
    camera: Option<([f64; 3], [f64; 3], f64)>,
}

/// A box that slides over the floor: 3 pixels a frame.
const BOX: Mover = Mover { boxes: &[([0.0; 3], [0.4, 0.4, 0.35])], start: [3.6, 0.4, 1.0], step: 0.1, camera: None };
/// A plate that faces the camera, and a knob on it whose shade on the plate goes along: 3 pixels a frame.
const PLATE: Mover = Mover {
    boxes: &[([0.0; 3], [0.15, 0.5, 0.5]), ([-0.27, 0.0, 0.0], [0.12, 0.12, 0.12])],
    start: [4.0, 1.2, 1.6],
    step: 0.06,
    camera: Some(([1.4, 1.4, 2.4], [5.0, 1.2, 2.4], 38.0)),
};

fn mesh(boxes: &[([f32; 3], [f32; 3])]) -> Mesh {
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut mesh = Mesh::default();
    for (middle, half) in boxes {
        let first = mesh.positions.len() as u32;
        let corner = |i: u32| {
            std::array::from_fn(|axis| middle[axis] + if i >> axis & 1 == 1 { half[axis] } else { -half[axis] })
        };
        mesh.positions.extend((0..8).map(corner));
        let triangles = |q: [u32; 4]| [q[0], q[1], q[2], q[0], q[2], q[3]].map(|corner| first + corner);
        mesh.indices.extend(quads.into_iter().flat_map(triangles));
    }
    mesh
}

/// The two rooms without what moves, and where that is after some steps.
struct Stage {
    scene: Arc<Scene>,
    mover: &'static Mover,
    camera: SceneCamera,
}

impl Stage {
    fn new(mover: &'static Mover) -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
        let mut scene = Scene::load(root.join("two_rooms")).expect("the scene ships with the repository");
        scene.meshes.push(mesh(mover.boxes));
        scene.materials.push(Material { base_color: COLOR, emission: [0.0; 3], texture: None });
        let mut camera = scene.camera(Some("a")).expect("camera a").clone();
        if let Some((position, target, vfov_deg)) = mover.camera {
            camera = SceneCamera { position, target, vfov_deg, ..camera };
        }
        Self { scene: Arc::new(scene), mover, camera }
    }

    fn at(&self, step: u32) -> Instance {
        let [x, y, z] = self.mover.start;
        Instance {
            name: "mover".into(),
            mesh: self.scene.meshes.len() - 1,
            material: self.scene.materials.len() - 1,
            linear: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            translation: [x, y, z + self.mover.step * f64::from(step)],
        }
    }

    fn host(&self, settings: Settings, size: [u32; 2], motion: bool) -> Host {
        let scene = self.scene.clone();
        let settings = Settings { voxel_size: 0.25, ..settings };
        let options = HostOptions { size: Some(size), settings, motion, validation: true, ..HostOptions::new(scene) };
        let mut host = Host::new(options).expect("a device with the validation layer");
        host.set_camera(self.camera.clone()).expect("a valid camera");
        host
    }

    /// A host that has drawn it at rest for so many frames.
    fn show(&self, motion: bool, step: u32, frames: u32) -> Show<'_> {
        let settings = Settings { probe_tile: 8, bounce_rays: 2, ..Settings::default() };
        let mut show = Show { host: self.host(settings, SIZE, motion), stage: self };
        show.place(step);
        show.frames(frames);
        show
    }

    /// How it is in the end, against one that has been there for long.
    fn compare(&self, motion: bool, settled: u32, truth: &Image) -> Seen {
        let mut show = self.show(motion, 0, settled);
        let mut was = vec![false; truth.pixels.len()];
        let mut now = was.clone();
        for step in 1..=STEPS {
            show.place(step);
            show.frames(1);
            now = show.mask();
            was.iter_mut().zip(&now).for_each(|(was, now)| *was |= now);
        }
        let masks = [(true, true), (true, false), (false, false)]
            .map(|kind| was.iter().zip(&now).map(|(was, is)| (*was, *is) == kind).collect::<Vec<bool>>());
        let stats = show.host.stats().clone();
        let [moving, after] = [0, 4].map(|frames| {
            show.frames(frames);
            let image = show.image();
            [0, 1, 2].map(|k| Patches::of(&image, truth, &masks[k]))
        });
        let seen = Seen { moving, after };
        for (patches, when) in [(&seen.moving, "moving"), (&seen.after, "4 frames later")] {
            println!(
                "motion {motion}, {when}: on it {}; where it was {}; elsewhere {}",
                patches[0], patches[1], patches[2]
            );
        }
        let [traced, carried] = [stats.probes_traced, stats.probes_carried];
        println!("probes: {traced} traced, {carried} carried, {} rejected", stats.probes_rejected);
        seen
    }
}

struct Show<'a> {
    host: Host,
    stage: &'a Stage,
}

impl Show<'_> {
    fn place(&mut self, step: u32) {
        self.host.update_instances(&[(ID, Some(self.stage.at(step)))]).expect("valid");
    }

    fn frames(&mut self, count: u32) {
        (0..count).for_each(|_| self.host.frame().expect("a frame"));
    }

    fn image(&mut self) -> Image {
        assert_eq!(self.host.validation_messages(), Vec::<String>::new());
        self.host.read_indirect().expect("E_ind")
    }

    /// Where it is seen.
    fn mask(&mut self) -> Vec<bool> {
        let is_it = |p: &[f32; 3]| p.iter().zip(COLOR).all(|(a, b)| (a - b).abs() < 2e-3);
        self.host.read_albedo().expect("albedo").pixels.iter().map(is_it).collect()
    }
}

/// By how much patches are too bright: each its sum over its sum in the truth, less one.
#[derive(Debug)]
struct Patches(Vec<f64>);

impl Patches {
    fn of(image: &Image, truth: &Image, mask: &[bool]) -> Self {
        let mut found = Vec::new();
        for corner in 0..SIZE[0] / PATCH * (SIZE[1] / PATCH) {
            let (left, top) = (corner % (SIZE[0] / PATCH) * PATCH, corner / (SIZE[0] / PATCH) * PATCH);
            let inside = |k: u32| ((top + k / PATCH) * SIZE[0] + left + k % PATCH) as usize;
            let places: Vec<usize> = (0..PATCH * PATCH).map(inside).filter(|at| mask[*at]).collect();
            if places.len() >= PATCH_PIXELS {
                let sum = |image: &Image| places.iter().map(|at| luminance(image.pixels[*at])).sum::<f64>();
                found.push(sum(image) / sum(truth) - 1.0);
            }
        }
        Self(found)
    }

    fn worst(&self) -> f64 {
        self.0.iter().fold(0.0, |worst, v| worst.max(v.abs()))
    }

    fn rms(&self) -> f64 {
        (self.0.iter().map(|v| v * v).sum::<f64>() / self.0.len() as f64).sqrt()
    }
}

impl std::fmt::Display for Patches {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let (low, high) = self.0.iter().fold((0f64, 0f64), |(low, high), v| (low.min(*v), high.max(*v)));
        write!(f, "{} rms {:.4} {low:+.3} to {high:+.3}", self.0.len(), self.rms())
    }
}

/// On what moves, where it has been, and elsewhere.
struct Seen {
    /// In the last frame in which it moves.
    moving: [Patches; 3],
    /// Four frames later.
    after: [Patches; 3],
}

/// On a box and where it has been, nothing is brighter or darker by 5 % four frames after it has come to rest. What it
/// shaded and shades, beyond, is another light by a third: averages of what was before would need a hundred frames.
#[test]
fn what_moves_leaves_no_trail() {
    let stage = Stage::new(&BOX);
    let truth = stage.show(true, STEPS, 128).image();
    let seen = stage.compare(true, 96, &truth);
    let [object, trail, rest] = &seen.after;
    assert!(object.0.len() >= 2 && trail.0.len() >= 6, "{} {}", object.0.len(), trail.0.len());
    assert!(object.worst() < 0.05 && trail.worst() < 0.05, "{object}; {trail}");
    assert!(rest.rms() < 0.035, "{rest}");
}

/// Without motion a plate keeps the light of the place on screen, and the shade of the knob on it trails behind.
#[test]
fn light_goes_along_with_motion_vectors() {
    let stage = Stage::new(&PLATE);
    let truth = stage.show(true, STEPS, 64).image();
    let [with, without] = [true, false].map(|motion| stage.compare(motion, 48, &truth));
    for [with, without] in [[&with.moving, &without.moving], [&with.after, &without.after]] {
        assert!(with[0].0.len() > 8 && with[0].rms() < 0.9 * without[0].rms(), "{} {}", with[0], without[0]);
    }
}

/// While all stands still motion says nothing new.
#[test]
fn motion_of_what_rests_changes_nothing() {
    let stage = Stage::new(&BOX);
    let [with, without] = [true, false].map(|motion| {
        let settings = Settings { light_faces_per_frame: 4096, bounce_rays: 1, ..Settings::default() };
        let mut host = stage.host(settings, SIZE, motion);
        (0..16).for_each(|_| host.frame().expect("a frame"));
        host.read_indirect().expect("E_ind")
    });
    assert!(with.pixels.iter().any(|p| luminance(*p) > 0.1));
    assert!(with == without);
}

/// With `temporal_frames` 1 each frame stands for itself: its noise has nothing to do with that of the one before.
#[test]
fn one_temporal_frame_is_no_average() {
    let stage = Stage::new(&BOX);
    let alike = [1, 16].map(|temporal_frames| {
        // Noise enough, and no probes that are carried along.
        let settings = Settings { pixel_rays: 8, temporal_frames, light_faces_per_frame: 8192, ..Settings::default() };
        let mut host = stage.host(Settings { bounce_rays: 0, ..settings }, [48, 32], true);
        let mut image = || {
            host.frame().expect("a frame");
            host.read_indirect().expect("E_ind")
        };
        (0..48).for_each(|_| drop(image()));
        let images: Vec<Image> = (0..32).map(|_| image()).collect();
        let (mut noise, mut together) = (0.0, 0.0);
        for pixel in 0..images[0].pixels.len() {
            let values: Vec<f64> = images.iter().map(|image| luminance(image.pixels[pixel])).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            noise += values[1..].iter().map(|v| (v - mean).powi(2)).sum::<f64>();
            together += values.windows(2).map(|pair| (pair[0] - mean) * (pair[1] - mean)).sum::<f64>();
        }
        together / noise
    });
    println!("frame to frame noise is alike by {alike:.3?}");
    assert!(alike[0] < 0.1 && alike[1] > 0.3, "{alike:.3?}");
}
