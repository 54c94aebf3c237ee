//! The ABI: what C sees is what Rust has.

mod common;

use brickgi::capi::*;
use common::{installed, repository, run, scratch, shared_library};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::mem::{offset_of, size_of};
use std::process::Command;

/// The name of a field as the header has it.
fn camel_case(name: &str) -> String {
    let mut words = name.split('_');
    let first = words.next().unwrap_or_default().to_owned();
    words.fold(first, |name, word| name + &word[..1].to_uppercase() + &word[1..])
}

/// C assertions of a struct's size and of every field's offset and size. The pattern has no `..`: a field that is
/// forgotten here does not compile.
macro_rules! layout {
    ($out:ident: $($name:ident { $($field:ident),* $(,)? })*) => {$(
        let _ = |value: $name| { let $name { $($field: _),* } = value; };
        let name = stringify!($name);
        writeln!($out, "_Static_assert(sizeof({name}) == {}, \"{name}\");", size_of::<$name>()).unwrap();
        writeln!($out, "_Static_assert(_Alignof({name}) == {}, \"{name}\");", align_of::<$name>()).unwrap();
        $(
            let field = camel_case(stringify!($field));
            let (offset, size) = (offset_of!($name, $field), field_size(|value: &$name| &raw const value.$field));
            writeln!($out, "_Static_assert(offsetof({name}, {field}) == {offset}, \"{name}.{field}\");").unwrap();
            writeln!($out, "_Static_assert(sizeof((({name} *)0)->{field}) == {size}, \"{name}.{field}\");").unwrap();
        )*
    )*};
}

fn field_size<S, F>(_: impl Fn(&S) -> *const F) -> usize {
    size_of::<F>()
}

/// C assertions of constants.
macro_rules! constants {
    ($out:ident: $($name:ident)*) => {$(
        writeln!($out, "_Static_assert({0} == {1}, \"{0}\");", stringify!($name), $name).unwrap();
    )*};
}

#[test]
fn every_struct_lies_in_c_as_it_does_in_rust() {
    let mut text = String::from("#include <brickgi.h>\n");
    layout! { text:
        BgiDeviceQuery { s_type, p_next, get_instance_proc_addr, instance, physical_device }
        BgiDeviceRequirements { s_type, p_next, api_version, supported, missing_size, missing }
        BgiSettings {
            s_type, p_next, voxel_size, grid_offset, coverage_groups, voxelize_bricks_per_frame, memory_budget,
            light_faces_per_frame, bounce_rays, direct_samples, hit_model, probe_tile, temporal_frames, pixel_rays,
            voxelize_ms, region_culling, simplify_voxels, direct_lights, single_bounce, gather_interval,
            near_field, probes_per_frame,
        }
        BgiContextCreateInfo {
            s_type, p_next, abi_version, frames_in_flight, get_instance_proc_addr, instance, physical_device, device,
            settings, log, log_user_data, parallel_for, parallel_user_data,
        }
        BgiTexture { s_type, p_next, id, width, height, rgba8 }
        BgiMaterial { s_type, p_next, id, base_color, emission, has_base_color_texture, base_color_texture, transmittance, use_texture_alpha }
        BgiMesh { s_type, p_next, id, vertex_count, index_count, positions, uvs, indices }
        BgiVertexData { data, buffer, offset, stride, format }
        BgiIndexData { data, buffer, offset, index_type }
        BgiInstance { s_type, p_next, id, mesh, material, translation, linear }
        BgiMeshUpdate {
            s_type, p_next, removed_instances, removed_meshes, textures, materials, meshes, instances,
            removed_instance_count, removed_mesh_count, texture_count, material_count, mesh_count, instance_count,
        }
        BgiLight {
            s_type, p_next, light_type, direction, irradiance, intensity, position, radiance, range, inner_angle,
            outer_angle, radius, two_sided, half_axis_u, half_axis_v,
        }
        BgiLighting { s_type, p_next, lights, light_count, sky_radiance, sky }
        BgiShadowLayer { s_type, p_next, layer, x, y, width, height, position, view_rotation, projection }
        BgiShadowMap {
            s_type, p_next, light, width, height, layer_count, view, layers, reversed, range, depth_bias, normal_offset,
        }
        BgiSky { s_type, p_next, sky_type, zenith, horizon, ground, up, intensity, rotation }
        BgiSkyImage { s_type, p_next, layout, format, width, height, texels, texels_size }
        BgiViewCreateInfo { s_type, p_next, width, height }
        BgiCamera { s_type, p_next, position, view_rotation, projection }
        BgiDispatchInfo {
            s_type, p_next, command_buffer, view, depth, normal, output, output_format, clear_depth, x, y, width, height,
            debug_view, albedo, direct, composite, motion, motion_scale,
        }
        BgiPassTime { name, ms }
        BgiResourceSize { name, bytes }
        BgiStats {
            s_type, p_next, frame_ms, cpu_ms, world_bytes, view_bytes, rays, frames, bricks, bricks_missing,
            bricks_left_out, bricks_missing_in_view, bricks_voxelized, faces, faces_unreached, convergence, pages,
            meshes_pending, pass_count, resource_count, passes, resources, mesh_triangles, kept_triangles,
            probes_traced, probes_carried, probe_conflicts, probes_rejected,
        }
    }
    constants! { text: BGI_ABI_VERSION BGI_API_VERSION BGI_ERROR_INTERNAL BGI_STRUCTURE_TYPE_SHADOW_LAYER BGI_MAX_COUNT }
    let header = header();
    let structs = header.lines().filter(|line| line.starts_with("typedef struct") && line.ends_with('{')).count();
    assert_eq!(text.matches("_Alignof").count(), structs, "a struct of the header is not compared");
    let source = scratch("abi").join("layout.c");
    fs::write(&source, text).expect("source");
    for compiler in installed(&["gcc", "clang"]) {
        let include = repository().join("include");
        run(Command::new(compiler).args(["-std=c11", "-fsyntax-only", "-Werror", "-I"]).arg(include).arg(&source));
    }
}

#[test]
fn every_input_struct_has_a_type_of_its_own() {
    let header = header();
    let types = header.lines().filter_map(|line| line.strip_prefix("#define BGI_STRUCTURE_TYPE_"));
    let values = types.map(|line| line.split(' ').nth(1).expect("a value")).collect::<Vec<_>>();
    assert_eq!(values.iter().collect::<BTreeSet<_>>().len(), values.len());
    assert_eq!(values.len(), header.matches("\n    BgiStructureType sType;").count());
}

#[test]
#[cfg(target_os = "linux")]
fn library_exports_exactly_the_headers_functions() {
    let header = header();
    let word = |line: &str| Some(line.split_once('(')?.0.rsplit([' ', '*']).next()?.to_owned());
    let declared = header.lines().filter(|line| !line.starts_with(['/', ' ', '#', '}']));
    let declared = declared.filter_map(word).filter(|name| name.starts_with("bgi")).collect::<BTreeSet<_>>();
    let symbols = run(Command::new("nm").args(["-D", "--defined-only"]).arg(shared_library()));
    let exported = symbols.lines().filter_map(|line| line.split(' ').nth(2)).map(str::to_owned).collect();
    assert!(declared.len() > 10, "{declared:?}");
    assert_eq!(declared, exported);
}

#[test]
#[cfg(target_os = "linux")]
fn library_does_not_link_the_vulkan_loader() {
    let needed = run(Command::new("readelf").arg("-d").arg(shared_library()));
    assert!(!needed.contains("libvulkan"), "{needed}");
}

fn header() -> String {
    fs::read_to_string(repository().join("include/brickgi.h")).expect("the header")
}
