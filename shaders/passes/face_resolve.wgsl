// Packs the voxelised faces of a brick tightly, in the layout of lib/brick.wgsl. One workgroup a brick, one voxel of a
// block a thread. Surfaces that occur often are stored once, where that is shorter.

#import shared/limits.wgsl
#import lib/triangles.wgsl
#import lib/scan.wgsl
#import lib/run_time.wgsl

struct FaceResolvePush {
    first_brick: u32,
    // Words of `payload`.
    payload_words: u32,
    hit_model: u32,
}
var<immediate> push: FaceResolvePush;

@res var<storage, read> voxel_states: array<u32>;
@res var<storage, read> voxel_records: array<u32>;
// A bit for each cell of the apron: the cell is out of reach of light and eye.
@res var<storage, read> reach_masks: array<u32>;
@res var<storage, read_write> voxel_args: array<u32, 4>;
// Word 0: words used.
@res var<storage, read_write> payload_used: array<atomic<u32>, 4>;
@res var<storage, read_write> payload: array<u32>;
@res var<storage, read_write> brick_results: array<BrickResult>;

// An occupied voxel of a block, or zeros.
struct Packed {
    // Sides stored 6 | sides lit 6 << 6 | part-filled << 31.
    word: u32,
    // What stands below: voxels 7 | lit sides 9 << 7.
    place: u32,
    // Where its surfaces are or, with NEW set, are to be written.
    surface: u32,
}
const NEW: u32 = 0x80000000u;

// Per block: voxels 7 | lit sides 9 << 7 | surfaces 9 << 16 | emissive << 31.
var<workgroup> totals: array<u32, 8>;
var<workgroup> emissive: atomic<u32>;
var<workgroup> mask_low: array<atomic<u32>, 8>;
var<workgroup> mask_high: array<atomic<u32>, 8>;
var<workgroup> unreached: atomic<u32>;
var<workgroup> start: u32;
// Of a block's voxels: sides stored, and surfaces, six each.
var<workgroup> stored: array<u32, 64>;
var<workgroup> surfaces: array<vec2<u32>, 384>;
// Where a voxel's surfaces stand, if it is the first of its block to have them.
var<workgroup> places: array<u32, 64>;

fn voxel_count(total: u32) -> u32 { return total & 127u; }
fn lit_count(total: u32) -> u32 { return (total >> 7u) & 511u; }
fn surface_count(total: u32) -> u32 { return (total >> 16u) & 511u; }

// Words before a block's voxels.
fn voxels_run(total: u32) -> u32 { return lit_count(total) * (1u + (total >> 31u)); }

fn block_words(total: u32) -> u32 {
    return voxels_run(total) + voxel_count(total) + 2u * surface_count(total);
}

fn block_cell(block: u32, thread: u32) -> vec3<i32> {
    let corner = vec3<u32>(block & 1u, (block >> 1u) & 1u, block >> 2u) * 4u;
    return vec3<i32>(corner + vec3<u32>(thread & 3u, (thread >> 2u) & 3u, thread >> 4u));
}

fn state_at(batch: u32, cell: vec3<i32>) -> u32 {
    return voxel_states[batch * APRON_COUNT + apron_index(cell)];
}

fn record_of(batch: u32, cell: vec3<i32>, side: u32) -> u32 {
    return (batch * 512u + u32(cell.x + 8 * (cell.y + 8 * cell.z))) * RECORD_WORDS + side * 3u;
}

fn is_unreached(reach: u32, cell: vec3<i32>) -> bool {
    if reach == NONE { return false; }
    let bit = apron_index(cell);
    return ((reach_masks[reach + (bit >> 5u)] >> (bit & 31u)) & 1u) != 0u;
}

