// Packs the voxelised faces of a brick tightly: masks, voxels, planes, coverage, emission, albedo. One workgroup a
// brick, one voxel of a block a thread. The layout is that of lib/world.wgsl.

#import lib/triangles.wgsl

struct FaceResolvePush {
    first_brick: u32,
    // Words of `payload`.
    payload_words: u32,
    hit_model: u32,
}
var<immediate> push: FaceResolvePush;

@res var<storage, read> voxel_states: array<u32>;
@res var<storage, read> voxel_records: array<u32>;
@res var<storage, read_write> voxel_args: array<u32, 4>;
// Word 0: words used.
@res var<storage, read_write> payload_used: array<atomic<u32>, 4>;
@res var<storage, read_write> payload: array<u32>;
@res var<storage, read_write> brick_results: array<BrickResult>;

var<workgroup> scan: array<u32, 64>;
// Per block: voxels 7 | plane words 10 << 7 | lit 9 << 17 | emissive << 31.
var<workgroup> totals: array<u32, 8>;
var<workgroup> emissive: atomic<u32>;
var<workgroup> mask_low: array<atomic<u32>, 8>;
var<workgroup> mask_high: array<atomic<u32>, 8>;
var<workgroup> start: u32;

const VOXELS: u32 = 127u;

fn plane_words(total: u32) -> u32 { return (total >> 7u) & 1023u; }
fn lit_count(total: u32) -> u32 { return (total >> 17u) & 511u; }

