// The same from a flat layout: every brick of the window has a slot or none, every voxel of a slot a bit and six faces.

#import shared/limits.wgsl
#import shared/frame.wgsl

@res var<uniform> frame: Frame;
@res var<storage, read> flat_grid: array<u32>;
@res var<storage, read> flat_masks: array<u32>;
// Plane and light.
@res var<storage, read> flat_faces: array<vec2<u32>>;
@res var<storage, read> hits: array<vec4<i32>>;
@res var<storage, read_write> hit_words: array<vec2<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&hits) { return; }
    let cell = vec3<u32>(hits[id.x].xyz);
    let size = frame.extent * 4u;
    let brick = cell / BRICK_VOXELS;
    var words = vec2<u32>(0u);
    if all(brick < size) {
        let slot = flat_grid[brick.x + size.x * (brick.y + size.y * brick.z)];
        let voxel = (cell.x & 7u) | ((cell.y & 7u) << 3u) | ((cell.z & 7u) << 6u);
        if slot != NONE && ((flat_masks[slot * 16u + (voxel >> 5u)] >> (voxel & 31u)) & 1u) != 0u {
            words = flat_faces[(slot * 512u + voxel) * 6u + u32(hits[id.x].w)];
        }
    }
    hit_words[id.x] = words;
}
