// The sparse world, read side: the grid of bricks; lib/brick.wgsl reads the bricks. On the host src/bricks/grid.rs knows
// the grid.
//
// world_grid    per group: 64-bit mask of its 4 x 4 x 4 bricks, first entry; then entries: first word of each brick

#import shared/limits.wgsl
#import shared/frame.wgsl
#import lib/brick.wgsl
#import lib/run_time.wgsl

@res var<uniform> frame: Frame;
@res var<storage, read> world_grid: array<u32>;
@res var<storage, read> world_bricks: array<u32>;

fn brick_word(address: u32) -> u32 { return world_bricks[address]; }

fn group_address(group: vec3<u32>) -> u32 {
    let g = (group + frame.torus) & (frame.extent - 1u);
    return (g.x + frame.extent.x * (g.y + frame.extent.y * g.z)) * GROUP_WORDS;
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
