//! Who gets memory, whose turn it is, and what the window holds.

use super::*;
use std::collections::HashMap;

/// Pages of a brick, by its place; always the same.
fn pages_of(brick: IVec3) -> u32 {
    1 + (brick.x * 7 + brick.y * 13 + brick.z * 29).rem_euclid(20) as u32
}

/// A layer of bricks about the camera, and pages for some of them.
fn table(pages: u32) -> (BrickTable, Vec<IVec3>) {
    let mut table = BrickTable::new(UVec3::new(8, 1, 8));
    table.grow(pages);
    assert!(table.follow(DVec3::ZERO, None));
    let bricks: Vec<IVec3> =
        (-16..16).flat_map(|x| (-16..16).map(move |z| IVec3::new(x, 0, z))).filter(|b| table.covers(*b)).collect();
    table.enter(bricks.iter().copied());
    (table, bricks)
}

/// Bricks are handed to the GPU and come back at once, each with its pages.
fn voxelise(table: &mut BrickTable, bricks: &[(IVec3, Option<u32>)]) {
    let bricks: Vec<IVec3> = bricks.iter().map(|b| b.0).collect();
    bricks.iter().for_each(|b| table.start(*b));
    arrive(table, &bricks);
}

/// What the GPU says of bricks that it was given.
fn arrive(table: &mut BrickTable, bricks: &[IVec3]) {
    let result = |b| BrickResult { words: pages_of(b) * PAGE_WORDS, faces: 1, ..BrickResult::default() };
    let finished: Vec<_> = bricks.iter().map(|b| Finished { position: *b, result: result(*b) }).collect();
    table.finish(&finished);
}

/// Voxelises until nothing is to be done; how many bricks that took.
fn settle(table: &mut BrickTable, camera: DVec3) -> usize {
    let mut tries = 0;
    loop {
        table.share_out();
        let next = table.next(50, &Viewpoint::all_round(camera / 8.0));
        if next.is_empty() {
            return tries;
        }
        tries += next.len();
        assert!(tries < 10_000, "bricks take each other's place for ever");
        voxelise(table, &next);
    }
}

/// No brick that is missing lies nearer than one that is resident, but for those that holes are too small for.
fn assert_nearest(table: &BrickTable) {
    let nearest = table.waiting.keys().map(|b| table.distance(*b)).fold(f64::INFINITY, f64::min);
    let farther = table.resident.iter().filter(|(b, _)| table.distance(**b) > nearest);
    let pages: u32 = farther.map(|(_, b)| b.pages).sum();
    assert!(pages <= table.pages.capacity() / 16, "{pages} pages lie farther away than a brick without memory");
    assert!(table.pages.used() > table.pages.capacity() / 16 * 15, "memory is left");
}

#[test]
fn the_nearest_bricks_get_the_memory() {
    let (mut table, bricks) = table(4000);
    let tries = settle(&mut table, DVec3::ZERO);
    assert_nearest(&table);
    assert_eq!(table.left_out(), table.missing());
    assert_eq!(table.resident() + table.missing(), bricks.len() as u32);
    assert!(tries < bricks.len() * 3 / 4, "{tries}: what has no chance is not even tried");
    assert_eq!(settle(&mut table, DVec3::ZERO), 0, "nothing has changed");
}

/// Near bricks that change in every frame keep no far one waiting for ever.
#[test]
fn nothing_starves() {
    let (mut table, bricks) = table(40_000);
    let view = Viewpoint::all_round(DVec3::ZERO);
    let near: Vec<IVec3> = bricks.iter().copied().filter(|b| b.as_dvec3().length() < 6.0).collect();
    let farthest = bricks.iter().map(|b| view.patience(*b)).fold(0.0, f64::max);
    let per_frame = near.len() + 2;
    let mut frames = 0;
    while table.missing() > 0 {
        table.tick();
        table.touch(&near);
        let next = table.next(per_frame, &view);
        voxelise(&mut table, &next);
        frames += 1;
        // Two bricks a frame are not near ones.
        assert!(frames < bricks.len() / 2 + farthest as usize, "{} bricks still wait", table.missing());
    }
    assert!(frames > farthest as usize / 2, "the near ones have gone first");
}

