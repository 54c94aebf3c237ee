// What each pixel has averaged so far.

#import lib/probes.wgsl

// Three words a pixel: irradiance rgb and its weight as halves; see `surface_word`.
@res var<storage, read> history_in: array<u32>;

// Weight, in frames in which a probe stands close, with which a pixel stands for itself.
const ENOUGH: f32 = 16.0;
// What a frame weighs in the mean, over all the places where probes may stand.
const FRAME_WEIGHT: f32 = 0.4;
// And with which it rests between its turns.
const SETTLED: f32 = 48.0;

// Last frame's average at a surface, and its weight; 0 where it was not seen.
fn load_history(surface: Surface, pixel: vec2<u32>) -> vec4<f32> {
    if at_run_time(view.history_valid, bitcast<u32>(abs(surface.position.x))) == 0u { return vec4<f32>(0.0); }
    let before = surface_before(surface, pixel);
    if !before.in_view { return vec4<f32>(0.0); }
    let size = vec2<i32>(vec2<u32>(view.previous_size & 0xffffu, view.previous_size >> 16u));
    let place = before.place - 0.5;
    // A still camera lands on the pixel itself, up to rounding.
    let snapped = select(place, round(place), abs(place - round(place)) < vec2<f32>(0.01));
    let corner = vec2<i32>(floor(snapped));
    let part = snapped - vec2<f32>(corner);
    var sum = vec4<f32>(0.0);
    var weight_sum = 0.0;
    for (var k = 0; k < 4; k++) {
        let offset = vec2<i32>(k & 1, k >> 1u);
        let seen = corner + offset;
        if any(seen < vec2<i32>(0)) || any(seen >= size) { continue; }
        let bilinear = select(1.0 - part, part, offset == vec2<i32>(1));
        let weight = bilinear.x * bilinear.y;
        let at = u32(seen.y) * view.stride + u32(seen.x);
        if weight <= 1e-4 || !is_same_surface(history_in[at * 3u + 2u], surface.normal, before.distance, before.slack) { continue; }
        sum += weight * vec4<f32>(unpack2x16float(history_in[at * 3u]), unpack2x16float(history_in[at * 3u + 1u]));
        weight_sum += weight;
    }
    if weight_sum < 0.01 { return vec4<f32>(0.0); }
    var past = sum / weight_sum;
    // Light is another one a voxel on.
    if before.travelled > 0.0 { past.w = min(past.w, FRAME_WEIGHT * frame.voxel_size / before.travelled); }
    return past;
}

// Whether a pixel of this average may rest until its turn comes.
fn has_settled(past: vec4<f32>) -> bool {
    return min(past.w, f32(view.history_max)) >= SETTLED;
}

// Whether it is the turn of a probe, or of the pixels of a workgroup: one of each `interval` in a square of two by two is in
// a frame.
fn is_turn(place: vec2<u32>, frame_index: u32) -> bool {
    let own = ((place.x ^ place.y) & 1u) | ((place.y & 1u) << 1u);
    return (own - frame_index) % view.gather_interval == 0u;
}
