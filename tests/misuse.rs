//! Misuse through the C ABI, on a real device: a code and words for each, and the process goes on.

#[macro_use]
#[path = "common/bench.rs"]
mod bench;
#[path = "common/vulkan.rs"]
mod vulkan;

use ash::vk;
use ash::vk::Handle;
use bench::*;
use brickgi::capi::*;
use std::ffi::{CStr, c_char, c_void};
use std::ptr::{null, null_mut, without_provenance, without_provenance_mut};

/// An address that is not NULL and not aligned to anything; refused before it is read.
fn odd<T>() -> *const T {
    without_provenance(0x1001)
}

/// What a pNext chain might lead to.
const CHAIN: *const c_void = without_provenance(0x1000);

const ARGUMENT: BgiResult = BGI_ERROR_INVALID_ARGUMENT;
const HANDLE: BgiResult = BGI_ERROR_INVALID_HANDLE;
const STRUCTURE: BgiResult = BGI_ERROR_INVALID_STRUCTURE;

#[test]
fn bad_pointers_structs_and_counts_are_refused() {
    // SAFETY, for every block in this table: misuse that the header says is survived.
    Bench::new().expect(&[
        ("create: NULL info", ARGUMENT, "null", |_| unsafe { bgiCreateContext(null(), &mut null_mut()) }),
        ("create: NULL result", ARGUMENT, "null", |b| unsafe { bgiCreateContext(&b.create_info(), null_mut()) }),
        ("create: sType", STRUCTURE, "stype", |b| b.create(|info| info.s_type = BGI_STRUCTURE_TYPE_MESH)),
        ("create: pNext", STRUCTURE, "pnext", |b| b.create(|info| info.p_next = CHAIN)),
        ("create: ABI", BGI_ERROR_INCOMPATIBLE_ABI, "abi", |b| b.create(|info| info.abi_version = 0)),
        ("create: loader", ARGUMENT, "getinstanceprocaddr", |b| b.create(|info| info.get_instance_proc_addr = None)),
        ("create: instance", ARGUMENT, "instance", |b| b.create(|info| info.instance = vk::Instance::null())),
        ("create: device", ARGUMENT, "device", |b| b.create(|info| info.device = vk::Device::null())),
        ("create: physical", ARGUMENT, "physicaldevice", |b| {
            b.create(|info| info.physical_device = vk::PhysicalDevice::null())
        }),
        ("settings: NULL", ARGUMENT, "null", |_| unsafe { bgiGetDefaultSettings(BGI_PRESET_LOW, null_mut()) }),
        ("settings: preset", ARGUMENT, "preset", |_| unsafe { bgiGetDefaultSettings(9, &mut settings()) }),
        ("settings: sType", STRUCTURE, "stype", |_| unsafe { bgiGetDefaultSettings(0, &mut zeroed()) }),
        ("settings: sType in create", STRUCTURE, "stype", |b| b.create_with(|settings| settings.s_type = 0)),
        ("settings: voxel size", ARGUMENT, "voxel", |b| b.create_with(|settings| settings.voxel_size = 0.0)),
        ("settings: NaN", ARGUMENT, "voxel", |b| b.create_with(|settings| settings.voxel_size = f32::NAN)),
        ("settings: coverage", ARGUMENT, "coverage", |b| b.create_with(|settings| settings.coverage_groups[1] = 3)),
        ("settings: no room for bricks", BGI_ERROR_OUT_OF_MEMORY, "memory_budget", |b| {
            b.create_with(|settings| (settings.memory_budget, settings.coverage_groups) = (1 << 20, [64; 3]))
        }),
        ("settings: region culling", ARGUMENT, "regionculling", |b| {
            b.create_with(|settings| settings.region_culling = 2)
        }),
        ("settings: probes a frame", ARGUMENT, "probes_per_frame", |b| {
            b.create_with(|settings| settings.probes_per_frame = (1 << 20) + 1)
        }),
        ("settings: interval", ARGUMENT, "gather_interval", |b| b.create_with(|settings| settings.gather_interval = 3)),
        ("settings: near field", ARGUMENT, "nearfield", |b| b.create_with(|settings| settings.near_field = 2)),
        ("settings: hit model", ARGUMENT, "hitmodel", |b| b.create_with(|settings| settings.hit_model = 7)),
        ("requirements: NULL", ARGUMENT, "null", |b| unsafe { bgiGetDeviceRequirements(&b.query(), null_mut()) }),
        ("requirements: sType", STRUCTURE, "stype", |b| unsafe { bgiGetDeviceRequirements(&b.query(), &mut zeroed()) }),
        ("update: NULL", ARGUMENT, "null", |b| unsafe { bgiUpdateMeshes(b.context, null()) }),
        ("update: misaligned", ARGUMENT, "misaligned", |b| unsafe { bgiUpdateMeshes(b.context, odd()) }),
        ("update: sType", STRUCTURE, "stype", |b| b.update(|update| update.s_type = 0)),
        ("update: count without array", ARGUMENT, "instances", |b| b.update(|update| update.instance_count = 1)),
        ("update: count", ARGUMENT, "removedmeshes", |b| {
            b.update(|update| (update.removed_meshes, update.removed_mesh_count) = (&7, u32::MAX))
        }),
        ("mesh: sType", STRUCTURE, "meshes[0]", |b| b.update_mesh(|mesh| mesh.s_type = 0)),
        ("mesh: pNext", STRUCTURE, "pnext", |b| b.update_mesh(|mesh| mesh.p_next = CHAIN)),
        ("mesh: positions", ARGUMENT, "meshes[0].positions.data is null", |b| {
            b.update_mesh(|mesh| mesh.positions.data = null())
        }),
        ("mesh: misaligned", ARGUMENT, "meshes[0].positions is misaligned: 4 bytes", |b| {
            b.update_mesh(|mesh| mesh.positions.data = odd())
        }),
        ("mesh: misaligned offset", ARGUMENT, "meshes[0].positions is misaligned: 4 bytes", |b| {
            b.update_mesh(|mesh| mesh.positions.offset = 2)
        }),
        ("mesh: endless offset", ARGUMENT, "meshes[0].positions: 36 bytes from offset", |b| {
            b.update_mesh(|mesh| mesh.positions.offset = u64::MAX)
        }),
        ("mesh: format", ARGUMENT, "meshes[0].positions.format: 0 is no bgi_vertex_format_*", |b| {
            b.update_mesh(|mesh| mesh.positions.format = 0)
        }),
        ("mesh: a VkFormat", ARGUMENT, "meshes[0].uvs.format: 106 is no bgi_vertex_format_*", |b| {
            b.update_mesh(|mesh| mesh.uvs = BgiVertexData { format: 106, ..mesh.positions })
        }),
        ("mesh: short stride", ARGUMENT, "meshes[0].positions.stride is 8; an element has 12 bytes", |b| {
            b.update_mesh(|mesh| mesh.positions.stride = 8)
        }),
        ("mesh: uneven stride", ARGUMENT, "meshes[0].uvs.stride is 10; it must be a multiple of 4", |b| {
            b.update_mesh(|mesh| mesh.uvs = BgiVertexData { stride: 10, ..mesh.positions })
        }),
        ("mesh: vertex count", ARGUMENT, "meshes[0].vertexcount is 4294967295; 1 to 67108864", |b| {
            b.update_mesh(|mesh| mesh.vertex_count = u32::MAX)
        }),
        ("mesh: no vertices", ARGUMENT, "meshes[0].vertexcount is 0", |b| b.update_mesh(|mesh| mesh.vertex_count = 0)),
        ("mesh: no indices", ARGUMENT, "meshes[0].indexcount is 0", |b| b.update_mesh(|mesh| mesh.index_count = 0)),
        ("mesh: indices", ARGUMENT, "meshes[0].indices.data is null", |b| {
            b.update_mesh(|mesh| mesh.indices.data = null())
        }),
        ("mesh: misaligned indices", ARGUMENT, "meshes[0].indices is misaligned: 4 bytes", |b| {
            b.update_mesh(|mesh| mesh.indices.offset = 2)
        }),
        ("mesh: a VkIndexType", ARGUMENT, "meshes[0].indices.indextype: 1 is no bgi_index_type_*", |b| {
            b.update_mesh(|mesh| mesh.indices.index_type = 1)
        }),
        ("material: flag", ARGUMENT, "hasbasecolortexture", |b| b.update_material(|m| m.has_base_color_texture = 2)),
        ("texture: size", ARGUMENT, "textures[0]", |b| b.update_texture(|texture| texture.width = 1 << 20)),
        ("texture: texels", ARGUMENT, "rgba8", |b| b.update_texture(|texture| texture.rgba8 = null())),
        ("light: type", ARGUMENT, "lighttype", |b| b.light(|light| light.light_type = 0)),
        ("light: sType", STRUCTURE, "lights[0]", |b| b.light(|light| light.s_type = 0)),
        ("view: NULL result", ARGUMENT, "null", |b| unsafe { bgiCreateView(b.context, &view_info(), null_mut()) }),
        ("view: sType", STRUCTURE, "stype", |b| b.view(|info| info.s_type = 0)),
        ("camera: sType", STRUCTURE, "stype", |b| b.camera(|camera| camera.s_type = 0)),
        ("dispatch: sType", STRUCTURE, "stype", |b| b.dispatch(|info| info.s_type = 0)),
        ("dispatch: format", ARGUMENT, "outputformat", |b| {
            b.dispatch(|info| info.output_format = vk::Format::R8G8B8A8_UNORM)
        }),
        ("dispatch: debug view", ARGUMENT, "debugview", |b| b.dispatch(|info| info.debug_view = 11)),
        ("dispatch: half a composite", ARGUMENT, "albedo, direct and composite", |b| {
            b.dispatch(|info| info.albedo = vk::ImageView::from_raw(4))
        }),
        ("dispatch: composite into the output", ARGUMENT, "composite is output's", |b| {
            b.dispatch(|info| {
                [info.albedo, info.direct] = [4, 5].map(vk::ImageView::from_raw);
                info.composite = info.output;
            })
        }),
        ("dispatch: motion without a scale", ARGUMENT, "motionscale is [0.0, 0.0]", |b| {
            b.dispatch(|info| info.motion = vk::ImageView::from_raw(4))
        }),
        ("dispatch: motion with half a scale", ARGUMENT, "motionscale is [1.0, 0.0]", |b| {
            b.dispatch(|info| (info.motion, info.motion_scale) = (vk::ImageView::from_raw(4), [1.0, 0.0]))
        }),
        ("dispatch: motion with NaN", ARGUMENT, "motionscale is [nan, 1.0]", |b| {
            b.dispatch(|info| (info.motion, info.motion_scale) = (vk::ImageView::from_raw(4), [f32::NAN, 1.0]))
        }),
        ("dispatch: NaN", ARGUMENT, "cleardepth", |b| b.dispatch(|info| info.clear_depth = f32::NAN)),
        ("stats: NULL", ARGUMENT, "null", |b| unsafe { bgiGetStats(b.context, null_mut()) }),
        ("stats: sType", STRUCTURE, "stype", |b| b.stats(|stats| stats.s_type = 0)),
        ("stats: misaligned", ARGUMENT, "passes", |b| b.stats(|stats| stats.passes = odd::<BgiPassTime>().cast_mut())),
    ]);
}

