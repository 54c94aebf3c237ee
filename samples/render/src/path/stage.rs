//! A path joined with a scene: where camera and instances are at a time.

use super::crowd::Walker;
use super::curve::Curve;
use super::file::{BoxShape, CameraKey, Crowd, InstanceName, Object, PathFile, PoseKey, Rotation, Shape, Track};
use anyhow::{Context as _, Result, bail, ensure};
use brickgi_host::scene::{Instance, Material, Mesh};
use brickgi_host::{Scene, SceneCamera};
use glam::{DMat3, DQuat, DVec3, DVec4};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A cubic between two keys may swing below them: scale stops here.
const SMALLEST_SCALE: DVec3 = DVec3::splat(1e-3);

/// What a path moves. New instances have the ids after the scene's own.
#[derive(Debug)]
pub struct Stage {
    /// Number of frames, at least 1.
    pub frames: u32,
    /// Factor on linear light; `None`: automatic.
    pub exposure: Option<f32>,
    fps: f64,
    camera: SceneCamera,
    /// Position, target, vertical field of view in degrees.
    camera_curve: Option<Curve<7>>,
    movers: Vec<Mover>,
    crowds: Vec<Group>,
    /// What the host has been told, by id.
    shown: BTreeMap<u64, Instance>,
}

/// What moves by keys.
#[derive(Debug)]
struct Mover {
    /// By id, as they are without the path.
    rest: Vec<(u64, Instance)>,
    pivot: DVec3,
    /// Translation, quaternion, scale.
    curve: Curve<10>,
    /// Seconds, and whether it is there from then on.
    visible: Vec<(f64, bool)>,
}

/// A crowd, in the order of its ids.
#[derive(Debug)]
struct Group {
    first_id: u64,
    rest: Instance,
    /// Middle of its underside at rest.
    foot: DVec3,
    walkers: Vec<Walker>,
}

impl Stage {
    /// Reads a path and adds the meshes and materials of its boxes to the scene; `camera` is the scene's camera that
    /// gives what the path does not.
    pub fn load(path: &Path, scene: &mut Scene, camera: SceneCamera) -> Result<Self> {
        let file = PathFile::load(path)?;
        Self::new(&file, scene, camera).with_context(|| path.display().to_string())
    }

    fn new(file: &PathFile, scene: &mut Scene, camera: SceneCamera) -> Result<Self> {
        if let Some(wanted) = file.scene.as_ref().filter(|wanted| **wanted != scene.name) {
            bail!("scene: it is made for {wanted:?}, not for {:?}", scene.name);
        }
        let shown: BTreeMap<_, _> = (0..).zip(scene.instances.iter().cloned()).collect();
        let mut next_id = shown.len() as u64;
        let mut movers = Vec::new();
        for (index, object) in file.objects.iter().enumerate() {
            let mover = Mover::new(object, scene, &mut next_id);
            movers.push(mover.with_context(|| format!("objects[{index}].shape"))?);
        }
        let mut crowds = Vec::new();
        for (index, crowd) in file.crowds.iter().enumerate() {
            let group = Group::new(crowd, scene, &mut next_id);
            crowds.push(group.with_context(|| format!("crowds[{index}].shape"))?);
        }
        let mut moved = BTreeSet::new();
        for (index, id) in movers.iter().enumerate().flat_map(|(i, mover)| mover.rest.iter().map(move |r| (i, r.0))) {
            ensure!(moved.insert(id), "objects[{index}].shape: instance {id} is moved by an earlier object");
        }
        let stage = Self {
            frames: file.frame_count(),
            exposure: file.exposure,
            fps: file.fps,
            camera_curve: file.camera.as_ref().map(|track| camera_curve(track, camera.vfov_deg)),
            camera,
            movers,
            crowds,
            shown,
        };
        stage.check_cameras()?;
        Ok(stage)
    }

    /// When a frame is, in seconds.
    pub fn time(&self, frame: u32) -> f64 {
        f64::from(frame) / self.fps
    }

    /// The camera at `time` seconds.
    pub fn camera(&self, time: f64) -> SceneCamera {
        let Some(curve) = &self.camera_curve else { return self.camera.clone() };
        let [px, py, pz, tx, ty, tz, vfov_deg] = curve.at(time);
        SceneCamera { position: [px, py, pz], target: [tx, ty, tz], vfov_deg, ..self.camera.clone() }
    }

