// Over the output: what lies behind it. Rays of the camera into the world show bricks, albedo, normals, cached light and
// their own steps as rays of the gather find them, which is not what the G-buffer shows.

#import lib/hdda.wgsl
#import lib/gather.wgsl

struct DebugPush {
    // DEBUG_...
    shown: u32,
}
var<immediate> push: DebugPush;

@res var<storage, read> history_out: array<u32>;
@res var<storage, read> probes: array<vec4<f32>>;
@res var<storage, read> lobes_out: array<u32>;
@res var output_image: texture_storage_2d<rgba16float, write>;

// Steps that are shown as white.
const MANY_STEPS: f32 = 128.0;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= view.size) { return; }
    var color = vec3<f32>(0.0);
    let shown = at_run_time(push.shown, pixel.x);
    if shown == DEBUG_HISTORY {
        let weight = unpack2x16float(history_out[(pixel.y * view.stride + pixel.x) * 3u + 1u]).y;
        color = vec3<f32>(weight / f32(view.history_max));
    } else if shown == DEBUG_PROBES {
        let tile = pixel / view.tile_size;
        let kind = u32(probes[(tile.y * view.tiles.x + tile.x) * 2u].w);
        color = vec3<f32>(vec3<u32>(kind) == vec3<u32>(PROBE_NEW, PROBE_CARRIED, PROBE_IN_TURN));
    } else if shown == DEBUG_PROBE_RADIANCE {
        color = vec3<f32>(probe_radiance(pixel));
    } else if shown == DEBUG_FALLBACK {
        let surface = load_surface(pixel);
        let weight = gather_probes(pixel, surface, 0.0).weight;
        color = select(vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(0.0, min(weight, 1.0), 0.0), weight > LEAST_WEIGHT);
        if !surface.valid { color = vec3<f32>(0.0); }
    } else {
        // From the near plane on, which is finite.
        let near = pixel_position(pixel, 1.0 - view.clear_depth);
        let direction = normalize(pixel_position(pixel, 0.5) - near);
        let start = Start(view.camera + near / frame.voxel_size, vec3<f32>(0.0), 0.0);
        color = show(shown, trace(start, direction, 1e6), direction);
    }
    textureStore(output_image, view.origin + pixel, vec4<f32>(min(color, vec3<f32>(65000.0)), 1.0));
}

// Luminance in the direction that the pixel stands for in the map of its tile's probe; 0: there is none.
fn probe_radiance(pixel: vec2<u32>) -> f32 {
    let tile = pixel / view.tile_size;
    let index = tile.y * view.tiles.x + tile.x;
    if u32(probes[index * 2u].w) == PROBE_NONE { return 0.0; }
    let cell = (pixel - tile * view.tile_size) * 8u / view.tile_size;
    let pair = unpack2x16float(lobes_out[index * LOBE_WORDS + cell.y * 4u + (cell.x >> 1u)]);
    return select(pair.x, pair.y, (cell.x & 1u) == 1u);
}

fn show(shown: u32, hit: Hit, direction: vec3<f32>) -> vec3<f32> {
    if shown == DEBUG_STEPS { return heat(f32(trace_steps) / MANY_STEPS); }
    if shown == DEBUG_RADIANCE { return hit_radiance(hit, direction); }
    if hit.kind == MISS { return vec3<f32>(0.0); }
    let voxel = find_voxel(hit.cell);
    if shown == DEBUG_BRICKS {
        // A colour a brick, a shade a voxel.
        let cell = vec3<u32>(hit.cell) + frame.seed_origin;
        let color = pcg(hash3(cell >> vec3<u32>(3u)));
        let shade = 0.4 + 0.4 * unit_float(hash3(cell));
        return (0.3 + 0.7 * unpack4x8unorm(color).xyz) * shade;
    }
    // A cube may be hit on a side that it does not have.
    if !has_side(voxel, hit.side) { return vec3<f32>(0.0); }
    let albedo = voxel_albedo(voxel, hit.side);
    if shown == DEBUG_ALBEDO { return albedo; }
    if shown == DEBUG_IRRADIANCE {
        var sent = hit_radiance(hit, direction);
        if is_lit(voxel, hit.side) { sent -= voxel_emission(voxel, hit.side); }
        return select(max(sent, vec3<f32>(0.0)) * (3.14159265 / max(albedo, vec3<f32>(1e-3))), vec3<f32>(0.0), albedo < vec3<f32>(1e-3));
    }
    return voxel_plane(voxel, hit.side).normal * 0.5 + 0.5;
}

// Black, blue, green, red, white.
fn heat(value: f32) -> vec3<f32> {
    let v = 4.0 * clamp(value, 0.0, 1.0);
    return vec3<f32>(saturate(v - 2.0), saturate(v - 1.0) - saturate(v - 2.0), saturate(v) - saturate(v - 1.0))
        + vec3<f32>(saturate(v - 3.0));
}
