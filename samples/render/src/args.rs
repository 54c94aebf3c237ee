//! The command line; every option has a default.

use brickgi::{HitModel, Preset, Settings};
use clap::{Parser, ValueEnum};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Renders a scene with brickgi, beside the path-traced truth where one lies next to the scene.
#[derive(Parser, Debug)]
#[command(version)]
pub struct Args {
    /// A scene.json, the folder that holds one, a .glb or a .gltf [default: the Cornell box that ships]
    pub scene: Option<PathBuf>,
    /// Name of the camera [default: the scene's first]
    #[arg(long)]
    pub camera: Option<String>,
    /// Image size in pixels, as WIDTHxHEIGHT [default: the camera's own]
    #[arg(long, value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Frames to render with the camera at rest
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..), conflicts_with = "path")]
    pub frames: u32,
    /// Play the key-frames of this JSON file: a PNG a frame, and frames.csv
    #[arg(long, value_name = "FILE")]
    pub path: Option<PathBuf>,
    /// Frames rendered before the path starts, with time stopped at its start
    #[arg(long, default_value_t = 0, value_name = "FRAMES", requires = "path", value_parser = clap::value_parser!(u32).range(..=100_000))]
    pub settle: u32,
    /// Point on the speed/accuracy curve; the options below override it
    #[arg(long, value_enum, default_value = "medium")]
    pub preset: PresetName,
    /// Edge of a voxel in metres
    #[arg(long, default_value_t = 0.5)]
    pub voxel_size: f32,
    /// Shift of the voxel grid in voxels, as X,Y,Z
    #[arg(long, default_value = "0,0,0", value_parser = parse_triple::<f32>, allow_hyphen_values = true)]
    pub grid_offset: [f32; 3],
    /// Where a ray hits an occupied voxel
    #[arg(long, value_enum, default_value = "plane")]
    pub hit: HitName,
    /// World covered, in groups of 32 voxels, as X,Y,Z; powers of two
    #[arg(long, value_parser = parse_triple::<u32>)]
    pub coverage: Option<[u32; 3]>,
    /// Upper limit of the world's device memory in MiB
    #[arg(long)]
    pub memory: Option<u64>,
    /// Bricks voxelised a frame while any are waiting
    #[arg(long)]
    pub voxelize_bricks: Option<u32>,
    /// Milliseconds of GPU time that voxelisation may take a frame; 0: no limit
    #[arg(long)]
    pub voxelize_ms: Option<f32>,
    /// By how many voxels dense meshes may be simplified, 0 to 1; 0: not at all
    #[arg(long)]
    pub simplify_voxels: Option<f32>,
    /// Voxel faces lit a frame
    #[arg(long)]
    pub light_faces: Option<u32>,
    /// Hemisphere rays a face shoots per lighting update
    #[arg(long)]
    pub bounce_rays: Option<u32>,
    /// Whether these rays find light that comes straight from lights, sky and emitters alone
    #[arg(long)]
    pub single_bounce: Option<bool>,
    /// Shadow samples a face and light takes per lighting update
    #[arg(long)]
    pub direct_samples: Option<u32>,
    /// Lights that each of these samples asks at most
    #[arg(long)]
    pub direct_lights: Option<u32>,
    /// Pixels along the edge of a screen-probe tile: 8, 16 or 32
    #[arg(long)]
    pub probe_tile: Option<u32>,
    /// Frames that the temporal filter averages at most
    #[arg(long)]
    pub temporal_frames: Option<u32>,
    /// Frames in which settled probes and pixels look once: 1, 2 or 4
    #[arg(long)]
    pub gather_interval: Option<u32>,
    /// Screen probes that look in a frame at most; 0: no limit
    #[arg(long)]
    pub probes_per_frame: Option<u32>,
    /// Whether pixels look for what is near them, and hides their probes' light
    #[arg(long)]
    pub near_field: Option<bool>,
    /// Rays of each pixel and frame into the world, instead of probes; 0: probes
    #[arg(long)]
    pub pixel_rays: Option<u32>,
    /// Whether faces that neither light nor eye can reach go unlit where memory is short
    #[arg(long)]
    pub region_culling: Option<bool>,
    /// Edge in texels of shadow maps that the host draws of sun, points and spots, for brickgi to read; 0: shadows are rays
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(..=4096))]
    pub shadow_maps: u32,
    /// Whether brickgi is given motion vectors
    #[arg(long, default_value_t = true, action = clap::ArgAction::Set)]
    pub motion: bool,
    /// Write debug_<what>.png and .exr too: bricks, albedo, normals, radiance, irradiance and steps, as the camera's rays find
    /// them; history, probes, their radiance, and where none stands for a pixel
    #[arg(long)]
    pub debug_views: bool,
    /// Command buffers on the GPU at once
    #[arg(long, default_value_t = 2)]
    pub frames_in_flight: u32,
    /// Run under the Vulkan validation layer; any message makes the run fail
    #[arg(long)]
    pub validate: bool,
    /// Folder for the files [default: out/<scene>_<camera>, with a path out/<scene>_<path>]
    #[arg(long)]
    pub out: Option<PathBuf>,
}

