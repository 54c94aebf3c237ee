// Pixels that were not seen for long borrow from neighbours on the same surface, the less the more they have seen
// themselves: what a camera uncovers has the noise of many pixels' rays, not of its own few. What is borrowed goes to the
// output alone and not into the history, which stays sharp. (History reconstruction: Zhdan, "ReBLUR", Ray Tracing Gems II,
// 2021, chapter 49.)

#import lib/history.wgsl

struct ViewPush {
    frame_index: u32,
}
var<immediate> push: ViewPush;

// Three words a pixel, see `resolve`.
@res var<storage, read> history_out: array<u32>;
@res var output_image: texture_storage_2d<rgba16float, write>;

const NEIGHBOURS: u32 = 16u;
// The golden angle: places on a disk, evenly (Vogel 1979).
const TURN: f32 = 2.3999632;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= view.size) { return; }
    let own = load(pixel);
    if own.w >= ENOUGH { return; }
    let surface = load_surface(pixel);
    if !surface.valid { return; }
    let distance = length(surface.position);
    var sum = tamed(own);
    let turn = unit_float(pcg(pcg(pixel.y * view.stride + pixel.x) ^ push.frame_index)) * 2.0 * 3.14159265;
    for (var k = 0u; k < NEIGHBOURS; k++) {
        let far = (f32(k) + 0.5) / f32(NEIGHBOURS);
        let angle = turn + f32(k) * TURN;
        let away = f32(view.tile_size) * far * vec2<f32>(cos(angle), sin(angle));
        let place = vec2<i32>(floor(vec2<f32>(pixel) + 0.5 + away));
        if any(place < vec2<i32>(0)) || any(place >= vec2<i32>(view.size)) { continue; }
        let neighbour = load_surface(vec2<u32>(place));
        if !neighbour.valid { continue; }
        sum += tamed(load(vec2<u32>(place))) * (likeness(surface, neighbour, distance) * exp2(-2.0 * far * far));
    }
    let root = sum.xyz / max(sum.w, 1e-6);
    let borrowed = root * luminance(root);
    textureStore(output_image, view.origin + pixel, vec4<f32>(mix(borrowed, own.xyz, own.w / ENOUGH), 1.0));
}

// A pixel's average and its weight.
fn load(pixel: vec2<u32>) -> vec4<f32> {
    let at = (pixel.y * view.stride + pixel.x) * 3u;
    return vec4<f32>(unpack2x16float(history_out[at]), unpack2x16float(history_out[at + 1u]));
}

// The average so that its luminance is the root of what it was, times its weight; and the weight. One bright ray is not to
// light a neighbourhood.
fn tamed(average: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(average.xyz * inverseSqrt(max(luminance(average.xyz), 1e-12)), 1.0) * average.w;
}
