// A brick's words, as `brick_word` gives them, which whoever imports this declares. `face_resolve` writes them.
//
// Word 0: mask of its 2 x 2 x 2 blocks. Then a record for each: mask low, mask high, runs = first word 16 (from the brick)
// | lit sides 9 << 16 | emissive << 31. A block's words:
//
// light      a word a lit side: RGB9E5
// emission   in emissive blocks: a word a lit side, RGB9E5
// voxels     a word each: sides stored 6 | sides lit 6 << 6 | first surface 9 << 12 | first light 9 << 21
//            | lets light through << 30 | part-filled << 31
// surfaces   two words a stored side: plane; then albedo (RGB 11 11 10 of the square root), in part-filled voxels coverage
//            mask << 16 | albedo (RGB 5 6 5 of the square root). Voxels of equal surfaces share them

#import shared/limits.wgsl
#import lib/pack.wgsl

// Position of a 4 x 4 x 4 child inside its parent's 64-bit mask.
fn child_bit(p: vec3<u32>) -> u32 {
    return (p.x & 3u) | ((p.y & 3u) << 2u) | ((p.z & 3u) << 4u);
}

fn mask_has(low: u32, high: u32, bit: u32) -> bool {
    return ((select(low, high, bit >= 32u) >> (bit & 31u)) & 1u) != 0u;
}

// Set bits below `bit`.
fn mask_rank(low: u32, high: u32, bit: u32) -> u32 {
    let below = (1u << (bit & 31u)) - 1u;
    return select(countOneBits(low & below), countOneBits(low) + countOneBits(high & below), bit >= 32u);
}

// Block of a voxel inside its brick.
fn block_index(cell: vec3<u32>) -> u32 {
    return ((cell.x >> 2u) & 1u) | (((cell.y >> 2u) & 1u) << 1u) | (((cell.z >> 2u) & 1u) << 2u);
}

fn runs_lit(runs: u32) -> u32 { return (runs >> 16u) & 511u; }
fn runs_emissive(runs: u32) -> u32 { return runs >> 31u; }

// A block of 4 x 4 x 4 voxels; all zero: absent.
struct Block {
    // Mask of its occupied voxels.
    low: u32,
    high: u32,
    runs: u32,
    // Addresses of its light and voxels.
    light: u32,
    voxels: u32,
}

fn brick_block(brick: u32, block_mask: u32, block: u32) -> Block {
    if ((block_mask >> block) & 1u) == 0u { return Block(); }
    let record = brick + 1u + BLOCK_WORDS * countOneBits(block_mask & ((1u << block) - 1u));
    let runs = brick_word(record + 2u);
    let light = brick + (runs & 0xffffu);
    let voxels = light + runs_lit(runs) * (1u + runs_emissive(runs));
    return Block(brick_word(record), brick_word(record + 1u), runs, light, voxels);
}

// An occupied voxel.
struct Voxel {
    found: bool,
    word: u32,
    // Of its block.
    runs: u32,
    // Address of its first light.
    light: u32,
    // Address of its first surface.
    surfaces: u32,
}

fn block_voxel(block: Block, cell: vec3<u32>) -> Voxel {
    let bit = child_bit(cell);
    if !mask_has(block.low, block.high, bit) { return Voxel(); }
    let word = brick_word(block.voxels + mask_rank(block.low, block.high, bit));
    let surfaces = block.voxels + countOneBits(block.low) + countOneBits(block.high) + 2u * ((word >> 12u) & 511u);
    return Voxel(true, word, block.runs, block.light + ((word >> 21u) & 511u), surfaces);
}

fn brick_voxel(brick: u32, block_mask: u32, cell: vec3<u32>) -> Voxel {
    return block_voxel(brick_block(brick, block_mask, block_index(cell)), cell);
}

fn has_side(v: Voxel, side: u32) -> bool {
    return ((v.word >> side) & 1u) != 0u;
}

fn is_lit(v: Voxel, side: u32) -> bool {
    return ((v.word >> (side + 6u)) & 1u) != 0u;
}

fn is_translucent(v: Voxel) -> bool {
    return ((v.word >> 30u) & 1u) != 0u;
}

fn is_part_filled(v: Voxel) -> bool {
    return (v.word >> 31u) != 0u;
}

// Address of a stored side's surface.
fn surface_address(v: Voxel, side: u32) -> u32 {
    return v.surfaces + 2u * countOneBits(v.word & ((1u << side) - 1u));
}

fn voxel_plane(v: Voxel, side: u32) -> Plane {
    return plane_decode(side, brick_word(surface_address(v, side)));
}

// 4 x 4 coverage of a stored side.
fn voxel_mask(v: Voxel, side: u32) -> u32 {
    if !is_part_filled(v) { return 0xffffu; }
    return brick_word(surface_address(v, side) + 1u) >> 16u;
}

fn covers(v: Voxel, side: u32, p: vec3<f32>) -> bool {
    return !is_part_filled(v) || ((voxel_mask(v, side) >> mask_bit(side >> 1u, p)) & 1u) != 0u;
}

fn voxel_albedo(v: Voxel, side: u32) -> vec3<f32> {
    let word = brick_word(surface_address(v, side) + 1u);
    if is_part_filled(v) { return albedo_decode(word & 0xffffu); }
    return fine_albedo_decode(word);
}

// Address of a lit side's radiance.
fn light_address(v: Voxel, side: u32) -> u32 {
    return v.light + countOneBits((v.word >> 6u) & ((1u << side) - 1u));
}

fn voxel_emission(v: Voxel, side: u32) -> vec3<f32> {
    if runs_emissive(v.runs) == 0u { return vec3<f32>(0.0); }
    return rgb9e5_decode(brick_word(light_address(v, side) + runs_lit(v.runs)));
}
