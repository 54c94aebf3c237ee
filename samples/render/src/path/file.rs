//! The JSON of a path, checked by itself: what can be said without a scene.

use super::curve::Interpolation;
use anyhow::{Context as _, Result, ensure};
use serde::Deserialize;
use std::path::Path;

/// Largest distance from the origin along an axis, in metres.
const MAX_METRES: f64 = 1e6;
/// Most frames of a path.
const MAX_FRAMES: f64 = 1e6;

/// A whole file.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub struct PathFile {
    /// Name of the scene that it is made for; another one is refused.
    pub scene: Option<String>,
    /// Frames a second, up to 1000.
    pub fps: f64,
    /// Number of frames; either this or `duration`.
    frames: Option<u32>,
    /// Seconds from the first frame to the last one.
    duration: Option<f64>,
    /// Factor on linear light before tone mapping; absent: the automatic exposure of the first frame.
    pub exposure: Option<f32>,
    /// Absent: the scene's camera, at rest.
    pub camera: Option<Track<CameraKey>>,
    /// What moves by keys.
    #[serde(default)]
    pub objects: Vec<Object>,
    /// What moves by itself.
    #[serde(default)]
    pub crowds: Vec<Crowd>,
}

/// Keys and what happens between them.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub struct Track<K> {
    #[serde(default)]
    pub interpolation: Interpolation,
    /// Times ascend; at least one.
    pub keys: Vec<K>,
}

/// Where the camera is at a time.
#[derive(Deserialize, Clone, Copy, Debug)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// Seconds.
    pub time: f64,
    /// Metres.
    pub position: [f64; 3],
    /// A point on the view axis, in metres.
    pub target: [f64; 3],
    /// Vertical field of view in degrees; absent: the scene camera's.
    pub vfov: Option<f64>,
}

/// A moving thing: the scene's own, or a new one.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub struct Object {
    pub shape: Shape,
    /// The point about which it turns and is scaled, in metres: in world space for what is the scene's, from the middle
    /// of a box.
    #[serde(default)]
    pub pivot: [f64; 3],
    pub motion: Track<PoseKey>,
}

/// How an object is moved, from where the scene has it or, for a box, from the origin.
#[derive(Deserialize, Clone, Copy, Debug)]
#[serde(deny_unknown_fields)]
pub struct PoseKey {
    /// Seconds.
    pub time: f64,
    /// Metres.
    #[serde(default)]
    pub translation: [f64; 3],
    #[serde(default)]
    pub rotation: Rotation,
    #[serde(default)]
    pub scale: Scale,
    /// From this key to the next one.
    #[serde(default = "yes")]
    pub visible: bool,
}

/// About the pivot.
#[derive(Deserialize, Clone, Copy, Debug)]
#[serde(untagged, expecting = "expected [x, y, z, w] or {\"axis\": [x, y, z], \"degrees\": d}")]
pub enum Rotation {
    /// x, y, z, w; of any length but 0.
    Quaternion([f64; 4]),
    /// Counter-clockwise seen from the axis's tip.
    AxisAngle { axis: [f64; 3], degrees: f64 },
}

/// From the pivot; above 0.
#[derive(Deserialize, Clone, Copy, Debug)]
#[serde(untagged, expecting = "expected a number or [x, y, z]")]
pub enum Scale {
    Uniform(f64),
    Axes([f64; 3]),
}

/// What something looks like.
#[derive(Deserialize, Debug)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// A new box about the origin.
    Box(BoxShape),
    /// An instance of the scene; for a crowd, copies of the first of that name.
    Instance(InstanceName),
}

#[derive(Deserialize, Clone, Copy, Debug)]
#[serde(deny_unknown_fields, default)]
pub struct BoxShape {
    /// Metres.
    pub size: [f32; 3],
    /// Linear albedo, 0 to 1.
    pub color: [f32; 3],
    /// Radiance, up to 65000.
    pub emission: [f32; 3],
}

