//! Geometry for voxelisation, in voxels.

use crate::scene::{InstanceDesc, MaterialDesc, MeshDesc, MeshUpdate, Scene};
use crate::twin::random::Random;
use glam::{DVec3, Vec3};

pub const MATERIALS: u32 = 7;

/// A mesh of loose triangles.
struct Body {
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    indices: Vec<u32>,
    material: u64,
}

/// Bodies and sheets: each becomes a mesh of its own.
#[derive(Default)]
pub struct Bodies(Vec<Body>);

impl Bodies {
    /// Triangles given by corners, counter-clockwise seen from outside.
    pub fn add(&mut self, corners: &[[DVec3; 3]], material: u32) {
        let positions: Vec<[f32; 3]> = corners.iter().flatten().map(|p| p.as_vec3().to_array()).collect();
        // A little off, so that no column meets the border of a texel.
        let uvs = positions.iter().map(|p| [p[0] * 0.25 + p[2] * 0.125 + 0.013, p[1] * 0.25 + 0.013]).collect();
        let indices = (0..positions.len() as u32).collect();
        self.0.push(Body { positions, uvs, indices, material: u64::from(material) });
    }

    /// A closed convex body over a hexahedron's corners (bit 0: x, 1: y, 2: z).
    pub fn hexahedron(&mut self, corners: [DVec3; 8], material: u32) {
        const FACES: [[usize; 4]; 6] =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let c = |i: usize| corners[i];
        let faces = FACES.iter().flat_map(|f| [[c(f[0]), c(f[1]), c(f[2])], [c(f[0]), c(f[2]), c(f[3])]]);
        self.add(&faces.filter(|[a, b, c]| (*b - *a).cross(*c - *a) != DVec3::ZERO).collect::<Vec<_>>(), material);
    }

    pub fn cuboid(&mut self, low: DVec3, high: DVec3, material: u32) {
        let corner = |i: usize| DVec3::from(std::array::from_fn(|k| if i >> k & 1 == 1 { high[k] } else { low[k] }));
        self.hexahedron(std::array::from_fn(corner), material);
    }

    /// A box whose top is an edge: two opposing ramps, or one.
    pub fn wedge(&mut self, low: DVec3, high: DVec3, ridge: f64, material: u32) {
        let corner = |i: usize| {
            let mut p = DVec3::from(std::array::from_fn(|k| if i >> k & 1 == 1 { high[k] } else { low[k] }));
            if i & 2 != 0 {
                p.x = ridge;
            }
            p
        };
        self.hexahedron(std::array::from_fn(corner), material);
    }

    pub fn tetrahedron(&mut self, corners: [DVec3; 4], material: u32) {
        let [a, b, c, d] = corners;
        let volume = (b - a).cross(c - a).dot(d - a);
        let [b, c] = if volume > 0.0 { [c, b] } else { [b, c] };
        self.add(&[[a, b, c], [a, c, d], [a, d, b], [b, d, c]], material);
    }

    /// Everything as the SDK keeps it: greys, a lamp, a textured one, white, a pane, foliage.
    pub fn scene(&self) -> Scene {
        let rgba8: Vec<u8> = (0..8 * 8 * 4).map(|i: u32| (i * 37 % 251) as u8).collect();
        let texture = crate::scene::TextureDesc { id: 7, width: 8, height: 8, rgba8: &rgba8 };
        let material = |id: u32, base_color: [f32; 3], emission: [f32; 3], textured: bool| MaterialDesc {
            id: u64::from(id),
            base_color,
            emission,
            base_color_texture: textured.then_some(7),
            ..MaterialDesc::default()
        };
        let materials: [MaterialDesc; MATERIALS as usize] = [
            material(0, [0.5; 3], [0.0; 3], false),
            material(1, [0.8, 0.1, 0.3], [0.0; 3], false),
            material(2, [0.2; 3], [12.0, 7.0, 0.5], false),
            material(3, [0.9, 0.7, 1.0], [0.0; 3], true),
            material(4, [1.0; 3], [0.0, 0.25, 0.0], false),
            MaterialDesc { transmittance: 0.4, ..material(5, [0.6; 3], [3.0; 3], false) },
            MaterialDesc { transmittance: 0.125, texture_alpha: true, ..material(6, [0.4; 3], [0.0; 3], true) },
        ];
        let instance = |(id, body): (u64, &Body)| InstanceDesc {
            id,
            mesh: id,
            material: body.material,
            linear: [Vec3::X, Vec3::Y, Vec3::Z].map(|v| v.to_array()),
            translation: [0.0; 3],
        };
        let instances: Vec<InstanceDesc> = (0..).zip(&self.0).map(instance).collect();
        let meshes: Vec<MeshDesc> = (0..)
            .zip(&self.0)
            .map(|(id, b)| MeshDesc { id, positions: &b.positions, uvs: &b.uvs, indices: &b.indices })
            .collect();
        let update = MeshUpdate {
            textures: &[texture],
            materials: &materials,
            meshes: &meshes,
            instances: &instances,
            ..MeshUpdate::default()
        };
        let mut scene = Scene::default();
        scene.check(&update).expect("a scene");
        scene.apply(&update);
        scene
    }
}

