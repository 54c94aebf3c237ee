//! Compiles `shaders/passes/*.wgsl` to SPIR-V 1.3 (Vulkan 1.1) with naga and writes, from what naga reflects, the table
//! of pipelines (code, bindings by name, accesses) and the Rust twins of the structs and constants in
//! `shaders/shared`. One source for both sides: a layout cannot drift.

#[path = "build/reflect.rs"]
mod reflect;
#[path = "build/source.rs"]
mod source;

use naga::back::spv;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Text of a shader, and what replaces it.
type Change = (&'static str, &'static str);
/// Output and composite have 32 bits a channel.
const FLOAT32: Change = ("rgba16float", "rgba32float");
/// Pixels do not look for what is near.
const FAR: Change = ("const NEAR_FIELD: bool = true;", "const NEAR_FIELD: bool = false;");
/// The world has changed of late.
const WATCHING: Change = ("const WATCHES: bool = false;", "const WATCHES: bool = true;");
/// Probes for what those of the first layer do not stand for.
const SECOND_LAYER: Change = ("const ADAPTS: bool = false;", "const ADAPTS: bool = true;");
/// What rays find has not bounced before.
const ONCE: Change =
    ("e += hit_radiance(hit, direction);", "e += sent_directly(hit, start.xyz, direction, face.seed, index);");
/// There are lights with an extent.
const AREAS: Change = ("const AREAS: bool = false;", "const AREAS: bool = true;");
/// The host has shadow maps.
const MAPS: Change = ("let said = MAP_SILENT;", "let said = ask_map(light, p, normal);");

/// Pipelines made from another pass's source: (pass, new name, changes).
const PERMUTATIONS: &[(&str, &str, &[Change])] = &[
    ("resolve", "resolve_float32", &[FLOAT32]),
    ("resolve", "resolve_far", &[FAR]),
    ("resolve", "resolve_far_float32", &[FAR, FLOAT32]),
    ("resolve", "resolve_watching", &[WATCHING]),
    ("resolve", "resolve_watching_float32", &[WATCHING, FLOAT32]),
    ("resolve", "resolve_far_watching", &[FAR, WATCHING]),
    ("resolve", "resolve_far_watching_float32", &[FAR, WATCHING, FLOAT32]),
    ("probe_place", "probe_adapt", &[SECOND_LAYER]),
    ("disocclusion", "disocclusion_float32", &[FLOAT32]),
    ("debug_view", "debug_view_float32", &[FLOAT32]),
    ("composite", "composite_float32", &[FLOAT32]),
    ("light_bounce", "light_bounce_once", &[AREAS, ONCE]),
    ("light_direct", "light_direct_areas", &[AREAS]),
    ("light_direct", "light_direct_maps", &[AREAS, MAPS]),
    ("light_direct_many", "light_direct_many_areas", &[AREAS]),
    ("light_direct_many", "light_direct_many_maps", &[AREAS, MAPS]),
];

fn main() {
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("shaders");
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets it"));
    println!("cargo::rerun-if-changed=shaders");
    println!("cargo::rerun-if-changed=build");

    let mut types = reflect::Types::default();
    write_table("SHADERS", &root.join("passes"), &root, &out, &mut types);
    // Shaders that only unit tests run: a table of their own, which the product does not hold.
    let mut test_types = reflect::Types::default();
    write_table("TEST_SHADERS", &root.join("tests"), &root, &out, &mut test_types);
    std::fs::write(out.join("test_shared.rs"), test_types.without(&types).finish()).expect("OUT_DIR is writable");
    std::fs::write(out.join("shared.rs"), types.finish()).expect("OUT_DIR is writable");
}

/// Compiles a folder and writes its table, `<name in lower case>.rs`.
fn write_table(name: &str, folder: &Path, root: &Path, out: &Path, types: &mut reflect::Types) {
    let mut passes: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("the folder exists")
        .map(|entry| entry.expect("readable").path())
        .filter(|path| path.extension().is_some_and(|e| e == "wgsl"))
        .collect();
    passes.sort();

    let mut table = format!("/// Every pipeline, by name.\npub static {name}: &[Shader] = &[\n");
    for path in &passes {
        let pass = path.file_stem().expect("a file").to_str().expect("ascii").to_owned();
        let text = source::load(root, path);
        compile(&pass, &text, path, out, &mut table, types);
        for (_, permuted, changes) in PERMUTATIONS.iter().filter(|p| p.0 == pass) {
            let text = changes.iter().fold(text.clone(), |text, (from, to)| {
                assert!(text.contains(from), "{pass} has no `{from}`");
                text.replace(from, to)
            });
            compile(permuted, &text, path, out, &mut table, types);
        }
    }
    table.push_str("];\n");
    std::fs::write(out.join(format!("{}.rs", name.to_lowercase())), table).expect("OUT_DIR is writable");
}

fn compile(name: &str, text: &str, path: &Path, out: &Path, table: &mut String, types: &mut reflect::Types) {
    let module = naga::front::wgsl::parse_str(text)
        .unwrap_or_else(|e| panic!("{}\n{}", path.display(), e.emit_to_string_with_path(text, name)));
    let info =
        Validator::new(ValidationFlags::all(), Capabilities::IMMEDIATES | Capabilities::SHADER_FLOAT16_IN_FLOAT32)
            .validate(&module)
            .unwrap_or_else(|e| panic!("{}\n{}", path.display(), e.emit_to_string_with_path(text, name)));
    let unchecked = naga::proc::BoundsCheckPolicy::Unchecked;
    let options = spv::Options {
        lang_version: (1, 3),
        flags: spv::WriterFlags::empty(),
        fake_missing_bindings: false,
        // What wgpu turns on for untrusted code: our indices are in range by construction.
        bounds_check_policies: naga::proc::BoundsCheckPolicies {
            index: unchecked,
            buffer: unchecked,
            image_load: unchecked,
            binding_array: unchecked,
        },
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
        force_loop_bounding: false,
        emit_int_div_checks: false,
        binding_map: reflect::binding_map(&module),
        ..Default::default()
    };
    let pipeline = spv::PipelineOptions { shader_stage: naga::ShaderStage::Compute, entry_point: "main".to_owned() };
    let words = spv::write_vec(&module, &info, &options, Some(&pipeline)).expect("naga writes SPIR-V");
    let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
    std::fs::write(out.join(format!("{name}.spv")), bytes).expect("OUT_DIR is writable");

    types.add_module(&module, name);
    let entry = &module.entry_points[0];
    writeln!(
        table,
        "    Shader {{ name: {name:?}, spirv: include_spirv!(\"{name}.spv\"), workgroup: {:?}, push_bytes: {}, \
         shared_bytes: {}, bindings: &[{}] }},",
        entry.workgroup_size,
        reflect::push_bytes(&module),
        reflect::shared_bytes(&module),
        reflect::bindings(&module, &info),
    )
    .expect("a string takes it");
}
