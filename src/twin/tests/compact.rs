//! Bricks that move together on the GPU lie as a copy on the CPU would have them.

use crate::bricks::Arrived;
use crate::frame::Frame;
use crate::gpu::Location;
use crate::gpu::shared::{BrickCopy, PAGE_WORDS};
use crate::passes;
use crate::twin::gpu::Gpu;
use crate::twin::random::Random;

/// Gaps of a page to many, runs of a page to many times what the workgroup reads at once.
#[test]
fn runs_move_onto_their_own_places() {
    let mut random = Random::new(61);
    let mut gpu = Gpu::new(&["brick_commit", "brick_compact"]);
    for _ in 0..20 {
        let (mut runs, mut free, mut end) = (Vec::new(), 0, 0);
        for _ in 0..1 + random.below(40) {
            let most = [3, 64, 500][random.below(3) as usize];
            let source = end + 1 + random.below(most);
            let pages = 1 + random.below(most);
            let [source_word, target_word, words] = [source, free, pages].map(|pages| pages * PAGE_WORDS);
            runs.push(BrickCopy { source: source_word, target_word, words, unused: 0 });
            (free, end) = (free + pages, source + pages);
        }
        let mut expected: Vec<u32> = (0..end * PAGE_WORDS).map(|_| random.next() as u32).collect();
        let words = expected.len();
        gpu.buffer("world_bricks", words * 4, Location::Readback);
        let mut frame = Frame::default();
        frame.upload.push("brick_source", &expected);
        let all = BrickCopy { source: 0, target_word: 0, words: words as u32, unused: 0 };
        let arrived = Arrived { copies: vec![all], ..Arrived::default() };
        passes::bricks::commit(&mut frame, &[], &arrived, &[]);
        gpu.run(&frame);
        let mut frame = Frame::default();
        passes::bricks::commit(&mut frame, &runs, &Arrived::default(), &[]);
        gpu.run(&frame);
        for run in &runs {
            let [from, to, count] = [run.source, run.target_word, run.words].map(|word| word as usize);
            expected.copy_within(from..from + count, to);
        }
        assert!(gpu.read::<u32>("world_bricks", words) == expected, "{} runs, {end} pages", runs.len());
    }
}
