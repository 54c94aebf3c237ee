// Copies what the probes have found that tiles keep. One workgroup a tile and layer.

#import lib/probes.wgsl

struct ViewPush {
    frame_index: u32,
}
var<immediate> push: ViewPush;

@res var<storage, read> probes: array<vec4<f32>>;
@res var<storage, read> probe_claims: array<u32>;
@res var<storage, read> probe_irradiance_in: array<vec4<f32>>;
@res var<storage, read_write> probe_irradiance: array<vec4<f32>>;
@res var<storage, read> probe_guides_in: array<vec4<f32>>;
@res var<storage, read_write> probe_guides: array<vec4<f32>>;
@res var<storage, read> lobes_in: array<u32>;
@res var<storage, read_write> lobes_out: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let index = probe_index(group.xy, group.z);
    if u32(probes[index * 2u].w) != PROBE_CARRIED { return; }
    let source = probe_claims[index] & PROBE_MASK;
    if thread < LOBE_WORDS { lobes_out[index * LOBE_WORDS + thread] = lobes_in[source * LOBE_WORDS + thread]; }
    if thread < 9u { probe_irradiance[index * 9u + thread] = probe_irradiance_in[source * 9u + thread]; }
    if thread == 63u {
        let guide = probe_guides_in[source];
        probe_guides[index] = vec4<f32>(guide.xyz + view.camera_delta, guide.w);
    }
}
