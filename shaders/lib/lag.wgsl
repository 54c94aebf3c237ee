// Whether the light of 8 x 8 pixels has changed: by how much they find it brighter than their averages say, all together, so
// that the noise of one ray is not mistaken for it. An average is never drawn towards what a frame has found, only counts
// for less from the next one on: in the mean it keeps what it has.

#import lib/history.wgsl

// Behind the history's pixels, two words for each 8 x 8: means as halves; deviation as half | count << 16.
struct Lag {
    // Of what the last few frames in which they looked found, less what was known, over that; and of more of them.
    means: vec2<f32>,
    // Of one such frame.
    deviation: f32,
    // Frames in which they looked.
    count: u32,
    // These pixels, or those of a turn with them, lag behind.
    roused: bool,
}

// Weight of a frame in the means, and in the deviation once it is known.
const LAG_RATES: vec2<f32> = vec2<f32>(0.5, 0.125);
const DEVIATION_RATE: f32 = 0.015625;
// Frames after which the deviation is known.
const LAG_KNOWN: u32 = 8u;
// Deviations of the mean from which on it is a change, and from which on more frames are to tell.
const SIGNIFICANT: f32 = 4.0;
const SUSPICIOUS: f32 = 2.4;
// Deviations that one frame counts for at most: alone it may be suspicious, but is no change. A rare bright ray would
// otherwise have the average that it is in forgotten, and the light with it.
const ONE_FRAME: f32 = 3.0;
// Part of what is known that is worth it.
const NOTABLE: f32 = 0.05;

fn lag_at(group: vec2<u32>) -> u32 {
    return view.lag_start + 2u * (group.y * ((view.stride + 7u) / 8u) + group.x);
}

fn read_lag(group: vec2<u32>) -> Lag {
    let at = lag_at(group);
    let word = history_in[at + 1u];
    return Lag(unpack2x16float(history_in[at]), unpack2x16float(word).x, word >> 16u, false);
}

fn load_lag(place: vec2<u32>) -> Lag {
    let last = (view.size + 7u) / 8u - 1u;
    let group = min(place, last);
    if at_run_time(view.knows_lag, group.x) == 0u { return Lag(); }
    var lag = read_lag(group);
    for (var k = 0u; k < 4u; k++) {
        let other = min((group & vec2<u32>(0xfffffffeu)) + vec2<u32>(k & 1u, k >> 1u), last);
        lag.roused |= lag_of(read_lag(other), SUSPICIOUS) > 0.0;
    }
    return lag;
}

// The means as far as they are more than chance, else 0.
fn lag_of(lag: Lag, deviations: f32) -> f32 {
    let errors = lag.deviation * sqrt(LAG_RATES / (2.0 - LAG_RATES));
    let off = select(vec2<f32>(0.0), abs(lag.means), abs(lag.means) > max(vec2<f32>(NOTABLE), deviations * errors));
    return select(0.0, max(off.x, off.y), lag.count >= LAG_KNOWN);
}

// What averages may weigh: the less the further they lag behind.
fn lag_weight(lag: Lag) -> f32 {
    let off = select(0.0, lag_of(lag, SIGNIFICANT), lag.roused);
    return select(65000.0, FRAME_WEIGHT / off, off > 0.0);
}

// `sum`: of all pixels that looked, how much brighter they were found, and what was known.
fn next_lag(lag: Lag, sum: vec2<f32>) -> Lag {
    if !(sum.y > 0.0) { return lag; }
    let found = clamp(sum.x / sum.y, -4.0, 4.0);
    let square = (found - lag.means.y) * (found - lag.means.y);
    let rate = max(1.0 / f32(lag.count + 1u), DEVIATION_RATE);
    let deviation = sqrt(mix(lag.deviation * lag.deviation, square, rate));
    let bounded = clamp(found, -ONE_FRAME * deviation, ONE_FRAME * deviation);
    return Lag(mix(lag.means, vec2<f32>(bounded), LAG_RATES), deviation, min(lag.count + 1u, 1024u), false);
}
