//! Meshes in the host's buffers, through the C ABI, on a real device under the validation layer.

#[macro_use]
#[path = "common/bench.rs"]
mod bench;
#[path = "common/stage.rs"]
mod stage;
#[path = "common/vulkan.rs"]
mod vulkan;

use ash::vk;
use bench::*;
use brickgi::capi::*;
use half::f16;
use stage::*;

/// A wavy square of `cells` x `cells` cells, whose numbers halves can hold: where the camera sees a wall, or what is put
/// there with another `depth`.
struct Shape {
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    indices: Vec<u16>,
}

impl Shape {
    fn new(cells: u16, depth: f32) -> Self {
        let corners = || (0..=cells).flat_map(|y| (0..=cells).map(move |x| (x, y)));
        let round = |v: f32| f16::from_f32(v).to_f32();
        let along = |i: u16| round(4.0 * f32::from(i) / f32::from(cells) - 2.0);
        let position = |(x, y): (u16, u16)| [along(x), along(y), -WALL - depth * f32::from((x ^ y) & 3)];
        let quad = |(x, y): (u16, u16)| {
            let at = x + y * (cells + 1);
            [at, at + 1, at + cells + 2, at, at + cells + 2, at + cells + 1]
        };
        Self {
            positions: corners().map(position).collect(),
            uvs: corners().map(|(x, y)| [along(x), along(y)]).collect(),
            indices: corners().filter(|(x, y)| *x < cells && *y < cells).flat_map(quad).collect(),
        }
    }

    fn mesh(&self, positions: BgiVertexData, uvs: BgiVertexData, indices: BgiIndexData) -> BgiMesh {
        structure! { BgiMesh, BGI_STRUCTURE_TYPE_MESH,
            id: 1,
            vertex_count: self.positions.len() as u32,
            index_count: self.indices.len() as u32,
            positions: positions,
            uvs: uvs,
            indices: indices,
        }
    }

    /// Halves and 16-bit indices: something else, vertices of position and texture coordinates with something between them,
    /// indices. And where positions, texture coordinates and indices begin.
    fn packed(&self) -> (Vec<u8>, [u64; 3]) {
        let mut bytes = vec![0xff; 50];
        for (position, uv) in self.positions.iter().zip(&self.uvs) {
            let halves =
                |values: &[f32]| values.iter().flat_map(|v| f16::from_f32(*v).to_ne_bytes()).collect::<Vec<_>>();
            bytes.extend(halves(position));
            bytes.extend([0xff; 2]);
            bytes.extend(halves(uv));
            bytes.extend([0xff; 4]);
        }
        let indices = bytes.len() as u64;
        bytes.extend(self.indices.iter().flat_map(|i| i.to_ne_bytes()));
        (bytes, [50, 58, indices])
    }

    fn in_buffer(&self, stage: &mut Stage) -> BgiMesh {
        let (bytes, at) = self.packed();
        self.of_buffer(stage.buffer(&bytes), at)
    }

    fn of_buffer(&self, buffer: vk::Buffer, [positions, uvs, indices]: [u64; 3]) -> BgiMesh {
        let vertices = BgiVertexData { buffer, stride: 16, format: BGI_VERTEX_FORMAT_FLOAT16, ..zeroed() };
        self.mesh(
            BgiVertexData { offset: positions, ..vertices },
            BgiVertexData { offset: uvs, ..vertices },
            BgiIndexData { buffer, offset: indices, index_type: BGI_INDEX_TYPE_UINT16, ..zeroed() },
        )
    }

    /// Hands the shape to `with` as floats and 32-bit indices in host memory.
    fn in_memory(&self, with: impl FnOnce(BgiMesh)) {
        let wide: Vec<u32> = self.indices.iter().map(|i| u32::from(*i)).collect();
        with(self.mesh(floats(self.positions.as_flattened()), floats(self.uvs.as_flattened()), indices(&wide)));
    }

