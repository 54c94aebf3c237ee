//! What the world is made of.

use super::geometry::{BgiIndexData, BgiVertexData};
use super::guard::{Failure, guard_context};
use super::input::{self, structure_types};
use super::types::*;
use super::vk::VkBuffer;
use crate::scene::{BufferMeshDesc, InstanceDesc, MaterialDesc, MeshDesc, MeshUpdate, TextureDesc};
use std::borrow::Cow;
use std::ffi::c_void;

/// An 8-bit sRGB colour texture.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiTexture {
    /// BGI_STRUCTURE_TYPE_TEXTURE
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// Chosen by the host; a texture that has it already is replaced.
    pub id: u64,
    /// Texels per row, 1 to 16384. 256 is plenty: a voxel sees an average.
    pub width: u32,
    /// Rows, 1 to 16384.
    pub height: u32,
    /// width * height * 4 bytes, RGBA, rows from the top; colour sRGB-encoded, alpha linear. Copied.
    pub rgba8: *const u8,
}

/// A Lambertian material.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiMaterial {
    /// BGI_STRUCTURE_TYPE_MATERIAL
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// Chosen by the host; a material that has it already is replaced.
    pub id: u64,
    /// Albedo, linear Rec.709, 0 to 1; multiplied with the texture; the product is clamped to 0.95.
    pub base_color: [f32; 3],
    /// Radiance that the front side emits: linear Rec.709, 0 or more, in the unit of the lights.
    pub emission: [f32; 3],
    /// 1: baseColorTexture is used; 0: it is ignored.
    pub has_base_color_texture: u32,
    /// Id of a texture of this or an earlier update.
    pub base_color_texture: u64,
    /// Share of the light that goes straight through, 0 (opaque) to 1; the surface takes the rest.
    pub transmittance: f32,
    /// 1: light also goes through where the texture's alpha is less than 1 (cutouts, foliage); 0: alpha is ignored.
    pub use_texture_alpha: u32,
}

/// A triangle mesh, all of it in host memory or all of it in buffers.
///
/// Host memory is copied before the call returns. Buffers are read by the following bgiDispatch calls: these record copies
/// out of them, in the order in which the meshes were handed over and up to 4.5 MiB a call, less where memoryBudget is used
/// up; a large mesh takes several. The call that comes framesInFlight after the last of them makes the mesh. Until then it is
/// pending (BgiStats.meshesPending): its instances are not there yet, or have the mesh of this id that was there before. If
/// a number is not finite then, or an index not below vertexCount, the mesh counts as empty and the log has a warning.
///
/// While a mesh is pending its buffers do not change, and whenever such a command buffer executes, what they hold is
/// complete, visible to VK_PIPELINE_STAGE_TRANSFER_BIT with VK_ACCESS_TRANSFER_READ_BIT, and owned by the queue's family.
/// Removing or replacing a mesh ends its being pending; its buffers may go once the GPU has finished with the command
/// buffers that were recorded before.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiMesh {
    /// BGI_STRUCTURE_TYPE_MESH
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// Chosen by the host; a mesh that has it already is replaced, in all its instances.
    pub id: u64,
    /// Vertices, 1 to BGI_MAX_COUNT.
    pub vertex_count: u32,
    /// Three per triangle, 3 to BGI_MAX_COUNT.
    pub index_count: u32,
    /// x, y, z in object space, metres, finite.
    pub positions: BgiVertexData,
    /// Optional (neither data nor buffer): u, v, finite. (0, 0) is the corner of the texture's first texel; repeats.
    pub uvs: BgiVertexData,
    /// Each below vertexCount; triangles are counter-clockwise seen from the front.
    pub indices: BgiIndexData,
}

/// A mesh placed in the world.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiInstance {
    /// BGI_STRUCTURE_TYPE_INSTANCE
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// Chosen by the host; an instance that has it already is moved or changed.
    pub id: u64,
    /// Id of a mesh of this or an earlier update.
    pub mesh: u64,
    /// Id of a material of this or an earlier update.
    pub material: u64,
    /// World position of the object's origin in metres, finite.
    pub translation: [f64; 3],
    /// Columns of the linear part (rotation, scale, shear) of object to world, finite: linear[column][row].
    pub linear: [[f32; 3]; 3],
}