#[test]
fn bad_ranges_orders_and_ids_are_refused() {
    const UNKNOWN: BgiResult = BGI_ERROR_UNKNOWN_ID;
    Bench::new().expect(&[
        ("create: frames", ARGUMENT, "frames", |b| b.create(|info| info.frames_in_flight = 0)),
        ("create: frames", ARGUMENT, "frames", |b| b.create(|info| info.frames_in_flight = 9)),
        ("mesh: NaN", ARGUMENT, "mesh 1: a position is not finite", |b| {
            b.update_mesh(|mesh| mesh.positions = floats(&[f32::NAN; 9]))
        }),
        ("mesh: infinite half", ARGUMENT, "mesh 1: a position is not finite", |b| {
            b.update_mesh(|mesh| mesh.positions = halves(&[0x7c00; 9]))
        }),
        ("mesh: infinite uv", ARGUMENT, "mesh 1: a texture coordinate is not finite", |b| {
            b.update_mesh(|mesh| mesh.uvs = floats(&[f32::INFINITY; 6]))
        }),
        ("mesh: index", ARGUMENT, "mesh 1: an index is out of range", |b| {
            b.update_mesh(|mesh| mesh.indices = indices(&[0, 1, 3]))
        }),
        ("mesh: short index", ARGUMENT, "mesh 1: an index is out of range", |b| {
            b.update_mesh(|mesh| mesh.indices = short_indices(&[0, 1, 3]))
        }),
        ("mesh: not triangles", ARGUMENT, "mesh 1", |b| b.update_mesh(|mesh| mesh.index_count = 2)),
        ("instance: NaN", ARGUMENT, "instance", |b| b.update_instance(|i| i.linear[1][1] = f32::NAN)),
        ("instance: infinite", ARGUMENT, "instance", |b| b.update_instance(|i| i.translation[0] = f64::INFINITY)),
        ("instance: mesh", UNKNOWN, "mesh 77", |b| b.update_instance(|instance| instance.mesh = 77)),
        ("instance: material", UNKNOWN, "material 77", |b| b.update_instance(|instance| instance.material = 77)),
        ("removed instance", UNKNOWN, "instance 77", |b| {
            b.update(|update| (update.removed_instances, update.removed_instance_count) = (&77, 1))
        }),
        ("removed mesh", UNKNOWN, "mesh 77", |b| {
            b.update(|update| (update.removed_meshes, update.removed_mesh_count) = (&77, 1))
        }),
        ("material: alpha flag", ARGUMENT, "usetexturealpha", |b| b.update_material(|m| m.use_texture_alpha = 2)),
        ("material: transmittance", ARGUMENT, "transmittance", |b| b.update_material(|m| m.transmittance = 1.5)),
        ("material: transmittance NaN", ARGUMENT, "transmittance", |b| {
            b.update_material(|m| m.transmittance = f32::NAN)
        }),
        ("material: NaN", ARGUMENT, "material", |b| b.update_material(|m| m.emission[0] = f32::NAN)),
        ("material: texture", UNKNOWN, "texture 77", |b| {
            b.update_material(|m| (m.has_base_color_texture, m.base_color_texture) = (1, 77))
        }),
        ("texture: zero size", ARGUMENT, "texture", |b| b.update_texture(|texture| texture.height = 0)),
        ("light: NaN", ARGUMENT, "light", |b| b.light(|light| light.irradiance[2] = f32::NAN)),
        ("light: direction", ARGUMENT, "light", |b| b.light(|light| light.direction = [0.0; 3])),
        ("light: type", ARGUMENT, "lights[0].lighttype", |b| b.light(|light| light.light_type = 6)),
        ("point: position", ARGUMENT, "lights[0]: position", |b| {
            b.light(|light| (light.light_type, light.position[1]) = (BGI_LIGHT_TYPE_POINT, f64::INFINITY))
        }),
        ("point: range", ARGUMENT, "lights[0]: range", |b| {
            b.light(|light| (light.light_type, light.range) = (BGI_LIGHT_TYPE_POINT, -1.0))
        }),
        ("spot: no angle", ARGUMENT, "lights[0]: the outer angle", |b| {
            b.light(|light| light.light_type = BGI_LIGHT_TYPE_SPOT)
        }),
        ("spot: behind", ARGUMENT, "lights[0]: the outer angle", |b| {
            b.light(|light| (light.light_type, light.outer_angle) = (BGI_LIGHT_TYPE_SPOT, 1.6))
        }),
        ("spot: angles", ARGUMENT, "lights[0]: the inner angle", |b| {
            b.light(|light| (light.light_type, light.outer_angle, light.inner_angle) = (BGI_LIGHT_TYPE_SPOT, 0.5, 0.6))
        }),
        ("spot: direction", ARGUMENT, "lights[0]: direction", |b| {
            b.light(|light| {
                (light.light_type, light.outer_angle, light.direction) = (BGI_LIGHT_TYPE_SPOT, 0.5, [f32::NAN; 3])
            })
        }),
        ("sphere: radius", ARGUMENT, "lights[0]: radius", |b| {
            b.light(|light| (light.light_type, light.radius) = (BGI_LIGHT_TYPE_SPHERE, 0.0))
        }),
        ("sphere: radiance", ARGUMENT, "lights[0]: radiance", |b| {
            b.light(|light| (light.light_type, light.radius, light.radiance) = (BGI_LIGHT_TYPE_SPHERE, 1.0, [-1.0; 3]))
        }),
        ("rectangle: axis", ARGUMENT, "lights[0]: a half axis", |b| {
            b.light(|light| (light.light_type, light.half_axis_u) = (BGI_LIGHT_TYPE_RECTANGLE, [1.0; 3]))
        }),
        ("rectangle: askew", ARGUMENT, "lights[0]: the half axes", |b| {
            b.light(|light| {
                light.light_type = BGI_LIGHT_TYPE_RECTANGLE;
                (light.half_axis_u, light.half_axis_v) = ([1.0, 0.0, 0.0], [1.0, 1.0, 0.0]);
            })
        }),
        ("rectangle: sides", ARGUMENT, "lights[0].twosided", |b| {
            b.light(|light| (light.light_type, light.two_sided) = (BGI_LIGHT_TYPE_RECTANGLE, 2))
        }),
        ("light: negative sky", ARGUMENT, "sky", |b| b.lighting(|lighting| lighting.sky_radiance[0] = -1.0)),
        ("sky: type", ARGUMENT, "sky.skytype", |b| b.sky(|sky| sky.sky_type = 3)),
        ("sky: struct", STRUCTURE, "bgisky.stype", |b| b.sky(|sky| sky.s_type = BGI_STRUCTURE_TYPE_LIGHT)),
        ("sky: NaN", ARGUMENT, "sky: horizon", |b| b.sky(|sky| sky.horizon[1] = f32::NAN)),
        ("sky: up", ARGUMENT, "sky: up", |b| b.sky(|sky| sky.up = [0.0; 3])),
        ("sky: no image", ARGUMENT, "sky: no image", |b| b.sky(|sky| sky.sky_type = BGI_SKY_TYPE_IMAGE)),
        ("sky: rotation", ARGUMENT, "sky: rotation", |b| {
            b.sky(|sky| (sky.sky_type, sky.rotation[0][0]) = (BGI_SKY_TYPE_IMAGE, 1.0))
        }),
        ("sky image: layout", ARGUMENT, "layout", |b| b.sky_image(|image| image.layout = 0)),
        ("sky image: format", ARGUMENT, "format", |b| b.sky_image(|image| image.format = vk::Format::R8G8B8A8_SRGB)),
        ("sky image: zero", ARGUMENT, "sky image: sides", |b| {
            b.sky_image(|image| (image.width, image.height, image.texels_size) = (0, 0, 0))
        }),
        ("sky image: faces", ARGUMENT, "square", |b| b.sky_image(|image| image.height = 3)),
        ("sky image: size", ARGUMENT, "96 bytes of texels", |b| b.sky_image(|image| image.texels_size = 92)),
        ("sky image: NULL", ARGUMENT, "texels", |b| b.sky_image(|image| image.texels = null())),
        ("view: zero", ARGUMENT, "view", |b| b.view(|info| info.width = 0)),
        ("view: huge", ARGUMENT, "view", |b| b.view(|info| info.height = 20_000)),
        ("dispatch before camera", ARGUMENT, "camera", |b| b.dispatch(|_| ())),
        ("camera: NaN", ARGUMENT, "camera", |b| b.camera(|camera| camera.position[1] = f64::NAN)),
        ("camera: projection", ARGUMENT, "projection", |b| b.camera(|camera| camera.projection = [[0.0; 4]; 4])),
        ("dispatch: commands", ARGUMENT, "command", |b| {
            b.dispatch(|info| info.command_buffer = vk::CommandBuffer::null())
        }),
        ("dispatch: image", ARGUMENT, "depth", |b| b.dispatch(|info| info.depth = vk::ImageView::null())),
        ("dispatch: zero size", ARGUMENT, "width", |b| b.dispatch(|info| info.width = 0)),
        ("dispatch: over the view", ARGUMENT, "width", |b| b.dispatch(|info| info.width = 17)),
        ("dispatch: beyond all images", ARGUMENT, "begins at [0, 16384]", |b| b.dispatch(|info| info.y = 16_384)),
    ]);
}

