// Irradiance of each pixel: four probes around it weighted by plane distance and normal; where none stands for it, its
// own rays into the world cache. What is near a pixel it sees by a short ray of its own, and another one looks whether
// something hides the probes' light. Then the average over time with rejection where the surface was not seen before, and
// cut short where light has changed.

#import lib/reach.wgsl
#import lib/history.wgsl
#import lib/lag.wgsl
#import lib/gather.wgsl

struct ViewPush {
    frame_index: u32,
}
var<immediate> push: ViewPush;

@res var<storage, read> probes: array<vec4<f32>>;
@res var<storage, read> probe_guides: array<vec4<f32>>;
// As `history_in`.
@res var<storage, read_write> history_out: array<u32>;
@res var output_image: texture_storage_2d<rgba16float, write>;

// Another line where a setting leaves it to probes alone (build.rs).
const NEAR_FIELD: bool = true;
// Whether the world has changed of late, and averages are cut short where they lag behind.
const WATCHES: bool = false;
// How far (voxels) a pixel looks for what stands between it and what a probe sees.
const GUIDED: f32 = 16.0;
// Frames averaged while the world or its lights are changing.
const UNSTEADY: u32 = 8u;
// Rays of a pixel for which no probe stands.
const FALLBACK_RAYS: u32 = 4u;
const PI: f32 = 3.14159265;

var<workgroup> differences: array<vec2<f32>, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>,
        @builtin(local_invocation_index) thread: u32) {
    var lag = Lag();
    if WATCHES { lag = load_lag(group.xy); }
    var difference = vec2<f32>(0.0);
    if all(id.xy < view.size) { difference = resolve(id.xy, group.xy, lag); }
    if !WATCHES { return; }
    differences[thread] = difference;
    workgroupBarrier();
    if thread < 8u {
        for (var k = 8u + thread; k < 64u; k += 8u) { differences[thread] += differences[k]; }
    }
    workgroupBarrier();
    if thread > 0u { return; }
    var sum = differences[0];
    for (var k = 1u; k < 8u; k++) { sum += differences[k]; }
    let next = next_lag(lag, sum);
    let at = lag_at(group.xy);
    history_out[at] = pack2x16float(next.means);
    history_out[at + 1u] = pack2x16float(vec2<f32>(next.deviation, 0.0)) | (next.count << 16u);
}

// How much brighter the pixel was found than it is known, and how bright that is; 0 where it did not look or knows too little.
fn resolve(pixel: vec2<u32>, group: vec2<u32>, lag: Lag) -> vec2<f32> {
    let at = pixel.y * view.stride + pixel.x;
    let surface = load_surface(pixel);
    if !surface.valid {
        store_history(at, vec4<f32>(0.0), NO_SURFACE);
        textureStore(output_image, view.origin + pixel, vec4<f32>(0.0));
        return vec2<f32>(0.0);
    }
    let past = load_history(surface, pixel);
    let rests = has_settled(past) && !lag.roused;
    // Whole workgroups at once: pixels that rest beside others that look would spare no time.
    if rests && !is_turn(group, push.frame_index) {
        store_history(at, past, surface_word(surface));
        textureStore(output_image, view.origin + pixel, vec4<f32>(past.xyz, 1.0));
        return vec2<f32>(0.0);
    }
    let now = gather(pixel, at, surface, select(push.frame_index, push.frame_index / view.gather_interval, rests));
    // While the world is changing, what pixels trust little also leaves the average.
    let kept = past.w * select(1.0, 1.0 - 1.0 / f32(view.history_max), view.history_max <= UNSTEADY);
    let most = select(f32(view.history_max) - now.w, 0.0, view.history_max == 1u);
    let weight = min(min(kept, lag_weight(lag)), most);
    // Weights grow with time: light that is still settling leaves the average soon.
    let e = mix(past.xyz, now.xyz, 2.0 * now.w / (weight + 2.0 * now.w));
    let average = clamp(e, vec3<f32>(0.0), vec3<f32>(65000.0));
    store_history(at, vec4<f32>(average, weight + now.w), surface_word(surface));
    textureStore(output_image, view.origin + pixel, vec4<f32>(average, 1.0));
    let known = luminance(past.xyz);
    return select(vec2<f32>(0.0), vec2<f32>(luminance(now.xyz) - known, known), past.w >= ENOUGH);
}

