// One probe a tile. A tile whose turn it is, or whose pixels have not been seen for long, or that no probe of the last frame
// has come to, gets a new one, on a pixel that moves through the tile over time; the others keep the one that has come
// (`probe_reproject`).

#import lib/history.wgsl
#import lib/lag.wgsl
#import lib/follow.wgsl

struct ViewPush {
    frame_index: u32,
}
var<immediate> push: ViewPush;

@res var<storage, read> probes_in: array<vec4<f32>>;
// Two words of four floats a probe: position (camera-relative metres), one of PROBE_...; normal, its pixel's bits
// (x | y << 16).
@res var<storage, read_write> probes: array<vec4<f32>>;
@res var<storage, read> probe_claims: array<u32>;

struct Place {
    surface: Surface,
    pixel: vec2<u32>,
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= view.tiles.x * view.tiles.y { return; }
    let tile = vec2<u32>(id.x % view.tiles.x, id.x / view.tiles.x);
    let claim = probe_claims[id.x];
    var place = find_place(tile, push.frame_index);
    var kind = select(PROBE_NONE, PROBE_NEW, place.surface.valid);
    // Its pixel stands for the tile's: it is another one in each frame.
    // What looks twice at the same probes finds the same twice.
    let rests = has_settled(load_history(place.surface, place.pixel)) && !load_lag(place.pixel / 8u).roused;
    if !place.surface.valid || rests {
        if is_turn(tile, push.frame_index) {
            place = find_place(tile, push.frame_index / view.gather_interval);
            kind = select(PROBE_NONE, PROBE_IN_TURN, place.surface.valid);
        } else if claim != 0u {
            let source = claim & PROBE_MASK;
            let old = probes_in[source * 2u];
            let followed = follow_probe(old.xyz + view.camera_delta, probes_in[source * 2u + 1u].xyz);
            place.surface = followed.surface;
            place.pixel = followed.pixel;
            kind = PROBE_CARRIED;
        }
    }
    probes[id.x * 2u] = vec4<f32>(place.surface.position, f32(kind));
    probes[id.x * 2u + 1u] = vec4<f32>(place.surface.normal, bitcast<f32>(place.pixel.x | (place.pixel.y << 16u)));
}

fn find_place(tile: vec2<u32>, index: u32) -> Place {
    var place = Place();
    // A tile may hold sky: a few places are tried. The rays have the sequence's other part.
    for (var attempt = 0u; attempt < 4u && !place.surface.valid; attempt++) {
        place.pixel = tile * view.tile_size + vec2<u32>(kronecker4(attempt, index).xy * f32(view.tile_size));
        if all(place.pixel < view.size) { place.surface = load_surface(place.pixel); }
    }
    return place;
}