#[test]
fn bad_shadow_maps_are_refused() {
    let bench = Bench::new();
    assert_eq!(bench.shadow_maps(|_, _| ()), BGI_SUCCESS, "{}", last_error(bench.context));
    let whole =
        |_: &mut [BgiShadowMap; 2], layers: &mut [BgiShadowLayer; 2]| (layers[1].width, layers[1].height) = (64, 32);
    assert_eq!(bench.shadow_maps(whole), BGI_SUCCESS, "{}", last_error(bench.context));
    // SAFETY, for every block in this table: misuse that the header says is survived.
    bench.expect(&[
        ("NULL", ARGUMENT, "maps is null", |b| unsafe { bgiSetShadowMaps(b.context, 1, null()) }),
        ("count", ARGUMENT, "maps: 4294967295 elements", |b| unsafe {
            bgiSetShadowMaps(b.context, u32::MAX, without_provenance(0x1000))
        }),
        ("sType", STRUCTURE, "maps[1].stype", |b| b.shadow_maps(|maps, _| maps[1].s_type = 0)),
        ("pNext", STRUCTURE, "maps[0].pnext", |b| b.shadow_maps(|maps, _| maps[0].p_next = CHAIN)),
        ("layers: NULL", ARGUMENT, "maps[1].layers is null", |b| b.shadow_maps(|maps, _| maps[1].layers = null())),
        ("layers: sType", STRUCTURE, "maps[0].layers[0].stype", |b| b.shadow_maps(|_, layers| layers[0].s_type = 0)),
        ("no layers", ARGUMENT, "maps[0]: layers", |b| b.shadow_maps(|maps, _| maps[0].layer_count = 0)),
        ("seven layers", ARGUMENT, "maps[0]: layers", |b| {
            let layers = [structure! { BgiShadowLayer, BGI_STRUCTURE_TYPE_SHADOW_LAYER, }; 7];
            b.shadow_maps(|maps, _| (maps[0].layers, maps[0].layer_count) = (layers.as_ptr(), 7))
        }),
        ("view", ARGUMENT, "maps[1]: view", |b| b.shadow_maps(|maps, _| maps[1].view = vk::ImageView::null())),
        ("no such light", ARGUMENT, "maps[1]: light: there is none", |b| b.shadow_maps(|maps, _| maps[1].light = 5)),
        ("sphere", ARGUMENT, "maps[0]: light: spheres", |b| b.shadow_maps(|maps, _| maps[0].light = 3)),
        ("rectangle", ARGUMENT, "maps[0]: light: spheres", |b| b.shadow_maps(|maps, _| maps[0].light = 4)),
        ("light twice", ARGUMENT, "maps[1]: light 0 has a map", |b| b.shadow_maps(|maps, _| maps[1].light = 0)),
        ("no width", ARGUMENT, "maps[0]: width and height", |b| b.shadow_maps(|maps, _| maps[0].width = 0)),
        ("height", ARGUMENT, "maps[0]: width and height", |b| b.shadow_maps(|maps, _| maps[0].height = 16_385)),
        ("reversed", ARGUMENT, "maps[1].reversed is 2", |b| b.shadow_maps(|maps, _| maps[1].reversed = 2)),
        ("range", ARGUMENT, "maps[1]: range", |b| b.shadow_maps(|maps, _| maps[1].range = -1.0)),
        ("range of the sun", ARGUMENT, "maps[0]: range", |b| b.shadow_maps(|maps, _| maps[0].range = 1.0)),
        ("depth bias", ARGUMENT, "maps[0]: depth bias", |b| b.shadow_maps(|maps, _| maps[0].depth_bias = f32::NAN)),
        ("normal offset", ARGUMENT, "maps[0]: normal offset", |b| {
            b.shadow_maps(|maps, _| maps[0].normal_offset = -0.1)
        }),
        ("infinite offset", ARGUMENT, "maps[0]: normal offset", |b| {
            b.shadow_maps(|maps, _| maps[0].normal_offset = f32::INFINITY)
        }),
        ("matrix", ARGUMENT, "maps[1].layers[0]: a value", |b| {
            b.shadow_maps(|_, layers| layers[1].projection[2][3] = f32::NAN)
        }),
        ("flat matrix", ARGUMENT, "maps[1].layers[0]: projection", |b| {
            b.shadow_maps(|_, layers| layers[1].projection[2] = [0.0; 4])
        }),
        ("rotation", ARGUMENT, "maps[0].layers[0]: view_rotation", |b| {
            b.shadow_maps(|_, layers| layers[0].view_rotation = [[0.0; 3]; 3])
        }),
        ("position", ARGUMENT, "maps[0].layers[0]: a value", |b| {
            b.shadow_maps(|_, layers| layers[0].position[1] = f64::INFINITY)
        }),
        ("layer", ARGUMENT, "maps[0].layers[0]: layer", |b| b.shadow_maps(|_, layers| layers[0].layer = 2048)),
        ("rectangle: no height", ARGUMENT, "maps[0].layers[0]: rectangle", |b| {
            b.shadow_maps(|_, layers| layers[0].width = 64)
        }),
        ("rectangle: outside", ARGUMENT, "maps[0].layers[0]: rectangle", |b| {
            b.shadow_maps(|_, layers| (layers[0].x, layers[0].width, layers[0].height) = (u32::MAX, 1, 1))
        }),
    ]);
}