    /// Which instances are not as they were at the last call: where they are at `time` seconds, `None` for gone.
    pub fn changes(&mut self, time: f64) -> Vec<(u64, Option<Instance>)> {
        let moved = self.movers.iter().flat_map(|mover| mover.at(time));
        let walked = self.crowds.iter().flat_map(|group| group.at(time));
        let mut changes: Vec<_> = moved.chain(walked).collect();
        changes.retain(|(id, now)| self.shown.get(id) != now.as_ref());
        for (id, now) in &changes {
            match now {
                Some(instance) => self.shown.insert(*id, instance.clone()),
                None => self.shown.remove(id),
            };
        }
        changes
    }

    fn check_cameras(&self) -> Result<()> {
        let bad = (0..self.frames).map(|frame| self.time(frame)).find(|time| !self.camera(*time).is_usable());
        match bad {
            Some(time) => bail!("camera: at {time:.2} s it looks straight up or down, or at its own position"),
            None => Ok(()),
        }
    }
}

impl Mover {
    fn new(object: &Object, scene: &mut Scene, next_id: &mut u64) -> Result<Self> {
        let rest = match &object.shape {
            Shape::Box(shape) => {
                *next_id += 1;
                vec![(*next_id - 1, add_box(scene, shape))]
            }
            Shape::Instance(name) => find(scene, name)?,
        };
        let keys = &object.motion.keys;
        let visible = keys.iter().map(|key| (key.time, key.visible)).collect();
        Ok(Self { rest, pivot: object.pivot.into(), curve: pose_curve(&object.motion), visible })
    }

    fn at(&self, time: f64) -> impl Iterator<Item = (u64, Option<Instance>)> + '_ {
        let [tx, ty, tz, qx, qy, qz, qw, sx, sy, sz] = self.curve.at(time);
        let rotation = DQuat::from_vec4(DVec4::new(qx, qy, qz, qw)).normalize();
        let linear = DMat3::from_quat(rotation) * DMat3::from_diagonal(DVec3::new(sx, sy, sz).max(SMALLEST_SCALE));
        let translation = DVec3::new(tx, ty, tz) + self.pivot - linear * self.pivot;
        let visible = self.visible[self.visible.partition_point(|key| key.0 <= time).saturating_sub(1)].1;
        let placed = move |rest| visible.then(|| placed(rest, linear, translation));
        self.rest.iter().map(move |(id, rest)| (*id, placed(rest)))
    }
}

impl Group {
    fn new(crowd: &Crowd, scene: &mut Scene, next_id: &mut u64) -> Result<Self> {
        let rest = match &crowd.shape {
            Shape::Box(shape) => add_box(scene, shape),
            Shape::Instance(name) => find(scene, name)?.swap_remove(0).1,
        };
        let first_id = *next_id;
        *next_id += u64::from(crowd.count);
        Ok(Self { first_id, foot: foot(scene, &rest), rest, walkers: Walker::all(crowd) })
    }

    fn at(&self, time: f64) -> impl Iterator<Item = (u64, Option<Instance>)> + '_ {
        (self.first_id..).zip(&self.walkers).map(move |(id, walker)| {
            let (place, rotation) = walker.at(time);
            (id, Some(placed(&self.rest, rotation, place - rotation * self.foot)))
        })
    }
}

/// The instance after a further transform of the world.
fn placed(rest: &Instance, linear: DMat3, translation: DVec3) -> Instance {
    let own = glam::Mat3::from_cols_array_2d(&rest.linear).as_dmat3();
    Instance {
        linear: (linear * own).as_mat3().to_cols_array_2d(),
        translation: (linear * DVec3::from(rest.translation) + translation).to_array(),
        ..rest.clone()
    }
}

/// Those of the scene's instances, with their ids; at least one.
fn find(scene: &Scene, name: &InstanceName) -> Result<Vec<(u64, Instance)>> {
    let all = (0..).zip(&scene.instances);
    let known = || {
        let names: BTreeSet<&str> = scene.instances.iter().map(|instance| &*instance.name).collect();
        names.into_iter().take(20).collect::<Vec<_>>().join(", ")
    };
    let found: Vec<_> = match name {
        InstanceName::Index(index) => all.skip(*index).take(1).map(|(id, i)| (id, i.clone())).collect(),
        InstanceName::Name(name) => all.filter(|(_, i)| i.name == *name).map(|(id, i)| (id, i.clone())).collect(),
    };
    match name {
        _ if !found.is_empty() => Ok(found),
        InstanceName::Index(index) => bail!("no instance {index}; the scene has {}", scene.instances.len()),
        InstanceName::Name(name) => bail!("no instance {name:?}; the scene has: {}", known()),
    }
}

/// Adds mesh and material; the instance is at the origin and not in the scene.
fn add_box(scene: &mut Scene, shape: &BoxShape) -> Instance {
    let high = shape.size.map(|edge| edge * 0.5);
    scene.meshes.push(Mesh::cuboid(high.map(|v| -v), high));
    scene.materials.push(Material { base_color: shape.color, emission: shape.emission, texture: None });
    Instance::at(scene.meshes.len() - 1, scene.materials.len() - 1, [0.0; 3])
}

