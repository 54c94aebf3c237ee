//! Direct irradiance of the lights with shadows, by rays on the CPU.

use crate::image::Image;
use crate::scene::Light;
use glam::{DVec3, Vec3, Vec3A};
use obvhs::{BvhBuildParams, cwbvh::CwBvh, cwbvh::builder::build_cwbvh_from_tris, ray::Ray, triangle::Triangle};
use rayon::prelude::*;
use std::f64::consts::{SQRT_2, TAU};
use std::time::Duration;

/// Shadow rays start this far off the surface, relative to the distances involved.
const OFFSET: f64 = 2e-5;
/// Of a light with an extent, each pixel.
const AREA_SAMPLES: u32 = 64;

/// A bounding volume hierarchy over the scene, for shadow rays.
pub struct ShadowScene {
    bvh: CwBvh,
    triangles: Vec<Triangle>,
}

impl ShadowScene {
    /// Builds the hierarchy over world-space triangles.
    pub fn new(triangles: &[[[f32; 3]; 3]]) -> Self {
        let triangle = |[v0, v1, v2]: [Vec3A; 3]| Triangle { v0, v1, v2 };
        let triangles: Vec<Triangle> = triangles.iter().map(|t| triangle(t.map(Vec3A::from))).collect();
        let bvh = build_cwbvh_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
        let ordered = bvh.primitive_indices.iter().map(|i| triangles[*i as usize]).collect();
        Self { bvh, triangles: ordered }
    }

    /// Whether anything lies between the origin and `reach` metres along the unit direction.
    pub fn occluded(&self, origin: DVec3, direction: DVec3, reach: f64) -> bool {
        let ray = Ray::new(origin.as_vec3a(), direction.as_vec3a(), 0.0, reach as f32);
        !self.bvh.ray_traverse_miss(ray, |ray, id| self.triangles[id].intersect(ray))
    }

    /// Irradiance of all lights at a surface point with the unit normal towards the viewer.
    pub fn irradiance(&self, position: DVec3, normal: DVec3, lights: &[Light]) -> [f32; 3] {
        let offset = OFFSET * (1.0 + position.abs().max_element());
        let mut sum = DVec3::ZERO;
        for light in lights {
            let samples =
                if matches!(light, Light::Sphere { .. } | Light::Rectangle { .. }) { AREA_SAMPLES } else { 1 };
            for index in 0..samples {
                let (toward, reach, strength) = arriving(light, position, place(position, index));
                let cosine = normal.dot(toward);
                if cosine <= 0.0 || strength == DVec3::ZERO {
                    continue;
                }
                if !self.occluded(position + normal * offset, toward, reach - 2.0 * offset) {
                    sum += strength * (cosine / f64::from(samples));
                }
            }
        }
        sum.as_vec3().to_array()
    }

    /// E_direct of every pixel; `surface` gives its position and unit normal, or `None` where nothing is.
    pub fn render(
        &self,
        [width, height]: [u32; 2],
        lights: &[Light],
        surface: impl Fn(u32, u32) -> Option<(DVec3, DVec3)> + Sync,
    ) -> Image {
        let pixel = |index: u32| match surface(index % width, index / width) {
            Some((position, normal)) => self.irradiance(position, normal, lights),
            None => [0.0; 3],
        };
        Image { width, height, pixels: (0..width * height).into_par_iter().map(pixel).collect() }
    }
}

/// Sample `index` at a position: the additive sequence of sqrt 2 and sqrt 3 from a start of the position's own.
fn place(position: DVec3, index: u32) -> [f64; 2] {
    let start = position.dot(DVec3::new(12.9898, 78.233, 37.719)).sin() * 43758.5453;
    [start + f64::from(index) * SQRT_2, 1.7 * start + f64::from(index) * 3f64.sqrt()].map(|u| u.rem_euclid(1.0))
}

/// Unit direction towards the light's place `u`, distance to it, and irradiance on a plane facing it.
fn arriving(light: &Light, at: DVec3, u: [f64; 2]) -> (DVec3, f64, DVec3) {
    let vector = |v: [f32; 3]| Vec3::from(v).as_dvec3();
    let to = |place: DVec3| {
        let distance = (place - at).length().max(1e-9);
        ((place - at) / distance, distance)
    };
    let window = |distance: f64, range: f32| {
        let share = if range > 0.0 { distance / f64::from(range) } else { 0.0 };
        (1.0 - share.powi(4)).max(0.0).powi(2) / (distance * distance)
    };
    match *light {
        Light::Directional { direction, irradiance } => {
            (-vector(direction).normalize_or_zero(), f64::from(f32::MAX), vector(irradiance))
        }
        Light::Point { position, intensity, range } => {
            let (toward, distance) = to(position.into());
            (toward, distance, vector(intensity) * window(distance, range))
        }
        Light::Spot { position, direction, intensity, inner_angle, outer_angle, range } => {
            let (toward, distance) = to(position.into());
            let outer = f64::from(outer_angle).cos();
            let cosine = -toward.dot(vector(direction).normalize_or_zero());
            let cone = ((cosine - outer) / (f64::from(inner_angle).cos() - outer).max(1e-3)).clamp(0.0, 1.0);
            (toward, distance, vector(intensity) * (cone * cone * window(distance, range)))
        }
        Light::Sphere { position, radius, radiance } => {
            // Evenly over the cap that is seen.
            let (axis, distance) = to(position.into());
            let radius = f64::from(radius);
            if distance <= radius {
                return (axis, distance, DVec3::ZERO);
            }
            let cap = 1.0 - (1.0 - (radius / distance).powi(2)).sqrt();
            let cosine = 1.0 - u[0] * cap;
            let sine = (1.0 - cosine * cosine).sqrt();
            let (side, other) = axis.any_orthonormal_pair();
            let (y, x) = (TAU * u[1]).sin_cos();
            let reach = distance * cosine - (radius.powi(2) - (distance * sine).powi(2)).max(0.0).sqrt();
            (axis * cosine + (side * x + other * y) * sine, reach, vector(radiance) * (TAU * cap))
        }
        Light::Rectangle { position, half_u, half_v, radiance, two_sided } => {
            let [half_u, half_v] = [half_u, half_v].map(vector);
            let [x, y] = u.map(|u| 2.0 * u - 1.0);
            let (toward, distance) = to(DVec3::from(position) + half_u * x + half_v * y);
            let seen = -toward.dot(half_u.cross(half_v)) * 4.0 / (distance * distance);
            (toward, distance, vector(radiance) * if two_sided { seen.abs() } else { seen.max(0.0) })
        }
    }
}
