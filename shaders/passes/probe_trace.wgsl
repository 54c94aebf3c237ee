// 64 rays a probe, half of them where light came from in earlier frames: the probe's lobes, a luminance for each cell of an
// 8 x 8 hemi-octahedral map about its normal, carried from frame to frame. The others go by the cosine alone, so
// that none can count for much; each weighs by the inverse of its density, so that the mean does not depend on what the
// lobes hold. (Importance sampling of screen probes: Brick GI, SIGGRAPH 2024; Lumen, SIGGRAPH 2022. Defensive mixture:
// Hesterberg 1995. Systematic sampling: one offset for all rays.) One workgroup a probe.
//
// Its irradiance then, for nine normals about its own: a 3 x 3 hemi-octahedral map whose middle is the probe's own normal,
// exact for flat surfaces, positive everywhere, as large as nine spherical-harmonics coefficients. What is very near the
// probe is left out and the rest made up to a whole hemisphere: it stands for the pixels around, which look for themselves
// at what is near them (`resolve`).

#import lib/reach.wgsl
#import lib/probes.wgsl

struct ViewPush {
    frame_index: u32,
}
var<immediate> push: ViewPush;

@res var<storage, read> probes: array<vec4<f32>>;
@res var<storage, read_write> probe_irradiance: array<vec4<f32>>;
// A ray of each probe, drawn in proportion to what it brings: where it hit (camera-relative metres) and its radiance's bits.
@res var<storage, read_write> probe_guides: array<vec4<f32>>;
// LOBE_WORDS a probe: luminance of its cells as halves, two a word; its normal, or NONE last where there is no probe.
@res var<storage, read> lobes_in: array<u32>;
@res var<storage, read_write> lobes_out: array<u32>;

// Part of the rays that goes by the lobes.
const BY_LOBES: f32 = 0.5;
// Weight of a frame in the lobes.
const LOBE_RATE: f32 = 0.125;

struct Ray {
    radiance: vec3<f32>,
    // Whether it ends near the probe.
    is_near: bool,
    // About the probe's normal.
    direction: vec3<f32>,
    // Solid angle that it stands for.
    weight: f32,
}

var<workgroup> rays: array<Ray, 64>;
// Of each cell: what it has by cosine, and by lobes.
var<workgroup> shares: array<vec2<f32>, 64>;
// Sum of the densities of the cells before.
var<workgroup> below: array<f32, 64>;
var<workgroup> lobes: array<f32, 64>;
var<workgroup> chosen: u32;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let index = probe_index(group.xy, group.z);
    let place = probes[index * 2u];
    let kind = u32(place.w);
    if kind == PROBE_CARRIED { return; }
    if kind == PROBE_NONE {
        if thread == 0u { lobes_out[index * LOBE_WORDS + 33u] = NONE; }
        return;
    }
    let turn = select(push.frame_index, push.frame_index / view.gather_interval, kind == PROBE_IN_TURN);
    let normal = probes[index * 2u + 1u].xyz;
    let to_world = basis(normal);

    // The density of each cell.
    let middle = cell_direction(thread, vec2<f32>(0.5));
    let lobe = old_lobe(group.z, place.xyz, to_world * middle.xyz);
    // Normals that lean away from the probe's see more of the horizon.
    shares[thread] = vec2<f32>(middle.z + 0.2, lobe * middle.z) * middle.w;
    workgroupBarrier();
    var before = vec2<f32>(0.0);
    var all = vec2<f32>(0.0);
    for (var k = 0u; k < 64u; k++) {
        if k == thread { before = all; }
        all += shares[k];
    }
    let scale = vec2<f32>(1.0 - BY_LOBES, BY_LOBES) / max(all, vec2<f32>(1e-30));
    let lopsided = select(vec2<f32>(1.0 / all.x, 0.0), scale, all.y > 0.0);
    below[thread] = dot(before, lopsided);
    workgroupBarrier();

    // Ray k is at (k + offset) / 64 of their sum.
    let offset = kronecker4(pcg(index), turn).z;
    let at = (f32(thread) + offset) / 64.0;
    var cell = 0u;
    for (var half = 32u; half > 0u; half >>= 1u) {
        if below[cell + half] <= at { cell += half; }
    }
    let low = below[cell];
    let density = density_of(cell, lopsided);
    let first = ceil(64.0 * low - offset);
    let jitter = kronecker4(pcg(index * 64u + cell), turn).w;
    let along = clamp((at - low) / density, 0.0, 1.0);
    let local = cell_direction(cell, fract(vec2<f32>(along + unit_float(pcg(index * 64u + cell)),
                                                     jitter + (f32(thread) - first) * 0.618034)));
    let origin = view.camera + place.xyz / frame.voxel_size + normal * 0.001;
    let direction = to_world * local.xyz;
    let hit = trace(Start(origin, normal, FACE_ERROR), direction, 1e6);
    ask_for_light(hit);
    let radiance = hit_radiance(hit, direction);
    let weight = local.w / (4096.0 * density);
    rays[thread] = Ray(radiance, hit.t <= view.near_field, local.xyz, weight);
    workgroupBarrier();

    if thread < 9u { probe_irradiance[index * 9u + thread] = irradiance(thread); }
    lobes[thread] = new_lobe(lobe, below[thread], density_of(thread, lopsided), offset);
    if thread == 0u {
        atomicAdd(&counters[0], 1u);
        chosen = draw(unit_float(pcg(pcg(index) ^ turn)));
        if chosen == NONE { probe_guides[index] = vec4<f32>(0.0); }
        lobes_out[index * LOBE_WORDS + 32u] = pack2x16snorm(normal.xy);
        lobes_out[index * LOBE_WORDS + 33u] = pack2x16snorm(vec2<f32>(normal.z, 0.0));
    }
    workgroupBarrier();
    if thread == chosen {
        let target_point = place.xyz + direction * (hit.t * frame.voxel_size);
        probe_guides[index] = vec4<f32>(target_point, bitcast<f32>(rgb9e5_encode(radiance, vec3<f32>(0.5))));
    }
    if thread < 32u {
        lobes_out[index * LOBE_WORDS + thread] = pack2x16float(vec2<f32>(lobes[2u * thread], lobes[2u * thread + 1u]));
    }
}