/// 64 layers of four views will do.
#[test]
fn too_many_shadow_maps_are_refused() {
    let bench = Bench::new();
    let light = structure! { BgiLight, BGI_STRUCTURE_TYPE_LIGHT, light_type: BGI_LIGHT_TYPE_POINT, };
    let lights = [light; 20];
    let result = bench.lighting(|lighting| (lighting.lights, lighting.light_count) = (lights.as_ptr(), 20));
    assert_eq!(result, BGI_SUCCESS);
    let mut layer = structure! { BgiShadowLayer, BGI_STRUCTURE_TYPE_SHADOW_LAYER, };
    (0..4).for_each(|i| layer.projection[i][i] = 1.0);
    (0..3).for_each(|i| layer.view_rotation[i][i] = 1.0);
    let layers = [layer; 6];
    let set = |layer_counts: &[u32], views: u64| {
        let map = |(light, count): (u32, &u32)| {
            structure! { BgiShadowMap, BGI_STRUCTURE_TYPE_SHADOW_MAP,
                light: light, width: 8, height: 8, layer_count: *count, layers: layers.as_ptr(),
                view: vk::ImageView::from_raw(1 + u64::from(light) % views),
            }
        };
        let maps: Vec<_> = (0..).zip(layer_counts).map(map).collect();
        // SAFETY: as the header says; nothing is dispatched.
        let result = unsafe { bgiSetShadowMaps(bench.context, maps.len() as u32, maps.as_ptr()) };
        (result, last_error(bench.context))
    };
    let most = [6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 4];
    assert_eq!(set(&most, 4).0, BGI_SUCCESS);
    assert_eq!(set(&[], 1).0, BGI_SUCCESS);
    let (result, text) = set(&[&most[..], &[1]].concat(), 4);
    assert!(result == ARGUMENT && text.contains("maps: more than 64 layers"), "{text}");
    let (result, text) = set(&most[..5], 5);
    assert!(result == ARGUMENT && text.contains("maps: more than 4 different views"), "{text}");
}