/// A batch of changes, applied in the order of the fields. Each array is optional: count 0. Ids are the host's own
/// numbers, each kind with its own. All host memory is copied before the call returns.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiMeshUpdate {
    /// BGI_STRUCTURE_TYPE_MESH_UPDATE
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *const c_void,
    /// Ids of instances to remove.
    pub removed_instances: *const u64,
    /// Ids of meshes to remove; their instances must be gone, at the latest by this update.
    pub removed_meshes: *const u64,
    /// Textures to add or replace.
    pub textures: *const BgiTexture,
    /// Materials to add or replace.
    pub materials: *const BgiMaterial,
    /// Meshes to add or replace.
    pub meshes: *const BgiMesh,
    /// Instances to add, move or change.
    pub instances: *const BgiInstance,
    /// Elements of removedInstances.
    pub removed_instance_count: u32,
    /// Elements of removedMeshes.
    pub removed_mesh_count: u32,
    /// Elements of textures.
    pub texture_count: u32,
    /// Elements of materials.
    pub material_count: u32,
    /// Elements of meshes.
    pub mesh_count: u32,
    /// Elements of instances.
    pub instance_count: u32,
}

structure_types! {
    BgiTexture = BGI_STRUCTURE_TYPE_TEXTURE,
    BgiMaterial = BGI_STRUCTURE_TYPE_MATERIAL,
    BgiMesh = BGI_STRUCTURE_TYPE_MESH,
    BgiInstance = BGI_STRUCTURE_TYPE_INSTANCE,
    BgiMeshUpdate = BGI_STRUCTURE_TYPE_MESH_UPDATE,
}

impl BgiTexture {
    /// # Safety
    /// `rgba8` leads to as many readable bytes as the header says.
    unsafe fn desc<'a>(&self, index: usize) -> Result<TextureDesc<'a>, Failure> {
        let field = format!("textures[{index}]");
        if self.width.max(self.height) > BGI_MAX_EXTENT {
            let text =
                format!("{field}: {} x {} texels; each edge must be 1 to {BGI_MAX_EXTENT}", self.width, self.height);
            return Err(Failure::argument(text));
        }
        let bytes = self.width as usize * self.height as usize * 4;
        // SAFETY: the caller's promise; the extent's limit keeps the product within 1 GiB.
        let rgba8 = unsafe { input::memory(self.rgba8, bytes, &format!("{field}.rgba8"))? };
        Ok(TextureDesc { id: self.id, width: self.width, height: self.height, rgba8 })
    }
}

impl BgiMaterial {
    fn desc(&self, index: usize) -> Result<MaterialDesc, Failure> {
        let flag = |value, name: &str| input::flag(value, &format!("materials[{index}].{name}"));
        let textured = flag(self.has_base_color_texture, "hasBaseColorTexture")?;
        let base_color_texture = textured.then_some(self.base_color_texture);
        let texture_alpha = flag(self.use_texture_alpha, "useTextureAlpha")?;
        let Self { id, base_color, emission, transmittance, .. } = *self;
        Ok(MaterialDesc { id, base_color, emission, base_color_texture, transmittance, texture_alpha })
    }
}

/// A mesh in host memory, read.
struct HostMesh<'a> {
    id: u64,
    positions: Cow<'a, [[f32; 3]]>,
    uvs: Cow<'a, [[f32; 2]]>,
    indices: Cow<'a, [u32]>,
}

impl HostMesh<'_> {
    fn desc(&self) -> MeshDesc<'_> {
        MeshDesc { id: self.id, positions: &self.positions, uvs: &self.uvs, indices: &self.indices }
    }
}

impl BgiMesh {
    fn is_in_buffers(&self) -> bool {
        self.positions.buffer != VkBuffer::null()
    }

    /// What decides how the rest is read.
    fn check(&self, field: impl Fn(&str) -> String) -> Result<(), Failure> {
        for (name, count) in [("vertexCount", self.vertex_count), ("indexCount", self.index_count)] {
            if !(1..=BGI_MAX_COUNT).contains(&count) {
                return Err(Failure::argument(format!("{} is {count}; 1 to {BGI_MAX_COUNT} are allowed", field(name))));
            }
        }
        let sources = [
            ("positions", self.positions.data, self.positions.buffer),
            ("uvs", self.uvs.data, self.uvs.buffer),
            ("indices", self.indices.data, self.indices.buffer),
        ];
        for (name, data, buffer) in sources {
            let both = if self.is_in_buffers() { !data.is_null() } else { buffer != VkBuffer::null() };
            if both {
                let text = "a mesh lies in host memory or in buffers, not in both";
                return Err(Failure::argument(format!("{}: {text}", field(name))));
            }
        }
        Ok(())
    }

