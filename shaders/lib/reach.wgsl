// Rays that come to a face without light, though nothing stands before it: they ask the host to flood in what is there.

#import lib/hdda.wgsl
#import lib/random.wgsl

// Word 0: probes that looked; 1 to 3: the last frame's probes that came to a tile, those that came to one where another
// was, and those that were given up. From REQUESTS_WORD on, two words for each of REQUESTS places: how many rays have
// asked, and the cell that one of them asked for (window, halved: x | y << 10 | z << 20).
@res var<storage, read_write> counters: array<atomic<u32>, COUNTER_WORDS>;

// The ray must have started where light or eye reaches.
fn ask_for_light(hit: Hit) {
    if at_run_time(frame.unreached, hit.side) == 0u || hit.kind == MISS || is_lit(find_voxel(hit.cell), hit.side) { return; }
    let front = hit.cell + vec3<i32>(side_normal(hit.side));
    if any(front < vec3<i32>(0)) || find_voxel(front).found { return; }
    let brick = vec3<u32>(front) >> vec3<u32>(3u);
    let place = REQUESTS_WORD + 2u * (pcg(brick.x | (brick.y << 10u) | (brick.z << 20u)) % REQUESTS);
    let half = vec3<u32>(front) >> vec3<u32>(1u);
    atomicAdd(&counters[place], 1u);
    atomicStore(&counters[place + 1u], half.x | (half.y << 10u) | (half.z << 20u));
}