#[test]
fn bad_buffers_of_meshes_are_refused() {
    Bench::new().expect(&[
        ("both", ARGUMENT, "meshes[0].positions: a mesh lies in host memory or in buffers", |b| {
            b.update_buffer_mesh(|mesh, _| mesh.positions.data = bench::mesh().positions.data)
        }),
        ("mixed", ARGUMENT, "meshes[0].indices: a mesh lies in host memory or in buffers", |b| {
            b.update_buffer_mesh(|mesh, _| mesh.indices = bench::mesh().indices)
        }),
        ("mixed the other way", ARGUMENT, "meshes[0].uvs: a mesh lies in host memory or in buffers", |b| {
            b.update_buffer_mesh(|mesh, _| {
                mesh.uvs = mesh.positions;
                (mesh.positions, mesh.indices) = (bench::mesh().positions, bench::mesh().indices);
            })
        }),
        ("no indices", ARGUMENT, "mesh 1: indices.buffer is vk_null_handle", |b| {
            b.update_buffer_mesh(|mesh, _| mesh.indices.buffer = vk::Buffer::null())
        }),
        ("format", ARGUMENT, "meshes[0].positions.format: 97 is no bgi_vertex_format_*", |b| {
            b.update_buffer_mesh(|mesh, _| mesh.positions.format = 97)
        }),
        ("index type", ARGUMENT, "meshes[0].indices.indextype: 0 is no bgi_index_type_*", |b| {
            b.update_buffer_mesh(|mesh, _| mesh.indices.index_type = 0)
        }),
        ("stride", ARGUMENT, "mesh 1: positions.stride is 8; an element has 12 bytes", |b| {
            b.update_buffer_mesh(|mesh, _| mesh.positions.stride = 8)
        }),
        ("offset", ARGUMENT, "mesh 1: positions.offset is 2; it must be a multiple of 4", |b| {
            b.update_buffer_mesh(|mesh, _| mesh.positions.offset = 2)
        }),
        ("beyond the end", ARGUMENT, "mesh 1: indices: 12 bytes from offset 1048576 on; the buffer has ", |b| {
            b.update_buffer_mesh(|mesh, _| mesh.indices.offset = 1 << 20)
        }),
        ("strides beyond the end", ARGUMENT, "mesh 1: uvs: 2097160 bytes from offset 0 on; the buffer has ", |b| {
            b.update_buffer_mesh(|mesh, _| mesh.uvs = BgiVertexData { stride: 1 << 20, ..mesh.positions })
        }),
        ("endless offset", ARGUMENT, "mesh 1: positions: 36 bytes from offset 18446744073709551612 on", |b| {
            b.update_buffer_mesh(|mesh, _| mesh.positions.offset = u64::MAX - 3)
        }),
        ("no vertices", ARGUMENT, "meshes[0].vertexcount is 0", |b| {
            b.update_buffer_mesh(|mesh, _| mesh.vertex_count = 0)
        }),
        ("not triangles", ARGUMENT, "mesh 1: indices must be three per triangle", |b| {
            b.update_buffer_mesh(|mesh, _| mesh.index_count = 2)
        }),
        ("twice", ARGUMENT, "mesh 1 is given twice, in host memory and in buffers", |b| {
            b.update_buffer_mesh(|_, other| *other = bench::mesh())
        }),
        ("removed before it is there", BGI_ERROR_UNKNOWN_ID, "mesh 1", |b| {
            b.update(|update| (update.removed_meshes, update.removed_mesh_count) = (&1, 1))
        }),
    ]);
}

