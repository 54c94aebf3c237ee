// One view's camera, this frame and the last.
struct View {
    // Depth-buffer clip space to view space.
    clip_to_view: mat4x4<f32>,
    // Rotation (w column unused).
    view_to_world: mat4x4<f32>,
    // Camera-relative world (metres) to clip space, this frame.
    clip: mat4x4<f32>,
    // Camera-relative world (metres) of this frame to last frame's clip space.
    previous_clip: mat4x4<f32>,
    // Camera in grid space.
    camera: vec3<f32>,
    // Depth where nothing was drawn.
    clear_depth: f32,
    // Rendered region in pixels.
    size: vec2<u32>,
    // Probes: one a tile.
    tiles: vec2<u32>,
    // Row of the history buffers in pixels.
    stride: u32,
    tile_size: u32,
    // Frames averaged at most.
    history_max: u32,
    // 1: last frame's history can be used.
    history_valid: u32,
    // Last frame's camera minus this frame's, metres.
    camera_delta: vec3<f32>,
    // Rendered region of the last frame: width | height << 16.
    previous_size: u32,
    // Rays of each pixel into the world instead of probes; 0: probes.
    pixel_rays: u32,
    // Of so many settled probes, and of so many settled pixels, one looks in a frame.
    gather_interval: u32,
    // Within so many voxels pixels look for themselves, and what probes hit there does not count; negative: nowhere.
    near_field: f32,
    // 1: `motion_image` is one.
    has_motion: u32,
    // From its values to parts of the image: where a pixel was, less where it is.
    motion_scale: vec2<f32>,
    // To be added: by how much the middle of the last frame's projection lay off this one's, parts of the image (jitter).
    motion_shift: vec2<f32>,
    // Where the rendered region begins in the host's images.
    origin: vec2<u32>,
    // Width in metres of a pixel one metre in front of the camera.
    pixel_width: f32,
    // First word of the lags in the history buffers.
    lag_start: u32,
    // 1: the last frame has left lags.
    knows_lag: u32,
    // So many probes look in a frame; 0: all that want to.
    probes_per_frame: u32,
}
