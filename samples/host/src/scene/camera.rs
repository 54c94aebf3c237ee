//! A pinhole camera in the references' terms, and as brickgi wants it.

use glam::{DMat3, DVec3};

/// A pinhole camera; square pixels, rays through pixel centres.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCamera {
    /// Unique in its scene.
    pub name: String,
    /// World position in metres.
    pub position: [f64; 3],
    /// A point on the view axis.
    pub target: [f64; 3],
    /// Roughly up; not parallel to the view axis.
    pub up: [f64; 3],
    /// Vertical field of view in degrees.
    pub vfov_deg: f64,
    /// Distance of the near plane in metres.
    pub near: f64,
    /// Pixels per row of the camera's own image.
    pub width: u32,
    /// Rows of the camera's own image.
    pub height: u32,
}

impl SceneCamera {
    /// Looks at a box from outside, slightly from above.
    pub fn framing([low, high]: [[f64; 3]; 2]) -> Self {
        let (low, high) = (DVec3::from(low), DVec3::from(high));
        let (center, radius) = ((low + high) / 2.0, ((high - low).length() / 2.0).max(1e-3));
        let vfov_deg: f64 = 45.0;
        let distance = radius / (vfov_deg.to_radians() / 2.0).sin();
        let position = center + DVec3::new(0.45, 0.4, 0.8).normalize() * distance;
        Self {
            name: "default".into(),
            position: position.to_array(),
            target: center.to_array(),
            up: [0.0, 1.0, 0.0],
            vfov_deg,
            near: radius * 1e-3,
            width: 1280,
            height: 720,
        }
    }

    /// Right, up and forward, orthonormal.
    pub fn axes(&self) -> [DVec3; 3] {
        let forward = (DVec3::from(self.target) - DVec3::from(self.position)).normalize();
        let right = forward.cross(self.up.into()).normalize();
        [right, right.cross(forward), forward]
    }

    /// Unnormalised direction through the centre of pixel (x, y); its component along the view axis is 1.
    pub fn pixel_ray(&self, x: u32, y: u32, [width, height]: [u32; 2]) -> DVec3 {
        let [right, up, forward] = self.axes();
        let tangent = (self.vfov_deg.to_radians() / 2.0).tan();
        let (width, height) = (f64::from(width), f64::from(height));
        let across = tangent * (width / height) * (2.0 * (f64::from(x) + 0.5) / width - 1.0);
        let upward = tangent * (1.0 - 2.0 * (f64::from(y) + 0.5) / height);
        forward + right * across + up * upward
    }

    /// Rotation into view space: x right, y up, looking along -z.
    pub fn view_rotation(&self) -> DMat3 {
        let [right, up, forward] = self.axes();
        DMat3::from_cols(right, up, -forward).transpose()
    }

    /// Columns of the reverse, infinite projection to Vulkan clip space: depth is near / distance, y points down.
    pub fn projection(&self, [width, height]: [u32; 2]) -> [[f32; 4]; 4] {
        let tangent = (self.vfov_deg.to_radians() / 2.0).tan();
        let x = f64::from(height) / (f64::from(width) * tangent);
        [
            [x as f32, 0.0, 0.0, 0.0],
            [0.0, (-1.0 / tangent) as f32, 0.0, 0.0],
            [0.0, 0.0, 0.0, -1.0],
            [0.0, 0.0, self.near as f32, 0.0],
        ]
    }

    /// The camera for an image of `size`, moved by `offset` metres.
    pub fn to_gi(&self, size: [u32; 2], offset: [f64; 3]) -> brickgi::scene::Camera {
        brickgi::scene::Camera {
            position: (DVec3::from(self.position) + DVec3::from(offset)).to_array(),
            view_rotation: self.view_rotation().as_mat3().to_cols_array_2d(),
            projection: self.projection(size),
        }
    }

    /// Whether the camera defines an image.
    pub fn is_usable(&self) -> bool {
        let axes_exist = self.axes().iter().all(|axis| axis.is_finite());
        let lens = (1e-3..179.0).contains(&self.vfov_deg) && self.near > 0.0 && self.near.is_finite();
        axes_exist && DVec3::from(self.position).is_finite() && lens && self.width > 0 && self.height > 0
    }
}
