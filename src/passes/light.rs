//! Group "lighting": `face_compact`, `light_direct` (or one of its kin), `light_bounce` (or `light_bounce_once`), `light_store`.

use crate::frame::Frame;
use crate::gpu::shared::{LIGHT_SPHERE, Light, LightBrick, LightPush, ShadowLayer};
use crate::scene;
use crate::settings::Settings;

/// What lights the faces.
pub struct Lights {
    pub all: Vec<Light>,
    /// Of their shadow maps.
    pub layers: Vec<ShadowLayer>,
}

/// Lights `face_count` faces of the chosen bricks `sweeps` times; `first_update` numbers the sweeps over time.
pub fn light(
    frame: &mut Frame,
    bricks: &[LightBrick],
    face_count: u32,
    sweeps: u32,
    first_update: u32,
    lights: &Lights,
    settings: &Settings,
) {
    let Lights { all: lights, layers } = lights;
    frame.upload.push("lights", lights);
    frame.upload.push("light_bricks", bricks);
    if !layers.is_empty() {
        frame.upload.push("shadow_layers", layers);
    }
    let (brick_count, groups) = (bricks.len() as u32, face_count.div_ceil(64));
    let bounces = settings.bounce_rays > 0;
    let have_extent = lights.iter().any(|l| l.kind >= LIGHT_SPHERE);
    let direct = direct_pass(lights.len(), have_extent, !layers.is_empty(), settings);
    let direct_groups = if are_many(lights.len(), settings) { brick_count } else { groups };
    frame.dispatch("face_compact", [brick_count, 1, 1], [0u32; 0]);
    for sweep in 0..sweeps {
        let push = LightPush { face_count, brick_count, update: first_update + sweep };
        // Without bounces it still clears what the sweep before left.
        if !lights.is_empty() || !bounces {
            frame.dispatch(direct, [direct_groups, 1, 1], push);
        }
        if bounces {
            frame.dispatch(bounce_pass(settings), [groups, 1, 1], push);
        }
        frame.dispatch("light_store", [brick_count, 1, 1], push);
    }
}

/// Whether a brick's faces choose among the lights.
fn are_many(lights: usize, settings: &Settings) -> bool {
    lights > settings.direct_lights as usize
}

/// What these lights need, whether or not any of their shadow maps covers anything.
pub fn direct_passes(
    lights: &[scene::Light],
    have_maps: bool,
    settings: &Settings,
) -> impl Iterator<Item = &'static str> + use<> {
    let have_extent = lights.iter().any(scene::Light::has_extent);
    let [without, with] = [false, true].map(|maps| direct_pass(lights.len(), have_extent, maps, settings));
    // Without rays it clears what the sweep before left.
    let any = !lights.is_empty() || settings.bounce_rays == 0;
    any.then_some(without).into_iter().chain((any && have_maps).then_some(with))
}

/// The pass of direct light by so many lights, some of which may have an extent, or shadow maps.
fn direct_pass(lights: usize, have_extent: bool, have_maps: bool, settings: &Settings) -> &'static str {
    let [all, many] = match (have_maps, have_extent) {
        (true, _) => ["light_direct_maps", "light_direct_many_maps"],
        (_, true) => ["light_direct_areas", "light_direct_many_areas"],
        _ => ["light_direct", "light_direct_many"],
    };
    if are_many(lights, settings) { many } else { all }
}

/// The pass of bounce rays.
pub fn bounce_pass(settings: &Settings) -> &'static str {
    if settings.single_bounce { "light_bounce_once" } else { "light_bounce" }
}
