//! A path is played whole: a picture and a line of figures a frame, under the validation layer.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn repository() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("scratch folder");
    folder
}

/// Plays a path in the scene of two rooms.
fn play(path: &Path, out: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_brickgi-render"));
    command.arg(repository().join("tests/data/two_rooms_door")).arg("--path").arg(path).arg("--out").arg(out);
    command.args(["--size", "64x36", "--voxel-size", "0.25", "--settle", "8", "--validate"]);
    command.output().expect("the program")
}

/// The mean of all channels and pixels, 0 to 255.
fn brightness(picture: &Path) -> f64 {
    let pixels = image::open(picture).expect("a picture").into_rgb8();
    assert_eq!(pixels.dimensions(), (64, 36), "{}", picture.display());
    pixels.iter().map(|v| f64::from(*v)).sum::<f64>() / pixels.len() as f64
}

#[test]
fn light_comes_in_once_the_door_is_open() {
    let folder = scratch("door");
    let text = std::fs::read_to_string(repository().join("samples/paths/door.json")).expect("the path that ships");
    let mut json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    // 13 frames instead of 91; the door opens from 1 s to 3 s.
    json["fps"] = 2.into();
    std::fs::write(folder.join("door.json"), json.to_string()).expect("a path with fewer frames");
    let output = play(&folder.join("door.json"), &folder.join("out"));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));

    let picture = |frame| folder.join("out").join(format!("frame_{frame:04}.png"));
    let [closed, open] = [0, 12].map(|frame| brightness(&picture(frame)));
    assert!((0..13).all(|frame| picture(frame).is_file()) && !picture(13).exists());
    assert!(open > 3.0 * closed + 10.0, "brightness {closed} behind the closed door, {open} behind the open one");

    let mut table = csv::Reader::from_path(folder.join("out/frames.csv")).expect("the table");
    let header = table.headers().expect("a header").clone();
    let rows: Vec<csv::StringRecord> = table.records().map(|row| row.expect("a row")).collect();
    let column = |name: &str| {
        let index = header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no column {name} in {header:?}"));
        rows.iter().map(|row| row[index].parse().expect("a number")).collect::<Vec<f64>>()
    };
    assert_eq!(column("frame"), (0..13).map(f64::from).collect::<Vec<_>>());
    assert_eq!(column("time_s")[12], 6.0);
    assert_eq!(column("camera_x"), [11.7; 13]);
    assert_eq!(column("instances_changed"), [0., 0., 0., 1., 1., 1., 1., 0., 0., 0., 0., 0., 0.]);
    let moving = column("voxelize_ms").iter().map(|ms| *ms > 0.0).collect::<Vec<_>>();
    assert!(!moving[2] && moving[3] && !moving[12], "bricks are voxelised once the door moves: {moving:?}");
    let light = column("mean_indirect");
    assert!(light[12] > 10.0 * light[0] + 0.01, "{light:?}");
    let (total, mut parts) = (column("gpu_ms"), vec![0.0; 13]);
    for group in ["voxelize_ms", "commit_ms", "lighting_ms", "gather_ms"] {
        parts.iter_mut().zip(column(group)).for_each(|(sum, ms)| *sum += ms);
    }
    for (sum, total) in parts.iter().zip(&total) {
        assert!(*total > 0.0 && *sum > 0.5 * total && *sum < 1.001 * total, "{sum} of {total} ms");
    }
    for (name, least) in [("bricks", 1.0), ("faces", 100.0), ("world_bytes", 1e5), ("cpu_ms", 1e-3)] {
        assert!(column(name).iter().all(|value| *value >= least), "{name}: {:?}", column(name));
    }
}

#[test]
fn bad_paths_are_refused() {
    let folder = scratch("bad_paths");
    for (name, text, words) in [
        ("missing.json", None, "cannot read"),
        ("text.json", Some("not JSON"), "line 1"),
        ("half.json", Some(r#"{"fps": 1, "frames": 1"#), "line 1"),
        (
            "order.json",
            Some(
                r#"{"fps": 1, "frames": 1, "objects": [{"shape": {"box": {}}, "motion": {"keys": [
            {"time": 1}, {"time": 0.5}]}}]}"#,
            ),
            "objects[0]: motion.keys[1].time: 0.5 is not after 1",
        ),
        (
            "unknown.json",
            Some(
                r#"{"fps": 1, "frames": 1, "objects": [{"shape": {"instance": "zebra"},
            "motion": {"keys": [{"time": 0}]}}]}"#,
            ),
            "objects[0].shape: no instance \"zebra\"",
        ),
        ("nan.json", Some(r#"{"fps": NaN, "frames": 1}"#), "line 1"),
        ("other.json", Some(r#"{"fps": 1, "frames": 1, "scene": "city"}"#), "made for \"city\""),
    ] {
        let path = folder.join(name);
        text.into_iter().for_each(|text| std::fs::write(&path, text).expect("a bad file"));
        let output = play(&path, &folder.join("out"));
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{name}: {error}");
        assert!(error.contains("error: ") && error.contains(name) && error.contains(words), "{name}: {error}");
        assert!(!folder.join("out").exists(), "{name}");
    }
}
