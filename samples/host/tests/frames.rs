//! The frame loop as a host runs it.

use brickgi::Settings;
use brickgi_host::scene::{Instance, Light};
use brickgi_host::{Host, HostOptions, Image, Scene};
use glam::{Mat3, Vec3};
use std::path::PathBuf;

fn cornell() -> Scene {
    Scene::load(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../scenes/cornell")).expect("the default scene")
}

#[test]
fn frames_are_clean_under_validation() {
    for frames_in_flight in [1, 2, 3] {
        let options = HostOptions { frames_in_flight, validation: true, ..HostOptions::new(cornell()) };
        let mut host = Host::new(options).expect("a host");
        let other = host.scene().cameras[1].clone();
        for frame in 0..8 {
            if frame == 4 {
                host.set_camera(other.clone()).expect("the second camera");
            }
            host.frame().expect("a frame");
        }
        assert!(host.read_indirect().expect("E_ind").is_finite());
        assert!(host.read_normal().expect("normals").is_finite());
        host.frame().expect("a frame after reading");
        host.wait_idle().expect("idle");
        assert_eq!(host.validation_messages(), Vec::<String>::new());
    }
}

/// A host at few pixels, with little light, under validation.
fn small(scene: Scene) -> Host {
    let settings = Settings { voxel_size: 0.25, light_faces_per_frame: 64, bounce_rays: 0, ..Settings::default() };
    let options = HostOptions { size: Some([96, 54]), validation: true, settings, ..HostOptions::new(scene) };
    Host::new(options).expect("a host")
}

/// Depth, normal, albedo, emission and direct light after some frames, and how many voxel faces there are.
fn pictures(host: &mut Host) -> ([Image; 5], u32) {
    (0..12).for_each(|_| host.frame().expect("a frame"));
    let depth = host.read_depth().expect("depth").map(|d| [*d, 0.0, 0.0]);
    let (normal, albedo) = (host.read_normal().expect("normals"), host.read_albedo().expect("albedo"));
    let (emission, direct) = (host.read_emission().expect("emission"), host.direct().expect("direct light"));
    assert_eq!(host.validation_messages(), Vec::<String>::new());
    ([depth, normal, albedo, emission, direct], host.stats().faces)
}

/// Share of the pixels that differ.
fn differing(a: &Image, b: &Image) -> f64 {
    let far =
        |(a, b): &(&[f32; 3], &[f32; 3])| a.iter().zip(b.iter()).any(|(a, b)| (a - b).abs() > 2e-3 + 1e-3 * b.abs());
    a.pixels.iter().zip(&b.pixels).filter(far).count() as f64 / a.pixels.len() as f64
}

/// Moved, turned, stretched and mirrored instances look as if their meshes had been made so; what is removed is gone,
/// and what is added is there.
#[test]
fn moved_instances_are_drawn_and_voxelised_moved() {
    let mut scene = cornell();
    scene.lights.push(Light::Point { position: [3.0, 5.0, -3.0], intensity: [20.0; 3], range: 0.0 });
    let own = |index: usize| scene.instances[index].clone();
    let turn = Mat3::from_rotation_y(0.4);
    let place = |instance: Instance, linear: Mat3, translation: [f64; 3]| Instance {
        linear: linear.to_cols_array_2d(),
        translation,
        ..instance
    };
    let changes = [
        (1, Some(place(own(1), turn * Mat3::from_diagonal(Vec3::new(-1.0, 0.5, 1.0)), [2.0, 0.3, -1.0]))),
        (2, None),
        (3, Some(place(own(3), Mat3::from_diagonal(Vec3::new(1.0, -0.7, 1.0)), [0.0, 4.0, 0.0]))),
        (9, Some(place(own(2), turn, [-2.0, 0.0, 0.5]))),
    ];
    let mut moved = small(scene.clone());
    (0..3).for_each(|_| moved.frame().expect("a frame"));
    let before = moved.read_depth().expect("depth");
    moved.update_instances(&changes).expect("valid changes");
    let (seen, faces) = pictures(&mut moved);
    assert!(before != seen[0].map(|d| d[0]), "the changes are in sight");

    let added = changes[3].1.clone().expect("added");
    let kept = [own(0), changes[0].1.clone().expect("moved"), changes[2].1.clone().expect("moved"), added];
    let mut baked = Scene { meshes: Vec::new(), instances: Vec::new(), ..scene.clone() };
    for instance in kept {
        let mut mesh = scene.meshes[instance.mesh].clone();
        mesh.positions = mesh.positions.iter().map(|p| instance.to_world(*p).map(|v| v as f32)).collect();
        if Mat3::from_cols_array_2d(&instance.linear).determinant() < 0.0 {
            mesh.indices.chunks_exact_mut(3).for_each(|triangle| triangle.swap(1, 2));
        }
        baked.instances.push(place(Instance { mesh: baked.meshes.len(), ..instance }, Mat3::IDENTITY, [0.0; 3]));
        baked.meshes.push(mesh);
    }
    let (made, made_faces) = pictures(&mut small(baked));
    for (index, name) in ["depth", "normal", "albedo", "emission", "direct"].iter().enumerate() {
        let share = differing(&seen[index], &made[index]);
        assert!(share < 0.005, "{name} differs in {share:.4} of the pixels");
        assert!(made[index].pixels.iter().any(|p| *p != [0.0; 3]), "{name} is not empty");
    }
    assert!(faces.abs_diff(made_faces) <= made_faces / 100, "{faces} voxel faces, {made_faces}");
    let refused = moved.update_instances(&[(77, None)]).expect_err("it is not there");
    assert!(refused.to_string().contains("77"), "{refused}");
    assert_eq!(pictures(&mut moved).0[0], seen[0], "nothing has changed");
}

#[test]
fn validation_hears_a_mistake() {
    let gpu = brickgi_host::Gpu::open(true).expect("a device under validation");
    let handles = gpu.handles();
    // SAFETY: deliberately wrong usage, harmless to the driver: a buffer without any usage.
    unsafe {
        let entry = ash::StaticFn { get_instance_proc_addr: handles.get_instance_proc_addr };
        let instance = ash::Instance::load(&entry, handles.instance);
        let device = ash::Device::load(instance.fp_v1_0(), handles.device);
        let buffer = device.create_buffer(&ash::vk::BufferCreateInfo::default().size(16), None);
        buffer.into_iter().for_each(|b| device.destroy_buffer(b, None));
    }
    assert!(gpu.validation_messages().iter().any(|m| m.contains("VUID")));
}

#[test]
fn options_outside_their_range_are_errors() {
    let size = HostOptions { size: Some([0, 10]), ..HostOptions::new(cornell()) };
    assert!(Host::new(size).is_err());
    let flight = HostOptions { frames_in_flight: 9, ..HostOptions::new(cornell()) };
    assert!(Host::new(flight).is_err());
    let camera = HostOptions { camera: Some("zebra".into()), ..HostOptions::new(cornell()) };
    assert!(Host::new(camera).err().is_some_and(|e| e.to_string().contains("a, b")));
}