    /// The same of [`Shape::packed`].
    fn in_packed_memory(&self, with: impl FnOnce(BgiMesh)) {
        let (bytes, [positions, uvs, indices]) = self.packed();
        let data = bytes.as_ptr().cast();
        let vertices = BgiVertexData { data, stride: 16, format: BGI_VERTEX_FORMAT_FLOAT16, ..zeroed() };
        with(self.mesh(
            BgiVertexData { offset: positions, ..vertices },
            BgiVertexData { offset: uvs, ..vertices },
            BgiIndexData { data, offset: indices, index_type: BGI_INDEX_TYPE_UINT16, ..zeroed() },
        ));
    }
}

/// For tests that do not look at the image: little light saves time.
fn context(stage: &Stage) -> Gi {
    context_with(stage, |settings| (settings.light_faces_per_frame, settings.bounce_rays) = (64, 0))
}

fn context_with(stage: &Stage, change: impl FnOnce(&mut BgiSettings)) -> Gi {
    let gi = stage.gi(|settings| {
        settings.voxel_size = 0.25;
        change(settings);
    });
    let texels = [[255, 40, 40, 255], [40, 255, 40, 255], [40, 40, 255, 255], [255; 4]];
    let texture = structure! { BgiTexture, BGI_STRUCTURE_TYPE_TEXTURE,
        id: 1, width: 2, height: 2, rgba8: texels.as_ptr().cast(),
    };
    let material = structure! { BgiMaterial, BGI_STRUCTURE_TYPE_MATERIAL,
        id: 1, base_color: [0.8; 3], has_base_color_texture: 1, base_color_texture: 1,
    };
    let lamp = structure! { BgiMaterial, BGI_STRUCTURE_TYPE_MATERIAL, id: 2, emission: [4.0, 2.0, 1.0], };
    let materials = [material, lamp];
    gi.update(|update| {
        (update.textures, update.texture_count) = (&texture, 1);
        (update.materials, update.material_count) = (materials.as_ptr(), 2);
    });
    gi
}

/// The mesh as the wall, and beside it as a lamp.
fn add(gi: &Gi, mesh: BgiMesh) {
    let wall = structure! { BgiInstance, BGI_STRUCTURE_TYPE_INSTANCE,
        id: 1, mesh: 1, material: 1, linear: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    };
    let lamp = BgiInstance {
        id: 2,
        material: 2,
        linear: [[0.0, 0.0, -0.5], [0.0, 0.5, 0.0], [0.5, 0.0, 0.0]],
        translation: [-1.0, 0.0, -1.0],
        ..wall
    };
    let instances = [wall, lamp];
    gi.update(|update| {
        (update.meshes, update.mesh_count) = (&mesh, 1);
        (update.instances, update.instance_count) = (instances.as_ptr(), 2);
    });
}

/// Bricks, faces and pages.
fn figures(gi: &Gi) -> [u32; 3] {
    let stats = gi.stats();
    assert_eq!((stats.bricks_missing, stats.meshes_pending), (0, 0));
    [stats.bricks, stats.faces, stats.pages]
}

/// What a mesh in host memory comes to.
fn figures_of(stage: &mut Stage, shape: &Shape) -> [u32; 3] {
    let gi = context(stage);
    shape.in_memory(|mesh| add(&gi, mesh));
    (0..16).for_each(|_| stage.dispatch(&[&gi]));
    let figures = figures(&gi);
    stage.wait();
    gi.end();
    figures
}

