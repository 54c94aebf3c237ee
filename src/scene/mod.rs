//! What the host said: meshes, instances, materials, textures, lights, sky and cameras.
//!
//! Ids are chosen by the host; adding an id that exists replaces it. Every slice is copied before the call returns; meshes
//! may lie in the host's buffers instead.

mod camera;
mod clusters;
mod geometry;
mod lights;
mod shadows;
mod sheets;
mod simplify;
mod sky;
mod sky_map;
mod store;

pub use camera::Camera;
pub(crate) use clusters::Cluster;
pub(crate) use geometry::Array;
pub use geometry::{BufferAddress, BufferMeshDesc, IndexBuffer, IndexType, VertexBuffer, VertexFormat};
pub use lights::Light;
pub(crate) use shadows::{MAX_SHADOW_LAYERS, MAX_SHADOW_VIEWS, check_shadow_maps, shadow_views};
pub use shadows::{ShadowLayer, ShadowMap};
pub(crate) use simplify::Triangles;
pub use sky::Sky;
pub use sky_map::{SkyFormat, SkyImage, SkyLayout};
pub(crate) use store::{Instance, Mesh, Scene};

/// A triangle mesh of one material set.
#[derive(Clone, Copy, Debug)]
pub struct MeshDesc<'a> {
    /// Chosen by the host.
    pub id: u64,
    /// Object-space positions in metres.
    pub positions: &'a [[f32; 3]],
    /// Texture coordinates, one per position, or empty. (0, 0) is the texture's first texel; repeats.
    pub uvs: &'a [[f32; 2]],
    /// Three per triangle; counter-clockwise seen from the front.
    pub indices: &'a [u32],
}

/// A Lambertian material; by default black and opaque.
#[derive(Clone, Copy, Debug, Default)]
pub struct MaterialDesc {
    /// Chosen by the host.
    pub id: u64,
    /// Linear Rec.709 albedo, 0 to 1; multiplied with the texture; the product is clamped to 0.95.
    pub base_color: [f32; 3],
    /// Radiance that the front side emits (linear Rec.709, in the unit of the lights).
    pub emission: [f32; 3],
    /// A texture added in this or an earlier call.
    pub base_color_texture: Option<u64>,
    /// Share of the light that goes straight through, 0 (opaque) to 1; the surface takes the rest. Kept as coverage: as
    /// many of a voxel side's 4 x 4 parts are open.
    pub transmittance: f32,
    /// Whether light also goes through where the texture's alpha is less than 1: cutouts, foliage.
    pub texture_alpha: bool,
}

/// An 8-bit sRGB colour texture.
#[derive(Clone, Copy, Debug)]
pub struct TextureDesc<'a> {
    /// Chosen by the host.
    pub id: u64,
    /// Texels per row, 1 to 16384.
    pub width: u32,
    /// Rows, 1 to 16384.
    pub height: u32,
    /// `width * height * 4` bytes, RGBA, rows from the top; colour sRGB-encoded, alpha linear.
    pub rgba8: &'a [u8],
}

/// A mesh placed in the world.
#[derive(Clone, Copy, Debug)]
pub struct InstanceDesc {
    /// Chosen by the host.
    pub id: u64,
    /// A mesh added in this or an earlier call.
    pub mesh: u64,
    /// A material added in this or an earlier call.
    pub material: u64,
    /// Columns of the linear part (rotation, scale, shear) of object to world.
    pub linear: [[f32; 3]; 3],
    /// World position of the object's origin in metres.
    pub translation: [f64; 3],
}

/// A batch of changes, applied in the order: removals, textures, materials, meshes, instances.
#[derive(Clone, Copy, Debug, Default)]
pub struct MeshUpdate<'a> {
    /// Instances to remove.
    pub removed_instances: &'a [u64],
    /// Meshes to remove; their instances must be gone.
    pub removed_meshes: &'a [u64],
    /// Textures to add or replace.
    pub textures: &'a [TextureDesc<'a>],
    /// Materials to add or replace.
    pub materials: &'a [MaterialDesc],
    /// Meshes to add or replace.
    pub meshes: &'a [MeshDesc<'a>],
    /// Meshes to add or replace that lie in the host's buffers; other ids than those of `meshes`.
    pub buffer_meshes: &'a [BufferMeshDesc],
    /// Instances to add, move or change.
    pub instances: &'a [InstanceDesc],
}