#[test]
fn bad_handles_are_refused() {
    // SAFETY, for every block in this table: misuse that the header says is survived.
    Bench::new().expect(&[
        ("NULL", HANDLE, "context", |_| unsafe { bgiDestroyContext(null_mut()) }),
        ("made up", HANDLE, "context", |_| unsafe { bgiDestroyContext(without_provenance_mut(0x40)) }),
        ("an address", HANDLE, "context", |b| unsafe { bgiDestroyContext((&raw const *b).cast_mut().cast()) }),
        ("a view as a context", HANDLE, "context", |b| unsafe { bgiDestroyContext(b.view.cast()) }),
        ("a context as a view", HANDLE, "view", |b| unsafe { bgiDestroyView(b.context, b.context.cast()) }),
        ("NULL view", HANDLE, "view", |b| unsafe { bgiDestroyView(b.context, null_mut()) }),
        ("dispatch: NULL view", HANDLE, "view", |b| b.dispatch(|info| info.view = null_mut())),
        ("destroyed twice", HANDLE, "context", |b| unsafe {
            let context = b.make_context();
            assert_eq!(bgiDestroyContext(context), BGI_SUCCESS);
            bgiDestroyContext(context)
        }),
        ("used after its end", HANDLE, "context", |b| unsafe {
            let context = b.make_context();
            assert_eq!(bgiDestroyContext(context), BGI_SUCCESS);
            bgiGetStats(context, null_mut())
        }),
        ("view destroyed twice", HANDLE, "view", |b| unsafe {
            let view = b.make_view(b.context);
            assert_eq!(bgiDestroyView(b.context, view), BGI_SUCCESS);
            bgiDestroyView(b.context, view)
        }),
        ("another context's view", HANDLE, "view", |b| unsafe {
            let other = b.make_context();
            let result = bgiDestroyView(other, b.view);
            assert_eq!(bgiDestroyContext(other), BGI_SUCCESS);
            result
        }),
    ]);
}

