//! What the tests of the C ABI share.
#![allow(dead_code, reason = "each test program uses a part")]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// The repository's root.
pub fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A fresh folder for what a test writes.
pub fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("scratch folder");
    folder
}

/// Compares a generated text with its checked-in file; with `BRICKGI_BLESS=1` writes the file instead.
pub fn bless(path: &str, text: &str) {
    let file = repository().join(path);
    if env::var_os("BRICKGI_BLESS").is_some_and(|value| value == "1") {
        fs::write(&file, text).unwrap_or_else(|error| panic!("{path}: {error}"));
        return;
    }
    let there = fs::read_to_string(&file).unwrap_or_else(|error| panic!("{path}: {error}"));
    let line = there.lines().zip(text.lines()).position(|(a, b)| a != b);
    let line = line.unwrap_or_else(|| there.lines().count().min(text.lines().count())) + 1;
    assert!(there == text, "{path} is out of date from line {line}: run the tests once with BRICKGI_BLESS=1");
}

/// Those of the given commands that are installed.
pub fn installed(commands: &[&'static str]) -> Vec<&'static str> {
    let works = |command: &&&str| Command::new(command).arg("--version").output().is_ok_and(|out| out.status.success());
    commands.iter().filter(works).copied().collect()
}

/// Runs a command; fails with all it said where it fails.
pub fn run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {}\n{text}", output.status);
    text
}

/// The shared library of the build that this test belongs to.
pub fn shared_library() -> PathBuf {
    let program = env::current_exe().expect("the test's own path");
    let deps = program.parent().expect("a folder");
    let name = format!("{}brickgi{}", env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX);
    let candidates = [deps.join(&name), deps.parent().expect("a folder").join(&name)];
    let newest = candidates.iter().filter_map(|path| Some((fs::metadata(path).ok()?.modified().ok()?, path))).max();
    newest.unwrap_or_else(|| panic!("none of {candidates:?} exists")).1.clone()
}
