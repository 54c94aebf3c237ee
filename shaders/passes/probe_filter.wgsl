// Irradiance of each probe for nine normals about its own: a 3 x 3 hemi-octahedral map whose middle is the probe's own
// normal, exact for flat surfaces, positive everywhere, as large as nine spherical-harmonics coefficients.

#import lib/probes.wgsl

@res var<storage, read> probes: array<vec4<f32>>;
@res var<storage, read> probe_rays: array<vec4<f32>>;
@res var<storage, read_write> probe_irradiance: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = id.x / 9u;
    if index >= view.tiles.x * view.tiles.y || probes[index * 2u].w == 0.0 { return; }
    let texel = id.x - index * 9u;
    let normal = hemi_octahedral(vec2<f32>(vec2<u32>(texel % 3u, texel / 3u)) * 0.25 + 0.25).xyz;
    var e = vec3<f32>(0.0);
    for (var k = 0u; k < 64u; k++) {
        let ray = probe_rays[index * 64u + k];
        let xy = unpack2x16snorm(bitcast<u32>(ray.w));
        let direction = vec3<f32>(xy, sqrt(max(1.0 - dot(xy, xy), 0.0)));
        e += ray.xyz * max(dot(normal, direction), 0.0);
    }
    probe_irradiance[id.x] = vec4<f32>(e, 0.0);
}
