// Forward reprojection of the last frame's probes: each goes to the tile that its surface is in now, and of several the
// nearest to the camera stays there. It is given up where another surface stands at its place. (Brick GI, SIGGRAPH 2024.)

#import lib/reach.wgsl
#import lib/probes.wgsl
#import lib/follow.wgsl

struct ViewPush {
    frame_index: u32,
}
var<immediate> push: ViewPush;

@res var<storage, read> probes_in: array<vec4<f32>>;
// Of each tile and layer: the nearness of what has come (see `PROBE_MASK`) and the probe's index; 0: nothing has.
@res var<storage, read_write> probe_claims: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let tiles = previous_tiles();
    if id.x >= PROBE_LAYERS * tiles.x * tiles.y { return; }
    let old = probes_in[id.x * 2u];
    if u32(old.w) == PROBE_NONE { return; }
    let position = old.xyz + view.camera_delta;
    let normal = probes_in[id.x * 2u + 1u].xyz;
    let followed = follow_probe(position, normal);
    if !followed.in_view { return; }
    if !followed.is_there {
        atomicAdd(&counters[3], 1u);
        return;
    }
    let tile = followed.pixel / view.tile_size;
    let distance = length(followed.surface.position);
    // Positive floats are ordered as their bits are: eight of the exponent and four below it.
    let nearness = (bitcast<u32>(1.0 / max(distance, 1e-6)) << 1u) & ~PROBE_MASK;
    let layer = id.x / (tiles.x * tiles.y);
    let others = atomicMax(&probe_claims[probe_index(tile, layer)], nearness | id.x);
    atomicAdd(&counters[select(2u, 1u, others == 0u)], 1u);
}
