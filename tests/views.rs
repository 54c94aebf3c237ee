//! Views through the C ABI, on a real device under the validation layer: projections of all kinds, several views in one
//! image, resolutions that change.

#[macro_use]
#[path = "common/bench.rs"]
mod bench;
#[path = "common/stage.rs"]
mod stage;
#[path = "common/vulkan.rs"]
mod vulkan;

use bench::*;
use brickgi::capi::*;
use stage::*;

const FRAMES: usize = 12;
const FAR: f32 = 50.0;

/// The wall that the camera sees, and beside it, out of view, a board that shades it from the right.
fn world(gi: &Gi) {
    let wall = [[-3.0, -3.0, -WALL], [3.0, -3.0, -WALL], [3.0, 3.0, -WALL], [-3.0, 3.0, -WALL]];
    let board = [[2.1, -3.0, -WALL], [2.1, -3.0, 1.0], [2.1, 3.0, 1.0], [2.1, 3.0, -WALL]];
    let positions = [wall, board].concat();
    let triangles = [0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7];
    let mesh = structure! { BgiMesh, BGI_STRUCTURE_TYPE_MESH,
        id: 1, vertex_count: 8, index_count: 12,
        positions: floats(positions.as_flattened()), indices: indices(&triangles),
    };
    let grey = structure! { BgiMaterial, BGI_STRUCTURE_TYPE_MATERIAL, id: 1, base_color: [0.6; 3], };
    let placed = structure! { BgiInstance, BGI_STRUCTURE_TYPE_INSTANCE,
        id: 1, mesh: 1, material: 1, linear: UPRIGHT,
    };
    gi.update(|update| {
        (update.materials, update.material_count) = (&grey, 1);
        (update.meshes, update.mesh_count) = (&mesh, 1);
        (update.instances, update.instance_count) = (&placed, 1);
    });
}

fn context(stage: &Stage) -> Gi {
    let gi = stage.gi(|settings| {
        settings.voxel_size = 0.25;
        settings.probe_tile = 8;
    });
    world(&gi);
    gi
}

/// Luminances of the output, and that nothing in it is black or not a number.
fn luminances(stage: &mut Stage) -> Vec<f32> {
    let floats: Vec<f32> = stage.output().into_iter().map(f32::from_bits).collect();
    let found: Vec<f32> = floats.chunks(4).map(|p| 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]).collect();
    assert!(found.iter().all(|e| e.is_finite() && *e > 0.0), "{found:?}");
    found
}

/// Root of the mean square difference over the root of the mean square.
fn apart(a: &[f32], b: &[f32]) -> f64 {
    let squares = |values: &mut dyn Iterator<Item = f32>| values.map(|v| f64::from(v * v)).sum::<f64>();
    (squares(&mut a.iter().zip(b).map(|(a, b)| a - b)) / squares(&mut b.iter().copied())).sqrt()
}

/// A projection, from which view space, the wall's depth, and that of nothing.
struct Lens {
    name: &'static str,
    rotation: [[f32; 3]; 3],
    projection: [[f32; 4]; 4],
    depth: f32,
    clear_depth: f32,
}

/// All of them see the wall's same places in the same pixels.
fn lenses() -> Vec<Lens> {
    let facing = |z: f32| [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, z]];
    // Depth is (a * distance + b) / distance; of an orthographic one a * distance + b, its pixels as wide at the wall.
    let lens = |name, hand: f32, [a, b]: [f32; 2], clear_depth: f32| Lens {
        name,
        rotation: facing(hand),
        projection: [[1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, -hand * a, -hand], [0.0, 0.0, b, 0.0]],
        depth: a + b / WALL,
        clear_depth,
    };
    let flat = |name, hand: f32, [a, b]: [f32; 2], clear_depth: f32| Lens {
        name,
        rotation: facing(hand),
        projection: [
            [1.0 / WALL, 0.0, 0.0, 0.0],
            [0.0, -1.0 / WALL, 0.0, 0.0],
            [0.0, 0.0, -hand * a, 0.0],
            [0.0, 0.0, b, 1.0],
        ],
        depth: a * WALL + b,
        clear_depth,
    };
    let span = FAR - NEAR;
    vec![
        lens("reverse, infinite", 1.0, [0.0, NEAR], 0.0),
        lens("reverse", 1.0, [-NEAR / span, NEAR * FAR / span], 0.0),
        lens("infinite", 1.0, [1.0, -NEAR], 1.0),
        lens("finite", 1.0, [FAR / span, -NEAR * FAR / span], 1.0),
        lens("left-handed, reverse, infinite", -1.0, [0.0, NEAR], 0.0),
        lens("left-handed, finite", -1.0, [FAR / span, -NEAR * FAR / span], 1.0),
        flat("orthographic", 1.0, [1.0 / span, -NEAR / span], 1.0),
        flat("orthographic, reverse, left-handed", -1.0, [-1.0 / span, FAR / span], 0.0),
    ]
}

