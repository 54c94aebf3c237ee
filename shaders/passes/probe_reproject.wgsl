// Forward reprojection of the last frame's probes: each goes to the tile that its surface is in now, and of several the
// nearest to the camera stays there. It is given up where another surface stands at its place. (Brick GI, SIGGRAPH 2024.)

#import lib/reach.wgsl
#import lib/probes.wgsl

struct ViewPush {
    frame_index: u32,
}
var<immediate> push: ViewPush;

@res var<storage, read> probes_in: array<vec4<f32>>;
// Of each tile: the nearness of what has come (see `PROBE_MASK`) and the probe's index; 0: nothing has.
@res var<storage, read_write> probe_claims: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<u32>(view.previous_size & 0xffffu, view.previous_size >> 16u);
    let tiles = (size + view.tile_size - 1u) / view.tile_size;
    if id.x >= tiles.x * tiles.y { return; }
    let old = probes_in[id.x * 2u];
    if u32(old.w) == PROBE_NONE { return; }
    let position = old.xyz + view.camera_delta;
    let clip = view.clip * vec4<f32>(position, 1.0);
    let place = (clip.xy / max(clip.w, 1e-6) * 0.5 + 0.5) * vec2<f32>(view.size);
    if clip.w <= 0.0 || any(place < vec2<f32>(0.0)) || any(place >= vec2<f32>(view.size)) { return; }
    let surface = load_surface(vec2<u32>(place));
    let normal = probes_in[id.x * 2u + 1u].xyz;
    let distance = length(position);
    if !surface.valid || dot(normal, surface.normal) < SAME_FACING
        || abs(dot(surface.position - position, surface.normal)) > SAME_PLANE * distance + 1e-3 {
        atomicAdd(&counters[3], 1u);
        return;
    }
    let tile = vec2<u32>(place) / view.tile_size;
    // Positive floats are ordered as their bits are: eight of the exponent and four below it.
    let nearness = (bitcast<u32>(1.0 / max(distance, 1e-6)) << 1u) & ~PROBE_MASK;
    let others = atomicMax(&probe_claims[tile.y * view.tiles.x + tile.x], nearness | id.x);
    atomicAdd(&counters[select(2u, 1u, others == 0u)], 1u);
}
