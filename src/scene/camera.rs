//! The camera of a view, and of a shadow map's layer.

use super::lights::require;
use glam::{DMat3, DMat4, Mat3, Mat4};

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

impl Camera {
    /// Says what is not finite or of no use.
    pub(crate) fn check(&self) -> Result<(), &'static str> {
        let finite = self.position.iter().all(|v| v.is_finite())
            && self.view_rotation.iter().flatten().chain(self.projection.iter().flatten()).all(|v| v.is_finite());
        require(finite, "a value is not finite")?;
        require(self.projection().determinant().abs() >= 1e-30, "projection cannot be inverted")?;
        require(self.rotation().determinant().abs() >= 0.5, "view_rotation is not a rotation")
    }

    /// Clip space of a position relative to the camera in metres.
    pub(crate) fn clip(&self) -> DMat4 {
        self.projection() * DMat4::from_mat3(self.rotation())
    }

    pub(crate) fn projection(&self) -> DMat4 {
        Mat4::from_cols_array_2d(&self.projection).as_dmat4()
    }

    pub(crate) fn rotation(&self) -> DMat3 {
        Mat3::from_cols_array_2d(&self.view_rotation).as_dmat3()
    }
}
