//! Direct irradiance of the lights with hard shadows, by rays on the CPU.

use crate::image::Image;
use crate::scene::Light;
use glam::{DVec3, Vec3A};
use obvhs::{BvhBuildParams, cwbvh::CwBvh, cwbvh::builder::build_cwbvh_from_tris, ray::Ray, triangle::Triangle};
use rayon::prelude::*;
use std::time::Duration;

/// Shadow rays start this far off the surface, relative to the distances involved.
const OFFSET: f64 = 2e-5;

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
        let mut sum = DVec3::ZERO;
        for light in lights {
            let (toward, reach, strength) = arriving(light, position);
            let cosine = normal.dot(toward);
            if cosine <= 0.0 || strength == DVec3::ZERO {
                continue;
            }
            let offset = OFFSET * (1.0 + position.abs().max_element());
            if !self.occluded(position + normal * offset, toward, reach - 2.0 * offset) {
                sum += strength * cosine;
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

/// Unit direction towards the light, distance to it, and irradiance on a plane facing it.
fn arriving(light: &Light, at: DVec3) -> (DVec3, f64, DVec3) {
    let rgb = |v: [f32; 3]| glam::Vec3::from(v).as_dvec3();
    match light {
        Light::Directional { direction, irradiance } => {
            (-rgb(*direction).normalize_or_zero(), f64::from(f32::MAX), rgb(*irradiance))
        }
        Light::Point { position, intensity } => {
            let path = DVec3::from(*position) - at;
            let distance = path.length().max(1e-9);
            (path / distance, distance, rgb(*intensity) / (distance * distance))
        }
    }
}
