//! The C sample's generated headers are what their sources say.
//!
//! `BRICKGI_BLESS=1 cargo test --test c_sample_data` writes them anew.

mod common;

use common::{bless, repository};
use std::fmt::Write;
use std::fs;

/// Numbers as a C initialiser of floats.
fn floats(values: &[f32]) -> String {
    let values = values.iter().map(|value| format!("{value:?}f")).collect::<Vec<_>>();
    format!("{{{}}}", values.join(", "))
}

/// Cells in lines of at most `per_line`.
fn lines(cells: &[String], per_line: usize) -> String {
    cells.chunks(per_line).map(|line| format!("    {},\n", line.join(", "))).collect()
}

/// The scene's cameras, as `scene.json` has them.
fn cameras() -> String {
    let text = fs::read_to_string(repository().join("samples/scenes/cornell/scene.json")).expect("scene.json");
    let scene: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let camera = |camera: &serde_json::Value| {
        let number = |value: &serde_json::Value| format!("{:?}", value.as_f64().expect("a number"));
        let vector = |name: &str| {
            let cells = camera[name].as_array().expect("a vector").iter().map(number).collect::<Vec<_>>();
            format!("{{{}}}", cells.join(", "))
        };
        let [position, target, up] = ["position", "target", "up"].map(vector);
        let [fov, near] = ["vfov_deg", "near"].map(|name| number(&camera[name]));
        let name = camera["name"].as_str().expect("a name").as_bytes()[0] as char;
        format!("    {{'{name}', {position}, {target}, {up}, {fov}, {near}}},\n")
    };
    scene["cameras"].as_array().expect("cameras").iter().map(camera).collect()
}

fn mesh_header() -> String {
    let scene = repository().join("samples/scenes/cornell/cornell.glb");
    let gltf::Gltf { document, blob } = gltf::Gltf::open(scene).expect("a readable scene");
    let blob = blob.expect("a .glb with its one buffer inside");
    let (mut positions, mut indices, mut parts) = (Vec::new(), Vec::new(), String::new());
    for mesh in document.meshes() {
        for primitive in mesh.primitives() {
            let material = primitive.material();
            let reader = primitive.reader(|_| Some(&blob[..]));
            let (first_vertex, first_index) = (positions.len(), indices.len());
            positions.extend(reader.read_positions().expect("positions").map(|position| floats(&position)));
            let read = reader.read_indices().expect("indices").into_u32();
            indices.extend(read.map(|index| index.to_string()));
            let (vertex_count, index_count) = (positions.len() - first_vertex, indices.len() - first_index);
            let color = &material.pbr_metallic_roughness().base_color_factor()[..3];
            let strength = material.emissive_strength().unwrap_or(1.0);
            let emission = material.emissive_factor().map(|channel| channel * strength);
            let name = material.name().unwrap_or("unnamed");
            let ranges = format!("{first_vertex}, {vertex_count}, {first_index}, {index_count}");
            writeln!(parts, "    {{\"{name}\", {ranges}, {}, {}}},", floats(color), floats(&emission)).unwrap();
        }
    }
    format!(
        "/* Generated from samples/scenes/cornell by tests/c_sample_data.rs (BRICKGI_BLESS=1 writes it anew). */
#ifndef CORNELL_MESH_H
#define CORNELL_MESH_H

#include <stdint.h>

/* One material's triangles. Indices count from the part's first vertex. */
typedef struct CornellPart {{
    const char *material;
    uint32_t first_vertex, vertex_count, first_index, index_count;
    float base_color[3]; /* linear Rec.709 */
    float emission[3];   /* radiance of the front side */
}} CornellPart;

typedef struct CornellCamera {{
    char name;
    double position[3], target[3], up[3];
    double vertical_fov; /* degrees */
    double near_plane;   /* metres */
}} CornellCamera;

enum {{ CORNELL_VERTICES = {}, CORNELL_INDICES = {}, CORNELL_PARTS = {}, CORNELL_CAMERAS = {} }};

static const float cornell_positions[CORNELL_VERTICES][3] = {{
{}}};

static const uint32_t cornell_indices[CORNELL_INDICES] = {{
{}}};

static const CornellPart cornell_parts[CORNELL_PARTS] = {{
{parts}}};

static const CornellCamera cornell_cameras[CORNELL_CAMERAS] = {{
{}}};

#endif
",
        positions.len(),
        indices.len(),
        parts.lines().count(),
        cameras().lines().count(),
        lines(&positions, 4),
        lines(&indices, 24),
        cameras(),
    )
}

fn shader_header() -> String {
    use naga::back::spv;
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    let source = fs::read_to_string(repository().join("samples/c/gbuffer.wgsl")).expect("the shader");
    let module =
        naga::front::wgsl::parse_str(&source).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&source)));
    let info = Validator::new(ValidationFlags::all(), Capabilities::IMMEDIATES).validate(&module).expect("valid WGSL");
    let options = spv::Options { lang_version: (1, 3), flags: spv::WriterFlags::empty(), ..Default::default() };
    let words = spv::write_vec(&module, &info, &options, None).expect("SPIR-V");
    let cells = words.iter().map(|word| format!("{word:#010x}")).collect::<Vec<_>>();
    format!(
        "/* Generated from gbuffer.wgsl by tests/c_sample_data.rs (BRICKGI_BLESS=1 writes it anew). */
#ifndef GBUFFER_SPIRV_H
#define GBUFFER_SPIRV_H

#include <stdint.h>

/* Entry points: vertex_main, fragment_main. */
static const uint32_t gbuffer_spirv[{}] = {{
{}}};

#endif
",
        words.len(),
        lines(&cells, 9)
    )
}

#[test]
fn mesh_is_the_scenes() {
    bless("samples/c/cornell_mesh.h", &mesh_header());
}

#[test]
fn shader_is_the_sources() {
    bless("samples/c/gbuffer_spirv.h", &shader_header());
}
