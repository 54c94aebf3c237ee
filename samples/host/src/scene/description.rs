//! `scene.json` of the references: mesh file, cameras, lights and sky.

use super::{Light, Scene, SceneCamera, Sky, SkyLayout, SkyPicture, gltf_file};
use crate::error::{Error, Result};
use crate::image::Image;
use glam::Mat3;
use serde::Deserialize;
use std::path::Path;

#[derive(Deserialize)]
struct Description {
    name: String,
    mesh: String,
    #[serde(default)]
    sky: SkyEntry,
    #[serde(default)]
    lights: Vec<LightEntry>,
    cameras: Vec<CameraEntry>,
}

/// One of three: `radiance`; `zenith`, `horizon` and `ground`; or `image`, a lat-long OpenEXR file beside the scene, with
/// `intensity` and an angle by which it is turned about +y, counter-clockwise seen from above.
#[derive(Deserialize)]
#[serde(untagged)]
enum SkyEntry {
    Constant {
        radiance: [f32; 3],
    },
    Gradient {
        zenith: [f32; 3],
        horizon: [f32; 3],
        ground: [f32; 3],
    },
    Image {
        image: String,
        #[serde(default = "one")]
        intensity: f32,
        #[serde(default)]
        turn_deg: f32,
    },
}

impl Default for SkyEntry {
    fn default() -> Self {
        Self::Constant { radiance: [0.0; 3] }
    }
}

fn one() -> f32 {
    1.0
}

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum LightEntry {
    Directional {
        direction: [f32; 3],
        irradiance: [f32; 3],
    },
    Point {
        position: [f64; 3],
        intensity: [f32; 3],
        #[serde(default)]
        range: f32,
    },
    Spot {
        position: [f64; 3],
        direction: [f32; 3],
        intensity: [f32; 3],
        #[serde(default)]
        inner_angle_deg: f32,
        outer_angle_deg: f32,
        #[serde(default)]
        range: f32,
    },
    Sphere {
        position: [f64; 3],
        radius: f32,
        radiance: [f32; 3],
    },
    Rectangle {
        position: [f64; 3],
        half_u: [f32; 3],
        half_v: [f32; 3],
        radiance: [f32; 3],
        #[serde(default)]
        two_sided: bool,
    },
}

#[derive(Deserialize)]
struct CameraEntry {
    name: String,
    position: [f64; 3],
    target: [f64; 3],
    up: [f64; 3],
    vfov_deg: f64,
    #[serde(default = "default_near")]
    near: f64,
    width: u32,
    height: u32,
}

fn default_near() -> f64 {
    0.05
}

/// Loads the description and the mesh it names; lights, sky and cameras come from the description alone.
pub(super) fn load(path: &Path) -> Result<Scene> {
    let text = std::fs::read_to_string(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
    let description: Description = serde_json::from_str(&text).map_err(|e| Error::scene(path, e))?;
    let mesh = path.parent().unwrap_or(Path::new(".")).join(&description.mesh);
    let geometry = gltf_file::load(&mesh)?;
    let (sky, sky_picture) = description.sky.load(path)?;
    Ok(Scene {
        name: description.name,
        lights: description.lights.into_iter().map(Light::from).collect(),
        sky,
        sky_picture,
        cameras: description.cameras.into_iter().map(SceneCamera::from).collect(),
        ..geometry
    })
}

impl SkyEntry {
    /// `scene`: the file that says it.
    fn load(self, scene: &Path) -> Result<(Sky, Option<SkyPicture>)> {
        Ok(match self {
            Self::Constant { radiance } => (Sky::Constant { radiance }, None),
            Self::Gradient { zenith, horizon, ground } => {
                (Sky::Gradient { zenith, horizon, ground, up: [0.0, 1.0, 0.0] }, None)
            }
            Self::Image { image, intensity, turn_deg } => {
                let rotation = Mat3::from_rotation_y(turn_deg.to_radians()).to_cols_array_2d();
                let Image { width, height, pixels } =
                    Image::read_exr(&scene.parent().unwrap_or(Path::new(".")).join(image))?;
                let rgba32 = pixels.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect();
                let picture = SkyPicture { layout: SkyLayout::LatLong, width, height, rgba32 };
                (Sky::Image { intensity: [intensity; 3], rotation }, Some(picture))
            }
        })
    }
}

impl From<LightEntry> for Light {
    fn from(entry: LightEntry) -> Self {
        match entry {
            LightEntry::Directional { direction, irradiance } => Self::Directional { direction, irradiance },
            LightEntry::Point { position, intensity, range } => Self::Point { position, intensity, range },
            LightEntry::Spot { position, direction, intensity, inner_angle_deg, outer_angle_deg, range } => {
                let [inner_angle, outer_angle] = [inner_angle_deg, outer_angle_deg].map(f32::to_radians);
                Self::Spot { position, direction, intensity, inner_angle, outer_angle, range }
            }
            LightEntry::Sphere { position, radius, radiance } => Self::Sphere { position, radius, radiance },
            LightEntry::Rectangle { position, half_u, half_v, radiance, two_sided } => {
                Self::Rectangle { position, half_u, half_v, radiance, two_sided }
            }
        }
    }
}

impl From<CameraEntry> for SceneCamera {
    fn from(entry: CameraEntry) -> Self {
        let CameraEntry { name, position, target, up, vfov_deg, near, width, height } = entry;
        Self { name, position, target, up, vfov_deg, near, width, height }
    }
}
