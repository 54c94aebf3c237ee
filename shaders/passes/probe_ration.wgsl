// Where more probes want to look than may (`probes_per_frame`), some are put off: they keep the last frame's that has come, or
// their tile has none in this frame. First come those of tiles that would have none.

#import lib/ration.wgsl

struct ViewPush {
    frame_index: u32,
}
var<immediate> push: ViewPush;

@res var<storage, read> probe_claims: array<u32>;

// A thread's part of the numbers of `probe_order`.
const SHARE: u32 = PROBE_NEEDS * PROBE_RANKS / 64u;

var<workgroup> sums: array<u32, 64>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    var sum = 0u;
    for (var k = 0u; k < SHARE; k++) { sum += probe_claims[first_order() + thread * SHARE + k]; }
    sums[thread] = sum;
    workgroupBarrier();
    let tile = vec2<u32>(id.x % view.tiles.x, id.x / view.tiles.x % view.tiles.y);
    let layer = id.x / (view.tiles.x * view.tiles.y);
    if layer >= PROBE_LAYERS { return; }
    let kind = u32(probes[id.x * 2u].w);
    if kind == PROBE_NONE || kind == PROBE_CARRIED { return; }
    let claim = probe_claims[id.x];
    let order = probe_order(tile, layer, kind, claim, push.frame_index);
    let share = (order - first_order()) / SHARE;
    var before = 0u;
    for (var k = 0u; k < share; k++) { before += sums[k]; }
    for (var k = first_order() + share * SHARE; k < order; k++) { before += probe_claims[k]; }
    // All of the same number at once: some may always look.
    if before < view.probes_per_frame { return; }
    if claim == 0u {
        probes[id.x * 2u].w = f32(PROBE_NONE);
        return;
    }
    let followed = follow_claim(claim);
    store_probe(id.x, followed.surface, followed.pixel, PROBE_CARRIED);
}
