// The sparse world, read side. `face_resolve` writes this layout, `light_store` finds light in it; on the host
// src/bricks/grid.rs knows the grid.
//
// world_grid    per group: 64-bit mask of its 4 x 4 x 4 bricks, first entry; then entries: first word of each brick
// world_bricks  per brick: word 0 = mask of its 2 x 2 x 2 blocks; block records; then per block: voxels, planes, light
//
// Block record: mask low, mask high, voxels | planes << 16, light | count << 16 | emissive << 31 (words from the brick).
// Voxel: sides stored 6 | sides lit 6 << 6 | first plane 10 << 12 | first light 9 << 22 | part-filled << 31.
// A part-filled voxel's planes are followed by a 16-bit coverage mask for each. Light: RGB9E5 of each lit side, then
// (emissive blocks) RGB9E5 emission of each, then 16-bit albedo of each.

#import shared/limits.wgsl
#import shared/frame.wgsl
#import lib/pack.wgsl

@res var<uniform> frame: Frame;
@res var<storage, read> world_grid: array<u32>;
@res var<storage, read> world_bricks: array<u32>;

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

fn group_address(group: vec3<u32>) -> u32 {
    let g = (group + frame.torus) & (frame.extent - 1u);
    return (g.x + frame.extent.x * (g.y + frame.extent.y * g.z)) * GROUP_WORDS;
}

// Block of a voxel inside its brick.
fn block_index(cell: vec3<u32>) -> u32 {
    return ((cell.x >> 2u) & 1u) | (((cell.y >> 2u) & 1u) << 1u) | (((cell.z >> 2u) & 1u) << 2u);
}

// An occupied voxel.
struct Voxel {
    found: bool,
    word: u32,
    // Address of its first plane.
    planes: u32,
    // First word of its brick.
    brick: u32,
    // Light word of its block's record.
    light: u32,
}

fn brick_voxel(brick: u32, block_mask: u32, cell: vec3<u32>) -> Voxel {
    let block = block_index(cell);
    if ((block_mask >> block) & 1u) == 0u { return Voxel(); }
    let record = brick + 1u + BLOCK_WORDS * countOneBits(block_mask & ((1u << block) - 1u));
    let low = world_bricks[record];
    let high = world_bricks[record + 1u];
    let bit = child_bit(cell);
    if !mask_has(low, high, bit) { return Voxel(); }
    let runs = world_bricks[record + 2u];
    let word = world_bricks[brick + (runs & 0xffffu) + mask_rank(low, high, bit)];
    return Voxel(true, word, brick + (runs >> 16u) + ((word >> 12u) & 1023u), brick, world_bricks[record + 3u]);
}

// First word of the brick that holds a voxel, or NONE.
fn find_brick(cell: vec3<u32>) -> u32 {
    let group = group_address(cell >> vec3<u32>(5u));
    let low = world_grid[group];
    let high = world_grid[group + 1u];
    let bit = child_bit(cell >> vec3<u32>(3u));
    if !mask_has(low, high, bit) { return NONE; }
    return world_grid[world_grid[group + 2u] + mask_rank(low, high, bit)];
}

fn find_voxel(cell: vec3<i32>) -> Voxel {
    if any(cell < vec3<i32>(0)) || any(vec3<u32>(cell) >= frame.extent * GROUP_VOXELS) { return Voxel(); }
    let brick = find_brick(vec3<u32>(cell));
    if brick == NONE { return Voxel(); }
    return brick_voxel(brick, world_bricks[brick], vec3<u32>(cell));
}

fn has_side(v: Voxel, side: u32) -> bool {
    return ((v.word >> side) & 1u) != 0u;
}

fn is_lit(v: Voxel, side: u32) -> bool {
    return ((v.word >> (side + 6u)) & 1u) != 0u;
}

// Rank of a side among the stored ones.
fn side_rank(v: Voxel, side: u32) -> u32 {
    return countOneBits(v.word & ((1u << side) - 1u));
}

fn voxel_plane(v: Voxel, side: u32) -> Plane {
    return plane_decode(side, world_bricks[v.planes + side_rank(v, side)]);
}

// 4 x 4 coverage of a stored side.
fn voxel_mask(v: Voxel, side: u32) -> u32 {
    if (v.word >> 31u) == 0u { return 0xffffu; }
    let rank = side_rank(v, side);
    let words = world_bricks[v.planes + countOneBits(v.word & 63u) + (rank >> 1u)];
    return (words >> ((rank & 1u) * 16u)) & 0xffffu;
}

fn covers(v: Voxel, side: u32, p: vec3<f32>) -> bool {
    return (v.word >> 31u) == 0u || ((voxel_mask(v, side) >> mask_bit(side >> 1u, p)) & 1u) != 0u;
}

// Place of a lit side among its block's lit sides.
fn light_rank(v: Voxel, side: u32) -> u32 {
    return ((v.word >> 22u) & 511u) + countOneBits((v.word >> 6u) & ((1u << side) - 1u));
}

// Address of a lit side's radiance.
fn light_address(v: Voxel, side: u32) -> u32 {
    return v.brick + (v.light & 0xffffu) + light_rank(v, side);
}

fn voxel_emission(v: Voxel, side: u32) -> vec3<f32> {
    if (v.light >> 31u) == 0u { return vec3<f32>(0.0); }
    return rgb9e5_decode(world_bricks[light_address(v, side) + ((v.light >> 16u) & 511u)]);
}

fn voxel_albedo(v: Voxel, side: u32) -> vec3<f32> {
    let rank = light_rank(v, side);
    let runs = 1u + (v.light >> 31u);
    let first = v.brick + (v.light & 0xffffu) + ((v.light >> 16u) & 511u) * runs;
    return albedo_decode((world_bricks[first + (rank >> 1u)] >> ((rank & 1u) * 16u)) & 0xffffu);
}