#[test]
fn lighting_goes_round() {
    let (mut table, bricks) = table(40_000);
    settle(&mut table, DVec3::ZERO);
    let budget = bricks.len() as u32 / 10;
    let mut lit: HashMap<u32, Vec<u32>> = HashMap::new();
    for frame in 0..200 {
        table.tick();
        // Lights that change in every frame.
        table.invalidate_lighting();
        let light = LightBudget { faces: budget, room: budget, bricks: usize::MAX, sweeps: 1 };
        let (chosen, faces) = table.choose_for_light(&light, DVec3::ZERO);
        assert_eq!((chosen.len() as u32, faces), (budget, budget));
        chosen.iter().for_each(|b| lit.entry(b.base).or_default().push(frame));
    }
    assert_eq!(lit.len(), bricks.len(), "every brick has had its turn");
    let gap = lit.values().flat_map(|frames| frames.windows(2).map(|f| f[1] - f[0])).max();
    assert!(gap.is_some_and(|gap| gap < 40), "a brick waits {gap:?} frames");
}

/// A camera high above a scene that the window can hold keeps it; a scene larger than the window is followed.
#[test]
fn the_window_holds_the_scene() {
    let mut table = BrickTable::new(UVec3::new(8, 2, 8));
    let scene = Some((DVec3::new(-1000.0, -3.0, -100.0), DVec3::new(1000.0, 20.0, 100.0)));
    let holds = |table: &BrickTable, p: DVec3| table.covers((p / 8.0).floor().as_ivec3());
    assert!(table.follow(DVec3::new(0.0, 60.0, 0.0), scene));
    let (low, high) = (DVec3::new(0.0, -5.0, -102.0), DVec3::new(0.0, 22.0, 102.0));
    assert!(holds(&table, low) && holds(&table, high));
    assert!(table.follow(DVec3::new(400.0, 1e6, 0.0), scene));
    assert!(holds(&table, low + DVec3::X * 400.0) && holds(&table, high + DVec3::X * 400.0));
    assert!(!table.follow(DVec3::new(410.0, -1e6, 10.0), scene), "nothing to gain");
    // The scene has grown: what the window can hold it must.
    let grown = Some((DVec3::new(-1000.0, -9.0, -100.0), DVec3::new(1000.0, 20.0, 120.0)));
    table.follow(DVec3::new(410.0, 0.0, 10.0), grown);
    assert!(holds(&table, DVec3::new(410.0, -9.0, 120.0)));
}

#[test]
fn the_memory_follows_the_camera() {
    let (mut table, _) = table(4000);
    settle(&mut table, DVec3::ZERO);
    let near = DVec3::new(20.0, 0.0, 0.0);
    assert!(!table.follow(near, None));
    assert_eq!(settle(&mut table, near), 0, "too little to begin anew");
    let far = DVec3::new(40.0, 0.0, 0.0);
    assert!(!table.follow(far, None), "the window stays");
    assert!(settle(&mut table, far) > 0);
    assert_nearest(&table);
}

#[test]
fn freed_memory_goes_to_those_that_wait() {
    let (mut table, bricks) = table(4000);
    settle(&mut table, DVec3::ZERO);
    // The nearest lose their triangles.
    let emptied: Vec<IVec3> = table.by_distance().into_iter().take(100).collect();
    table.touch(&emptied);
    emptied.iter().for_each(|b| table.start(*b));
    let nothing = BrickResult::default();
    let finished: Vec<_> = emptied.iter().map(|b| Finished { position: *b, result: nothing }).collect();
    table.finish(&finished);
    assert!(settle(&mut table, DVec3::ZERO) > 0);
    assert_nearest(&table);
    // As soon as there is enough, all come.
    table.grow(20_000);
    settle(&mut table, DVec3::ZERO);
    assert_eq!((table.resident(), table.missing()), (bricks.len() as u32, 0));
}