/// Which of the scene's instances.
#[derive(Deserialize, Clone, Debug)]
#[serde(untagged, expecting = "expected the name of an instance or its index")]
pub enum InstanceName {
    /// One, counted from 0.
    Index(usize),
    /// All of that name.
    Name(String),
}

/// Things that walk straight on over an area and turn back at its border.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub struct Crowd {
    pub shape: Shape,
    /// 1 to 100 000.
    pub count: u32,
    /// Corner of the area in which the middles of their undersides are, in metres.
    pub low: [f64; 3],
    /// The opposite corner.
    pub high: [f64; 3],
    /// Metres a second, level.
    pub speed: f64,
    /// The same seed gives the same crowd.
    #[serde(default)]
    pub seed: u64,
}

impl PathFile {
    /// Reads and checks a file; an error names it, the key and what is wrong.
    pub fn load(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        Self::parse(&text).with_context(|| path.display().to_string())
    }

    /// As [`Self::load`]; the error does not name the file.
    pub fn parse(text: &str) -> Result<Self> {
        let json = &mut serde_json::Deserializer::from_str(text);
        let file: Self = serde_path_to_error::deserialize(&mut *json)?;
        json.end()?;
        file.check()?;
        Ok(file)
    }

    /// Number of frames, at least 1.
    pub fn frame_count(&self) -> u32 {
        let by_time = self.duration.map(|seconds| (seconds * self.fps + 1e-6) as u32 + 1);
        self.frames.or(by_time).unwrap_or(1)
    }

    fn check(&self) -> Result<()> {
        ensure!(self.fps > 0.0 && self.fps <= 1000.0, "fps: {} is not above 0 and at most 1000", self.fps);
        ensure!(self.frames.is_some() != self.duration.is_some(), "frames, duration: give one of the two");
        let duration = self.duration.unwrap_or(0.0);
        ensure!((0.0..=MAX_FRAMES / self.fps).contains(&duration), "duration: {duration} is not 0 to a million frames");
        let frames = self.frame_count();
        ensure!((1.0..=MAX_FRAMES).contains(&f64::from(frames)), "frames: {frames} is not 1 to a million");
        let exposure = self.exposure.unwrap_or(1.0);
        ensure!(exposure > 0.0 && exposure.is_finite(), "exposure: {exposure} is not above 0");
        if let Some(camera) = &self.camera {
            check_times("camera", camera.keys.iter().map(|key| key.time))?;
            for (index, key) in camera.keys.iter().enumerate() {
                key.check().with_context(|| format!("camera.keys[{index}]"))?;
            }
        }
        for (index, object) in self.objects.iter().enumerate() {
            object.check().with_context(|| format!("objects[{index}]"))?;
        }
        for (index, crowd) in self.crowds.iter().enumerate() {
            crowd.check().with_context(|| format!("crowds[{index}]"))?;
        }
        Ok(())
    }
}

impl CameraKey {
    fn check(&self) -> Result<()> {
        check_point("position", self.position)?;
        check_point("target", self.target)?;
        let vfov = self.vfov.unwrap_or(60.0);
        ensure!((1.0..179.0).contains(&vfov), "vfov: {vfov} is not 1 to 179 degrees");
        Ok(())
    }
}

impl Object {
    fn check(&self) -> Result<()> {
        self.shape.check()?;
        check_point("pivot", self.pivot)?;
        check_times("motion", self.motion.keys.iter().map(|key| key.time))?;
        for (index, key) in self.motion.keys.iter().enumerate() {
            key.check().with_context(|| format!("motion.keys[{index}]"))?;
        }
        Ok(())
    }
}

impl PoseKey {
    fn check(&self) -> Result<()> {
        check_point("translation", self.translation)?;
        let turned = match self.rotation {
            Rotation::Quaternion(q) => q.iter().map(|v| v * v).sum::<f64>(),
            Rotation::AxisAngle { axis, .. } => axis.iter().map(|v| v * v).sum::<f64>(),
        };
        ensure!((1e-12..=1e12).contains(&turned), "rotation: its axis or quaternion has no direction");
        let scale = self.scale.axes();
        ensure!(scale.iter().all(|s| (1e-3..=1e3).contains(s)), "scale: {scale:?} is not within 0.001 to 1000");
        Ok(())
    }
}

