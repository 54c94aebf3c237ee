//! Faces that stay keep their light when their brick is voxelised again.

use crate::bricks::Arrived;
use crate::frame::Frame;
use crate::gpu::Location;
use crate::gpu::shared::{LightCarry, UNLIT};
use crate::passes;
use crate::twin::gpu::Gpu;
use crate::twin::layout::{Brick, Face, Voxel, encode};
use crate::twin::random::Random;
use glam::IVec3;

fn face(random: &mut Random) -> Face {
    let emission = if random.chance(0.1) { random.next() as u32 } else { 0 };
    let (plane, albedo) = (random.below(3), random.below(3));
    Face { plane, albedo, mask: 0xffff, lit: random.chance(0.7), emission }
}

/// Changes some voxels of a brick, and some sides of others.
fn change(brick: &mut Brick, random: &mut Random) {
    for cell in (0..512).map(|i| IVec3::new(i & 7, i >> 3 & 7, i >> 6)) {
        if random.chance(0.2) {
            brick.remove(&cell);
        } else if random.chance(0.2) {
            let mut voxel = Voxel { translucent: random.chance(0.1), ..Voxel::default() };
            voxel.faces.iter_mut().for_each(|side| *side = random.chance(0.5).then(|| face(random)));
            brick.insert(cell, voxel);
        }
    }
}

#[test]
fn faces_that_stay_keep_their_light() {
    let mut random = Random::new(17);
    let mut gpu = Gpu::new(&["light_carry"]);
    let (mut old, mut new) = (Vec::new(), Vec::new());
    let (mut carries, mut expected) = (Vec::new(), Vec::new());
    let (mut kept, mut unlit) = (0, 0);
    for _ in 0..100 {
        let mut brick = Brick::new();
        change(&mut brick, &mut random);
        let (mut words, before) = encode(&brick);
        let mut places: Vec<u32> = before.values().copied().collect();
        places.sort_unstable();
        places.into_iter().for_each(|word| words[word as usize] = random.next() as u32);
        change(&mut brick, &mut random);
        let (fresh, after) = encode(&brick);
        carries.push(LightCarry { base: old.len() as u32, source: new.len() as u32 });
        let mut carried = fresh.clone();
        for (face, word) in after {
            carried[word as usize] = before.get(&face).map_or(UNLIT, |word| words[*word as usize]);
            *if before.contains_key(&face) { &mut kept } else { &mut unlit } += 1;
        }
        old.extend(words);
        new.extend(fresh);
        expected.extend(carried);
    }
    for (name, words) in [("world_bricks", &old), ("brick_source", &new)] {
        gpu.buffer(name, words.len() * 4, Location::Readback);
        gpu.write(name, words);
    }
    let mut frame = Frame::default();
    passes::bricks::commit(&mut frame, &[], &Arrived { carries, ..Arrived::default() }, &[]);
    gpu.run(&frame);
    println!("{kept} faces stay, {unlit} are new");
    assert!(kept > 1000 && unlit > 1000);
    assert!(gpu.read::<u32>("brick_source", expected.len()) == expected);
    assert!(gpu.read::<u32>("world_bricks", old.len()) == old);
}