#[test]
fn what_is_kept_of_a_shrunk_world_is_the_nearest() {
    let (mut table, bricks) = table(20_000);
    settle(&mut table, DVec3::ZERO);
    let before: HashMap<IVec3, u32> = table.resident.iter().map(|(b, r)| (*b, r.page)).collect();
    let moves: HashMap<u32, u32> = table.shrink(2000).into_iter().map(|[from, to, _]| (from, to)).collect();
    assert_nearest(&table);
    assert!(table.resident.iter().all(|(b, r)| moves[&before[b]] == r.page && r.page + r.pages <= 2000));
    assert_eq!(table.resident() + table.missing(), bricks.len() as u32);
}

/// A world has loaded when everything that fits is there, and again only after a good part of it is new.
#[test]
fn a_world_loads_once() {
    let (mut table, bricks) = table(4000);
    let first = table.next(50, &Viewpoint::all_round(DVec3::ZERO));
    voxelise(&mut table, &first);
    assert!(!table.has_loaded(), "the rest is missing");
    settle(&mut table, DVec3::ZERO);
    assert!(table.has_loaded());
    let near: Vec<IVec3> = bricks.iter().copied().filter(|b| b.as_dvec3().length() < 4.0).collect();
    table.touch(&near);
    settle(&mut table, DVec3::ZERO);
    assert!(!table.has_loaded(), "what has changed was there before");
    let elsewhere = DVec3::new(1600.0, 0.0, 0.0);
    assert!(table.follow(elsewhere, None));
    let entered: Vec<IVec3> = bricks.iter().map(|b| *b + IVec3::X * 200).filter(|b| table.covers(*b)).collect();
    table.enter(entered.into_iter());
    settle(&mut table, elsewhere);
    assert!(table.has_loaded(), "another place");
}

#[test]
fn what_has_changed_is_redone_though_the_window_moves() {
    let (mut table, _) = table(40_000);
    settle(&mut table, DVec3::ZERO);
    let changed = IVec3::new(5, 0, 0);
    table.touch(&[changed]);
    let camera = DVec3::new(80.0, 0.0, 0.0);
    assert!(table.follow(camera, None));
    assert!(table.covers(changed));
    let next = table.next(10, &Viewpoint::all_round(camera));
    assert_eq!(next, [(changed, None)]);
}

/// Its triangles may have changed while it was outside, where no change is told.
#[test]
fn what_comes_back_before_its_result_is_voxelised_anew() {
    let (mut table, _) = table(40_000);
    settle(&mut table, DVec3::ZERO);
    let brick = IVec3::new(5, 0, 0);
    table.touch(&[brick]);
    table.start(brick);
    assert!(table.follow(DVec3::X * 10_000.0, None) && table.follow(DVec3::ZERO, None));
    arrive(&mut table, &[brick]);
    assert_eq!((table.resident(), table.next(10, &Viewpoint::all_round(DVec3::ZERO))), (1, vec![(brick, None)]));
}

/// Also one that loses its place meanwhile.
#[test]
fn a_brick_is_voxelised_once_at_a_time() {
    let (mut table, _) = table(40_000);
    settle(&mut table, DVec3::ZERO);
    let far = *table.by_distance().last().expect("bricks");
    table.touch(&[far]);
    table.start(far);
    table.shrink(4000);
    assert!(!table.resident.contains_key(&far) && !table.waiting.contains_key(&far));
    let missing = table.missing();
    assert_eq!(missing as usize, table.waiting.len() + 1, "it is counted once");
    arrive(&mut table, &[far]);
    assert!(table.waiting.contains_key(&far) || table.resident.contains_key(&far));
}

/// What holds no triangles takes no room in the table, once it has been seen to vanish.
#[test]
fn what_has_vanished_is_forgotten() {
    let (mut table, bricks) = table(40_000);
    settle(&mut table, DVec3::ZERO);
    let gone = bricks[0];
    table.touch(&[gone]);
    table.forget(gone);
    assert_eq!(table.next(10, &Viewpoint::all_round(DVec3::ZERO)), [(gone, None)], "it is still to be seen");
    table.start(gone);
    let nothing = BrickResult::default();
    table.finish(&[Finished { position: gone, result: nothing }]);
    assert_eq!(table.resident() as usize, bricks.len());
    table.forget(gone);
    assert_eq!((table.resident() as usize, table.missing()), (bricks.len() - 1, 0));
}

