//! The host's shadow maps.

use super::lights::require;
use super::{Camera, Light};
use crate::error::Error;
use ash::vk;

/// Different images among all maps.
pub(crate) const MAX_SHADOW_VIEWS: usize = 4;
/// Layers of all maps.
pub(crate) const MAX_SHADOW_LAYERS: usize = 64;

/// A shadow map of the host's, of one light: single, in cascades, or a cube.
///
/// A point of a face is lit by the first layer whose frustum it is in: it is moved along the face's normal, brought to
/// clip space, and compared with the one texel there. It is lit where its depth, less `depth_bias` (reversed: plus), is
/// not beyond the texel's. Points move over their faces with time, which filters the shadow's edge.
///
/// It is moved by as much as the surface rises within half a texel, which the library knows from the layer; by 0.05 voxel,
/// as faces lie on mean planes; and by `normal_offset`. So a map that was drawn without any bias, at pixel centres, needs
/// none here.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowMap {
    /// Its light's index in what `set_lights` was last given: directional, point or spot. One map a light. A map whose light
    /// is no longer there, or has an extent now, is passed over.
    pub light: u32,
    /// A 2D-array view (of a cube map, too): depth aspect of a depth format, or R32_SFLOAT; single-sampled. Usage SAMPLED,
    /// layout `SHADER_READ_ONLY_OPTIMAL`, readable by compute shaders when a dispatch begins. Maps may share it: at most 4
    /// different ones.
    pub view: vk::ImageView,
    /// Width and height of its first level in texels, 1 to 16384.
    pub size: [u32; 2],
    /// 1 to 6; of all maps at most 64. Cascades finest first.
    pub layers: Vec<ShadowLayer>,
    /// Larger is nearer: reverse depth.
    pub reversed: bool,
    /// 0: texels hold depth. Above, of points and spots: they hold distance from the light over `range` (metres).
    pub range: f32,
    /// What depth is relieved of before it is compared, in units of the texels; finite.
    pub depth_bias: f32,
    /// Metres by which points are moved along their face's normal beside what the library adds; 0 or more.
    pub normal_offset: f32,
}

/// A part of a shadow map: a cascade, a face of a cube, or all of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowLayer {
    /// Array layer of the view; it exists.
    pub layer: u32,
    /// Its part of that layer, which the viewport was: x, y, width and height in texels. All 0: the whole.
    pub rectangle: [u32; 4],
    /// What it was drawn with. Who has only a matrix from world to clip space gives it as `projection`, with the
    /// world's origin and no rotation, and loses digits far away.
    pub camera: Camera,
}

impl ShadowMap {
    fn check(&self, lights: &[Light]) -> Result<(), &'static str> {
        let light = lights.get(self.light as usize);
        require(light.is_some(), "light: there is none of this index")?;
        let can = |light: &Light| matches!(light, Light::Directional { .. } | Light::Point { .. } | Light::Spot { .. });
        require(light.is_some_and(can), "light: spheres and rectangles have no shadow maps")?;
        require(self.view != vk::ImageView::null(), "view is VK_NULL_HANDLE")?;
        require(self.size.iter().all(|edge| (1..=16_384).contains(edge)), "width and height must be 1 to 16384")?;
        require((1..=6).contains(&self.layers.len()), "layers: 1 to 6 are possible")?;
        require(self.range.is_finite() && self.range >= 0.0, "range is not finite, or negative")?;
        let is_directional = matches!(light, Some(Light::Directional { .. }));
        require(self.range == 0.0 || !is_directional, "range: a directional light is at no distance")?;
        require(self.depth_bias.is_finite(), "depth bias is not finite")?;
        require(self.normal_offset.is_finite() && self.normal_offset >= 0.0, "normal offset is not finite, or negative")
    }
}

impl ShadowLayer {
    /// Corner and size in an image of this size, texels.
    pub(crate) fn part(&self, size: [u32; 2]) -> [[u32; 2]; 2] {
        let [x, y, width, height] = self.rectangle;
        if self.rectangle == [0; 4] { [[0; 2], size] } else { [[x, y], [width, height]] }
    }

    fn check(&self, size: [u32; 2]) -> Result<(), &'static str> {
        let [corner, part] = self.part(size);
        let inside =
            |axis: usize| part[axis] > 0 && u64::from(corner[axis]) + u64::from(part[axis]) <= size[axis].into();
        require(inside(0) && inside(1), "rectangle is empty, or not in the image")?;
        require(self.layer < 2048, "layer must be below 2048")?;
        self.camera.check()
    }
}

/// Checks all maps before any is taken.
pub(crate) fn check_shadow_maps(maps: &[ShadowMap], lights: &[Light]) -> Result<(), Error> {
    for (index, map) in maps.iter().enumerate() {
        let fault = |at: String| move |fault| Error::invalid(format!("maps[{index}]{at}: {fault}"));
        map.check(lights).map_err(fault(String::new()))?;
        for (number, layer) in map.layers.iter().enumerate() {
            layer.check(map.size).map_err(fault(format!(".layers[{number}]")))?;
        }
        if maps[..index].iter().any(|other| other.light == map.light) {
            return Err(Error::invalid(format!("maps[{index}]: light {} has a map already", map.light)));
        }
    }
    if maps.iter().map(|map| map.layers.len()).sum::<usize>() > MAX_SHADOW_LAYERS {
        return Err(Error::invalid(format!("maps: more than {MAX_SHADOW_LAYERS} layers")));
    }
    if shadow_views(maps).len() > MAX_SHADOW_VIEWS {
        return Err(Error::invalid(format!("maps: more than {MAX_SHADOW_VIEWS} different views")));
    }
    Ok(())
}

/// The different views, in the order of the maps.
pub(crate) fn shadow_views(maps: &[ShadowMap]) -> Vec<vk::ImageView> {
    let mut views = Vec::new();
    for map in maps {
        if !views.contains(&map.view) {
            views.push(map.view);
        }
    }
    views
}
