// What a hit reads, from the layout of lib/brick.wgsl: whether the voxel is occupied, the side's plane and its light.

#import lib/world.wgsl

// Cell, and side.
@res var<storage, read> hits: array<vec4<i32>>;
@res var<storage, read_write> hit_words: array<vec2<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&hits) { return; }
    let voxel = find_voxel(hits[id.x].xyz);
    let side = u32(hits[id.x].w);
    var words = vec2<u32>(0u);
    if voxel.found && has_side(voxel, side) {
        words.x = world_bricks[surface_address(voxel, side)];
        if is_lit(voxel, side) { words.y = world_bricks[light_address(voxel, side)]; }
    }
    hit_words[id.x] = words;
}
