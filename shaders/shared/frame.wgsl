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
    // Rectangle: the same of the neighbouring edge.
    axis_v: vec3<f32>,
    cone_offset: f32,
}
