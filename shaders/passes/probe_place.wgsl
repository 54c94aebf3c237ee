// One probe a tile. A tile whose turn it is, or whose pixels have not been seen for long, or that no probe of the last frame
// has come to, gets a new one, on a pixel that moves through the tile over time; the others keep the one that has come
// (`probe_reproject`).
//
// As `probe_adapt` it then fills the second layer: where pixels are found that the probes around them do not stand for, a
// strip of another surface or a thing narrower than a tile, one of these gets a probe, too. (Adaptive placement: Lumen,
// SIGGRAPH 2022.)

#import lib/history.wgsl
#import lib/lag.wgsl
#import lib/gather.wgsl
#import lib/ration.wgsl

struct ViewPush {
    frame_index: u32,
}
var<immediate> push: ViewPush;

// Two words of four floats a probe: position (camera-relative metres), one of PROBE_...; normal, its pixel's bits
// (x | y << 16).
// See `probe_reproject`; behind the claims, how many probes of each need and rank want to look.
@res var<storage, read_write> probe_claims: array<atomic<u32>>;

// Another line in `probe_adapt` (build.rs).
const ADAPTS: bool = false;
// Places that are tried.
const ATTEMPTS: u32 = 4u;
// Weight of all probes around a pixel below which they do not stand for it.
const ALONE: f32 = 0.01;

struct Place {
    surface: Surface,
    pixel: vec2<u32>,
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= view.tiles.x * view.tiles.y { return; }
    let tile = vec2<u32>(id.x % view.tiles.x, id.x / view.tiles.x);
    let index = probe_index(tile, u32(ADAPTS));
    let claim = atomicLoad(&probe_claims[index]);
    var place = find_place(tile, push.frame_index);
    var kind = select(PROBE_NONE, PROBE_NEW, place.surface.valid);
    // Its pixel stands for the tile's: it is another one in each frame. What looks twice at the same probes finds the same
    // twice.
    if !place.surface.valid || rests(place) {
        if is_turn(tile, push.frame_index) {
            place = find_place(tile, push.frame_index / view.gather_interval);
            kind = select(PROBE_NONE, PROBE_IN_TURN, place.surface.valid);
        } else if claim != 0u {
            let followed = follow_claim(claim);
            place = Place(followed.surface, followed.pixel);
            kind = PROBE_CARRIED;
            if ADAPTS && !rests(place) { kind = PROBE_NEW; }
        } else if ADAPTS {
            kind = PROBE_NONE;
        }
    }
    store_probe(index, place.surface, place.pixel, kind);
    if kind == PROBE_NONE || kind == PROBE_CARRIED { return; }
    atomicAdd(&probe_claims[probe_order(tile, u32(ADAPTS), kind, claim, push.frame_index)], 1u);
}

fn rests(place: Place) -> bool {
    return has_settled(load_history(place.surface, place.pixel)) && !load_lag(place.pixel / 8u).roused;
}

fn find_place(tile: vec2<u32>, index: u32) -> Place {
    var place = Place();
    // A tile may hold sky: a few places are tried. The rays have the sequence's other part.
    for (var attempt = 0u; attempt < ATTEMPTS && !place.surface.valid; attempt++) {
        let seed = u32(ADAPTS) * ATTEMPTS + attempt;
        place.pixel = tile * view.tile_size + vec2<u32>(kronecker4(seed, index).xy * f32(view.tile_size));
        if any(place.pixel >= view.size) { continue; }
        place.surface = load_surface(place.pixel);
        if ADAPTS && !is_alone(place) { place.surface.valid = false; }
    }
    return place;
}

// Whether the first layer's probes do not stand for a pixel.
fn is_alone(place: Place) -> bool {
    let distance = length(place.surface.position);
    var weight = 0.0;
    for (var k = 0u; k < 4u; k++) {
        weight += probe_weight(place.pixel, place.surface, distance, probe_around(place.pixel, k));
    }
    return weight < ALONE;
}
