// A queued brick.
struct BatchBrick {
    // In `triangle_lists`.
    first_triangle: u32,
    triangle_count: u32,
    // Hash of the brick's world position.
    seed: u32,
    // Its place in its group: x | y << 2 | z << 4.
    place: u32,
    // Its first word in `reach_masks`; NONE: every face that may be lit is.
    reach: u32,
}

// What `face_resolve` tells the host of a brick.
struct BrickResult {
    // Words of the brick; 0: empty.
    words: u32,
    // First word in `payload`; NONE: did not fit, try again.
    offset: u32,
    // Lit faces.
    faces: u32,
    // Occupied voxels | different surfaces << 16.
    voxels_surfaces: u32,
    // Faces that are not lit because nothing reaches them.
    unreached: u32,
    // Which voxels are occupied: a mask of two words for each block.
    occupied: array<u32, 16>,
}

struct Material {
    base_color: vec3<f32>,
    // First texel in `texels`, or NO_TEXTURE.
    texture: u32,
    emission: vec3<f32>,
    // Width | height << 16.
    texture_size: u32,
    // Share of the light that it stops, 0 to 1; multiplied with the texture's alpha if texture_alpha is 1.
    opacity: f32,
    texture_alpha: u32,
    unused: vec2<u32>,
}

// Words to copy from `payload` to `world_bricks`.
struct BrickCopy {
    source: u32,
    target_word: u32,
    words: u32,
    unused: u32,
}

// Light to carry over to a brick that is voxelised again.
struct LightCarry {
    // First word in `world_bricks` of the brick that it had been.
    base: u32,
    // First word in `brick_source` of what takes its place.
    source: u32,
}

const ASKS: u32 = 0x80000000u;

// What lighting has found of a brick: means of its faces, radiance, sums of the three channels.
struct LightChange {
    // Found, less what was known.
    difference: f32,
    // Between the two.
    radiance: f32,
    // Deviation of `difference` if each face errs by itself.
    deviation: f32,
}

// A brick chosen for lighting.
struct LightBrick {
    // First word in `world_bricks`.
    base: u32,
    // Brick position in the window: x | y << 10 | z << 20; with ASKS, rays of its faces may ask for light.
    position: u32,
    // Its faces' first place in `vis_faces`.
    first_face: u32,
    // Weight of the new value, 0 to 1.
    alpha: f32,
}
