// Irradiance of each probe for nine normals about its own: a 3 x 3 hemi-octahedral map whose middle is the probe's own
// normal, exact for flat surfaces, positive everywhere, as large as nine spherical-harmonics coefficients. What is very
// near the probe is left out and the rest made up to a whole hemisphere: it stands for the pixels around, which look for
// themselves at what is near them (`resolve`).

#import lib/probes.wgsl
#import lib/pack.wgsl

struct ViewPush {
    frame_index: u32,
}
var<immediate> push: ViewPush;

@res var<storage, read> probes: array<vec4<f32>>;
@res var<storage, read> probe_rays: array<vec2<u32>>;
@res var<storage, read_write> probe_irradiance: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = id.x / 9u;
    if index >= view.tiles.x * view.tiles.y || probes[index * 2u].w == 0.0 { return; }
    let texel = id.x - index * 9u;
    let normal = hemi_octahedral(vec2<f32>(vec2<u32>(texel % 3u, texel / 3u)) * 0.25 + 0.25).xyz;
    var all = vec4<f32>(0.0);
    var far = vec4<f32>(0.0);
    for (var k = 0u; k < 64u; k++) {
        let ray = probe_rays[index * 64u + k];
        let direction = probe_direction(index, k, push.frame_index);
        let weight = max(dot(normal, direction.xyz), 0.0) * direction.w / 64.0;
        let brought = vec4<f32>(rgb9e5_decode(ray.x) * weight, weight);
        all += brought;
        if bitcast<f32>(ray.y) > NEAR { far += brought; }
    }
    let share = far.w / all.w;
    probe_irradiance[id.x] = vec4<f32>(select(all.xyz, far.xyz / share, share > 0.1), select(1.0, share, share > 0.1));
}
