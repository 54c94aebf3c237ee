//! Somebody else's program: the C sample builds without a warning, runs without a validation message, and writes the
//! image that the Rust host makes.

mod common;

use brickgi::Settings;
use brickgi::scene::{InstanceDesc, MeshUpdate};
use brickgi_host::{Host, HostOptions, Image, Scene};
use common::{installed, repository, run, scratch, shared_library};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Builds the sample against the shared library of this build.
fn build(folder: &Path, compiler: &str) -> PathBuf {
    let library = shared_library();
    let library_folder = library.parent().expect("a folder");
    let program = folder.join(format!("cornell-{compiler}"));
    let mut command = Command::new(compiler);
    command.args(["-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-o"]).arg(&program);
    command.arg("-I").arg(repository().join("include"));
    for name in ["cornell.c", "gbuffer.c", "host.c", "picture.c"] {
        command.arg(repository().join("samples/c").join(name));
    }
    command.arg("-L").arg(library_folder).arg(format!("-Wl,-rpath,{}", library_folder.display()));
    run(command.args(["-lbrickgi", "-lvulkan", "-lm"]));
    program
}

/// Width, height and the numbers of a little-endian colour PFM, rows from the top.
fn read_pfm(path: &Path) -> (usize, usize, Vec<[f32; 3]>) {
    let bytes = fs::read(path).expect("the image");
    let mut lines = bytes.splitn(4, |byte| *byte == b'\n');
    let mut line = || lines.next().expect("a line");
    assert_eq!(line(), b"PF");
    let size = String::from_utf8(line().to_vec()).expect("a size");
    let (width, height) = size.split_once(' ').expect("two numbers");
    let (width, height) = (width.parse().expect("a width"), height.parse().expect("a height"));
    assert_eq!(line(), b"-1.0");
    let numbers = line().as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect::<Vec<_>>();
    let pixels = numbers.as_chunks::<3>().0;
    let rows = pixels.chunks(width).rev().flatten().copied().collect();
    (width, height, rows)
}

/// What the Rust host makes of the same scene, camera, settings and number of frames, the first of which see nothing.
fn rust_image(camera: &str, empty_frames: u32) -> Image {
    let scene = Scene::load(repository().join("samples/scenes/cornell")).expect("the scene");
    let settings = Settings { voxel_size: 0.25, ..Settings::default() };
    let size = Some([160, 90]);
    let options = HostOptions { camera: Some(camera.into()), size, settings, ..HostOptions::new(scene) };
    let mut host = Host::new(options).expect("a host");
    let instances = host.scene().instances.clone();
    let instances = (0..).zip(&instances).map(|(id, i)| InstanceDesc {
        id,
        mesh: i.mesh as u64,
        material: i.material as u64,
        linear: i.linear,
        translation: i.translation,
    });
    let instances: Vec<_> = instances.collect();
    let ids: Vec<u64> = instances.iter().map(|i| i.id).collect();
    for frame in 0..8 {
        let (removed, added) = match frame {
            0 if empty_frames > 0 => (&ids[..], &[][..]),
            _ if frame == empty_frames => (&[][..], &instances[..]),
            _ => Default::default(),
        };
        let update = MeshUpdate { removed_instances: removed, instances: added, ..MeshUpdate::default() };
        host.context_mut().update_meshes(&update).expect("a valid update");
        host.frame().expect("a frame");
    }
    host.read_indirect().expect("E_ind")
}

/// From buffers the meshes come as many frames later as are in flight.
#[test]
fn c_sample_renders_the_cornell_box_as_the_rust_host_does() {
    let folder = scratch("c_sample");
    let program = build(&folder, "cc");
    for (camera, meshes, empty_frames) in [("a", None, 0), ("b", None, 0), ("a", Some("--mesh-buffers"), 2)] {
        let out = folder.join(camera);
        let mut command = Command::new(&program);
        command.args(["--validate", "--frames", "8", "--size", "160x90", "--voxel-size", "0.25"]);
        run(command.args(["--camera", camera]).args(meshes).arg("--out").arg(&out));
        let (width, height, pixels) = read_pfm(&out.with_extension("pfm"));
        assert_eq!((width, height, pixels.len()), (160, 90, 160 * 90));
        assert!(pixels.as_flattened().iter().all(|value| value.is_finite() && *value >= 0.0), "camera {camera}");
        let lit = pixels.iter().filter(|pixel| pixel[1] > 0.0).count();
        let mean = pixels.iter().map(|pixel| pixel[1]).sum::<f32>() / lit.max(1) as f32;
        assert!(
            lit > pixels.len() / 2 && (0.05..2.0).contains(&mean),
            "camera {camera}: {lit} lit pixels, mean {mean}"
        );
        // Two rasterisers, two programs, one library: their G-buffers agree to the last bit (they differ by signs only,
        // which round alike), so the images must as well.
        let bits = |pixels: &[[f32; 3]]| pixels.as_flattened().iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        let same = bits(&pixels) == bits(&rust_image(camera, empty_frames).pixels);
        assert!(same, "camera {camera} {meshes:?}: not the Rust host's image");
        let picture = fs::metadata(out.with_extension("ppm")).expect("the picture").len();
        assert_eq!(picture, "P6\n160 90\n255\n".len() as u64 + 160 * 90 * 3);
    }
}

#[test]
fn c_sample_builds_with_every_compiler() {
    let folder = scratch("c_sample_compilers");
    for compiler in installed(&["gcc", "clang"]) {
        build(&folder, compiler);
    }
}

#[test]
fn c_sample_says_what_is_wrong_with_its_arguments() {
    let program = build(&scratch("c_sample_arguments"), "cc");
    for wrong in [&["--camera", "z"][..], &["--frames", "0"], &["--size", "0x4"], &["--voxel-size", "-1"], &["--out"]] {
        let output = Command::new(&program).args(wrong).output().expect("the program");
        assert!(!output.status.success() && !output.stderr.is_empty(), "{wrong:?}");
    }
    let output = Command::new(&program).args(["--voxel-size", "1000"]).output().expect("the program");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && text.contains("voxel_size"), "{text}");
}