#[test]
fn failures_reach_the_log_and_the_context() {
    unsafe extern "C" fn log(lines: *mut c_void, severity: BgiLogSeverity, message: *const c_char) {
        assert_eq!(severity, BGI_LOG_ERROR);
        // SAFETY: the pointer is the test's vector, on the test's thread; the message ends with a zero. Calling back
        // into the library is allowed.
        unsafe {
            let text = CStr::from_ptr(message).to_str().expect("UTF-8").to_owned();
            (*lines.cast::<Vec<String>>()).push(text);
            assert_eq!(bgiDestroyContext(null_mut()), BGI_ERROR_INVALID_HANDLE);
        }
    }
    let bench = Bench::new();
    let mut lines = Vec::<String>::new();
    let mut info = bench.create_info();
    info.log = Some(log);
    info.log_user_data = (&raw mut lines).cast();
    let mut context = null_mut();
    // SAFETY: as the header says; NULL structs are misuse that is survived.
    unsafe {
        assert_eq!(bgiCreateContext(&info, &mut context), BGI_SUCCESS);
        assert_eq!(bgiSetLights(context, null()), BGI_ERROR_INVALID_ARGUMENT);
        assert_eq!(last_error(context), "BgiLighting is NULL");
        // Another thread reads it too; a short buffer gets what fits and the whole length.
        let token = context.addr();
        let read = move || {
            let mut text = [1 as c_char; 4];
            let length = bgiGetLastError(without_provenance_mut(token), text.as_mut_ptr(), text.len());
            (length, text.map(|c| c as u8))
        };
        assert_eq!(std::thread::spawn(read).join().expect("the thread"), (19, *b"Bgi\0"));
        assert_eq!(bgiDestroyContext(context), BGI_SUCCESS);
        info.device = vk::Device::null();
        assert_eq!(bgiCreateContext(&info, &mut context), BGI_ERROR_INVALID_ARGUMENT);
    }
    assert_eq!(lines, ["BgiLighting is NULL", "device is VK_NULL_HANDLE"]);
}

