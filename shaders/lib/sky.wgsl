// Radiance from beyond the world, by what `frame` says of it.

#import lib/pack.wgsl
#import shared/limits.wgsl
#import shared/frame.wgsl
#import lib/run_time.wgsl

// Octahedral map of RGB9E5 words, row by row, four in each vector; only that of an image is as large as it says. A uniform
// buffer: `resolve` has all the storage buffers that a phone allows.
@res var<uniform> sky_map: array<vec4<u32>, SKY_EDGE * SKY_EDGE / 4u>;

fn sky_radiance(direction: vec3<f32>) -> vec3<f32> {
    let kind = at_run_time(frame.sky_kind, bitcast<u32>(abs(direction.x)));
    if kind == SKY_CONSTANT { return frame.sky; }
    if kind == SKY_GRADIENT {
        let height = dot(direction, frame.sky_x);
        return mix(frame.sky_y, select(frame.sky_z, frame.sky, height > 0.0), min(abs(height), 1.0));
    }
    let local = vec3<f32>(dot(direction, frame.sky_x), dot(direction, frame.sky_y), dot(direction, frame.sky_z));
    let d = local / (abs(local.x) + abs(local.y) + abs(local.z));
    let folded = (1.0 - abs(d.yx)) * select(vec2<f32>(-1.0), vec2<f32>(1.0), d.xy >= vec2<f32>(0.0));
    let place = select(d.xy, folded, d.z < 0.0) * 0.5 + 0.5;
    let texel = min(vec2<u32>(place * f32(SKY_EDGE)), vec2<u32>(SKY_EDGE - 1u));
    let word = texel.x + SKY_EDGE * texel.y;
    return frame.sky * rgb9e5_decode(sky_map[word >> 2u][word & 3u]);
}
