//! The camera of a view.

/// A camera exactly as the G-buffer was rendered with it: any handedness, reverse or infinite depth,
/// jittered or orthographic projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// World position in metres.
    pub position: [f64; 3],
    /// Columns of the rotation from world to view space.
    pub view_rotation: [[f32; 3]; 3],
    /// Columns of the projection from view space to Vulkan clip space (y down in the framebuffer, depth 0 to 1).
    pub projection: [[f32; 4]; 4],
}