#[test]
fn outputs_follow_the_count_and_array_pattern() {
    let bench = Bench::new();
    let mut text = [1 as c_char; 256];
    let mut needs = structure! { BgiDeviceRequirements, BGI_STRUCTURE_TYPE_DEVICE_REQUIREMENTS, };
    // SAFETY: as the header says.
    unsafe {
        assert_eq!(bgiGetDeviceRequirements(&bench.query(), &mut needs), BGI_SUCCESS);
        assert_eq!((needs.supported, needs.missing_size), (1, 1), "nothing is missing: the size of an empty text");
        (needs.missing, needs.missing_size) = (text.as_mut_ptr(), 256);
        assert_eq!(bgiGetDeviceRequirements(&bench.query(), &mut needs), BGI_SUCCESS);
        assert_eq!((needs.missing_size, text[0]), (1, 0));
        let mut stats = structure! { BgiStats, BGI_STRUCTURE_TYPE_STATS, };
        assert_eq!(bgiGetStats(bench.context, &mut stats), BGI_SUCCESS);
        if stats.resource_count > 1 {
            let mut one = zeroed::<BgiResourceSize>();
            (stats.resources, stats.resource_count) = (&raw mut one, 1);
            assert_eq!(bgiGetStats(bench.context, &mut stats), BGI_INCOMPLETE);
            assert_eq!(stats.resource_count, 1);
        }
    }
}

#[test]
fn two_contexts_in_two_threads_do_not_meet() {
    let (one, two) = (Bench::new(), Bench::new());
    let tokens = [(one.context.addr(), one.view.addr()), (two.context.addr(), two.view.addr())];
    let workers = tokens.map(|(context, view)| {
        std::thread::spawn(move || {
            let (context, view) = (without_provenance_mut(context), without_provenance_mut(view));
            for _ in 0..200 {
                let lighting = structure! { BgiLighting, BGI_STRUCTURE_TYPE_LIGHTING, };
                // SAFETY: as the header says; the NULL camera is misuse that is survived.
                unsafe {
                    assert_eq!(bgiSetLights(context, &lighting), BGI_SUCCESS);
                    assert_eq!(bgiSetCamera(context, view, null()), BGI_ERROR_INVALID_ARGUMENT);
                }
                assert_eq!(last_error(context), "BgiCamera is NULL");
            }
        })
    });
    workers.into_iter().for_each(|worker| worker.join().expect("a worker"));
}