// `Packed.word` of a voxel.
fn voxel_word(batch: u32, reach: u32, cell: vec3<i32>) -> u32 {
    let state = state_at(batch, cell);
    let surface = state & 63u;
    if surface == 0u { return 0u; }
    let hit_model = at_run_time(push.hit_model, surface);
    var sides = surface;
    var lit = 0u;
    for (var side = 0u; side < 6u; side++) {
        let bit = 1u << side;
        let front_cell = cell + vec3<i32>(side_normal(side));
        let front = state_at(batch, front_cell);
        let open = (front & 63u) == 0u;
        if hit_model == 1u && open { sides |= bit; }
        if (sides & bit) == 0u { continue; }
        // A closed face is lit itself unless a thin wall lies in its voxel or in the one in front.
        let walls = ((state | front) >> 6u) & 7u & ~(1u << (side >> 1u));
        let emits = ((state >> (9u + side)) & 1u) != 0u;
        if open && !emits && is_unreached(reach, front_cell) {
            atomicAdd(&unreached, 1u);
            continue;
        }
        if open || (hit_model == 0u && (emits || walls == 0u)) { lit |= bit; }
    }
    return sides | (lit << 6u) | (((state >> 16u) & 1u) << 30u) | (((state >> 15u) & 1u) << 31u);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let batch = group.x;
    if thread < 8u {
        atomicStore(&mask_low[thread], 0u);
        atomicStore(&mask_high[thread], 0u);
    }
    if batch == 0u && thread == 0u { voxel_args[0] = 0u; }
    if thread == 0u { atomicStore(&unreached, 0u); }
    let reach = batch_bricks[push.first_brick + batch].reach;
    var voxels: array<Packed, 8>;
    for (var block = 0u; block < 8u; block++) {
        if thread == 0u { atomicStore(&emissive, 0u); }
        workgroupBarrier();
        let cell = block_cell(block, thread);
        let word = voxel_word(batch, reach, cell);
        let lit = (word >> 6u) & 63u;
        stored[thread] = word & 63u;
        if word != 0u {
            load_surfaces(batch, cell, word, thread);
            if thread < 32u { atomicOr(&mask_low[block], 1u << thread); } else { atomicOr(&mask_high[block], 1u << (thread - 32u)); }
            if ((state_at(batch, cell) >> 9u) & lit) != 0u { atomicOr(&emissive, 1u); }
        }
        workgroupBarrier();
        let like = first_like(thread);
        var size = vec2<u32>(0u);
        if word != 0u { size = vec2<u32>(1u | (countOneBits(lit) << 7u), select(0u, countOneBits(word & 63u), like == thread)); }
        let place = sum_below(thread, size);
        let total = scan[63];
        places[thread] = place.y;
        workgroupBarrier();
        voxels[block] = Packed(word, place.x, places[like] | select(0u, NEW, like == thread));
        if thread == 0u { totals[block] = total.x | (total.y << 16u) | (atomicLoad(&emissive) << 31u); }
    }
    workgroupBarrier();

    if thread == 0u { start = reserve(push.first_brick + batch); }
    let first = workgroupUniformLoad(&start);
    if first == NONE { return; }
    var run = first + 1u;
    for (var block = 0u; block < 8u; block++) {
        if voxel_count(totals[block]) != 0u { run += BLOCK_WORDS; }
    }
    for (var block = 0u; block < 8u; block++) {
        let cell = block_cell(block, thread);
        if voxels[block].word != 0u { write_voxel(batch, cell, voxels[block], run, totals[block]); }
        run += block_words(totals[block]);
    }
}

// Plane and albedo word of a stored side. A side without surface (cube hits): the plane of its outer wall, the albedo of
// another side (hole repair).
fn side_surface(batch: u32, cell: vec3<i32>, side: u32) -> vec2<u32> {
    let surface = state_at(batch, cell) & 63u;
    if ((surface >> side) & 1u) == 0u {
        let plane = plane_encode(side, side_normal(side), vec3<f32>(0.5) + 0.49 * side_normal(side));
        return vec2<u32>(plane, voxel_records[record_of(batch, cell, firstTrailingBit(surface)) + 1u]);
    }
    let record = record_of(batch, cell, side);
    return vec2<u32>(voxel_records[record], voxel_records[record + 1u]);
}