/// Frames of one context before the wall as a lens sees it.
fn seen_by(stage: &mut Stage, lens: &Lens) -> Vec<f32> {
    let gi = context(stage);
    gi.look(gi.view, lens.rotation, lens.projection);
    stage.set_depth(lens.depth);
    (0..FRAMES).for_each(|_| stage.dispatch_with(&[&gi], |_, info| info.clear_depth = lens.clear_depth));
    let found = luminances(stage);
    let history = history_of(stage, &gi, lens.clear_depth);
    assert!(history > (FRAMES as f32 - 1.0) / 256.0, "{}: history {history}", lens.name);
    gi.end();
    found
}

/// Mean of the frames that pixels have averaged, of those that they may.
fn history_of(stage: &mut Stage, gi: &Gi, clear_depth: f32) -> f32 {
    stage.dispatch_with(&[gi], |_, info| {
        (info.clear_depth, info.debug_view) = (clear_depth, BGI_DEBUG_VIEW_HISTORY);
    });
    let shown = stage.output();
    shown.chunks(4).map(|p| f32::from_bits(p[0])).sum::<f32>() / (shown.len() / 4) as f32
}

#[test]
fn every_projection_sees_the_same_light() {
    let mut stage = Stage::new(2);
    let lenses = lenses();
    let plain = seen_by(&mut stage, &lenses[0]);
    let (low, high) = plain.iter().fold((f32::MAX, 0.0f32), |(low, high), e| (low.min(*e), high.max(*e)));
    assert!(high > 1.3 * low, "the board shades: {low} to {high}");
    for lens in &lenses[1..] {
        let difference = apart(&seen_by(&mut stage, lens), &plain);
        println!("{}: {difference:.4}", lens.name);
        assert!(difference < 0.02, "{}: {difference}", lens.name);
    }
}

/// One frame of some views of a context, each in a region of the same images.
fn dispatch_regions(stage: &mut Stage, gi: &Gi, regions: &[(BgiView, [u32; 4])]) {
    for (view, [x, y, width, height]) in regions {
        stage.dispatch_with(&[gi], |_, info| {
            info.view = *view;
            [info.x, info.y, info.width, info.height] = [*x, *y, *width, *height];
        });
    }
}

#[test]
fn views_share_images_by_regions() {
    const HALF: u32 = EDGE / 2;
    let mut stage = Stage::new(2);
    let alone = context(&stage);
    (0..FRAMES).for_each(|_| dispatch_regions(&mut stage, &alone, &[(alone.view, [0, 0, HALF, HALF])]));
    let expected = stage.output();
    alone.end();

    for origin in [[HALF, 0], [0, HALF], [HALF - 3, HALF - 5]] {
        let gi = context(&stage);
        let before = stage.output();
        for _ in 0..FRAMES {
            dispatch_regions(&mut stage, &gi, &[(gi.view, [origin[0], origin[1], HALF, HALF])]);
        }
        let found = stage.output();
        let pixel = |image: &[u32], x: u32, y: u32| image[((y * EDGE + x) * 4) as usize..][..4].to_vec();
        for y in 0..EDGE {
            for x in 0..EDGE {
                let [column, row] = [x.wrapping_sub(origin[0]), y.wrapping_sub(origin[1])];
                let inside = column < HALF && row < HALF;
                let wanted = if inside { pixel(&expected, column, row) } else { pixel(&before, x, y) };
                assert_eq!(pixel(&found, x, y), wanted, "pixel {x}, {y} of the region at {origin:?}");
            }
        }
        gi.end();
    }
}