    /// # Safety
    /// The arrays are readable and as long as the header says.
    unsafe fn in_host_memory<'a>(&self, index: usize) -> Result<HostMesh<'a>, Failure> {
        let field = |name: &str| format!("meshes[{index}].{name}");
        self.check(field)?;
        // SAFETY: the caller's promise.
        unsafe {
            let positions = self.positions.read(self.vertex_count, &field("positions"))?;
            let uvs = if self.uvs.data.is_null() {
                Cow::default()
            } else {
                self.uvs.read(self.vertex_count, &field("uvs"))?
            };
            let indices = self.indices.read(self.index_count, &field("indices"))?;
            Ok(HostMesh { id: self.id, positions, uvs, indices })
        }
    }

    /// # Safety
    /// The buffers are as the header says.
    unsafe fn in_buffers(&self, index: usize) -> Result<BufferMeshDesc, Failure> {
        let field = |name: &str| format!("meshes[{index}].{name}");
        self.check(field)?;
        let Self { id, vertex_count, index_count, .. } = *self;
        // SAFETY: the caller's promise.
        unsafe {
            let positions = self.positions.in_buffer(&field("positions"))?;
            let uvs = if self.uvs.buffer == VkBuffer::null() { None } else { Some(self.uvs.in_buffer(&field("uvs"))?) };
            let indices = self.indices.in_buffer(&field("indices"))?;
            Ok(BufferMeshDesc { id, vertex_count, index_count, positions, uvs, indices })
        }
    }
}

impl BgiInstance {
    fn desc(&self) -> InstanceDesc {
        let Self { id, mesh, material, linear, translation, .. } = *self;
        InstanceDesc { id, mesh, material, linear, translation }
    }
}

/// Every element as the core takes it, or the first failure.
fn describe<T, D>(items: &[T], desc: impl Fn(&T, usize) -> Result<D, Failure>) -> Result<Vec<D>, Failure> {
    items.iter().enumerate().map(|(index, item)| desc(item, index)).collect()
}

/// Adds, replaces, moves or removes what the world is made of. On an error nothing of the batch is applied. Records
/// nothing: the GPU work is done by the following bgiDispatch calls, a bounded amount each.
///
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT, BGI_ERROR_INVALID_STRUCTURE,
/// BGI_ERROR_UNKNOWN_ID or BGI_ERROR_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiUpdateMeshes(context: BgiContext, update: *const BgiMeshUpdate) -> BgiResult {
    guard_context(context, |state| {
        // SAFETY: the header asks for readable structs and arrays, as long as their counts say.
        unsafe {
            let update = input::structure(update)?;
            let textures = input::structures(update.textures, update.texture_count, "textures")?;
            let materials = input::structures(update.materials, update.material_count, "materials")?;
            let meshes = input::structures(update.meshes, update.mesh_count, "meshes")?;
            let instances = input::structures(update.instances, update.instance_count, "instances")?;
            let textures = describe(textures, |texture, index| texture.desc(index))?;
            let materials = describe(materials, BgiMaterial::desc)?;
            let (mut host_meshes, mut buffer_meshes) = (Vec::new(), Vec::new());
            for (index, mesh) in meshes.iter().enumerate() {
                if mesh.is_in_buffers() {
                    buffer_meshes.push(mesh.in_buffers(index)?);
                } else {
                    host_meshes.push(mesh.in_host_memory(index)?);
                }
            }
            let meshes = host_meshes.iter().map(HostMesh::desc).collect::<Vec<_>>();
            let instances = instances.iter().map(BgiInstance::desc).collect::<Vec<_>>();
            state.context.update_meshes(&MeshUpdate {
                removed_instances: input::slice(
                    update.removed_instances,
                    update.removed_instance_count,
                    "removedInstances",
                )?,
                removed_meshes: input::slice(update.removed_meshes, update.removed_mesh_count, "removedMeshes")?,
                textures: &textures,
                materials: &materials,
                meshes: &meshes,
                buffer_meshes: &buffer_meshes,
                instances: &instances,
            })?;
        }
        Ok(BGI_SUCCESS)
    })
}