fn load_surfaces(batch: u32, cell: vec3<i32>, word: u32, thread: u32) {
    for (var side = 0u; side < 6u; side++) {
        if ((word >> side) & 1u) != 0u { surfaces[thread * 6u + side] = side_surface(batch, cell, side); }
    }
}

// The first voxel of the block that has the same surfaces.
fn first_like(thread: u32) -> u32 {
    let sides = stored[thread];
    for (var other = 0u; other < thread; other++) {
        if stored[other] != sides { continue; }
        var same = true;
        for (var rest = sides; same && rest != 0u; rest &= rest - 1u) {
            let side = firstTrailingBit(rest);
            same = all(surfaces[other * 6u + side] == surfaces[thread * 6u + side]);
        }
        if same { return other; }
    }
    return thread;
}

// Takes room in the payload, tells the host, and writes the brick's header.
fn reserve(brick: u32) -> u32 {
    var size = 1u;
    var block_mask = 0u;
    var faces = 0u;
    var counts = 0u;
    var occupied = array<u32, 16>();
    for (var block = 0u; block < 8u; block++) {
        occupied[2u * block] = atomicLoad(&mask_low[block]);
        occupied[2u * block + 1u] = atomicLoad(&mask_high[block]);
        let total = totals[block];
        if voxel_count(total) == 0u { continue; }
        block_mask |= 1u << block;
        size += BLOCK_WORDS + block_words(total);
        faces += lit_count(total);
        counts += voxel_count(total) | (surface_count(total) << 16u);
    }
    if block_mask == 0u {
        brick_results[brick] = BrickResult();
        return NONE;
    }
    let first = atomicAdd(&payload_used[0], size);
    let fits = first + size <= push.payload_words;
    brick_results[brick] = BrickResult(size, select(NONE, first, fits), faces, counts, atomicLoad(&unreached), occupied);
    if !fits { return NONE; }
    payload[first] = block_mask;
    var record = first + 1u;
    var run = 1u + BLOCK_WORDS * countOneBits(block_mask);
    for (var block = 0u; block < 8u; block++) {
        let total = totals[block];
        if voxel_count(total) == 0u { continue; }
        payload[record] = atomicLoad(&mask_low[block]);
        payload[record + 1u] = atomicLoad(&mask_high[block]);
        payload[record + 2u] = run | (lit_count(total) << 16u) | (total & 0x80000000u);
        record += BLOCK_WORDS;
        run += block_words(total);
    }
    return first;
}

// A voxel, its surfaces if it is the first to have them, its emission, and its light, which starts at the emission.
fn write_voxel(batch: u32, cell: vec3<i32>, voxel: Packed, run: u32, total: u32) {
    let surface = state_at(batch, cell) & 63u;
    let first_surface = voxel.surface & ~NEW;
    let voxel_at = run + voxels_run(total);
    payload[voxel_at + voxel_count(voxel.place)] = voxel.word | (first_surface << 12u) | (lit_count(voxel.place) << 21u);
    var at = voxel_at + voxel_count(total) + 2u * first_surface;
    var light = run + lit_count(voxel.place);
    for (var side = 0u; side < 6u; side++) {
        if ((voxel.word >> side) & 1u) == 0u { continue; }
        if (voxel.surface & NEW) != 0u {
            let words = side_surface(batch, cell, side);
            payload[at] = words.x;
            payload[at + 1u] = words.y;
            at += 2u;
        }
        if ((voxel.word >> (side + 6u)) & 1u) == 0u { continue; }
        var emission = 0u;
        if (total >> 31u) != 0u {
            if ((surface >> side) & 1u) != 0u { emission = voxel_records[record_of(batch, cell, side) + 2u]; }
            payload[light + lit_count(total)] = emission;
        }
        payload[light] = emission;
        light += 1u;
    }
}