/// The mesh of a buffer is there in the dispatch that takes it in, as if it had been handed over just before.
#[test]
fn the_image_does_not_say_where_a_mesh_came_from() {
    let shape = Shape::new(8, 0.0625);
    for frames_in_flight in 1..=3 {
        let mut images = Vec::new();
        for how in ["buffer", "memory", "packed memory"] {
            let mut stage = Stage::new(frames_in_flight);
            let gi = context_with(&stage, |settings| settings.bounce_rays = 1);
            if how == "buffer" {
                let mesh = shape.in_buffer(&mut stage);
                add(&gi, mesh);
                assert_eq!(gi.stats().meshes_pending, 1);
            }
            for _ in 0..frames_in_flight {
                stage.dispatch(&[&gi]);
                assert_eq!(gi.stats().meshes_pending, u32::from(how == "buffer"));
                assert_eq!(gi.resource("readback") > 0, how == "buffer");
            }
            match how {
                "memory" => shape.in_memory(|mesh| add(&gi, mesh)),
                "packed memory" => shape.in_packed_memory(|mesh| add(&gi, mesh)),
                _ => assert_eq!(gi.stats().bricks_missing, 0),
            }
            stage.dispatch(&[&gi]);
            assert!(gi.stats().bricks_missing > 0);
            (0..10).for_each(|_| stage.dispatch(&[&gi]));
            assert_eq!((gi.resource("readback"), gi.log()), (0, Vec::new()));
            let triangles = gi.stats().mesh_triangles;
            assert!(triangles > 0 && triangles == gi.stats().kept_triangles);
            images.push(((figures(&gi), triangles), stage.output()));
            gi.end();
        }
        let lit: Vec<f32> = images[0].1.iter().map(|bits| f32::from_bits(*bits)).collect();
        let (low, high) = lit.chunks(4).fold((f32::MAX, 0.0f32), |(l, h), p| (l.min(p[0]), h.max(p[0])));
        println!("{frames_in_flight} in flight: bricks, faces, pages {:?}; red {low} to {high}", images[0].0);
        assert!(images[0].0.0[0] > 20 && low > 0.0 && high > 1.5 * low, "there is something to see");
        assert!(images.iter().all(|image| *image == images[0]), "{frames_in_flight} in flight");
    }
}

/// Almost half of what the budget is.
#[test]
fn a_large_mesh_comes_in_pieces_within_the_budget() {
    const BUDGET: u64 = 1 << 20;
    let mut shape = Shape::new(120, 0.0625);
    // Few triangles of many vertices: reading them is what takes long.
    shape.indices.truncate(3 * 400);
    for frames_in_flight in [1, 8] {
        let mut stage = Stage::new(frames_in_flight);
        let mut found = Vec::new();
        for in_buffer in [true, false] {
            let gi = context_with(&stage, |settings| {
                (settings.memory_budget, settings.light_faces_per_frame, settings.bounce_rays) = (BUDGET, 64, 0);
            });
            if in_buffer {
                add(&gi, shape.in_buffer(&mut stage));
            } else {
                shape.in_memory(|mesh| add(&gi, mesh));
            }
            let (mut frames, mut pending, mut most) = (0, 0, 0);
            while gi.stats().meshes_pending > 0 || gi.stats().bricks_missing > 0 || frames < 24 {
                stage.dispatch(&[&gi]);
                frames += 1;
                pending += gi.stats().meshes_pending;
                most = most.max(gi.resource("readback"));
                assert!(gi.stats().world_bytes <= BUDGET, "{} bytes", gi.stats().world_bytes);
                assert!(frames < 2000, "it never comes");
            }
            println!(
                "{frames_in_flight} in flight: pending for {pending} frames, {most} bytes at most; loaded in {frames}"
            );
            assert_eq!((pending > 2, most > 0 && most < BUDGET / 4), (in_buffer, in_buffer));
            found.push(figures(&gi));
            stage.wait();
            gi.end();
        }
        assert_eq!(found[0], found[1]);
    }
}