#[test]
fn each_view_has_its_own_history() {
    const HALF: u32 = EDGE / 2;
    let mut stage = Stage::new(2);
    let gi = context(&stage);
    let second = gi.another_view();
    // Off the middle, as eyes of a headset: each sees a half of what one view would.
    for (view, shift) in [(gi.view, -1.0), (second, 1.0)] {
        let mut projection = REVERSE;
        (projection[0][0], projection[2][0]) = (2.0, shift);
        gi.look(view, UPRIGHT, projection);
    }
    let regions = [(gi.view, [0, 0, HALF, EDGE]), (second, [HALF, 0, HALF, EDGE])];
    (0..FRAMES).for_each(|_| dispatch_regions(&mut stage, &gi, &regions));
    let both = luminances(&mut stage);
    for (view, region) in regions {
        stage.dispatch_with(&[&gi], |_, info| {
            info.view = view;
            [info.x, info.y, info.width, info.height] = region;
            info.debug_view = BGI_DEBUG_VIEW_HISTORY;
        });
    }
    let history: Vec<f32> = stage.output().chunks(4).map(|p| f32::from_bits(p[0])).collect();
    let least = history.iter().fold(f32::MAX, |least, h| least.min(*h));
    assert!(least >= (FRAMES as f32 - 1.0) / 256.0, "a pixel has {} frames", least * 256.0);
    // The board is on the right.
    let mean = |half: u32| {
        let columns = |k: &usize| (*k as u32 % EDGE) / HALF == half;
        let picked: Vec<f32> = (0..both.len()).filter(columns).map(|k| both[k]).collect();
        picked.iter().sum::<f32>() / picked.len() as f32
    };
    assert!(mean(0) > 1.1 * mean(1), "{} and {}", mean(0), mean(1));
    gi.end();
    let whole = context(&stage);
    (0..FRAMES).for_each(|_| stage.dispatch(&[&whole]));
    let difference = apart(&both, &luminances(&mut stage));
    println!("two views and one: {difference:.4}");
    assert!(difference < 0.05, "{difference}");
    whole.end();
}

#[test]
fn a_new_resolution_keeps_what_was_averaged() {
    let mut stage = Stage::new(2);
    let gi = context(&stage);
    let region = |edge: u32| [(gi.view, [0, 0, edge, edge])];
    (0..48).for_each(|_| dispatch_regions(&mut stage, &gi, &region(EDGE)));
    let converged = luminances(&mut stage);
    for edge in [24, 17, EDGE] {
        dispatch_regions(&mut stage, &gi, &region(edge));
        stage.dispatch_with(&[&gi], |_, info| {
            [info.width, info.height] = [edge; 2];
            info.debug_view = BGI_DEBUG_VIEW_HISTORY;
        });
        let shown = stage.output();
        let inside = |k: &usize| (*k as u32 % EDGE) < edge && (*k as u32 / EDGE) < edge;
        let history: Vec<f32> =
            (0..converged.len()).filter(inside).map(|k| 256.0 * f32::from_bits(shown[4 * k])).collect();
        let mean = history.iter().sum::<f32>() / history.len() as f32;
        println!("{edge} pixels: {mean:.1} frames");
        assert!(mean > 36.0, "{edge} pixels: {mean} frames are left of 48");
    }
    dispatch_regions(&mut stage, &gi, &region(EDGE));
    let difference = apart(&luminances(&mut stage), &converged);
    println!("{difference:.4} from what it was");
    assert!(difference < 0.02, "{difference}");
    gi.end();
}

#[test]
fn jitter_costs_no_history() {
    let mut stage = Stage::new(2);
    let [still, jittered] = [false, true].map(|jitters| {
        let gi = context(&stage);
        for k in 0..32 {
            // Halton's sequence by 2 and 3, as engines jitter: half a pixel at most.
            let [x, y] = [2, 3].map(|base| halton(k % 8 + 1, base) - 0.5);
            let mut projection = REVERSE;
            // x of clip space is x - jitter * w, w = -z.
            projection[2][..2].copy_from_slice(&[2.0 * x / EDGE as f32, 2.0 * y / EDGE as f32]);
            gi.look(gi.view, UPRIGHT, if jitters { projection } else { REVERSE });
            stage.dispatch(&[&gi]);
        }
        let image = luminances(&mut stage);
        let history = 256.0 * history_of(&mut stage, &gi, 0.0);
        gi.end();
        (image, history)
    });
    let difference = apart(&jittered.0, &still.0);
    println!("{:.1} frames of {:.1}, {difference:.4} apart", jittered.1, still.1);
    assert!(jittered.1 > 0.9 * still.1, "{} frames of {}", jittered.1, still.1);
    assert!(difference < 0.03, "{difference}");
}

fn halton(index: u32, base: u32) -> f32 {
    let (mut left, mut scale, mut sum) = (index, 1.0, 0.0);
    while left > 0 {
        scale /= base as f32;
        sum += scale * (left % base) as f32;
        left /= base;
    }
    sum
}
