// Bricks that are voxelised again keep their light: what the faces that stay have is copied into what takes their place.
// One workgroup a brick, one voxel of a block a thread.

#import shared/bricks.wgsl
#import lib/brick.wgsl

@res var<storage, read> light_carries: array<LightCarry>;
@res var<storage, read> world_bricks: array<u32>;
@res var<storage, read_write> brick_source: array<u32>;

// Set in addresses of `brick_source`.
const FRESH: u32 = 0x80000000u;

fn brick_word(address: u32) -> u32 {
    if address >= FRESH { return brick_source[address - FRESH]; }
    return world_bricks[address];
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let carry = light_carries[group.x];
    let old_mask = brick_word(carry.base);
    let fresh_mask = brick_word(FRESH + carry.source);
    for (var block = 0u; block < 8u; block++) {
        let cell = vec3<u32>(thread & 3u, (thread >> 2u) & 3u, thread >> 4u);
        let fresh = block_voxel(brick_block(FRESH + carry.source, fresh_mask, block), cell);
        if !fresh.found { continue; }
        let old = block_voxel(brick_block(carry.base, old_mask, block), cell);
        for (var side = 0u; side < 6u; side++) {
            if !is_lit(fresh, side) { continue; }
            var word = UNLIT;
            if old.found && is_lit(old, side) { word = world_bricks[light_address(old, side)]; }
            brick_source[light_address(fresh, side) - FRESH] = word;
        }
    }
}