// Irradiance, and how much it counts in the average over time: probes move, and a pixel trusts the frames in which one
// stands close to it. `index`: counts the pixel's turns.
fn gather(pixel: vec2<u32>, at: u32, surface: Surface, index: u32) -> vec4<f32> {
    let start = pixel_start(surface);
    let seed = pcg(at);
    var far = Gathered();
    let own_rays = at_run_time(view.pixel_rays, at);
    if own_rays == 0u { far = gather_probes(pixel, surface, unit_float(pcg(seed ^ pcg(index)))); }
    if far.weight > LEAST_WEIGHT {
        let open = far.sum / far.weight;
        let weight = clamp(far.weight, 0.002, 1.0);
        if !NEAR_FIELD { return vec4<f32>(open.xyz, weight); }
        let direction = cosine_direction(surface.normal, r2(seed, index));
        let near = look(surface, start, direction, NEAR_VOXELS);
        if near.kind == HIT { return vec4<f32>(PI * hit_radiance(near, direction), weight); }
        let e = open.xyz - hidden(surface, start, open, probe_guides[far.guide]);
        return vec4<f32>(max(e, vec3<f32>(0.0)), weight);
    }
    // No probe stands for the pixel: rays of its own into the world cache.
    let rays = select(FALLBACK_RAYS, own_rays, own_rays > 0u);
    var e = vec3<f32>(0.0);
    for (var r = 0u; r < rays; r++) {
        let direction = cosine_direction(surface.normal, r2(seed, index * rays + r));
        let hit = trace(start, direction, 1e6);
        ask_for_light(hit);
        e += hit_radiance(hit, direction);
    }
    // Next to a probe, a few rays count for little.
    return vec4<f32>(e * (PI / f32(rays)), f32(rays) / 64.0);
}

// What of the probes' irradiance `e` does not reach the pixel: of a ray that a probe drew in proportion to what it brings,
// everything, if something near the pixel is in its way, less what that sends itself. w: the share of directions that the
// probe has seen.
fn hidden(surface: Surface, start: Start, e: vec4<f32>, guide: vec4<f32>) -> vec3<f32> {
    let radiance = rgb9e5_decode(bitcast<u32>(guide.w));
    let brightness = luminance(radiance);
    let to_guide = guide.xyz - surface.position;
    let distance = length(to_guide) / frame.voxel_size;
    let direction = normalize(to_guide);
    if !(brightness > 0.0) || dot(direction, surface.normal) < 0.02 { return vec3<f32>(0.0); }
    let scale = luminance(e.xyz) / brightness;
    var t = distance;
    var seen = vec3<f32>(0.0);
    if distance > NEAR_VOXELS {
        let hit = look(surface, start, direction, min(GUIDED, 0.95 * distance - 1.0));
        // What lets some light through has let the probe's ray pass, and may hide nothing.
        if hit.kind == MISS || hit.translucent { return vec3<f32>(0.0); }
        t = hit.t;
        seen = min(hit_radiance(hit, direction), 4.0 * radiance);
    }
    // What is very near the pixel sees for itself, and takes from the probes' mean.
    if t < NEAR_VOXELS { return radiance * (scale * e.w) - e.xyz * min(scale / PI, 2.0); }
    return (radiance - seen) * (scale * e.w);
}

// What a pixel sees within `reach` voxels; where the camera sees through it, nothing.
fn look(surface: Surface, start: Start, direction: vec3<f32>, reach: f32) -> Hit {
    var hit = trace(start, direction, reach);
    if hit.kind == HIT && is_seen_through(surface, surface.position + direction * (hit.t * frame.voxel_size)) {
        hit.kind = MISS;
    }
    ask_for_light(hit);
    return hit;
}

// Whether the camera sees that there is nothing at `hit` (camera-relative metres), in front of a pixel's surface: around
// it on screen is only what lies behind it and at most half as far in front of the surface. Voxels are coarser than
// pixels.
fn is_seen_through(surface: Surface, hit: vec3<f32>) -> bool {
    let clip = view.clip * vec4<f32>(hit, 1.0);
    if clip.w <= 0.0 { return false; }
    let place = vec2<i32>(floor((clip.xy / clip.w * 0.5 + 0.5) * vec2<f32>(view.size)));
    if any(place < vec2<i32>(0)) || any(place >= vec2<i32>(view.size)) { return false; }
    let height = dot(surface.normal, hit - surface.position);
    let distance = length(hit);
    for (var k = 0; k < 9; k++) {
        let at = clamp(place + vec2<i32>(k % 3, k / 3) - 1, vec2<i32>(0), vec2<i32>(view.size) - 1);
        let depth = textureLoad(depth_image, view.origin + vec2<u32>(at), 0).x;
        if depth == view.clear_depth { continue; }
        let seen = pixel_position(vec2<u32>(at), depth);
        if dot(surface.normal, seen - surface.position) > 0.5 * height
            || length(seen) < distance - frame.voxel_size { return false; }
    }
    return true;
}

fn pixel_start(surface: Surface) -> Start {
    let point = view.camera + surface.position / frame.voxel_size + surface.normal * 0.001;
    return Start(point, surface.normal, PIXEL_ERROR);
}

fn store_history(at: u32, average: vec4<f32>, seen: u32) {
    let start = pcg(at ^ pcg(push.frame_index));
    history_out[at * 3u] = pack2x16float(round_to_half(average.xy, start));
    history_out[at * 3u + 1u] = pack2x16float(round_to_half(average.zw, pcg(start)));
    history_out[at * 3u + 2u] = seen;
}

// Rounds up or down by chance, so that an average to which a frame adds less than the halves' spacing neither sticks nor
// drifts.
fn round_to_half(v: vec2<f32>, random: u32) -> vec2<f32> {
    let dither = vec2<u32>(random & 0x1fffu, random >> 19u);
    return bitcast<vec2<f32>>((bitcast<vec2<u32>>(v) + dither) & vec2<u32>(0xffffe000u));
}
