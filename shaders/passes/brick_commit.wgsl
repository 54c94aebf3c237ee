// Moves finished bricks to their place in the world. One workgroup a brick.

#import shared/bricks.wgsl

struct BrickCommitPush {
    first: u32,
}
var<immediate> push: BrickCommitPush;

@res var<storage, read> brick_copies: array<BrickCopy>;
@res var<storage, read> brick_source: array<u32>;
@res var<storage, read_write> world_bricks: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let copy = brick_copies[push.first + group.x];
    for (var i = thread; i < copy.words; i += 64u) {
        world_bricks[copy.target_word + i] = brick_source[copy.source + i];
    }
}
