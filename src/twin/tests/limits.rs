//! Every shader runs on a phone: design section 3, "Shaders".

use crate::gpu::shaders::{BindingKind, SHADERS, Shader};
use std::path::Path;
use std::process::Command;

const SPIRV_MAGIC: u32 = 0x0723_0203;
const SPIRV_1_3: u32 = 0x0001_0300;
const OP_EXTENSION: u32 = 10;
const OP_CAPABILITY: u32 = 17;
/// What Vulkan 1.1 guarantees without a feature: Shader (with Matrix) and ImageQuery.
const CAPABILITIES: [u32; 3] = [1, 0, 50];

fn count(shader: &Shader, kind: BindingKind) -> usize {
    shader.bindings.iter().filter(|b| b.kind == kind).count()
}

#[test]
fn every_shader_stays_within_a_phones_limits() {
    for shader in SHADERS {
        let most = |value: u32, limit: u32, what: &str| {
            assert!(value <= limit, "{}: {what}: {value}, a phone has {limit}", shader.name);
        };
        let [x, y, z] = shader.workgroup;
        most(x * y * z, 128, "invocations of a workgroup");
        most(x.max(y), 128, "workgroup size in x or y");
        most(z, 64, "workgroup size in z");
        most(shader.shared_bytes, 16 << 10, "bytes of workgroup memory");
        most(shader.push_bytes, 128, "bytes of push constants");
        most(count(shader, BindingKind::Storage) as u32, 8, "storage buffers");
        most(count(shader, BindingKind::StorageImage) as u32, 4, "storage images");
        most(count(shader, BindingKind::SampledImage) as u32, 16, "sampled images");
        most(count(shader, BindingKind::Uniform) as u32, 12, "uniform buffers");
    }
}

#[test]
fn every_shader_needs_no_more_than_vulkan_1_1() {
    for shader in SHADERS {
        let words = shader.spirv.words();
        assert_eq!(words[..2], [SPIRV_MAGIC, SPIRV_1_3], "{}", shader.name);
        let mut at = 5;
        while at < words.len() {
            let (length, code) = ((words[at] >> 16) as usize, words[at] & 0xffff);
            let known = code != OP_CAPABILITY || CAPABILITIES.contains(&words[at + 1]);
            assert!(known, "{}: SPIR-V capability {}", shader.name, words[at + 1]);
            assert_ne!(code, OP_EXTENSION, "{}: a SPIR-V extension", shader.name);
            at += length.max(1);
        }
    }
}

#[test]
fn every_shader_is_valid_spirv() {
    if Command::new("spirv-val").arg("--version").output().is_err() {
        eprintln!("SKIPPED: spirv-val is not installed (Debian: spirv-tools); no shader was validated by it");
        return;
    }
    for shader in SHADERS {
        let file = Path::new(env!("OUT_DIR")).join(format!("{}.spv", shader.name));
        let run = Command::new("spirv-val").args(["--target-env", "vulkan1.1"]).arg(&file).output();
        let run = run.expect("spirv-val runs");
        assert!(run.status.success(), "{}: {}", shader.name, String::from_utf8_lossy(&run.stderr));
    }
}
