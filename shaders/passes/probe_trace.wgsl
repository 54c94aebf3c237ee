// 64 directions a probe: one ray in each cell of its hemi-octahedral map, jittered. One workgroup a probe.

#import lib/hdda.wgsl
#import lib/random.wgsl
#import lib/probes.wgsl

struct ViewPush {
    frame_index: u32,
}
var<immediate> push: ViewPush;

@res var<storage, read> probes: array<vec4<f32>>;
// Radiance x solid angle, and the direction, of each ray: what `probe_filter` needs.
@res var<storage, read_write> probe_rays: array<vec4<f32>>;
// Word 0: rays traced.
@res var<storage, read_write> counters: array<atomic<u32>, 4>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let index = group.y * view.tiles.x + group.x;
    let place = probes[index * 2u];
    if place.w == 0.0 { return; }
    let normal = probes[index * 2u + 1u].xyz;
    let jitter = r2(pcg(index * 64u + thread), push.frame_index);
    let square = (vec2<f32>(vec2<u32>(thread & 7u, thread >> 3u)) + jitter) / 8.0;
    let local = hemi_octahedral(square);
    let origin = view.camera + place.xyz / frame.voxel_size + normal * 0.001;
    let radiance = hit_radiance(trace(origin, basis(normal) * local.xyz, normal, 1e6));
    let packed = vec3<f32>(radiance * (local.w / 64.0));
    probe_rays[index * 64u + thread] = vec4<f32>(packed, bitcast<f32>(pack2x16snorm(local.xy)));
    if thread == 0u { atomicAdd(&counters[0], 64u); }
}