impl Scale {
    /// Along x, y and z.
    pub fn axes(self) -> [f64; 3] {
        match self {
            Self::Uniform(all) => [all; 3],
            Self::Axes(axes) => axes,
        }
    }
}

impl Shape {
    fn check(&self) -> Result<()> {
        let Self::Box(BoxShape { size, color, emission }) = self else { return Ok(()) };
        let within = |values: &[f32; 3], low, high| values.iter().all(|v| (low..=high).contains(v));
        ensure!(within(size, 1e-3, 1e4), "shape.box.size: {size:?} is not within 0.001 to 10 000 m");
        ensure!(within(color, 0.0, 1.0), "shape.box.color: {color:?} is not within 0 to 1");
        ensure!(within(emission, 0.0, 65_000.0), "shape.box.emission: {emission:?} is not within 0 to 65 000");
        Ok(())
    }
}

impl Crowd {
    fn check(&self) -> Result<()> {
        self.shape.check()?;
        ensure!((1..=100_000).contains(&self.count), "count: {} is not 1 to 100 000", self.count);
        check_point("low", self.low)?;
        check_point("high", self.high)?;
        let ordered = self.low.iter().zip(&self.high).all(|(low, high)| low <= high);
        ensure!(ordered, "high: {:?} is below low, {:?}", self.high, self.low);
        ensure!((0.0..=1e3).contains(&self.speed), "speed: {} is not 0 to 1000 m/s", self.speed);
        Ok(())
    }
}

fn check_point(name: &str, point: [f64; 3]) -> Result<()> {
    let near = point.iter().all(|v| v.abs() <= MAX_METRES);
    ensure!(near, "{name}: {point:?} is farther than a million metres from the origin");
    Ok(())
}

fn check_times(track: &str, times: impl Iterator<Item = f64>) -> Result<()> {
    let times: Vec<f64> = times.collect();
    ensure!(!times.is_empty(), "{track}.keys: at least one is needed");
    let last = times.iter().position(|time| !(0.0..=1e6).contains(time));
    ensure!(last.is_none(), "{track}.keys[{}].time: not 0 to a million seconds", last.unwrap_or(0));
    for (index, pair) in times.windows(2).enumerate() {
        ensure!(pair[0] < pair[1], "{track}.keys[{}].time: {} is not after {}", index + 1, pair[1], pair[0]);
    }
    Ok(())
}

fn yes() -> bool {
    true
}

impl Default for Rotation {
    fn default() -> Self {
        Self::Quaternion([0.0, 0.0, 0.0, 1.0])
    }
}

impl Default for Scale {
    fn default() -> Self {
        Self::Uniform(1.0)
    }
}

