//! Lights as shaders read them.

use crate::bricks::WorldGrid;
use crate::gpu::shared::{
    LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_RECTANGLE, LIGHT_SPHERE, LIGHT_SPOT, LIGHT_TWO_SIDED_RECTANGLE,
    Light as GpuLight,
};
use crate::scene::Light;
use glam::{DVec3, Vec3};

/// `window`: its low corner in voxels.
pub fn gpu_light(light: &Light, grid: &WorldGrid, window: DVec3) -> GpuLight {
    let place = |position: [f64; 3]| (grid.to_voxels(DVec3::from(position)) - window).as_vec3().to_array();
    let unit = |direction: [f32; 3]| Vec3::from(direction).as_dvec3().normalize_or_zero().as_vec3().to_array();
    let voxels = |metres: f32| (f64::from(metres) / grid.voxel_size) as f32;
    let falloff = |range: f32| if range > 0.0 { voxels(range).powi(2).recip() } else { 0.0 };
    match *light {
        Light::Directional { direction, irradiance } => {
            GpuLight { kind: LIGHT_DIRECTIONAL, vector: unit(direction), color: irradiance, ..GpuLight::default() }
        }
        Light::Point { position, intensity, range } => GpuLight {
            kind: LIGHT_POINT,
            vector: place(position),
            color: intensity,
            extent: falloff(range),
            ..GpuLight::default()
        },
        Light::Spot { position, direction, intensity, inner_angle, outer_angle, range } => {
            let outer = outer_angle.cos();
            let scale = (inner_angle.cos() - outer).max(1e-3).recip();
            GpuLight {
                kind: LIGHT_SPOT,
                vector: place(position),
                color: intensity,
                extent: falloff(range),
                axis_u: unit(direction),
                cone_scale: scale,
                cone_offset: -outer * scale,
                ..GpuLight::default()
            }
        }
        Light::Sphere { position, radius, radiance } => GpuLight {
            kind: LIGHT_SPHERE,
            vector: place(position),
            color: radiance,
            extent: voxels(radius),
            ..GpuLight::default()
        },
        Light::Rectangle { position, half_u, half_v, radiance, two_sided } => GpuLight {
            kind: if two_sided { LIGHT_TWO_SIDED_RECTANGLE } else { LIGHT_RECTANGLE },
            vector: place(position),
            color: radiance,
            axis_u: half_u.map(voxels),
            axis_v: half_v.map(voxels),
            ..GpuLight::default()
        },
    }
}

#[cfg(test)]
mod tests;
