//! What a frame records while nothing changes.

use crate::frame::{Command, Frame};
use crate::gpu::{Player, Slot};
use crate::scene::{InstanceDesc, MaterialDesc, MeshDesc, MeshUpdate, Scene};
use crate::settings::Settings;
use crate::twin::gpu::Gpu;
use crate::world::{FrameScope, World};
use glam::{DMat4, DVec3};

const BRICK_PASSES: [&str; 7] =
    ["brick_compact", "light_carry", "brick_commit", "grid_update", "voxel_mark", "voxelize", "face_resolve"];
const LIGHT_PASSES: [&str; 4] = ["face_compact", "light_direct", "light_bounce", "light_store"];

/// The passes and the copies that a frame records.
fn recorded(frame: &Frame) -> Vec<&'static str> {
    let name = |command: &Command| match command {
        Command::Clear(name) | Command::Copy(name) => *name,
        Command::Dispatch { pass, .. } => *pass,
    };
    frame.commands.iter().map(name).collect()
}

fn records_bricks(frame: &Frame) -> bool {
    recorded(frame).iter().any(|name| BRICK_PASSES.contains(name))
}

fn records_light(frame: &Frame) -> bool {
    recorded(frame).iter().any(|name| LIGHT_PASSES.contains(name))
}

/// A square metre, level, `height` metres above the origin.
fn place(world: &mut World, scene: &mut Scene, height: f64) {
    let linear = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let instances = [InstanceDesc { id: 1, mesh: 1, material: 1, linear, translation: [0.0, height, 0.0] }];
    let changed = scene.apply(&MeshUpdate { instances: &instances, ..MeshUpdate::default() });
    world.instances_changed(&changed, scene);
}

#[test]
fn a_world_in_which_nothing_changes_records_no_pass() {
    let gpu = Gpu::new(&[&BRICK_PASSES[..], &LIGHT_PASSES].concat());
    let settings = Settings { coverage_groups: [2, 2, 2], ..Settings::default() };
    let mut slots = [Slot::new(&gpu.device).expect("a slot")];
    let mut world = World::new(&settings, 1).expect("a world");
    let mut scene = Scene::default();
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    scene.apply(&MeshUpdate {
        materials: &[MaterialDesc { id: 1, base_color: [0.5; 3], ..MaterialDesc::default() }],
        meshes: &[MeshDesc { id: 1, positions: &positions, uvs: &[], indices: &[0, 2, 1, 1, 2, 3] }],
        ..MeshUpdate::default()
    });
    let mut frames = 0;
    let mut run = |world: &mut World, scene: &mut Scene| {
        frames += 1;
        slots[0].recycle(&gpu.device);
        let mut scope = FrameScope::new(&gpu.device, &settings, &mut slots, 0, frames, Frame::default());
        world.follow([DVec3::ZERO].into_iter(), scene);
        world.frame(&mut scope, scene, DVec3::ZERO, DMat4::IDENTITY).expect("a frame");
        let frame = scope.frame;
        let mut player = Player::default();
        world.bind(0, scene, &mut player);
        gpu.play(&frame, player, &mut slots[0]);
        frame
    };
    for height in [1.0, -3.0, -3.0] {
        let moves = scene.instances.get(&1).is_none_or(|i| i.translation.y != height);
        place(&mut world, &mut scene, height);
        let at_once = run(&mut world, &mut scene);
        assert_eq!(records_bricks(&at_once), moves, "what has moved is redone, what has not is left alone");
        let after: Vec<Frame> = (0..if moves { 270 } else { 10 }).map(|_| run(&mut world, &mut scene)).collect();
        // The next frame takes in what this one voxelised.
        assert_eq!(after.iter().rposition(records_bricks), moves.then_some(0));
        // Four sweeps a frame, 992 in all.
        let lit = after.iter().rposition(records_light);
        assert_eq!(lit.map(|last| (200..260).contains(&last)), moves.then_some(true), "{lit:?}");
        assert_eq!(recorded(&after[after.len() - 1]), ["counters"], "all is settled");
        assert_eq!(world.table.convergence(), 1.0);
    }
    world.forget_light();
    assert_eq!(world.table.convergence(), 0.0);
    let frame = run(&mut world, &mut scene);
    assert!(records_light(&frame) && !records_bricks(&frame), "other light rouses what sleeps");
    assert!((1e-3..0.1).contains(&world.table.convergence()));
    assert!(world.table.faces() > 0 && world.table.missing() == 0);
    world.destroy(&gpu.device);
    slots[0].destroy(&gpu.device);
}