fn block_words(total: u32) -> u32 {
    let lit = lit_count(total);
    return (total & VOXELS) + plane_words(total) + lit * (1u + (total >> 31u)) + ((lit + 1u) >> 1u);
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

// Sides stored 6 | lit 6 << 6 | part-filled << 31 of an occupied voxel; 0 for an empty one.
fn voxel_word(batch: u32, cell: vec3<i32>) -> u32 {
    let state = state_at(batch, cell);
    let surface = state & 63u;
    if surface == 0u { return 0u; }
    var sides = surface;
    var lit = 0u;
    var part = 0u;
    for (var side = 0u; side < 6u; side++) {
        let bit = 1u << side;
        let front = state_at(batch, cell + vec3<i32>(side_normal(side)));
        let open = (front & 63u) == 0u;
        if push.hit_model == 1u && open { sides |= bit; }
        if (sides & bit) == 0u { continue; }
        // A closed face is lit itself unless a thin wall lies in its voxel or in the one in front.
        let walls = ((state | front) >> 6u) & 7u & ~(1u << (side >> 1u));
        let emits = ((state >> (9u + side)) & 1u) != 0u;
        if open || (push.hit_model == 0u && (emits || walls == 0u)) { lit |= bit; }
        if (surface & bit) != 0u && (voxel_records[record_of(batch, cell, side) + 1u] & 0xffffu) != 0xffffu { part = 1u; }
    }
    if push.hit_model == 1u { part = 0u; }
    return sides | (lit << 6u) | (part << 31u);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let batch = group.x;
    if thread < 8u {
        atomicStore(&mask_low[thread], 0u);
        atomicStore(&mask_high[thread], 0u);
    }
    if batch == 0u && thread == 0u { voxel_args[0] = 0u; }
    var words: array<u32, 8>;
    var places: array<u32, 8>;
    for (var block = 0u; block < 8u; block++) {
        let cell = block_cell(block, thread);
        let word = voxel_word(batch, cell);
        words[block] = word;
        if thread == 0u { atomicStore(&emissive, 0u); }
        workgroupBarrier();
        let sides = countOneBits(word & 63u);
        let lit = (word >> 6u) & 63u;
        var size = 0u;
        if word != 0u {
            let masks = (word >> 31u) * ((sides + 1u) >> 1u);
            size = 1u | ((sides + masks) << 7u) | (countOneBits(lit) << 17u);
            if thread < 32u { atomicOr(&mask_low[block], 1u << thread); } else { atomicOr(&mask_high[block], 1u << (thread - 32u)); }
            if ((state_at(batch, cell) >> 9u) & lit) != 0u { atomicOr(&emissive, 1u); }
        }
        scan[thread] = size;
        workgroupBarrier();
        for (var reach = 1u; reach < 64u; reach <<= 1u) {
            var left = 0u;
            if thread >= reach { left = scan[thread - reach]; }
            workgroupBarrier();
            scan[thread] += left;
            workgroupBarrier();
        }
        places[block] = scan[thread] - size;
        if thread == 63u { totals[block] = scan[63] | (atomicLoad(&emissive) << 31u); }
        workgroupBarrier();
    }

    if thread == 0u { start = reserve(push.first_brick + batch); }
    let first = workgroupUniformLoad(&start);
    if first == NONE { return; }
    write_brick(batch, thread, first, &words, &places);
}

// Takes room in the payload, tells the host, and writes the brick's header.
fn reserve(brick: u32) -> u32 {
    var size = 1u;
    var block_mask = 0u;
    var faces = 0u;
    var counts = 0u;
    for (var block = 0u; block < 8u; block++) {
        let total = totals[block];
        if (total & VOXELS) == 0u { continue; }
        block_mask |= 1u << block;
        size += BLOCK_WORDS + block_words(total);
        faces += lit_count(total);
        counts += (total & VOXELS) | (plane_words(total) << 16u);
    }
    if block_mask == 0u {
        brick_results[brick] = BrickResult(0u, 0u, 0u, 0u);
        return NONE;
    }
    let first = atomicAdd(&payload_used[0], size);
    let fits = first + size <= push.payload_words;
    brick_results[brick] = BrickResult(size, select(NONE, first, fits), faces, counts);
    if !fits { return NONE; }
    payload[first] = block_mask;
    var record = first + 1u;
    var run = 1u + BLOCK_WORDS * countOneBits(block_mask);
    for (var block = 0u; block < 8u; block++) {
        let total = totals[block];
        if (total & VOXELS) == 0u { continue; }
        let plane_run = run + (total & VOXELS);
        let light_run = plane_run + plane_words(total);
        payload[record] = atomicLoad(&mask_low[block]);
        payload[record + 1u] = atomicLoad(&mask_high[block]);
        payload[record + 2u] = run | (plane_run << 16u);
        payload[record + 3u] = light_run | (lit_count(total) << 16u) | (total & 0x80000000u);
        record += BLOCK_WORDS;
        run += block_words(total);
    }
    return first;
}

fn write_brick(batch: u32, thread: u32, first: u32, words: ptr<function, array<u32, 8>>, places: ptr<function, array<u32, 8>>) {
    var run = first + 1u;
    for (var block = 0u; block < 8u; block++) {
        if (totals[block] & VOXELS) != 0u { run += BLOCK_WORDS; }
    }
    for (var block = 0u; block < 8u; block++) {
        let total = totals[block];
        let word = (*words)[block];
        let place = (*places)[block];
        if word != 0u {
            payload[run + (place & VOXELS)] = word | (plane_words(place) << 12u) | (lit_count(place) << 22u);
            write_voxel(batch, block_cell(block, thread), word, run + (total & VOXELS), place, total);
        }
        // 16-bit albedos of two voxels may share a word: one thread packs them all.
        storageBarrier();
        workgroupBarrier();
        if thread == 0u { pack_albedos(run, total); }
        workgroupBarrier();
        run += block_words(total);
    }
}

// Planes, coverage, emission; the albedo of each face goes through its light word for now.
fn write_voxel(batch: u32, cell: vec3<i32>, word: u32, plane_run: u32, place: u32, total: u32) {
    var plane = plane_run + plane_words(place);
    let masks = plane + countOneBits(word & 63u);
    var light = plane_run + plane_words(total) + lit_count(place);
    let surface = state_at(batch, cell) & 63u;
    var mask_word = 0u;
    var rank = 0u;
    for (var side = 0u; side < 6u; side++) {
        if ((word >> side) & 1u) == 0u { continue; }
        // A side without surface (cube hits): the plane of its outer wall, the albedo of another side (hole repair).
        let own = ((surface >> side) & 1u) != 0u;
        let record = record_of(batch, cell, select(firstTrailingBit(surface), side, own));
        payload[plane] = voxel_records[record];
        if !own { payload[plane] = plane_encode(side, side_normal(side), vec3<f32>(0.5) + 0.49 * side_normal(side)); }
        plane += 1u;
        let cover = voxel_records[record + 1u];
        mask_word |= (cover & 0xffffu) << ((rank & 1u) * 16u);
        if (word >> 31u) != 0u && ((rank & 1u) == 1u || rank + 1u == countOneBits(word & 63u)) {
            payload[masks + (rank >> 1u)] = mask_word;
            mask_word = 0u;
        }
        rank += 1u;
        if ((word >> (side + 6u)) & 1u) != 0u {
            payload[light] = cover >> 16u;
            if (total >> 31u) != 0u { payload[light + lit_count(total)] = select(0u, voxel_records[record + 2u], own); }
            light += 1u;
        }
    }
}

// Albedos two a word; light starts at the emission.
fn pack_albedos(run: u32, total: u32) {
    let lit = lit_count(total);
    let light = run + (total & VOXELS) + plane_words(total);
    let albedo = light + lit * (1u + (total >> 31u));
    for (var i = 0u; i < lit; i += 2u) {
        var pair = payload[light + i];
        if i + 1u < lit { pair |= payload[light + i + 1u] << 16u; }
        payload[albedo + (i >> 1u)] = pair;
    }
    for (var i = 0u; i < lit; i++) {
        payload[light + i] = 0u;
        if (total >> 31u) != 0u { payload[light + i] = payload[light + lit + i]; }
    }
}