/// Middle of the underside of an instance's world bounds.
fn foot(scene: &Scene, instance: &Instance) -> DVec3 {
    let corners = scene.meshes[instance.mesh].positions.iter().map(|p| DVec3::from(instance.to_world(*p)));
    let bounds = corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let middle = (bounds.0 + bounds.1) / 2.0;
    DVec3::new(middle.x, bounds.0.y, middle.z)
}

fn camera_curve(track: &Track<CameraKey>, vfov: f64) -> Curve<7> {
    let values = |key: &CameraKey| {
        let ([px, py, pz], [tx, ty, tz]) = (key.position, key.target);
        (key.time, [px, py, pz, tx, ty, tz, key.vfov.unwrap_or(vfov)])
    };
    Curve::new(track.interpolation, track.keys.iter().map(values).collect())
}

/// Each quaternion is on the side of the one before: the way between two keys is the short one.
fn pose_curve(track: &Track<PoseKey>) -> Curve<10> {
    let mut before = DQuat::IDENTITY;
    let values = |key: &PoseKey| {
        let rotation = match key.rotation {
            Rotation::Quaternion(q) => DQuat::from_array(q).normalize(),
            Rotation::AxisAngle { axis, degrees } => {
                DQuat::from_axis_angle(DVec3::from(axis).normalize(), degrees.to_radians())
            }
        };
        before = if rotation.dot(before) < 0.0 { -rotation } else { rotation };
        let ([tx, ty, tz], [sx, sy, sz]) = (key.translation, key.scale.axes());
        (key.time, [tx, ty, tz, before.x, before.y, before.z, before.w, sx, sy, sz])
    };
    Curve::new(track.interpolation, track.keys.iter().map(values).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn repository() -> &'static Path {
        Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
    }

    fn rooms() -> Scene {
        Scene::load(repository().join("tests/data/two_rooms_door")).expect("it ships with the project")
    }

    /// In the scene of two rooms, half a frame a second.
    fn stage(rest: &str) -> Result<Stage> {
        let file = PathFile::parse(&format!(r#"{{"fps": 0.5, "frames": 3, {rest}}}"#))?;
        let mut scene = rooms();
        let camera = scene.cameras[0].clone();
        Stage::new(&file, &mut scene, camera)
    }

    #[test]
    fn things_turn_and_grow_about_their_pivot() {
        let motion = r#""pivot": [3, 0, 1], "motion": {"keys": [{"time": 0, "translation": [0, 1, 0], "scale": 2,
            "rotation": {"axis": [0, 2, 0], "degrees": 90}}]}"#;
        let mut stage = stage(&format!(r#""objects": [{{"shape": {{"instance": "crate"}}, {motion}}}]"#)).unwrap();
        let changes = stage.changes(0.0);
        let [(5, Some(moved))] = &changes[..] else { panic!("{changes:?}") };
        let near = |p: [f32; 3], to: [f64; 3]| DVec3::from(moved.to_world(p)).distance(to.into()) < 1e-6;
        assert!(near([3.0, 0.0, 1.0], [3.0, 1.0, 1.0]), "the pivot is only translated");
        assert!(near([3.0, 0.5, 2.0], [5.0, 2.0, 1.0]), "a metre along z is two along x: {:?}", moved);
        assert!(stage.changes(1.0).is_empty(), "it stands still");
    }

    #[test]
    fn what_is_invisible_is_gone_until_it_returns() {
        let keys = r#"[{"time": 0, "visible": false}, {"time": 2}, {"time": 4, "visible": false}]"#;
        let shape = r#"{"shape": {"box": {}}, "motion": {"keys": "#;
        let mut stage = stage(&format!(r#""objects": [{shape}{keys}}}}}]"#)).unwrap();
        let mut there = |time| stage.changes(time).iter().map(|(id, now)| (*id, now.is_some())).collect::<Vec<_>>();
        assert_eq!([there(0.0), there(1.9)], [vec![], vec![]]);
        assert_eq!([there(2.0), there(3.9)], [vec![(6, true)], vec![]]);
        assert_eq!([there(4.0), there(9.0)], [vec![(6, false)], vec![]]);
    }

    #[test]
    fn a_box_is_closed_and_faces_outward() {
        let mut scene = rooms();
        let shape = BoxShape { size: [2.0, 3.0, 4.0], ..BoxShape::default() };
        let index = add_box(&mut scene, &shape).mesh;
        let mesh = &scene.meshes[index];
        let corner = |i: &u32| DVec3::from(mesh.positions[*i as usize].map(f64::from));
        let signed = |t: &[u32]| corner(&t[0]).dot(corner(&t[1]).cross(corner(&t[2]))) / 6.0;
        let volume: f64 = mesh.indices.chunks(3).map(signed).sum();
        assert!((volume - 24.0).abs() < 1e-9, "{volume}");
        let edge = |t: &[u32], i: usize| (t[i], t[(i + 1) % 3]);
        let edges: BTreeSet<_> = mesh.indices.chunks(3).flat_map(|t| (0..3).map(move |i| edge(t, i))).collect();
        assert_eq!(edges.len(), 36, "no edge twice in one direction");
        assert!(edges.iter().all(|(a, b)| edges.contains(&(*b, *a))));
    }

    #[test]
    fn a_crowd_stands_on_its_ground() {
        let area = r#""count": 50, "low": [1, 0.5, 1], "high": [5, 0.5, 4], "speed": 1"#;
        for shape in [r#"{"instance": 5}"#, r#"{"box": {"size": [0.2, 3, 0.1]}}"#] {
            let mut scene = rooms();
            let file = format!(r#"{{"fps": 1, "frames": 1, "crowds": [{{"shape": {shape}, {area}}}]}}"#);
            let camera = scene.cameras[0].clone();
            let mut stage = Stage::new(&PathFile::parse(&file).unwrap(), &mut scene, camera).unwrap();
            let changes = stage.changes(2.0);
            assert_eq!(changes.len(), 50);
            for (id, now) in changes {
                let foot = foot(&scene, &now.expect("it is there"));
                assert!(id >= 6 && (foot.y - 0.5).abs() < 1e-6 && (foot.x - 3.0).abs() < 6.0, "{id} at {foot}");
            }
        }
    }

    #[test]
    fn errors_name_the_key_and_say_what_is_wrong() {
        let object =
            |name: &str| format!(r#"{{"shape": {{"instance": {name}}}, "motion": {{"keys": [{{"time": 0}}]}}}}"#);
        let camera = r#"{"keys": [{"time": 0, "position": [0, 1, 0], "target": [0, 5, 0]}]}"#;
        for (rest, words) in [
            (
                format!(r#""objects": [{}]"#, object(r#""gate""#)),
                "objects[0].shape: no instance \"gate\"; the scene has",
            ),
            (format!(r#""objects": [{}]"#, object("6")), "objects[0].shape: no instance 6; the scene has 6"),
            (format!(r#""objects": [{0}, {0}]"#, object("2")), "objects[1].shape: instance 2 is moved by an earlier"),
            (r#""scene": "city""#.into(), "scene: it is made for \"city\", not for \"two_rooms_door\""),
            (format!(r#""camera": {camera}"#), "camera: at 0.00 s it looks straight up"),
        ] {
            let error = stage(&rest).expect_err(&rest);
            assert!(format!("{error:#}").contains(words), "{error:#}");
        }
    }

    #[test]
    fn the_paths_that_ship_are_playable() {
        for (name, scene, frames) in [("door", "two_rooms_door", 91), ("crowd", "corridor", 61)] {
            let mut scene = Scene::load(repository().join("tests/data").join(scene)).expect("it ships");
            let camera = scene.cameras[0].clone();
            let path = repository().join(format!("samples/paths/{name}.json"));
            let mut stage = Stage::load(&path, &mut scene, camera).unwrap();
            assert_eq!(stage.frames, frames);
            assert_eq!(stage.changes(0.0).len(), if name == "crowd" { 2000 } else { 1 });
        }
    }

    #[test]
    fn the_example_in_the_readme_is_playable() {
        let readme = std::fs::read_to_string(repository().join("README.md")).expect("the README");
        let example = readme.split("```json").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
        let (mut scene, file) = (rooms(), PathFile::parse(example).unwrap());
        let camera = scene.cameras[0].clone();
        let changes = Stage::new(&file, &mut scene, camera).unwrap().changes(2.0);
        assert_eq!(changes.len(), 22, "the crate, the door and the crowd");
    }

    #[test]
    fn the_flight_through_the_city_has_30_metres_a_second() {
        let mut city = Scene { name: "city".into(), ..rooms() };
        let camera = city.cameras[0].clone();
        let stage = Stage::load(&repository().join("samples/paths/fly_city.json"), &mut city, camera).unwrap();
        let place = |frame| DVec3::from(stage.camera(stage.time(frame)).position);
        for frame in 1..stage.frames {
            let speed = place(frame).distance(place(frame - 1)) * 30.0;
            assert!((29.0..31.0).contains(&speed), "{speed} m/s at frame {frame}");
        }
    }
}