/// A multiple of 1/8 in [low, high].
fn eighth(random: &mut Random, low: i32, high: i32) -> f64 {
    f64::from(low * 8 + random.below(((high - low) * 8 + 1) as u32) as i32) / 8.0
}

fn eighths(random: &mut Random, low: i32, high: i32) -> DVec3 {
    DVec3::new(eighth(random, low, high), eighth(random, low, high), eighth(random, low, high))
}

fn material(random: &mut Random) -> u32 {
    random.below(MATERIALS)
}

/// Boxes of any size, some standing on others, with thin walls between.
pub fn boxes(random: &mut Random) -> Bodies {
    let mut all = Bodies::default();
    for _ in 0..12 {
        let low = eighths(random, -8, 12);
        let high = low + eighths(random, 0, 6) + 0.125;
        all.cuboid(low, high, material(random));
        // One on top, in contact with a part of it.
        let foot = DVec3::new(low.x + 0.25, high.y, low.z - 0.5);
        all.cuboid(foot, foot + eighths(random, 0, 3) + 0.25, material(random));
    }
    for _ in 0..6 {
        let low = eighths(random, -8, 8);
        let mut high = low + 9.0;
        let axis = random.below(3) as usize;
        high[axis] = low[axis] + f64::from(1 + random.below(5)) / 8.0;
        all.cuboid(low, high, material(random));
    }
    all
}

/// Roofs, ramps and skewed boxes.
pub fn ramps(random: &mut Random) -> Bodies {
    let mut all = Bodies::default();
    for _ in 0..14 {
        let low = eighths(random, -8, 10);
        let high = low + eighths(random, 1, 7);
        let ridge = low.x + eighth(random, 0, 1) * (high.x - low.x);
        all.wedge(low, high, ridge, material(random));
    }
    for _ in 0..8 {
        let low = eighths(random, -8, 10);
        let skew = eighths(random, -1, 1);
        let size = eighths(random, 1, 4);
        let corner = |i: usize| {
            let bit = |k: usize| f64::from((i >> k & 1) as u8);
            low + DVec3::new(bit(0), bit(1), bit(2)) * size + skew * bit(1)
        };
        all.hexahedron(std::array::from_fn(corner), material(random));
    }
    all
}

/// Open sheets, flat and sloped, seen from both sides.
pub fn sheets(random: &mut Random) -> Bodies {
    let mut all = Bodies::default();
    for _ in 0..16 {
        let a = eighths(random, -8, 12);
        let (u, v) = (eighths(random, -4, 4), eighths(random, -4, 4));
        let flat = DVec3::AXES[random.below(3) as usize];
        let (u, v) = if random.chance(0.5) { (u, v) } else { (u - u * flat, v - v * flat) };
        if u.cross(v) != DVec3::ZERO {
            all.add(&[[a, a + u, a + u + v], [a, a + u + v, a + v]], material(random));
        }
    }
    all
}

/// Small closed bodies, many to a voxel.
pub fn crumbs(random: &mut Random) -> Bodies {
    let mut all = Bodies::default();
    for index in 0..500 {
        let (low, high) = if index < 380 { (2, 4) } else { (-2, 10) };
        let at = eighths(random, low, high);
        let corners = std::array::from_fn(|_| at + eighths(random, 0, 1) * 0.75);
        let corners = corners.map(|p: DVec3| (p * 8.0).round() / 8.0);
        let [a, b, c, d] = corners;
        if (b - a).cross(c - a).dot(d - a) != 0.0 {
            all.tetrahedron(corners, material(random));
        }
    }
    all
}

/// Loose triangles and tetrahedra anywhere.
pub fn soup(random: &mut Random) -> Bodies {
    let mut all = Bodies::default();
    for _ in 0..120 {
        let at = random.point() * 20.0 - 6.0;
        let size = 8f64.powf(random.between(-0.5, 1.0));
        let corner = |random: &mut Random| at + (random.point() - 0.5) * size;
        let corners = [corner(random), corner(random), corner(random), corner(random)];
        if random.chance(0.4) {
            all.add(&[[corners[0], corners[1], corners[2]]], material(random));
        } else {
            all.tetrahedron(corners, material(random));
        }
    }
    all
}

/// A block and a thousand triangles in one voxel: more than its list holds at once. (Mesa's lavapipe ends all loops of
/// an invocation after 65 535 rounds together: from some 1 500 triangles on it loses the voxel.)
pub fn crowd(random: &mut Random) -> Bodies {
    let mut all = Bodies::default();
    all.cuboid(DVec3::new(2.0, 2.0, 2.0), DVec3::new(3.0, 2.5, 3.0), 0);
    for _ in 0..250 {
        let at = DVec3::new(2.25, 2.4, 2.25);
        all.tetrahedron(std::array::from_fn(|_| at + random.point() * 0.25), material(random));
    }
    all
}