/// Bricks that have come to take less leave holes that none of those which wait fits into.
#[test]
fn holes_smaller_than_a_brick_are_filled() {
    let (mut table, bricks) = table(8000);
    let voxelise = |table: &mut BrickTable, next: &[IVec3], pages: u32| {
        next.iter().for_each(|b| table.start(*b));
        let result = BrickResult { words: pages * PAGE_WORDS, ..BrickResult::default() };
        let finished: Vec<_> = next.iter().map(|b| Finished { position: *b, result }).collect();
        table.finish(&finished);
    };
    let settle = |table: &mut BrickTable, compacts: bool| {
        for round in 0.. {
            assert!(round < 200, "there is no end to it");
            let moved = compacts && !table.compact().is_empty();
            table.share_out();
            let next = table.next(50, &Viewpoint::all_round(DVec3::ZERO));
            let next: Vec<IVec3> = next.into_iter().map(|b| b.0).collect();
            voxelise(table, &next, 20);
            if next.is_empty() && !moved {
                break;
            }
        }
    };
    settle(&mut table, false);
    assert_eq!((table.resident(), table.pages.used()), (400, 8000), "full");
    let mut resident = table.by_distance();
    resident.sort_by_key(|b| pages_of(*b));
    for brick in resident {
        table.touch(&[brick]);
        voxelise(&mut table, &[brick], 17);
    }
    settle(&mut table, false);
    let scattered = table.resident();
    settle(&mut table, true);
    println!("{scattered} of {} bricks with the holes between them, {} without", bricks.len(), table.resident());
    assert!(table.pages.used() > 8000 / 32 * 30, "{} pages are in use", table.pages.used());
    assert!(table.resident() > scattered, "{} bricks", table.resident());
    assert!(table.compact().is_empty(), "nothing is moved again");
}

/// What there is no memory for is tried once where that is asked for, and never again while nothing changes.
#[test]
fn what_does_not_fit_is_surveyed_once() {
    let (mut table, bricks) = table(4000);
    let tries = settle(&mut table, DVec3::ZERO);
    assert!(tries < bricks.len() && table.waiting.values().any(|w| w.pages.is_none()));
    table.survey(true);
    let more = settle(&mut table, DVec3::ZERO);
    assert!(table.waiting.iter().all(|(b, w)| w.pages == Some(pages_of(*b))), "all are known");
    assert!(tries + more < bricks.len() * 3 / 2, "{tries} and {more} tries for {} bricks", bricks.len());
    assert_nearest(&table);
    assert_eq!(settle(&mut table, DVec3::ZERO), 0, "nothing has changed");
}

/// What changes in every frame is shown as it was when it was last handed to the GPU, not as it was before it moved.
#[test]
fn what_never_rests_is_redone_all_the_same() {
    let (mut table, _) = table(20_000);
    settle(&mut table, DVec3::ZERO);
    let brick = IVec3::new(1, 0, 1);
    let (mut flights, mut arrived) = (std::collections::VecDeque::from(vec![Vec::new(); 2]), Vec::new());
    for frame in 0..100 {
        table.tick();
        table.touch(&[brick]);
        let finished: Vec<IVec3> = flights.pop_front().expect("two are in flight");
        let result = |pages: u32| BrickResult { words: pages * PAGE_WORDS, faces: 1, ..BrickResult::default() };
        let pages = 1 + frame % 7;
        let finished: Vec<_> = finished.iter().map(|b| Finished { position: *b, result: result(pages) }).collect();
        let Arrived { carries, copies, new } = table.finish(&finished);
        assert_eq!((carries.len(), new), (copies.len(), 0), "its light is carried over");
        arrived.extend(copies.iter().map(|_| frame));
        let next = table.next(50, &Viewpoint::all_round(DVec3::ZERO));
        next.iter().for_each(|(b, _)| table.start(*b));
        flights.push_back(next.into_iter().map(|(b, _)| b).collect());
    }
    let gaps = arrived.windows(2).map(|w| w[1] - w[0]).max();
    assert!(arrived.len() > 30 && gaps <= Some(3), "{arrived:?}");
}
