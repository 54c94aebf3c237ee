//! What a camera that flies through a large world finds there.

use brickgi::Settings;
use brickgi_host::scene::{Instance, Material, Mesh, Sky};
use brickgi_host::{Host, HostOptions, Scene, SceneCamera};

/// Metres of a block of the town, with a tower in the middle of each.
const BLOCK: f64 = 20.0;
const BLOCKS: [usize; 2] = [7, 14];
/// Metres a frame: 30 m/s at 60 frames a second.
const STEP: f64 = 0.5;

/// A box of this half size on the ground.
fn tower([x, y, z]: [f32; 3]) -> Mesh {
    Mesh::cuboid([-x, 0.0, -z], [x, 2.0 * y, z])
}

/// Blocks along z, the camera above the first.
fn town() -> Scene {
    let half = BLOCK as f32 / 2.0;
    let ground = Mesh {
        positions: vec![[-half, 0.0, -half], [half, 0.0, -half], [-half, 0.0, half], [half, 0.0, half]],
        uvs: Vec::new(),
        indices: vec![0, 2, 1, 1, 2, 3],
    };
    let meshes = vec![ground, tower([4.0, 5.0, 4.0]), tower([3.0, 9.0, 3.0]), tower([6.0, 3.0, 2.0])];
    let mut instances = Vec::new();
    for index in 0..BLOCKS[0] * BLOCKS[1] {
        let (x, z) = (index % BLOCKS[0], index / BLOCKS[0]);
        let across = (x as f64 - (BLOCKS[0] - 1) as f64 / 2.0) * BLOCK;
        let place = [across, 0.0, z as f64 * BLOCK];
        instances.extend([0, 1 + (x + 2 * z) % 3].map(|mesh| Instance::at(mesh, 0, place)));
    }
    Scene {
        name: "town".into(),
        meshes,
        materials: vec![Material { base_color: [0.5; 3], emission: [0.0; 3], texture: None }],
        instances,
        sky: Sky::Constant { radiance: [1.0; 3] },
        cameras: vec![camera(0.0)],
        ..Scene::default()
    }
}

fn camera(z: f64) -> SceneCamera {
    SceneCamera {
        name: "flight".into(),
        position: [3.0, 6.0, z],
        target: [3.0, 5.0, z + 10.0],
        up: [0.0, 1.0, 0.0],
        vfov_deg: 60.0,
        near: 0.1,
        width: 32,
        height: 18,
    }
}

/// At 30 m/s and 15 bricks a frame, what comes into view within 64 m is there after eight frames at the latest.
#[test]
fn a_flight_finds_its_bricks_there() {
    let settings = Settings {
        coverage_groups: [16, 4, 16],
        voxelize_bricks_per_frame: 15,
        light_faces_per_frame: 64,
        bounce_rays: 0,
        ..Settings::default()
    };
    let mut host = Host::new(HostOptions { settings, validation: true, ..HostOptions::new(town()) }).expect("a device");
    let frame = |host: &mut Host| {
        host.frame().expect("a frame");
        assert!(host.stats().bricks_voxelized <= 15);
        host.stats().clone()
    };
    // What is near at the start.
    let mut waits = 0;
    while waits == 0 || host.stats().bricks_missing_in_view > 0 {
        frame(&mut host);
        waits += 1;
    }
    let (there, all) = (host.stats().bricks, host.stats().bricks + host.stats().bricks_missing);
    println!("what is near and in view is there after {waits} frames, with {there} of {all} bricks");
    assert!(waits > 8 && there * 3 < all, "what is near and in view comes first");
    let (mut late, mut latest, mut arrived) = (0, 0, 0);
    let frames = ((BLOCKS[1] as f64 - 4.0) * BLOCK / STEP) as u32;
    for index in 0..frames {
        host.set_camera(camera(f64::from(index) * STEP)).expect("a camera");
        let stats = frame(&mut host);
        late = if stats.bricks_missing_in_view > 0 { late + 1 } else { 0 };
        latest = latest.max(late);
        arrived += stats.bricks_voxelized;
    }
    println!("{arrived} bricks arrived in {frames} frames; one in view was missing for {latest} frames at most");
    assert!(arrived > 1500, "{arrived} bricks came into the window");
    assert!(latest <= 8, "a brick in view was missing for {latest} frames");
    assert_eq!(host.validation_messages(), Vec::<String>::new());
}
