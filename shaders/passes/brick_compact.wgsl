// Moves runs of bricks towards the start of the world, one after the other. A run may land on its own place before: one
// workgroup does it all, and has read a piece before it writes it.

#import shared/limits.wgsl
#import shared/bricks.wgsl

struct BrickCompactPush {
    count: u32,
}
var<immediate> push: BrickCompactPush;

// Places and words are whole pages; `source` is in `world_bricks`, too.
@res var<storage, read> brick_moves: array<BrickCopy>;
@res var<storage, read_write> world_bricks: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) thread: u32) {
    for (var index = 0u; index < push.count; index++) {
        let run = brick_moves[index];
        // A page a thread.
        for (var first = 0u; first < run.words; first += 64u * PAGE_WORDS) {
            let at = first + thread * PAGE_WORDS;
            var page: array<u32, PAGE_WORDS>;
            if at < run.words {
                for (var i = 0u; i < PAGE_WORDS; i++) { page[i] = world_bricks[run.source + at + i]; }
            }
            storageBarrier();
            if at < run.words {
                for (var i = 0u; i < PAGE_WORDS; i++) { world_bricks[run.target_word + at + i] = page[i]; }
            }
            storageBarrier();
        }
    }
}