// A direction in a cell, about the normal, and the solid angle of a cell times 64.
fn cell_direction(cell: u32, place: vec2<f32>) -> vec4<f32> {
    return hemi_octahedral((vec2<f32>(vec2<u32>(cell & 7u, cell >> 3u)) + place) / 8.0);
}

fn density_of(cell: u32, lopsided: vec2<f32>) -> f32 {
    return max(dot(shares[cell], lopsided), 1e-9);
}

// What came from a direction in the last frame: of the probe of the tile that the surface was in, and of this layer if it had
// one.
fn old_lobe(layer: u32, position: vec3<f32>, direction: vec3<f32>) -> f32 {
    if at_run_time(view.history_valid, layer) == 0u { return 0.0; }
    let clip = view.previous_clip * vec4<f32>(position, 1.0);
    let size = vec2<u32>(view.previous_size & 0xffffu, view.previous_size >> 16u);
    let tiles = previous_tiles();
    let pixel = vec2<i32>(floor((clip.xy / max(clip.w, 1e-6) * 0.5 + 0.5) * vec2<f32>(size)));
    if clip.w <= 0.0 || any(pixel < vec2<i32>(0)) || any(pixel >= vec2<i32>(size)) { return 0.0; }
    let tile = vec2<u32>(pixel) / view.tile_size;
    var first = ((layer * tiles.y + tile.y) * tiles.x + tile.x) * LOBE_WORDS;
    if lobes_in[first + 33u] == NONE { first = (tile.y * tiles.x + tile.x) * LOBE_WORDS; }
    let packed = lobes_in[first + 33u];
    if packed == NONE { return 0.0; }
    let normal = vec3<f32>(unpack2x16snorm(lobes_in[first + 32u]), unpack2x16snorm(packed).x);
    let local = direction * basis(normalize(normal));
    // Half a cell below the horizon is as good as on it.
    if local.z < -0.1 { return 0.0; }
    let cell = min(vec2<u32>(hemi_square(local) * 8.0), vec2<u32>(7u));
    let pair = unpack2x16float(lobes_in[first + cell.y * 4u + (cell.x >> 1u)]);
    return select(pair.x, pair.y, (cell.x & 1u) == 1u);
}

// A cell's luminance with what its rays have found: the root of the mean square, by which densities give the least variance.
fn new_lobe(old: f32, low: f32, density: f32, offset: f32) -> f32 {
    let first = u32(clamp(ceil(64.0 * low - offset), 0.0, 64.0));
    let end = u32(clamp(ceil(64.0 * (low + density) - offset), 0.0, 64.0));
    if end <= first { return old; }
    var sum = 0.0;
    for (var k = first; k < end; k++) {
        let own = select(luminance(rays[k].radiance), 0.0, rays[k].is_near);
        sum += own * own;
    }
    return min(sqrt(mix(old * old, sum / f32(end - first), LOBE_RATE)), 65000.0);
}

// For one of the nine normals; w: the share of directions that was seen.
fn irradiance(texel: u32) -> vec4<f32> {
    let normal = hemi_octahedral(vec2<f32>(vec2<u32>(texel % 3u, texel / 3u)) * 0.25 + 0.25).xyz;
    var all = vec4<f32>(0.0);
    var far = vec4<f32>(0.0);
    for (var k = 0u; k < 64u; k++) {
        let weight = max(dot(normal, rays[k].direction), 0.0) * rays[k].weight;
        let brought = vec4<f32>(rays[k].radiance, 1.0) * weight;
        all += brought;
        if !rays[k].is_near { far += brought; }
    }
    let share = far.w / max(all.w, 1e-9);
    return vec4<f32>(select(all.xyz, far.xyz / share, share > 0.1), select(1.0, share, share > 0.1));
}

// A ray in proportion to what it brings from afar; NONE: none brings anything.
fn draw(u: f32) -> u32 {
    var sum = 0.0;
    for (var k = 0u; k < 64u; k++) { sum += brought(k); }
    if sum == 0.0 { return NONE; }
    var rest = sum * u;
    for (var k = 0u; k < 63u; k++) {
        rest -= brought(k);
        if rest < 0.0 { return k; }
    }
    return 63u;
}

fn brought(ray: u32) -> f32 {
    return select(luminance(rays[ray].radiance) * rays[ray].direction.z * rays[ray].weight, 0.0, rays[ray].is_near);
}
