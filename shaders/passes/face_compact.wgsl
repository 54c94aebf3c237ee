// VisBuffer: the lit faces of the chosen bricks as one dense list (the talk's "Lighting Injection"). One workgroup a
// brick, one voxel of a block a thread; the host knows how many faces each brick has, so places need no counter.

#import lib/world.wgsl
#import shared/bricks.wgsl

@res var<storage, read> light_bricks: array<LightBrick>;
@res var<storage, read_write> vis_faces: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let index = group.x;
    let brick = light_bricks[index];
    let block_mask = world_bricks[brick.base];
    var place = brick.first_face;
    for (var block = 0u; block < 8u; block++) {
        if ((block_mask >> block) & 1u) == 0u { continue; }
        let corner = vec3<u32>(block & 1u, (block >> 1u) & 1u, block >> 2u) * BLOCK_VOXELS;
        let cell = corner + vec3<u32>(thread & 3u, (thread >> 2u) & 3u, thread >> 4u);
        let packed = brick_block(brick.base, block_mask, block);
        let voxel = block_voxel(packed, cell);
        if voxel.found {
            let local = cell.x | (cell.y << 3u) | (cell.z << 6u);
            for (var side = 0u; side < 6u; side++) {
                if is_lit(voxel, side) {
                    vis_faces[place + light_address(voxel, side) - packed.light] = (index << 12u) | (local << 3u) | side;
                }
            }
        }
        place += runs_lit(packed.runs);
    }
}
