//! Light that comes through panes and cutouts, against closed forms: a black room under a uniform sky, whose ceiling
//! lets a share of the light through.

use brickgi::Settings;
use brickgi::scene::{MaterialDesc, MeshUpdate, TextureDesc};
use brickgi_host::image::luminance;
use brickgi_host::scene::{Instance, Material, Mesh, Sky};
use brickgi_host::{Host, HostOptions, Scene, SceneCamera};
use std::f64::consts::PI;

const BLACK: u64 = 0;
const CEILING: u64 = 1;
const TEXTURE: u64 = 9;
/// Half the width and the height of the room, metres.
const HALF: f32 = 8.0;
const HEIGHT: f32 = 3.2;

/// A square, level, two-sided; texture coordinates in metres.
fn sheet(y: f32) -> Mesh {
    let positions = vec![[-HALF, y, -HALF], [HALF, y, -HALF], [-HALF, y, HALF], [HALF, y, HALF]];
    let uvs = positions.iter().map(|p: &[f32; 3]| [p[0], p[2]]).collect();
    Mesh { positions, uvs, indices: vec![0, 2, 1, 1, 2, 3] }
}

fn walls() -> Mesh {
    let corners = [[-HALF, -HALF], [HALF, -HALF], [HALF, HALF], [-HALF, HALF]];
    let positions = corners.iter().flat_map(|[x, z]| [[*x, 0.0, *z], [*x, HEIGHT, *z]]).collect();
    let indices = (0..4).flat_map(|k| [2 * k, 2 * k + 1, (2 * k + 2) % 8, (2 * k + 2) % 8, 2 * k + 1, (2 * k + 3) % 8]);
    Mesh { positions, uvs: Vec::new(), indices: indices.collect() }
}

/// Irradiance in the middle of the floor, over that under the open sky. `lid`: an opaque sheet lies a little
/// above the ceiling.
fn passed(ceiling: &MaterialDesc, texture: Option<&[u8; 16]>, lid: bool) -> f64 {
    let black = Material { base_color: [0.0; 3], emission: [0.0; 3], texture: None };
    let instance = |(mesh, material)| Instance::at(mesh, material as usize, [0.0; 3]);
    let mut instances = [(0, BLACK), (1, BLACK), (2, CEILING)].map(instance).to_vec();
    if lid {
        instances.push(instance((3, BLACK)));
    }
    let scene = Scene {
        name: "room".into(),
        meshes: vec![sheet(0.0), walls(), sheet(HEIGHT), sheet(HEIGHT + 0.06)],
        materials: vec![black.clone(), black],
        instances,
        sky: Sky::Constant { radiance: [1.0; 3] },
        cameras: vec![SceneCamera {
            name: "floor".into(),
            position: [0.0, 2.5, 0.1],
            target: [0.0, 0.0, 0.0],
            up: [0.0, 1.0, 0.0],
            vfov_deg: 60.0,
            near: 0.05,
            width: 16,
            height: 16,
        }],
        ..Scene::default()
    };
    let settings = Settings {
        voxel_size: 0.25,
        grid_offset: [0.37, 0.61, 0.23],
        // Everything is black.
        bounce_rays: 0,
        light_faces_per_frame: 64,
        ..Settings::default()
    };
    let mut host = Host::new(HostOptions { settings, validation: true, ..HostOptions::new(scene) }).expect("a device");
    let textures: Vec<TextureDesc> =
        texture.iter().map(|rgba8| TextureDesc { id: TEXTURE, width: 2, height: 2, rgba8: rgba8.as_slice() }).collect();
    let update = MeshUpdate { textures: &textures, materials: &[*ceiling], ..MeshUpdate::default() };
    host.context_mut().update_meshes(&update).expect("a valid material");
    (0..48).for_each(|_| host.frame().expect("a frame"));
    assert_eq!(host.validation_messages(), Vec::<String>::new());
    let image = host.read_indirect().expect("E_ind");
    image.pixels.iter().map(|p| luminance(*p)).sum::<f64>() / image.pixels.len() as f64 / PI
}

fn pane(transmittance: f32) -> MaterialDesc {
    MaterialDesc { id: CEILING, transmittance, ..MaterialDesc::default() }
}

/// Alpha of 2 x 2 texels.
fn cutout(alpha: [u8; 4]) -> [u8; 16] {
    std::array::from_fn(|i| if i % 4 == 3 { alpha[i / 4] } else { 0 })
}

/// Form factor of the ceiling as the middle of the floor sees it (Howell, A Catalog of Radiation Heat Transfer
/// Configuration Factors, B-4).
fn ceiling_factor() -> f64 {
    let (half, slant) = (f64::from(HALF), f64::from(HALF.hypot(HEIGHT)));
    4.0 / PI * half / slant * (half / slant).atan()
}

/// `expected`: of the light that the ceiling stands in the way of.
fn assert_share(found: f64, expected: f32, what: &str) {
    let expected = f64::from(expected) * ceiling_factor();
    println!("{what}: {found:.4}, {expected:.4} expected");
    assert!((found - expected).abs() < 0.015, "{what}: {found:.4} of the sky's light arrives, not {expected:.4}");
}

#[test]
fn a_pane_lets_its_share_through() {
    for transmittance in [0.0, 0.1, 0.35, 0.8, 1.0] {
        let found = passed(&pane(transmittance), None, false);
        assert_share(found, transmittance, &format!("transmittance {transmittance}"));
    }
}

#[test]
fn a_cutout_lets_light_through_where_its_alpha_says() {
    let material = MaterialDesc { base_color_texture: Some(TEXTURE), texture_alpha: true, ..pane(0.0) };
    assert_share(
        passed(&material, Some(&cutout([255, 0, 0, 255])), false),
        0.5,
        "squares of half a metre, every other one open",
    );
    assert_share(passed(&material, Some(&cutout([51; 4])), false), 0.8, "alpha 0.2");
    let opaque = MaterialDesc { texture_alpha: false, ..material };
    assert_share(passed(&opaque, Some(&cutout([0; 4])), false), 0.0, "alpha that does not count");
}

/// A sheet in the same voxels behind the pane still stops all light.
#[test]
fn a_pane_before_a_wall_opens_no_hole() {
    assert_share(passed(&pane(0.7), None, true), 0.0, "a lid on the pane");
}
