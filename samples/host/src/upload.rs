//! Says the scene in brickgi's words.

use crate::error::Result;
use crate::scene::{Instance, Light, Scene, Sky, SkyPicture};
use brickgi::Context;
use brickgi::scene::{InstanceDesc, MaterialDesc, MeshDesc, MeshUpdate, SkyFormat, SkyImage, TextureDesc};

/// Adds everything in one batch; ids are the scene's indices.
pub(crate) fn scene(context: &mut Context, scene: &Scene, offset: [f64; 3]) -> Result<()> {
    let textures: Vec<_> = (0u64..)
        .zip(&scene.textures)
        .map(|(id, t)| TextureDesc { id, width: t.width, height: t.height, rgba8: &t.rgba8 })
        .collect();
    let materials: Vec<_> = (0u64..)
        .zip(&scene.materials)
        .map(|(id, m)| MaterialDesc {
            id,
            base_color: m.base_color,
            emission: m.emission,
            base_color_texture: m.texture.map(|t| t as u64),
            ..MaterialDesc::default()
        })
        .collect();
    let meshes: Vec<_> = (0u64..)
        .zip(&scene.meshes)
        .map(|(id, m)| MeshDesc { id, positions: &m.positions, uvs: &m.uvs, indices: &m.indices })
        .collect();
    let instances: Vec<_> =
        (0u64..).zip(&scene.instances).map(|(id, instance)| describe(id, instance, offset)).collect();
    context.update_meshes(&MeshUpdate {
        textures: &textures,
        materials: &materials,
        meshes: &meshes,
        instances: &instances,
        ..MeshUpdate::default()
    })?;
    if let Some(SkyPicture { layout, width, height, rgba32 }) = &scene.sky_picture {
        let texels = bytemuck::cast_slice(rgba32);
        let format = SkyFormat::Rgba32Float;
        context.set_sky_image(&SkyImage { layout: *layout, format, width: *width, height: *height, texels })?;
    }
    lights(context, &scene.lights, scene.sky, offset)
}

/// Adds, moves and changes instances (`Some`) and removes them (`None`), by id, in one batch.
pub(crate) fn instances(context: &mut Context, changes: &[(u64, Option<Instance>)], offset: [f64; 3]) -> Result<()> {
    let placed = |(id, instance): &(u64, Option<Instance>)| Some(describe(*id, instance.as_ref()?, offset));
    let instances: Vec<_> = changes.iter().filter_map(placed).collect();
    let removed: Vec<u64> = changes.iter().filter(|(_, instance)| instance.is_none()).map(|(id, _)| *id).collect();
    let update = MeshUpdate { removed_instances: &removed, instances: &instances, ..MeshUpdate::default() };
    Ok(context.update_meshes(&update)?)
}

fn describe(id: u64, instance: &Instance, offset: [f64; 3]) -> InstanceDesc {
    InstanceDesc {
        id,
        mesh: instance.mesh as u64,
        material: instance.material as u64,
        linear: instance.linear,
        translation: moved(instance.translation, offset),
    }
}

/// Replaces the lights and the sky.
pub(crate) fn lights(context: &mut Context, lights: &[Light], sky: Sky, offset: [f64; 3]) -> Result<()> {
    let mut lights = lights.to_vec();
    lights.iter_mut().filter_map(Light::position_mut).for_each(|position| *position = moved(*position, offset));
    Ok(context.set_lights(&lights, sky)?)
}

fn moved(position: [f64; 3], offset: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| position[axis] + offset[axis])
}