impl Default for BoxShape {
    fn default() -> Self {
        Self { size: [1.0; 3], color: [0.7; 3], emission: [0.0; 3] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: &str = r#"{
        "scene": "hall", "fps": 10, "duration": 2, "exposure": 1.5,
        "camera": {"interpolation": "linear", "keys": [
            {"time": 0, "position": [0, 1, 2], "target": [0, 1, 0]},
            {"time": 2, "position": [4, 1, 2], "target": [0, 1, 0], "vfov": 50}]},
        "objects": [
            {"shape": {"instance": "crate"}, "pivot": [1, 0, 0], "motion": {"keys": [
                {"time": 0, "rotation": [0, 0, 0, 1]},
                {"time": 1, "rotation": {"axis": [0, 1, 0], "degrees": 90}, "scale": [1, 2, 1], "visible": false}]}},
            {"shape": {"instance": 3}, "motion": {"keys": [{"time": 0, "scale": 2}]}}],
        "crowds": [{"shape": {"box": {"size": [1, 2, 1]}}, "count": 9, "low": [0, 0, 0], "high": [9, 0, 9], "speed": 1}]
    }"#;

    #[test]
    fn a_whole_file_is_read() {
        let file = PathFile::parse(WHOLE).expect("a valid file");
        assert_eq!((file.frame_count(), file.objects.len(), file.crowds.len()), (21, 2, 1));
        let keys = &file.objects[0].motion.keys;
        assert_eq!((keys[0].visible, keys[1].visible, keys[1].scale.axes()), (true, false, [1.0, 2.0, 1.0]));
        assert!(matches!(file.objects[1].shape, Shape::Instance(InstanceName::Index(3))));
        let camera = file.camera.expect("a camera");
        assert_eq!((camera.interpolation, camera.keys[1].vfov), (Interpolation::Linear, Some(50.0)));
    }

    /// What is replaced, by what, and the words that the error must hold.
    #[test]
    fn errors_name_the_key_and_say_what_is_wrong() {
        let table = [
            (r#""duration": 2"#, r#""duration": 2, "frames": 3"#, "frames, duration: give one"),
            (r#""duration": 2"#, r#""frames": 0"#, "frames: 0"),
            (r#""duration": 2"#, r#""duration": 1e300"#, "duration: 1"),
            (r#""fps": 10"#, r#""fps": 0"#, "fps: 0"),
            (r#""fps": 10"#, r#""fps": NaN"#, "line 2"),
            (r#""fps": 10"#, r#""fps": 1e999"#, "fps: number out of range"),
            (r#""fps": 10"#, r#""fpz": 10"#, "unknown field `fpz`"),
            (r#""exposure": 1.5"#, r#""exposure": -1"#, "exposure: -1"),
            (r#""linear""#, r#""cubic""#, "camera.interpolation: unknown variant `cubic`"),
            (r#"{"time": 2, "#, r#"{"time": 0, "#, "camera.keys[1].time: 0 is not after 0"),
            (r#"{"time": 2, "#, r#"{"time": -2, "#, "camera.keys[1].time: not 0"),
            (r#""position": [4, 1, 2]"#, r#""position": [4, 1]"#, "camera.keys[1].position: invalid length 2"),
            (r#""position": [4, 1, 2]"#, r#""position": [4, 1e9, 2]"#, "camera.keys[1]: position: "),
            (r#""vfov": 50"#, r#""vfov": 180"#, "camera.keys[1]: vfov: 180"),
            (r#"[0, 0, 0, 1]"#, r#"[0, 0, 0, 0]"#, "objects[0]: motion.keys[0]: rotation: "),
            (r#"[0, 0, 0, 1]"#, r#"[0, 1]"#, "objects[0].motion.keys[0].rotation: expected [x, y, z, w]"),
            (r#"[1, 2, 1], "vis"#, r#"[1, 0, 1], "vis"#, "objects[0]: motion.keys[1]: scale: [1.0, 0.0, 1.0]"),
            (r#""keys": [{"time": 0, "scale": 2}]"#, r#""keys": []"#, "objects[1]: motion.keys: at least one"),
            (r#"{"instance": 3}"#, r#"{"sphere": 3}"#, "objects[1].shape: unknown variant `sphere`"),
            (r#"{"size": [1, 2, 1]}"#, r#"{"size": [1, 2, 0]}"#, "crowds[0]: shape.box.size: "),
            (r#""count": 9"#, r#""count": 0"#, "crowds[0]: count: 0"),
            (r#""count": 9"#, r#""count": -9"#, "crowds[0].count: invalid value"),
            (r#""high": [9, "#, r#""high": [-9, "#, "crowds[0]: high: "),
            (r#""speed": 1"#, r#""speed": -1"#, "crowds[0]: speed: -1"),
        ];
        for (good, bad, words) in table {
            assert_eq!(WHOLE.matches(good).count(), 1, "{good}");
            let error = PathFile::parse(&WHOLE.replace(good, bad)).expect_err(bad);
            assert!(format!("{error:#}").contains(words), "{bad}: {error:#}");
        }
    }
}
