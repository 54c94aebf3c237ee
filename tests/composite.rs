//! Direct and indirect light in one picture, through the C ABI, on a real device under the validation layer.

#[macro_use]
#[path = "common/bench.rs"]
mod bench;
#[path = "common/stage.rs"]
mod stage;
#[path = "common/vulkan.rs"]
mod vulkan;

use brickgi::capi::*;
use stage::*;
use std::f32::consts::PI;

fn composed(stage: &Stage, info: &mut BgiDispatchInfo) {
    [info.albedo, info.direct, info.composite] = [3, 4, COMPOSITE].map(|index| stage.view(index));
}

#[test]
fn a_composite_is_direct_light_and_albedo_times_indirect() {
    let mut stage = Stage::new(2);
    let gi = stage.gi(|_| ());
    (0..4).for_each(|_| stage.dispatch_with(&[&gi], composed));
    let floats = |bits: Vec<u32>| bits.into_iter().map(f32::from_bits).collect::<Vec<_>>();
    let [output, composite] = [OUTPUT, COMPOSITE].map(|index| floats(stage.pixels(index)));
    // An empty world under a sky: the wall has pi times its radiance.
    assert!((output[1] / PI - 1.0).abs() < 0.01, "{:?}", &output[..4]);
    for (pixel, (found, e)) in composite.chunks(4).zip(output.chunks(4)).enumerate() {
        for c in 0..3 {
            let expected = DIRECT[c] + ALBEDO[c] * e[c] / PI;
            assert!((found[c] / expected - 1.0).abs() < 1e-5, "pixel {pixel}: {found:?}, {e:?}");
        }
        assert_eq!(found[3], 1.0);
    }

    // Where the output is a debug view the composite is, too.
    stage.dispatch_with(&[&gi], |stage, info| {
        composed(stage, info);
        info.debug_view = BGI_DEBUG_VIEW_NORMALS;
    });
    let [output, composite] = [OUTPUT, COMPOSITE].map(|index| floats(stage.pixels(index)));
    assert!(output.chunks(4).zip(composite.chunks(4)).all(|(o, c)| o[..3] == c[..3]));
    gi.end();
    assert_eq!(stage.host.messages(), Vec::<String>::new());
}
