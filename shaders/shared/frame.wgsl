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
    // Radiance.
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
}

struct Light {
    // Directional: where it travels, normalised. Point: position in grid space.
    vector: vec3<f32>,
    kind: u32,
    // Directional: irradiance. Point: radiant intensity.
    color: vec3<f32>,
    unused: u32,
}