/// [`Preset`] on the command line.
#[derive(ValueEnum, Clone, Copy, Debug)]
pub enum PresetName {
    Low,
    Medium,
    High,
    Ultra,
}

/// [`HitModel`] on the command line.
#[derive(ValueEnum, Clone, Copy, Debug)]
pub enum HitName {
    Plane,
    Cube,
}

impl Args {
    /// The preset with the overrides; ranges are brickgi's to check.
    pub fn settings(&self) -> Settings {
        let base = Settings::preset(match self.preset {
            PresetName::Low => Preset::Low,
            PresetName::Medium => Preset::Medium,
            PresetName::High => Preset::High,
            PresetName::Ultra => Preset::Ultra,
        });
        Settings {
            voxel_size: self.voxel_size,
            grid_offset: self.grid_offset,
            coverage_groups: self.coverage.unwrap_or(base.coverage_groups),
            memory_budget: self.memory.map_or(base.memory_budget, |mib| mib.saturating_mul(1 << 20)),
            voxelize_bricks_per_frame: self.voxelize_bricks.unwrap_or(base.voxelize_bricks_per_frame),
            voxelize_ms: self.voxelize_ms.unwrap_or(base.voxelize_ms),
            simplify_voxels: self.simplify_voxels.unwrap_or(base.simplify_voxels),
            light_faces_per_frame: self.light_faces.unwrap_or(base.light_faces_per_frame),
            bounce_rays: self.bounce_rays.unwrap_or(base.bounce_rays),
            direct_samples: self.direct_samples.unwrap_or(base.direct_samples),
            single_bounce: self.single_bounce.unwrap_or(base.single_bounce),
            direct_lights: self.direct_lights.unwrap_or(base.direct_lights),
            hit_model: match self.hit {
                HitName::Plane => HitModel::Plane,
                HitName::Cube => HitModel::Cube,
            },
            probe_tile: self.probe_tile.unwrap_or(base.probe_tile),
            temporal_frames: self.temporal_frames.unwrap_or(base.temporal_frames),
            gather_interval: self.gather_interval.unwrap_or(base.gather_interval),
            probes_per_frame: self.probes_per_frame.unwrap_or(base.probes_per_frame),
            near_field: self.near_field.unwrap_or(base.near_field),
            pixel_rays: self.pixel_rays.unwrap_or(base.pixel_rays),
            region_culling: self.region_culling.unwrap_or(base.region_culling),
        }
    }

    /// The scene asked for, else the one that ships.
    pub fn scene_path(&self) -> Option<PathBuf> {
        self.scene.clone().or_else(default_scene)
    }
}

/// `samples/scenes/cornell` in the source tree, else beside the executable or above it.
fn default_scene() -> Option<PathBuf> {
    let built = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/cornell");
    let executable = std::env::current_exe().ok();
    let above = executable.iter().flat_map(|exe| exe.ancestors().skip(1));
    let beside = above.flat_map(|folder| [folder.join("scenes/cornell"), folder.join("samples/scenes/cornell")]);
    std::iter::once(built).chain(beside).find(|folder| folder.join("scene.json").is_file())
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    parsed.ok_or_else(|| "expected WIDTHxHEIGHT, for example 320x180".into())
}

fn parse_triple<T: FromStr>(text: &str) -> Result<[T; 3], String> {
    let parts: Option<Vec<T>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    parts.and_then(|parts| parts.try_into().ok()).ok_or_else(|| "expected three numbers, for example 0,0,0".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_the_medium_preset() {
        let args = Args::parse_from(["brickgi-render"]);
        assert_eq!(args.settings(), Settings::preset(Preset::Medium));
        assert!(args.scene_path().is_some());
    }

    #[test]
    fn options_override_the_preset() {
        let line = "r s.glb --size 64x32 --grid-offset -.37,.61,.23 --preset high --bounce-rays 3 --hit cube";
        let args = Args::parse_from(line.split(' '));
        assert_eq!((args.size, args.grid_offset), (Some([64, 32]), [-0.37, 0.61, 0.23]));
        let settings = args.settings();
        assert_eq!((settings.bounce_rays, settings.probe_tile, settings.hit_model), (3, 8, HitModel::Cube));
    }

    #[test]
    fn malformed_options_are_refused() {
        for line in [
            "r --settle 4",
            "r --path p.json --frames 9",
            "r --size 64",
            "r --size 64xx3",
            "r --grid-offset 1,2",
            "r --frames 0",
            "r --hit sphere",
        ] {
            assert!(Args::try_parse_from(line.split(' ')).is_err(), "{line}");
        }
    }
}
