//! Bad files and bad cameras: an error with words for each, and the process goes on.

use brickgi_host::{Host, HostOptions, Image, Scene};
use std::fs;
use std::path::{Path, PathBuf};

fn cornell() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/cornell")
}

/// A fresh folder.
fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("scratch folder");
    folder
}

/// Loading must fail with words that name the file.
fn assert_refused(path: &Path) {
    let error = Scene::load(path).expect_err("the file is bad").to_string();
    let name = path.file_name().and_then(|name| name.to_str()).expect("a name");
    assert!(error.contains(name) && error.len() > name.len() + 10, "{error}");
}

#[test]
fn missing_files_are_named() {
    let folder = scratch("missing");
    for name in ["none.glb", "none.gltf", "scene.json", "folder"] {
        assert_refused(&folder.join(name));
    }
    assert!(Scene::load(&folder).is_err_and(|e| e.to_string().contains("scene.json")));
    assert!(Image::read_exr(&folder.join("none.exr")).is_err_and(|e| e.to_string().contains("none.exr")));
    let text = fs::read_to_string(cornell().join("scene.json")).expect("the scene");
    fs::write(folder.join("scene.json"), text).expect("a copy without its mesh");
    assert!(Scene::load(&folder).is_err_and(|e| e.to_string().contains("cornell.glb")));
}

#[test]
fn unreadable_scenes_are_refused() {
    let folder = scratch("unreadable");
    let whole = fs::read(cornell().join("cornell.glb")).expect("the mesh");
    let inverted = whole.iter().map(|byte| !byte).collect::<Vec<_>>();
    let lens = fs::read_to_string(cornell().join("scene.json"))
        .expect("the scene")
        .replace("\"vfov_deg\": ", "\"vfov_deg\": -");
    fs::copy(cornell().join("cornell.glb"), folder.join("cornell.glb")).expect("a copy");
    let files: [(&str, &[u8]); 8] = [
        ("empty.glb", b""),
        ("header.glb", &whole[..12]),
        ("half.glb", &whole[..whole.len() / 2]),
        ("noise.glb", &inverted),
        ("text.gltf", b"not JSON"),
        ("nothing.gltf", br#"{"asset": {"version": "2.0"}}"#),
        ("fields.json", b"{}"),
        ("lens.json", lens.as_bytes()),
    ];
    for (name, bytes) in files {
        fs::write(folder.join(name), bytes).expect("a bad file");
        assert_refused(&folder.join(name));
    }
}

#[test]
fn a_camera_that_is_not_a_number_is_refused_and_the_host_goes_on() {
    let scene = Scene::load(cornell()).expect("the default scene");
    let options = HostOptions { size: Some([64, 36]), validation: true, ..HostOptions::new(scene) };
    let mut host = Host::new(options).expect("a host");
    host.frame().expect("a frame");
    let good = host.camera().clone();
    let mut bad = [good.clone(), good.clone(), good.clone(), good.clone()];
    bad[0].position[1] = f64::NAN;
    bad[1].target = good.position;
    bad[2].up = [f64::INFINITY, 0.0, 0.0];
    bad[3].vfov_deg = f64::NAN;
    for camera in bad {
        assert!(host.set_camera(camera).is_err_and(|e| e.to_string().contains("camera")));
        assert_eq!(host.camera(), &good);
        host.frame().expect("a frame with the camera as it was");
    }
    assert!(host.read_indirect().expect("E_ind").is_finite());
    assert_eq!(host.validation_messages(), Vec::<String>::new());
}
