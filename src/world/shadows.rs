//! Shadow maps as shaders read them.

use crate::bricks::WorldGrid;
use crate::gpu::shared::{LIGHT_SPOT, Light as GpuLight, ShadowLayer as GpuLayer};
use crate::gpu::{Bound, Player};
use crate::scene::{MAX_SHADOW_VIEWS, ShadowLayer, ShadowMap, shadow_views};
use ash::vk;
use glam::{DMat4, DVec3};

const IMAGES: [&str; MAX_SHADOW_VIEWS] = ["shadow_map_0", "shadow_map_1", "shadow_map_2", "shadow_map_3"];

/// The maps' layers; lights that have some are told which. `window`: its low corner in voxels.
pub fn gpu_layers(maps: &[ShadowMap], lights: &mut [GpuLight], grid: &WorldGrid, window: DVec3) -> Vec<GpuLayer> {
    let (views, mut layers) = (shadow_views(maps), Vec::new());
    for map in maps {
        let Some(light) = lights.get_mut(map.light as usize).filter(|light| light.kind <= LIGHT_SPOT) else { continue };
        let image = views.iter().position(|view| *view == map.view).expect("it is one of them") as u32;
        let first = layers.len();
        layers.extend(map.layers.iter().map(|layer| GpuLayer { image, ..gpu_layer(map, layer, grid, window) }));
        light.axis_v = [first as f32, layers.len() as f32, 0.0];
    }
    layers
}

fn gpu_layer(map: &ShadowMap, layer: &ShadowLayer, grid: &WorldGrid, window: DVec3) -> GpuLayer {
    let from_camera = grid.to_world(window) - DVec3::from(layer.camera.position);
    let to_metres = DMat4::from_translation(from_camera) * DMat4::from_scale(DVec3::splat(grid.voxel_size));
    let clip = layer.camera.clip() * to_metres;
    let [corner, size] = layer.part(map.size);
    let half_texel = |axis: usize| 1.0 / (f64::from(size[axis]) * clip.row(axis).truncate().length_squared());
    GpuLayer {
        clip: clip.as_mat4().to_cols_array_2d(),
        corner,
        size,
        half_texel: [0, 1].map(|axis| half_texel(axis) as f32),
        layer: layer.layer,
        normal_offset: (f64::from(map.normal_offset) / grid.voxel_size) as f32,
        depth_bias: map.depth_bias,
        order: if map.reversed { -1.0 } else { 1.0 },
        distance_scale: if map.range > 0.0 { (grid.voxel_size / f64::from(map.range)) as f32 } else { 0.0 },
        ..GpuLayer::default()
    }
}

/// Says what the images' names stand for: those that are not used, too.
pub fn bind(maps: &[ShadowMap], player: &mut Player) {
    let views = shadow_views(maps);
    for (index, name) in IMAGES.into_iter().enumerate().filter(|_| !views.is_empty()) {
        let view = views.get(index).unwrap_or(&views[0]);
        player.bound.insert(name, Bound::Image(*view, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL));
    }
}

#[cfg(test)]
mod tests;
