//! The program says what is wrong and ends with a failure; it never writes an image then.

use std::path::Path;
use std::process::Command;

#[test]
fn what_cannot_be_rendered_is_said() {
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let broken = scratch.join("broken.glb");
    std::fs::write(&broken, b"glTF, but not really").expect("a bad file");
    let (broken, missing) = (broken.to_str().expect("UTF-8"), "does/not/exist.glb");
    for (arguments, words) in [
        (&[missing][..], missing),
        (&[broken], "broken.glb"),
        (&["--size", "0x36"], "size 0 x 36"),
        (&["--camera", "zebra"], "zebra"),
        (&["--voxel-size", "NaN"], "voxel_size"),
        (&["--grid-offset", "NaN,0,0"], "grid_offset"),
    ] {
        let out = scratch.join("nothing");
        let mut command = Command::new(env!("CARGO_BIN_EXE_brickgi-render"));
        let output = command.args(arguments).arg("--out").arg(&out).output().expect("the program");
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {text}");
        assert!(text.contains("error: ") && text.contains(words), "{arguments:?}: {text}");
        assert!(!out.exists(), "{arguments:?}");
    }
}
