// 64 directions a probe: one ray in each cell of its hemi-octahedral map, jittered. One workgroup a probe.

#import lib/hdda.wgsl
#import lib/random.wgsl
#import lib/probes.wgsl

struct ViewPush {
    frame_index: u32,
}
var<immediate> push: ViewPush;

@res var<storage, read> probes: array<vec4<f32>>;
// Radiance of each ray (RGB9E5) and hit distance in voxels.
@res var<storage, read_write> probe_rays: array<vec2<u32>>;
// Word 0: rays traced.
@res var<storage, read_write> counters: array<atomic<u32>, 4>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let index = group.y * view.tiles.x + group.x;
    let place = probes[index * 2u];
    if place.w == 0.0 { return; }
    let normal = probes[index * 2u + 1u].xyz;
    let local = probe_direction(index, thread, push.frame_index);
    let origin = view.camera + place.xyz / frame.voxel_size + normal * 0.001;
    let hit = trace(Start(origin, normal, FACE_ERROR), basis(normal) * local.xyz, 1e6);
    // A hit's radiance goes on as it is stored.
    var radiance = 0u;
    if hit.kind == MISS {
        radiance = rgb9e5_encode(frame.sky, vec3<f32>(0.5));
    } else if hit.light != NONE {
        radiance = world_bricks[hit.light];
    }
    probe_rays[index * 64u + thread] = vec2<u32>(radiance, bitcast<u32>(hit.t));
    if thread == 0u { atomicAdd(&counters[0], 64u); }
}
