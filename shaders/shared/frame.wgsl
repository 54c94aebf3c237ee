// What every pass may know of the frame. Grid space: voxels, origin at the low corner of the covered window.
struct Frame {
    // Window in groups.
    extent: vec3<u32>,
    // Dispatch calls so far.
    frame_index: u32,
    // Physical group = (group + torus) & (extent - 1).
    torus: vec3<u32>,
    // 0 plane, 1 cube.
    hit_model: u32,
    // Everything resident lies inside, grid space.
    bounds_min: vec3<f32>,
    // Metres.
    voxel_size: f32,
    bounds_max: vec3<f32>,
    // Largest component of any emission, at least a small positive number.
    emission_max: f32,
    // Constant: radiance. Gradient: at the zenith. Image: its factor.
    sky: vec3<f32>,
    light_count: u32,
    // Window's position in voxels (wrapping): seeds stay with the world.
    seed_origin: vec3<u32>,
    // Rays a face and update.
    bounce_rays: u32,
    // Shadow samples a face, light and update.
    direct_samples: u32,
    // 1: some faces are not lit, for nothing reaches them.
    unreached: u32,
    // Gradient: up; radiance at the horizon; radiance of the ground. Image: its axes in the world.
    sky_x: vec3<f32>,
    sky_kind: u32,
    sky_y: vec3<f32>,
    sky_z: vec3<f32>,
    // Lights that each sample of a face asks at most.
    direct_lights: u32,
}

struct Light {
    // Directional: where it travels, normalised. Else: position in grid space.
    vector: vec3<f32>,
    kind: u32,
    // Directional: irradiance. Point, spot: radiant intensity. Sphere, rectangle: radiance.
    color: vec3<f32>,
    // Point, spot: 1 / range^2 in voxels, or 0. Sphere: radius in voxels.
    extent: f32,
    // Spot: where it shines, normalised. Rectangle: from the middle to that of an edge, voxels.
    axis_u: vec3<f32>,
    // Spot: falls off as clamp(cosine * scale + offset, 0, 1)^2.
    cone_scale: f32,
    // Rectangle: the same of the neighbouring edge. Directional, point, spot: the first layer of its shadow map in x, the one
    // after the last in y.
    axis_v: vec3<f32>,
    cone_offset: f32,
}

// A part of a light's shadow map: a cascade, a cube's face, or all of it.
struct ShadowLayer {
    // Grid space to clip space.
    clip: mat4x4<f32>,
    // Where it lies in the image, and how large it is, texels.
    corner: vec2<u32>,
    size: vec2<u32>,
    // Times w and a normal's x and y in clip space: how far its surface rises within half a texel, voxels.
    half_texel: vec2<f32>,
    // Which of the images, and which layer of it.
    image: u32,
    layer: u32,
    // Off the face along its normal, voxels.
    normal_offset: f32,
    depth_bias: f32,
    // 1: what is smaller is nearer; -1: what is larger.
    order: f32,
    // The image holds distances from the light: what a voxel is in it; 0: it holds depths.
    distance_scale: f32,
}
