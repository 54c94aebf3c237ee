// 64 directions a probe: one ray in each cell of its hemi-octahedral map, jittered. One workgroup a probe.

#import lib/reach.wgsl
#import lib/probes.wgsl

struct ViewPush {
    frame_index: u32,
}
var<immediate> push: ViewPush;

@res var<storage, read> probes: array<vec4<f32>>;
// Radiance of each ray (RGB9E5) and hit distance in voxels.
@res var<storage, read_write> probe_rays: array<vec2<u32>>;
// A ray of each probe, drawn in proportion to what it brings: where it hit (camera-relative metres) and its radiance's bits.
@res var<storage, read_write> probe_guides: array<vec4<f32>>;

var<workgroup> brought: array<f32, 64>;
var<workgroup> chosen: u32;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let index = group.y * view.tiles.x + group.x;
    let place = probes[index * 2u];
    if place.w == 0.0 { return; }
    let normal = probes[index * 2u + 1u].xyz;
    let local = probe_direction(index, thread, push.frame_index);
    let origin = view.camera + place.xyz / frame.voxel_size + normal * 0.001;
    let direction = basis(normal) * local.xyz;
    let hit = trace(Start(origin, normal, FACE_ERROR), direction, 1e6);
    ask_for_light(hit);
    // A hit's radiance goes on as it is stored.
    var radiance = 0u;
    if hit.kind == MISS {
        radiance = rgb9e5_encode(sky_radiance(direction), vec3<f32>(0.5));
    } else if hit.light != NONE {
        radiance = world_bricks[hit.light];
    }
    probe_rays[index * 64u + thread] = vec2<u32>(radiance, bitcast<u32>(hit.t));

    var own = 0.0;
    if hit.t > NEAR { own = luminance(rgb9e5_decode(radiance)) * local.z * local.w; }
    brought[thread] = own;
    workgroupBarrier();
    if thread == 0u {
        atomicAdd(&counters[0], 64u);
        var sum = 0.0;
        for (var k = 0u; k < 64u; k++) { sum += brought[k]; }
        var rest = sum * unit_float(pcg(pcg(index) ^ push.frame_index));
        chosen = 0u;
        while chosen < 63u && rest >= brought[chosen] {
            rest -= brought[chosen];
            chosen++;
        }
        if sum == 0.0 { probe_guides[index] = vec4<f32>(0.0); chosen = NONE; }
    }
    workgroupBarrier();
    if thread == chosen {
        let target_point = place.xyz + direction * (hit.t * frame.voxel_size);
        probe_guides[index] = vec4<f32>(target_point, bitcast<f32>(radiance));
    }
}
