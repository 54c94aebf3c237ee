//! `include/brickgi.h` is what the C ABI's source says, and every compiler that is installed takes it without a word.
//!
//! `BRICKGI_BLESS=1 cargo test --test header` writes the header anew.

mod common;

use common::{bless, installed, repository, run, scratch};
use std::fs;
use std::process::Command;

/// The files of the C ABI in the header's order; `vk.rs` is left out, so that Vulkan's names stay Vulkan's.
const SOURCES: [&str; 14] = [
    "types", "version", "errors", "device", "settings", "context", "geometry", "meshes", "sky", "lights", "shadows",
    "view", "dispatch", "stats",
];

fn generate() -> String {
    let root = repository();
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).expect("cbindgen.toml");

    let builder = SOURCES.iter().fold(cbindgen::Builder::new().with_config(config), |builder, name| {
        builder.with_src(root.join(format!("src/capi/{name}.rs")))
    });
    let mut header = Vec::new();
    builder.generate().expect("cbindgen").write(&mut header);
    String::from_utf8(header).expect("UTF-8")
}

#[test]
fn header_is_what_the_source_says() {
    bless("include/brickgi.h", &generate());
}

/// Compiles a host's source against the header, without a word of warning, in every dialect of every compiler.
fn compile(compilers: &[&'static str], dialects: &[&str], language: &str) {
    let folder = scratch(&format!("header_{language}"));
    let source = folder.join("host.c");
    let text = "#include <brickgi.h>\n#include <brickgi.h>\nint main(void) { return (int)(bgiGetAbiVersion() - BGI_ABI_VERSION); }\n";
    fs::write(&source, text).expect("source");
    for compiler in installed(compilers) {
        for dialect in dialects {
            let mut command = Command::new(compiler);
            command.args(["-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-x", language]);
            run(command.arg(format!("-std={dialect}")).arg("-I").arg(repository().join("include")).arg(&source));
        }
    }
}

#[test]
fn header_is_clean_c99_to_c23() {
    compile(&["gcc", "clang"], &["c99", "c11", "c17", "c2x"], "c");
}

#[test]
fn header_is_clean_cpp11_to_cpp23() {
    compile(&["g++", "clang++"], &["c++11", "c++14", "c++17", "c++20", "c++2b"], "c++");
}