#[test]
fn meshes_are_replaced_and_removed_while_they_are_pending() {
    let mut stage = Stage::new(3);
    let [one, other] = [Shape::new(8, 0.0625), Shape::new(8, 0.5)];
    let [as_one, as_other] = [&one, &other].map(|shape| figures_of(&mut stage, shape));
    assert_ne!(as_one, as_other);
    let [in_one, in_other] = [&one, &other].map(|shape| shape.in_buffer(&mut stage));
    let gi = context(&stage);
    for frames in 0..4 {
        let run = |stage: &mut Stage, frames| (0..frames).for_each(|_| stage.dispatch(&[&gi]));
        // By another buffer; what was read of the first one is forgotten.
        add(&gi, in_one);
        run(&mut stage, frames);
        add(&gi, in_other);
        assert_eq!(gi.stats().meshes_pending, 1);
        run(&mut stage, 16);
        assert_eq!(figures(&gi), as_other, "{frames} frames");
        // By host memory.
        add(&gi, in_other);
        run(&mut stage, frames);
        one.in_memory(|mesh| add(&gi, mesh));
        assert_eq!(gi.stats().meshes_pending, 0);
        run(&mut stage, 16);
        assert_eq!(figures(&gi), as_one, "{frames} frames");
        // What was there stays until the new one has come.
        add(&gi, in_other);
        run(&mut stage, 3);
        assert_eq!([gi.stats().bricks, gi.stats().meshes_pending], [as_one[0], 1]);
        run(&mut stage, 16);
        assert_eq!(figures(&gi), as_other, "{frames} frames");
        add(&gi, in_one);
        run(&mut stage, frames);
        let instances = [1, 2];
        gi.update(|update| {
            (update.removed_instances, update.removed_instance_count) = (instances.as_ptr(), 2);
            (update.removed_meshes, update.removed_mesh_count) = (&1, 1);
        });
        assert_eq!(gi.stats().meshes_pending, 0);
        run(&mut stage, 16);
        assert_eq!((figures(&gi), gi.resource("readback")), ([0; 3], 0), "{frames} frames");
    }
    assert_eq!(gi.log(), Vec::<String>::new());
    stage.wait();
    gi.end();
}

#[test]
fn meshes_that_cannot_be_used_count_as_empty() {
    let mut stage = Stage::new(2);
    let good = Shape::new(8, 0.0625);
    let expected = figures_of(&mut stage, &good);
    let gi = context(&stage);
    let in_good = good.in_buffer(&mut stage);
    let spoilt = |change: fn(&mut Shape)| {
        let mut shape = Shape::new(8, 0.0625);
        change(&mut shape);
        shape
    };
    for (shape, word) in [
        (spoilt(|shape| shape.positions[80][1] = f32::NAN), "mesh 1: a position is not finite"),
        (spoilt(|shape| shape.uvs[3][1] = f32::INFINITY), "mesh 1: a texture coordinate is not finite"),
        (spoilt(|shape| shape.indices[383] = 81), "mesh 1: an index is out of range"),
    ] {
        add(&gi, shape.in_buffer(&mut stage));
        (0..16).for_each(|_| stage.dispatch(&[&gi]));
        let log = gi.log();
        assert!(log.len() == 1 && log[0].contains("empty") && log[0].contains(word), "{log:?}");
        assert_eq!(figures(&gi), [0; 3]);
        add(&gi, in_good);
        (0..16).for_each(|_| stage.dispatch(&[&gi]));
        assert_eq!((figures(&gi), gi.log()), (expected, Vec::new()));
    }
    stage.wait();
    gi.end();
}

#[test]
fn contexts_read_one_buffer_in_one_command_buffer() {
    let mut stage = Stage::new(2);
    let shape = Shape::new(8, 0.0625);
    let expected = figures_of(&mut stage, &shape);
    let mesh = shape.in_buffer(&mut stage);
    let contexts = [context(&stage), context(&stage)];
    contexts.iter().for_each(|gi| add(gi, mesh));
    (0..16).for_each(|_| stage.dispatch(&[&contexts[0], &contexts[1]]));
    for gi in &contexts {
        assert_eq!((figures(gi), gi.log()), (expected, Vec::new()));
    }
    stage.wait();
    contexts.into_iter().for_each(Gi::end);
}
