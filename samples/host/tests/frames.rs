//! The frame loop as a host runs it.

use brickgi_host::{Host, HostOptions, Scene};
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
