// Which probes may look when not all that want to may.

#import lib/follow.wgsl

@res var<storage, read> probes_in: array<vec4<f32>>;
@res var<storage, read_write> probes: array<vec4<f32>>;

// Where the probe is that has claimed a tile.
fn follow_claim(claim: u32) -> Followed {
    let source = claim & PROBE_MASK;
    return follow_probe(probes_in[source * 2u].xyz + view.camera_delta, probes_in[source * 2u + 1u].xyz);
}

fn store_probe(index: u32, surface: Surface, pixel: vec2<u32>, kind: u32) {
    probes[index * 2u] = vec4<f32>(surface.position, f32(kind));
    probes[index * 2u + 1u] = vec4<f32>(surface.normal, bitcast<f32>(pixel.x | (pixel.y << 16u)));
}

// Where those that want to look as much as this one are counted, behind the claims: by need, then by rank, so that any number
// of ranks in sequence lie evenly on screen (ordered dither: Bayer 1973), others in each frame.
fn probe_order(tile: vec2<u32>, layer: u32, kind: u32, claim: u32, frame_index: u32) -> u32 {
    var need = layer;
    if kind == PROBE_IN_TURN { need = 2u; } else if claim != 0u { need = 3u; }
    var rank = 0u;
    for (var k = 0u; k < 4u; k++) {
        rank |= ((((tile.x ^ tile.y) >> k) & 1u) << 1u | ((tile.y >> k) & 1u)) << (6u - 2u * k);
    }
    return first_order() + need * PROBE_RANKS + (rank + 101u * frame_index) % PROBE_RANKS;
}

fn first_order() -> u32 {
    return PROBE_LAYERS * view.tiles.x * view.tiles.y;
}
