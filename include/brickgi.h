/* SPDX-License-Identifier: MIT OR Apache-2.0

brickgi: real-time diffuse global illumination for engines that already exist.

The host links this library, hands over its Vulkan device, its meshes and its lights, and each frame gives a command
buffer and a G-buffer; the library records compute work into it and the host gets an image of indirect light back.

  once         bgiGetDeviceRequirements  before the VkDevice is made
               bgiCreateContext          the world, on one VkDevice
               bgiCreateView             a camera's probes and history
  on a change  bgiUpdateMeshes, bgiSetLights, bgiSetSkyImage
  each frame   bgiSetShadowMaps where the host has some
               bgiSetCamera, then bgiDispatch between the host's G-buffer and its lighting pass
  at the end   bgiDestroyContext         once the GPU has finished

Units: metres, right-handed or left-handed as the host's data is; Y is up by the default coverage. Colours are linear
Rec.709. Radiance and irradiance are in a unit of the host's choice, the same for all lights and for the output.

Structs start with sType (which BGI_STRUCTURE_TYPE_* it is; anything else is refused) and pNext (NULL: this version has
no extension structs; anything else is refused). They never grow: later versions add fields through pNext. Zero a struct
first, then set sType and what you need.

Memory: what a pointer leads to is copied before the call returns; the VkBuffers of a mesh are read later (BgiMesh).
Nothing that the library returns is to be freed.

Threads: every function may be called on any thread. Calls on one context run one after another; calls on different
contexts run at once. A command buffer is the host's to synchronise, as always.

Errors: a negative BgiResult, and words in bgiGetLastError and in the log callback. After an error nothing of the call is
in effect. NULL, stale and foreign handles, wrong structs and numbers out of range are errors and never crashes. What
cannot be checked is the host's duty: that a pointer which is not NULL leads to as much memory as the API says, and that
Vulkan handles are valid. */

#ifndef BRICKGI_H
#define BRICKGI_H

/* Generated from src/capi by tests/header.rs (BRICKGI_BLESS=1 writes it anew): edit the comments there. */

#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

/// Most elements in any array handed in. A larger count is refused with BGI_ERROR_INVALID_ARGUMENT.
#define BGI_MAX_COUNT 67108864

/// Largest edge of an image or texture in pixels.
#define BGI_MAX_EXTENT 16384

/// Most layers of all shadow maps.
#define BGI_MAX_SHADOW_LAYERS 64

/// Most different views of shadow maps.
#define BGI_MAX_SHADOW_VIEWS 4

/// Bytes of a name in BgiPassTime and BgiResourceSize, its terminating zero included.
#define BGI_NAME_SIZE 64

/// Version of the API that this header describes: major << 22 | minor << 12 | patch.
#define BGI_API_VERSION 4096

/// Version of the ABI that this header describes. It changes only when a compiled host must be compiled again.
#define BGI_ABI_VERSION 1

/// What a BgiContext pretends to point at; there is no such object.
typedef struct BgiContext_T BgiContext_T;

/// What a BgiView pretends to point at; there is no such object.
typedef struct BgiView_T BgiView_T;

/// A context: the world (bricks, lighting) on one VkDevice. Made by bgiCreateContext, ended by bgiDestroyContext. A
/// token and not an address: the library looks it up before it touches anything, and never uses one again.
typedef struct BgiContext_T *BgiContext;

/// What a call returns: BGI_SUCCESS (0), a warning (positive: the call did its work) or an error (negative: it did
/// nothing). Test errors with `result < 0`. The words for it are in bgiGetLastError.
typedef int32_t BgiResult;

/// Says which struct a pointer leads to: one of BGI_STRUCTURE_TYPE_*. Values are never reused.
typedef uint32_t BgiStructureType;

/// A physical device to be judged. Every field is required.
typedef struct BgiDeviceQuery {
    /// BGI_STRUCTURE_TYPE_DEVICE_QUERY
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// The loader's entry point; every other function is fetched through it. The library never links the loader.
    PFN_vkGetInstanceProcAddr getInstanceProcAddr;
    /// Created for Vulkan 1.1 or newer.
    VkInstance instance;
    /// A physical device of `instance`.
    VkPhysicalDevice physicalDevice;
} BgiDeviceQuery;

/// What the library needs of a device. Zero it, then set sType.
typedef struct BgiDeviceRequirements {
    /// BGI_STRUCTURE_TYPE_DEVICE_REQUIREMENTS
    BgiStructureType sType;
    /// NULL
    void *pNext;
    /// Out: lowest apiVersion that the instance and the device must have been created for, as VK_MAKE_API_VERSION.
    uint32_t apiVersion;
    /// Out: 1 where the physical device will do, else 0.
    uint32_t supported;
    /// In: bytes at `missing`. Out: bytes written, terminating zero included, or needed where `missing` is NULL.
    uint32_t missingSize;
    /// Optional: receives what the device lacks as text, one readable line each; empty where it will do.
    char *missing;
} BgiDeviceRequirements;

/// A named point on the speed/accuracy curve: one of BGI_PRESET_*.
typedef uint32_t BgiPreset;

/// How a ray hits an occupied voxel: one of BGI_HIT_MODEL_*.
typedef uint32_t BgiHitModel;

/// Settings of a context, fixed at its creation. Fill it with bgiGetDefaultSettings, then change what you must.
typedef struct BgiSettings {
    /// BGI_STRUCTURE_TYPE_SETTINGS
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// Edge of a voxel in metres, 0.01 to 4; default 0.5. Memory and ray steps grow as it shrinks.
    float voxelSize;
    /// Shift of the voxel grid against the world's origin, in voxels per axis, -1024 to 1024; default 0.
    float gridOffset[3];
    /// World covered, in groups of 32 voxels per axis; powers of two, 1 to 64; default 32 x 8 x 32 (512 x 128 x 512 m
    /// at 0.5 m, Y up). Costs 16 bytes a group.
    uint32_t coverageGroups[3];
    /// Bricks voxelised a frame while any are waiting, 1 to 4096; default 512. Fewer where a sixteenth of
    /// memoryBudget (8 MiB at most), set aside for this, does not suffice. Costs nothing when none waits.
    uint32_t voxelizeBricksPerFrame;
    /// Upper limit of the world's device memory in bytes, at least 1 MiB; default 28 MiB. Holds in every frame: what does
    /// not fit is left out, the farthest first (BGI_WARNING_WORLD_INCOMPLETE). Textures, materials, coverageGroups and
    /// framesInFlight must leave room for a brick, else BGI_ERROR_OUT_OF_MEMORY.
    uint64_t memoryBudget;
    /// Voxel faces lit a frame, 64 to 4194240; default 131072. The main cost of lighting. At most what an eighth of
    /// memoryBudget holds at 12 bytes a face. A brick with more of them (3072 at most) is lit alone.
    uint32_t lightFacesPerFrame;
    /// Hemisphere rays a face shoots per lighting update, 0 to 64; default 4. 0 turns radiosity off.
    uint32_t bounceRays;
    /// Shadow samples a face and light takes per lighting update, 1 to 16; default 2.
    uint32_t directSamples;
    /// How a ray hits a voxel; default BGI_HIT_MODEL_PLANE.
    BgiHitModel hitModel;
    /// Pixels along the edge of a screen-probe tile: 8, 16 or 32; default 16.
    uint32_t probeTile;
    /// Frames that the full-resolution temporal filter averages at most while the world is at rest, 1 to 1024; default 256.
    /// 1 turns it off, for hosts with one of their own: each frame stands for itself, and pixels borrow from no neighbours.
    uint32_t temporalFrames;
    /// Rays that each pixel shoots into the world, 0 to 1024, instead of using probes; default 0: probes. The reference
    /// that probes are judged against; costs width * height * pixelRays rays a frame.
    uint32_t pixelRays;
    /// Milliseconds of GPU time that voxelisation may take a frame, 0 to 1000; default 0: no limit. From the timestamps of
    /// earlier frames, bricks are handed to the GPU as far as they will fit, one at least and voxelizeBricksPerFrame at
    /// most. Without effect where the device has no timestamps.
    float voxelizeMs;
    /// 1: faces that neither light nor eye can reach go without light of their own while the world does not fit into
    /// memoryBudget otherwise. 0: never; the default.
    uint32_t regionCulling;
    /// By how much dense meshes may be simplified, in voxels, 0 to 1; default 0: not at all. 0.1 suits meshes with many
    /// triangles a voxel. Triangles that voxels cannot tell apart are merged in the call that brings a mesh's first
    /// instance, for the largest scale of its instances, and anew when a larger one comes. What the host handed over is
    /// kept beside what is left.
    float simplifyVoxels;
    /// Lights that each of a face's directSamples asks at most, 1 to 4096; default 4. Of more, it asks some by chance, the
    /// more often the more they bring: the mean is the same, and a face costs directSamples times directLights rays at most.
    uint32_t directLights;
    /// 1: bounceRays find light that comes straight from lights, sky and emitters alone. Costs a shadow ray more for each
    /// that hits, towards one of the lights, drawn evenly. 0: light of any number of bounces; the default.
    uint32_t singleBounce;
    /// Frames in which a screen probe that has been carried along, and a pixel that has been seen for long, look once: 1, 2
    /// or 4; default 4, one of each two by two. What has not been seen for long looks in every frame.
    uint32_t gatherInterval;
    /// 1: each pixel looks for what stands within two voxels of it, and for what hides its probes' light within 16: contact
    /// shadows. Up to two short rays a pixel, the larger part of what the gather costs. 0: it takes what probes say.
    /// Default 1.
    uint32_t nearField;
    /// Screen probes of a view that look in a frame at most, 64 rays each, 0 to 1 048 576. Where more want to, tiles that would
    /// have no probe come first, and what is put off keeps what it saw before; pixels without a probe take those of tiles
    /// around. A 256th of them more may look, so that each comes to its turn. 0: no limit; the default.
    uint32_t probesPerFrame;
} BgiSettings;

/// Severity of a log line: one of BGI_LOG_*.
typedef uint32_t BgiLogSeverity;

/// Receives the library's log lines: one line of UTF-8 without a line feed, valid during the call only. Called on the
/// thread that made the API call, with no lock held: the library may be called from inside. Must return (no exception,
/// no longjmp).
typedef void (*BgiLogCallback)(void *userData, BgiLogSeverity severity, const char *message);

/// A piece of the library's work. Never throws; takes some ten microseconds to some milliseconds.
typedef void (*BgiTask)(void *taskData, uint32_t index);

/// Calls task(taskData, index) once for each index below `count`, on any threads and in any order, at once or one after
/// the other, and returns when all these calls have. Called by bgiUpdateMeshes and bgiDispatch, on their thread, where
/// there is much to do. Neither it nor the tasks' threads may meanwhile call the library on that context. Must return (no
/// exception, no longjmp).
typedef void (*BgiParallelFor)(void *userData, uint32_t count, BgiTask task, void *taskData);

/// What bgiCreateContext needs.
typedef struct BgiContextCreateInfo {
    /// BGI_STRUCTURE_TYPE_CONTEXT_CREATE_INFO
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// BGI_ABI_VERSION, of the header that the caller is compiled with.
    uint32_t abiVersion;
    /// Frames that the host may have on the GPU at once, 1 to 8. When bgiDispatch is called on a context for the n-th
    /// time, the GPU must have finished with the command buffer of call n - framesInFlight (host that records several
    /// views a frame: frames times views). The host's own frame fence gives this.
    uint32_t framesInFlight;
    /// The loader's entry point; required.
    PFN_vkGetInstanceProcAddr getInstanceProcAddr;
    /// Created for Vulkan 1.1 or newer; required. Must outlive the context, as `device` must.
    VkInstance instance;
    /// The physical device of `device`; required.
    VkPhysicalDevice physicalDevice;
    /// Created with what bgiGetDeviceRequirements asks for; required. None of its queues is ever touched.
    VkDevice device;
    /// Optional; NULL: the settings of BGI_PRESET_MEDIUM. Copied.
    const struct BgiSettings *settings;
    /// Optional; receives log lines, those of this call included, until the context is destroyed.
    BgiLogCallback log;
    /// Handed to `log` as it is; may be used on any thread that calls the library.
    void *logUserData;
    /// Optional; NULL: work is done on the calling thread. The result does not depend on it.
    BgiParallelFor parallelFor;
    /// Handed to `parallelFor` as it is.
    void *parallelUserData;
} BgiContextCreateInfo;

/// An 8-bit sRGB colour texture.
typedef struct BgiTexture {
    /// BGI_STRUCTURE_TYPE_TEXTURE
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// Chosen by the host; a texture that has it already is replaced.
    uint64_t id;
    /// Texels per row, 1 to 16384. 256 is plenty: a voxel sees an average.
    uint32_t width;
    /// Rows, 1 to 16384.
    uint32_t height;
    /// width * height * 4 bytes, RGBA, rows from the top; colour sRGB-encoded, alpha linear. Copied.
    const uint8_t *rgba8;
} BgiTexture;

/// A Lambertian material.
typedef struct BgiMaterial {
    /// BGI_STRUCTURE_TYPE_MATERIAL
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// Chosen by the host; a material that has it already is replaced.
    uint64_t id;
    /// Albedo, linear Rec.709, 0 to 1; multiplied with the texture; the product is clamped to 0.95.
    float baseColor[3];
    /// Radiance that the front side emits: linear Rec.709, 0 or more, in the unit of the lights.
    float emission[3];
    /// 1: baseColorTexture is used; 0: it is ignored.
    uint32_t hasBaseColorTexture;
    /// Id of a texture of this or an earlier update.
    uint64_t baseColorTexture;
    /// Share of the light that goes straight through, 0 (opaque) to 1; the surface takes the rest.
    float transmittance;
    /// 1: light also goes through where the texture's alpha is less than 1 (cutouts, foliage); 0: alpha is ignored.
    uint32_t useTextureAlpha;
} BgiMaterial;

/// What the numbers of a vertex attribute are: one of BGI_VERTEX_FORMAT_*. The value is their size in bytes.
typedef uint32_t BgiVertexFormat;

/// An attribute of a mesh's vertices, in host memory or in a buffer.
typedef struct BgiVertexData {
    /// Host memory, copied before the call returns; or NULL.
    const void *data;
    /// Or a buffer of the context's device, made with VK_BUFFER_USAGE_TRANSFER_SRC_BIT; else VK_NULL_HANDLE. BgiMesh says
    /// when it is read.
    VkBuffer buffer;
    /// Bytes from the start of `data` or `buffer` to the first vertex's first number, which is aligned to the size of a
    /// number.
    uint64_t offset;
    /// Bytes from one vertex to the next, a multiple of the size of a number; 0: nothing lies between them.
    uint32_t stride;
    /// BGI_VERTEX_FORMAT_*
    BgiVertexFormat format;
} BgiVertexData;

/// What indices are: one of BGI_INDEX_TYPE_*. The value is their size in bytes; VkIndexType has other values.
typedef uint32_t BgiIndexType;

/// A mesh's indices, side by side, in host memory or in a buffer.
typedef struct BgiIndexData {
    /// As in BgiVertexData.
    const void *data;
    /// As in BgiVertexData.
    VkBuffer buffer;
    /// Bytes from the start of `data` or `buffer` to the first index, which is aligned to the size of an index.
    uint64_t offset;
    /// BGI_INDEX_TYPE_*
    BgiIndexType indexType;
} BgiIndexData;

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
typedef struct BgiMesh {
    /// BGI_STRUCTURE_TYPE_MESH
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// Chosen by the host; a mesh that has it already is replaced, in all its instances.
    uint64_t id;
    /// Vertices, 1 to BGI_MAX_COUNT.
    uint32_t vertexCount;
    /// Three per triangle, 3 to BGI_MAX_COUNT.
    uint32_t indexCount;
    /// x, y, z in object space, metres, finite.
    struct BgiVertexData positions;
    /// Optional (neither data nor buffer): u, v, finite. (0, 0) is the corner of the texture's first texel; repeats.
    struct BgiVertexData uvs;
    /// Each below vertexCount; triangles are counter-clockwise seen from the front.
    struct BgiIndexData indices;
} BgiMesh;

/// A mesh placed in the world.
typedef struct BgiInstance {
    /// BGI_STRUCTURE_TYPE_INSTANCE
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// Chosen by the host; an instance that has it already is moved or changed.
    uint64_t id;
    /// Id of a mesh of this or an earlier update.
    uint64_t mesh;
    /// Id of a material of this or an earlier update.
    uint64_t material;
    /// World position of the object's origin in metres, finite.
    double translation[3];
    /// Columns of the linear part (rotation, scale, shear) of object to world, finite: linear[column][row].
    float linear[3][3];
} BgiInstance;

/// A batch of changes, applied in the order of the fields. Each array is optional: count 0. Ids are the host's own
/// numbers, each kind with its own. All host memory is copied before the call returns.
typedef struct BgiMeshUpdate {
    /// BGI_STRUCTURE_TYPE_MESH_UPDATE
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// Ids of instances to remove.
    const uint64_t *removedInstances;
    /// Ids of meshes to remove; their instances must be gone, at the latest by this update.
    const uint64_t *removedMeshes;
    /// Textures to add or replace.
    const struct BgiTexture *textures;
    /// Materials to add or replace.
    const struct BgiMaterial *materials;
    /// Meshes to add or replace.
    const struct BgiMesh *meshes;
    /// Instances to add, move or change.
    const struct BgiInstance *instances;
    /// Elements of removedInstances.
    uint32_t removedInstanceCount;
    /// Elements of removedMeshes.
    uint32_t removedMeshCount;
    /// Elements of textures.
    uint32_t textureCount;
    /// Elements of materials.
    uint32_t materialCount;
    /// Elements of meshes.
    uint32_t meshCount;
    /// Elements of instances.
    uint32_t instanceCount;
} BgiMeshUpdate;

/// How a sky's image covers the directions: one of BGI_SKY_LAYOUT_*.
typedef uint32_t BgiSkyLayout;

/// A sky's image: radiance, linear Rec.709. What is negative or not a number counts as 0, what is infinite as 65504.
typedef struct BgiSkyImage {
    /// BGI_STRUCTURE_TYPE_SKY_IMAGE
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// BGI_SKY_LAYOUT_*
    BgiSkyLayout layout;
    /// VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT (their alpha is passed over) or
    /// VK_FORMAT_B10G11R11_UFLOAT_PACK32.
    VkFormat format;
    /// Texels per row, 1 to BGI_MAX_EXTENT.
    uint32_t width;
    /// Rows (of a face), 1 to BGI_MAX_EXTENT; of a cube, as many as `width`.
    uint32_t height;
    /// Rows from the top, no padding; any alignment. Copied.
    const void *texels;
    /// Bytes at `texels`: width * height texels, of a cube six times as many.
    uint64_t texelsSize;
} BgiSkyImage;

/// Kind of a light: one of BGI_LIGHT_TYPE_*.
typedef uint32_t BgiLightType;

/// A light that is not a surface. Fields of other types are ignored. Colours are linear Rec.709, 0 or more, finite;
/// their unit is the host's choice, the same for all lights, emission and sky: the output has it too.
///
/// No light stands in its own way, but the meshes around one do: a lamp's shade shadows it, and a closed bulb lets nothing
/// out, unless it is left out of the meshes that are handed over.
typedef struct BgiLight {
    /// BGI_STRUCTURE_TYPE_LIGHT
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// BGI_LIGHT_TYPE_*
    BgiLightType lightType;
    /// Directional: in which the light travels. Spot: the cone's axis. Not zero, need not be normalised.
    float direction[3];
    /// Directional: irradiance on a plane perpendicular to it.
    float irradiance[3];
    /// Point: radiant intensity I; irradiance is I cos / d^2. Spot: I on the axis; irradiance is I f cos / d^2, and at
    /// the angle a to the axis f = clamp((cos a - cos outer) / max(cos inner - cos outer, 0.001), 0, 1)^2 (glTF,
    /// KHR_lights_punctual).
    float intensity[3];
    /// Not directional: world position in metres, of the middle where it has an extent.
    double position[3];
    /// Sphere, rectangle: radiance L. Of a sphere that is all above the horizon, irradiance is
    /// pi L (radius / d)^2 cos.
    float radiance[3];
    /// Point, spot: metres at which it ends, or 0: nowhere. Irradiance is multiplied with
    /// max(1 - (d / range)^4, 0)^2 (Karis, Real Shading in Unreal Engine 4, SIGGRAPH 2013).
    float range;
    /// Spot: from the axis to where the light begins to fall off, radians, 0 to outerAngle.
    float innerAngle;
    /// Spot: from the axis to where it ends, radians, above 0, at most pi / 2.
    float outerAngle;
    /// Sphere: metres, above 0.
    float radius;
    /// Rectangle: 0 or 1. 0: it shines to the side that halfAxisU x halfAxisV points to; 1: to both.
    uint32_t twoSided;
    /// Rectangle: from the middle to that of an edge, metres; not zero.
    float halfAxisU[3];
    /// Rectangle: the same of a neighbouring edge; perpendicular to halfAxisU.
    float halfAxisV[3];
} BgiLight;

/// Kind of a sky: one of BGI_SKY_TYPE_*.
typedef uint32_t BgiSkyType;

/// Light from beyond the world: radiance, linear Rec.709, 0 or more, finite. Fields of the other type are ignored.
typedef struct BgiSky {
    /// BGI_STRUCTURE_TYPE_SKY
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// BGI_SKY_TYPE_*
    BgiSkyType skyType;
    /// Gradient: radiance from straight above. With s the sine of the elevation, radiance is
    /// horizon + (zenith - horizon) s above the horizon, and horizon + (ground - horizon) (-s) below it.
    float zenith[3];
    /// Gradient: radiance from the horizon.
    float horizon[3];
    /// Gradient: radiance from straight below.
    float ground[3];
    /// Gradient: which way is up; not zero, need not be normalised.
    float up[3];
    /// Image: what its radiance is multiplied with.
    float intensity[3];
    /// Image: columns of the rotation from the image to the world; all zero: none.
    float rotation[3][3];
} BgiSky;

/// All lights and the sky.
typedef struct BgiLighting {
    /// BGI_STRUCTURE_TYPE_LIGHTING
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// lightCount lights. Copied.
    const struct BgiLight *lights;
    /// Elements of `lights`, 0 to 4096.
    uint32_t lightCount;
    /// Radiance from every direction that leaves the scene, linear Rec.709, 0 or more, finite. Ignored where there is a
    /// `sky`.
    float skyRadiance[3];
    /// Optional: a sky that is not the same from everywhere. Copied.
    const struct BgiSky *sky;
} BgiLighting;

/// A part of a shadow map: a cascade, a face of a cube, or all of it. A point p of the world is at
/// projection * (viewRotation * (p - position)) in clip space, as with a BgiCamera. Who has only a matrix from world to
/// clip space gives it as `projection`, `position` zero and `viewRotation` the identity, and loses digits far away.
typedef struct BgiShadowLayer {
    /// BGI_STRUCTURE_TYPE_SHADOW_LAYER
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// Array layer of the view; it exists.
    uint32_t layer;
    /// Its part of that layer, which the viewport was: left edge in texels.
    uint32_t x;
    /// Top edge in texels.
    uint32_t y;
    /// Width in texels. x, y, width and height all 0: the whole layer.
    uint32_t width;
    /// Height in texels.
    uint32_t height;
    /// World position in metres that it was drawn from.
    double position[3];
    /// Columns of the rotation from world to view space: viewRotation[column][row].
    float viewRotation[3][3];
    /// Columns of the projection from view space to Vulkan's clip space (y down in the image, depth 0 to 1):
    /// projection[column][row].
    float projection[4][4];
} BgiShadowLayer;

/// A shadow map of the host's, of one light: single, in cascades, or a cube.
///
/// A point of a voxel's face is lit by the first layer that covers it: 0 <= z <= w and -w <= x, y <= w in clip space. One
/// texel is read there, without filtering; the point is lit where its depth z / w is at most the texel's plus depthBias
/// (reversed: at least the texel's minus depthBias). Points move over their faces with time, which filters the shadow's
/// edge. What no layer covers gets its shadow by a ray through the bricks.
///
/// Before, the point is moved along its face's normal: by as much as the surface rises within half a texel, which follows
/// from the layer; by 0.05 voxel, for faces lie on mean planes; and by normalOffset. A map that was drawn without any bias
/// needs none here either. The map says alone who stands in the light: casters that are not among the meshes shadow, what
/// the map leaves out does not.
typedef struct BgiShadowMap {
    /// BGI_STRUCTURE_TYPE_SHADOW_MAP
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// Its light's index in what bgiSetLights was last given: directional, point or spot. One map a light. A map whose
    /// light is no longer there, or has an extent now, is passed over.
    uint32_t light;
    /// Width of the view's first level in texels, 1 to BGI_MAX_EXTENT.
    uint32_t width;
    /// Height of the view's first level in texels, 1 to BGI_MAX_EXTENT.
    uint32_t height;
    /// Elements of `layers`, 1 to 6; of all maps at most BGI_MAX_SHADOW_LAYERS.
    uint32_t layerCount;
    /// VK_IMAGE_VIEW_TYPE_2D_ARRAY, of a cube map, too; depth aspect of a depth format, or VK_FORMAT_R32_SFLOAT;
    /// single-sampled. Usage VK_IMAGE_USAGE_SAMPLED_BIT. At each bgiDispatch in layout
    /// VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, visible to VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT with
    /// VK_ACCESS_SHADER_READ_BIT. Maps may share a view; at most BGI_MAX_SHADOW_VIEWS different ones.
    VkImageView view;
    /// layerCount layers, cascades finest first. Copied.
    const struct BgiShadowLayer *layers;
    /// 0 or 1. 1: larger is nearer (reverse depth).
    uint32_t reversed;
    /// 0: texels hold depth. Above, of points and spots: they hold the distance from the light in metres over `range`.
    float range;
    /// See above; in units of the texels, finite.
    float depthBias;
    /// See above; metres, 0 or more.
    float normalOffset;
} BgiShadowMap;

/// What bgiCreateView needs.
typedef struct BgiViewCreateInfo {
    /// BGI_STRUCTURE_TYPE_VIEW_CREATE_INFO
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// Largest width of the view's images in pixels, 1 to BGI_MAX_EXTENT.
    uint32_t width;
    /// Largest height of the view's images in pixels, 1 to BGI_MAX_EXTENT.
    uint32_t height;
} BgiViewCreateInfo;

/// A view: a camera with its own probes and history over the context's world. Made by bgiCreateView, ended by
/// bgiDestroyView or with its context. A token, as BgiContext is.
typedef struct BgiView_T *BgiView;

/// A camera exactly as the G-buffer was rendered with it: any handedness; reverse, infinite, jittered or orthographic
/// projection. Everything finite. A point p of the world is at projection * (viewRotation * (p - position)) in clip
/// space.
typedef struct BgiCamera {
    /// BGI_STRUCTURE_TYPE_CAMERA
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// World position in metres.
    double position[3];
    /// Columns of the rotation from world to view space: viewRotation[column][row].
    float viewRotation[3][3];
    /// Columns of the projection from view space to Vulkan's clip space (y down in the framebuffer, depth 0 to 1):
    /// projection[column][row].
    float projection[4][4];
} BgiCamera;

/// What the output shows: one of BGI_DEBUG_VIEW_*.
typedef uint32_t BgiDebugView;

/// One view's frame. Every field but pNext, debugView, albedo, direct, composite, motion and motionScale is
/// required.
///
/// Images on entry, made so by the host's barrier: written and visible to VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT with
/// VK_ACCESS_SHADER_READ_BIT (depth, normal, albedo, direct, motion) or VK_ACCESS_SHADER_WRITE_BIT (output, composite). On exit their layouts are as on
/// entry, and `output` is last written in VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT with VK_ACCESS_SHADER_WRITE_BIT: the
/// host makes that visible to whatever reads it. Views are 2D, single-sampled, one level and one layer.
typedef struct BgiDispatchInfo {
    /// BGI_STRUCTURE_TYPE_DISPATCH_INFO
    BgiStructureType sType;
    /// NULL
    const void *pNext;
    /// In the recording state, outside a render pass, primary or secondary, of a queue family with compute; executed in
    /// the order of the bgiDispatch calls, on one queue or ordered by semaphores.
    VkCommandBuffer commandBuffer;
    /// Which view; it has a camera.
    BgiView view;
    /// Depth as rendered with the view's camera: depth aspect of a depth format, or VK_FORMAT_R32_SFLOAT. Usage
    /// VK_IMAGE_USAGE_SAMPLED_BIT, layout VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL.
    VkImageView depth;
    /// World-space surface normal in xyz, towards the camera: a float or snorm format. Usage
    /// VK_IMAGE_USAGE_SAMPLED_BIT, layout VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL.
    VkImageView normal;
    /// Receives the indirect irradiance E_ind in rgb (linear Rec.709, unit of the lights; multiply by albedo / pi) and
    /// 1 in a; all 0 where nothing was drawn. Usage VK_IMAGE_USAGE_STORAGE_BIT, layout VK_IMAGE_LAYOUT_GENERAL. Every
    /// pixel of the region is written, and none is read before: its contents on entry do not matter.
    VkImageView output;
    /// Format of `output`: VK_FORMAT_R16G16B16A16_SFLOAT or VK_FORMAT_R32G32B32A32_SFLOAT.
    VkFormat outputFormat;
    /// Value of `depth` where nothing was drawn: 1, or 0 with reverse depth.
    float clearDepth;
    /// Left column of the rendered region, the same in all images, in pixels; 0 to BGI_MAX_EXTENT - 1. The region lies inside
    /// the images; what is outside of it is neither read nor written, so that several views may share them.
    uint32_t x;
    /// Top row of the rendered region in pixels; 0 to BGI_MAX_EXTENT - 1.
    uint32_t y;
    /// Width of the rendered region in pixels; 1 to the view's width. It may be another one in each frame (dynamic
    /// resolution): what was averaged stays.
    uint32_t width;
    /// Height of the rendered region in pixels; 1 to the view's height.
    uint32_t height;
    /// What the output shows instead of E_ind: BGI_DEBUG_VIEW_NONE, or a picture for the host's developer. The first
    /// such call on a context creates a pipeline.
    BgiDebugView debugView;
    /// Optional, with `direct` and `composite`: albedo of the surfaces in rgb, linear Rec.709, 0 to 1. Usage
    /// VK_IMAGE_USAGE_SAMPLED_BIT, layout VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL.
    VkImageView albedo;
    /// Optional, with `albedo` and `composite`: what the surfaces send out by direct light and emission, and the
    /// background, in rgb (radiance, linear Rec.709, unit of the lights). Usage and layout as for `albedo`.
    VkImageView direct;
    /// Optional, with `albedo` and `direct`: receives what the host would draw, direct + albedo / pi x E_ind, in rgb and 1
    /// in a; what `output` shows where that is a debug view. Format, usage and layout as for `output`; another image,
    /// access on entry and exit as for `output`. The first such call on a context creates a pipeline.
    VkImageView composite;
    /// Optional: motion vectors, as engines hand them to temporal upscalers. For each pixel, in xy, where its surface was in
    /// the frame of the view's last bgiDispatch: previous pixel = pixel + motion * motionScale. The full motion on screen,
    /// the camera's too, and without jitter: what the cameras' projections are off their middle by is added here. A float or
    /// snorm format of two channels or more; 16 bits suffice. Where nothing was drawn it is not read. Usage
    /// VK_IMAGE_USAGE_SAMPLED_BIT, layout VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL. NULL: all is taken to have stood still
    /// since, and what moves leaves trails. Either may be given from one frame to the next.
    VkImageView motion;
    /// From the values of `motion` to pixels of this frame's region, x to the right and y down; finite and not 0. 1 and 1 if
    /// they are pixels, width and height if they are parts of the image, width / 2 and -height / 2 if they are clip space
    /// with y up; with the other sign if they point from where the surface was to where it is. Not read without `motion`.
    float motionScale[2];
} BgiDispatchInfo;

/// GPU time of one pass.
typedef struct BgiPassTime {
    /// The pass; UTF-8, ends with a zero.
    char name[64];
    /// Milliseconds by timestamps; all its dispatches of the frame summed.
    double ms;
} BgiPassTime;

/// A device allocation.
typedef struct BgiResourceSize {
    /// What it holds; UTF-8, ends with a zero.
    char name[64];
    /// Bytes allocated.
    uint64_t bytes;
} BgiResourceSize;

/// What a context holds and did. Times are those of the latest frame whose results have arrived. Zero it, then set
/// sType and, where wanted, the arrays with their counts.
typedef struct BgiStats {
    /// BGI_STRUCTURE_TYPE_STATS
    BgiStructureType sType;
    /// NULL
    void *pNext;
    /// Out: GPU milliseconds of the whole recording; 0 without timestamps.
    double frameMs;
    /// Out: CPU milliseconds of the latest bgiDispatch.
    double cpuMs;
    /// Out: device memory of the world in bytes, upload buffers and what frames in flight still use included: what
    /// memoryBudget bounds.
    uint64_t worldBytes;
    /// Out: device memory of all views in bytes.
    uint64_t viewBytes;
    /// Out: rays traced in the frame; those to lights as if there were no shadow maps.
    uint64_t rays;
    /// Out: bgiDispatch calls so far.
    uint64_t frames;
    /// Out: bricks resident.
    uint32_t bricks;
    /// Out: bricks that should be resident and are not (waiting, or no memory).
    uint32_t bricksMissing;
    /// Out: those of the missing bricks that are left out because the world does not fit into memoryBudget.
    uint32_t bricksLeftOut;
    /// Out: those of the missing bricks that are in view and nearer than 128 voxels, but for what is left out.
    uint32_t bricksMissingInView;
    /// Out: bricks that the latest bgiDispatch voxelises.
    uint32_t bricksVoxelized;
    /// Out: lit voxel faces resident.
    uint32_t faces;
    /// Out: voxel faces resident that are not lit, because neither light nor eye reaches them and memory is short.
    uint32_t facesUnreached;
    /// Out: how far the light of the faces has settled since lights or sky last changed, 0 to 1, times the share of the
    /// bricks that are resident. 1: all is loaded and settled, no lighting is recorded until something changes. What a
    /// loading screen waits for; light has come to every corner long before 1.
    float convergence;
    /// Out: allocation units of 32 bytes in use by bricks.
    uint32_t pages;
    /// Out: meshes in buffers that have not been read to the end yet: those handed over last. All is loaded where this and
    /// the missing bricks that are not left out are 0.
    uint32_t meshesPending;
    /// In: elements at `passes`. Out: elements written, or available where `passes` is NULL.
    uint32_t passCount;
    /// In: elements at `resources`. Out: elements written, or available where `resources` is NULL.
    uint32_t resourceCount;
    /// Optional: receives GPU times by pass, in recording order; none without timestamps.
    struct BgiPassTime *passes;
    /// Optional: receives every device allocation.
    struct BgiResourceSize *resources;
    /// Out: triangles of all meshes, as the host handed them over.
    uint64_t meshTriangles;
    /// Out: those that are kept of them; see simplifyVoxels.
    uint64_t keptTriangles;
    /// Out: screen probes that looked in the frame, 64 rays each.
    uint32_t probesTraced;
    /// Out: those of the frame before that have come to a tile of this one's: those that tiles keep, and
    /// those that they do not, since their turn to look has come or their pixels have not been seen for long.
    uint32_t probesCarried;
    /// Out: those that came to a tile where another has come.
    uint32_t probeConflicts;
    /// Out: those given up, since another surface is in their place.
    uint32_t probesRejected;
} BgiStats;

/// Done.
#define BGI_SUCCESS 0

/// Warning: an array or text of the caller was too small; what fits was written.
#define BGI_INCOMPLETE 1

/// Warning: the world does not fit into the memory budget of the settings; the farthest bricks are left out. They come
/// back when memory is freed or the camera moves towards them.
#define BGI_WARNING_WORLD_INCOMPLETE 2

/// A value is outside its documented range, or a required pointer is NULL or misaligned; the text names the field.
#define BGI_ERROR_INVALID_ARGUMENT -1

/// A BgiContext or BgiView that is NULL, was never created, is destroyed already, or is another context's.
#define BGI_ERROR_INVALID_HANDLE -2

/// A struct whose sType is not the expected one, or whose pNext chain this version does not know.
#define BGI_ERROR_INVALID_STRUCTURE -3

/// A mesh, material, texture or instance id that does not exist (any more).
#define BGI_ERROR_UNKNOWN_ID -4

/// The device lacks something that the library needs; the text names it.
#define BGI_ERROR_UNSUPPORTED_DEVICE -5

/// Host or device memory, or the memory budget of the settings, is too small for what was asked.
#define BGI_ERROR_OUT_OF_MEMORY -6

/// VK_ERROR_DEVICE_LOST came from the device. Destroy the context, then the device.
#define BGI_ERROR_DEVICE_LOST -7

/// Another Vulkan call failed; the text names the call and its VkResult.
#define BGI_ERROR_VULKAN -8

/// The header that the caller was compiled with has another ABI than the library.
#define BGI_ERROR_INCOMPATIBLE_ABI -9

/// A fault of the library itself, stopped before it reached the caller. The context refuses everything from now on but
/// being destroyed.
#define BGI_ERROR_INTERNAL -10

/// BgiSettings
#define BGI_STRUCTURE_TYPE_SETTINGS 1

/// BgiDeviceQuery
#define BGI_STRUCTURE_TYPE_DEVICE_QUERY 2

/// BgiDeviceRequirements
#define BGI_STRUCTURE_TYPE_DEVICE_REQUIREMENTS 3

/// BgiContextCreateInfo
#define BGI_STRUCTURE_TYPE_CONTEXT_CREATE_INFO 4

/// BgiMeshUpdate
#define BGI_STRUCTURE_TYPE_MESH_UPDATE 5

/// BgiTexture
#define BGI_STRUCTURE_TYPE_TEXTURE 6

/// BgiMaterial
#define BGI_STRUCTURE_TYPE_MATERIAL 7

/// BgiMesh
#define BGI_STRUCTURE_TYPE_MESH 8

/// BgiInstance
#define BGI_STRUCTURE_TYPE_INSTANCE 9

/// BgiLighting
#define BGI_STRUCTURE_TYPE_LIGHTING 10

/// BgiLight
#define BGI_STRUCTURE_TYPE_LIGHT 11

/// BgiViewCreateInfo
#define BGI_STRUCTURE_TYPE_VIEW_CREATE_INFO 12

/// BgiCamera
#define BGI_STRUCTURE_TYPE_CAMERA 13

/// BgiDispatchInfo
#define BGI_STRUCTURE_TYPE_DISPATCH_INFO 14

/// BgiStats
#define BGI_STRUCTURE_TYPE_STATS 15

/// BgiSky
#define BGI_STRUCTURE_TYPE_SKY 16

/// BgiSkyImage
#define BGI_STRUCTURE_TYPE_SKY_IMAGE 17

/// BgiShadowMap
#define BGI_STRUCTURE_TYPE_SHADOW_MAP 18

/// BgiShadowLayer
#define BGI_STRUCTURE_TYPE_SHADOW_LAYER 19

/// A call failed; the line is what bgiGetLastError says.
#define BGI_LOG_ERROR 1

/// Something works, but not as the host may expect.
#define BGI_LOG_WARNING 2

/// Fewest rays: phones at 60 Hz.
#define BGI_PRESET_LOW 0

/// The default.
#define BGI_PRESET_MEDIUM 1

/// More rays everywhere: desktop.
#define BGI_PRESET_HIGH 2

/// For screenshots and comparisons.
#define BGI_PRESET_ULTRA 3

/// Where it crosses a stored face plane inside that face's coverage mask. Accurate; the default.
#define BGI_HIT_MODEL_PLANE 0

/// Where it enters the voxel's cube. Kept for comparison.
#define BGI_HIT_MODEL_CUBE 1

/// IEEE 754 binary16. VK_FORMAT_R16G16B16A16_SFLOAT is this with a stride of 8: its fourth number is passed over.
#define BGI_VERTEX_FORMAT_FLOAT16 2

/// IEEE 754 binary32.
#define BGI_VERTEX_FORMAT_FLOAT32 4

/// 16-bit unsigned integers.
#define BGI_INDEX_TYPE_UINT16 2

/// 32-bit unsigned integers.
#define BGI_INDEX_TYPE_UINT32 4

/// Three colours: `zenith`, `horizon`, `ground`, `up`.
#define BGI_SKY_TYPE_GRADIENT 1

/// The image of bgiSetSkyImage: `intensity`, `rotation`.
#define BGI_SKY_TYPE_IMAGE 2

/// Equirectangular. The top row is +y, the middle of the image -z, and +x is to the right of it.
#define BGI_SKY_LAYOUT_LAT_LONG 1

/// Six square faces, one after another: +x, -x, +y, -y, +z, -z, each as Vulkan lays out a cube map.
#define BGI_SKY_LAYOUT_CUBE 2

/// Parallel light: `direction` and `irradiance`.
#define BGI_LIGHT_TYPE_DIRECTIONAL 1

/// An isotropic point: `position`, `intensity`, `range`.
#define BGI_LIGHT_TYPE_POINT 2

/// A point that shines into a cone: `position`, `direction`, `intensity`, `innerAngle`, `outerAngle`, `range`.
#define BGI_LIGHT_TYPE_SPOT 3

/// A ball: `position`, `radius`, `radiance`. Nothing is lit inside it.
#define BGI_LIGHT_TYPE_SPHERE 4

/// A rectangle: `position`, `halfAxisU`, `halfAxisV`, `radiance`, `twoSided`.
#define BGI_LIGHT_TYPE_RECTANGLE 5

/// E_ind.
#define BGI_DEBUG_VIEW_NONE 0

/// A colour for each brick, a shade for each of its voxels.
#define BGI_DEBUG_VIEW_BRICKS 1

/// Albedo of the voxel face that a ray of the camera hits, 0 to 1; 0 where it hits none.
#define BGI_DEBUG_VIEW_ALBEDO 2

/// Normal of that face's plane in world space, halved, plus 0.5.
#define BGI_DEBUG_VIEW_NORMALS 3

/// What that face sends out (radiance, in the lights' unit): the light that the gather finds there. The sky's where there
/// is none.
#define BGI_DEBUG_VIEW_RADIANCE 4

/// Cells that the ray visits: black 0, blue 32, green 64, red 96, white 128 and more.
#define BGI_DEBUG_VIEW_STEPS 5

/// Frames that the pixel has averaged, of those that it may: 0 to 1.
#define BGI_DEBUG_VIEW_HISTORY 6

/// What the pixel's tile has: a screen probe of the last frame (green), one that looks in its turn (blue) or for want of a
/// settled one (red), or none (black).
#define BGI_DEBUG_VIEW_PROBES 7

/// What arrives at the face that a ray of the camera hits (irradiance, direct and indirect, in the lights' unit): what it
/// sends out, its emission taken off, by its albedo. 0 where there is none, or no albedo.
#define BGI_DEBUG_VIEW_IRRADIANCE 8

/// The radiance map of each tile's screen probe, 8 x 8 hemi-octahedral directions about its normal: the root of the mean
/// square of the luminance that came from there in some eight frames, in the lights' unit.
#define BGI_DEBUG_VIEW_PROBE_RADIANCE 9

/// How far the probes stand for the pixel, green, 0 to 1; red where none does and it shoots rays into the world's cache
/// instead.
#define BGI_DEBUG_VIEW_FALLBACK 10

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// API version of the library that was loaded, packed as BGI_API_VERSION is.
uint32_t bgiGetVersion(void);

/// ABI version of the library that was loaded. Compare with BGI_ABI_VERSION before any other call.
uint32_t bgiGetAbiVersion(void);

/// Copies the text of the latest call that failed: on `context`, whichever thread made it; with NULL (or a handle that
/// is not live), the latest one that failed on this thread, on any context or none. Empty where there was none. A call
/// that succeeds does not clear it.
///
/// @param text Optional; receives UTF-8 that always ends with a zero, cut to `capacity`.
/// @param capacity Bytes at `text`.
/// @return Length of the whole text in bytes, without its terminating zero.
size_t bgiGetLastError(BgiContext context, char *text, size_t capacity);

/// Name of a result code, for logs: "BGI_SUCCESS" and so on; "BGI_RESULT_UNKNOWN" for a code that this library does not
/// have. The text is static.
const char *bgiResultName(BgiResult result);

/// Says whether a physical device will do, before a VkDevice is made on it. A device that will not do is no error of
/// this call: `supported` is 0 and `missing` says why.
///
/// @return BGI_SUCCESS; BGI_INCOMPLETE where `missingSize` was too small; BGI_ERROR_INVALID_ARGUMENT,
/// BGI_ERROR_INVALID_STRUCTURE, BGI_ERROR_OUT_OF_MEMORY or BGI_ERROR_VULKAN.
BgiResult bgiGetDeviceRequirements(const struct BgiDeviceQuery *query, struct BgiDeviceRequirements *requirements);

/// Fills the settings of a preset. `settings` must have its sType set and pNext NULL; the rest is overwritten.
///
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_ARGUMENT or BGI_ERROR_INVALID_STRUCTURE.
BgiResult bgiGetDefaultSettings(BgiPreset preset, struct BgiSettings *settings);

/// Creates a context: pipelines and fixed tables. Records nothing, submits nothing. Takes some milliseconds, most of
/// them in the driver's compiler.
///
/// @param context Receives the handle; NULL where the call fails. The caller owns it and ends it with
/// bgiDestroyContext.
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_ARGUMENT, BGI_ERROR_INVALID_STRUCTURE, BGI_ERROR_INCOMPATIBLE_ABI,
/// BGI_ERROR_UNSUPPORTED_DEVICE, BGI_ERROR_OUT_OF_MEMORY, BGI_ERROR_DEVICE_LOST or BGI_ERROR_VULKAN; the text is in
/// bgiGetLastError(NULL, ...).
BgiResult bgiCreateContext(const struct BgiContextCreateInfo *info, BgiContext *context);

/// Destroys a context and its views, and frees all their memory. The GPU must have finished with every command buffer
/// that bgiDispatch recorded into, and the VkDevice must still exist (a lost device is fine). Waits for calls that
/// other threads are making on the context; they and all later ones get BGI_ERROR_INVALID_HANDLE.
///
/// @return BGI_SUCCESS or BGI_ERROR_INVALID_HANDLE.
BgiResult bgiDestroyContext(BgiContext context);

/// Adds, replaces, moves or removes what the world is made of. On an error nothing of the batch is applied. Records
/// nothing: the GPU work is done by the following bgiDispatch calls, a bounded amount each.
///
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT, BGI_ERROR_INVALID_STRUCTURE,
/// BGI_ERROR_UNKNOWN_ID or BGI_ERROR_OUT_OF_MEMORY.
BgiResult bgiUpdateMeshes(BgiContext context, const struct BgiMeshUpdate *update);

/// Takes or replaces the image that skies of BGI_SKY_TYPE_IMAGE mean. Records nothing. The image is reduced, in some ten
/// milliseconds a million texels, to 64 x 64 mean radiances (16 KiB for each frame in flight while they are in use). Its
/// sum over the sphere stays, and so do, within 1 %, those over hemispheres, but for a sun that stands on their horizon.
/// Rays that miss the scene read the map: a sun in it is found by few of them and makes noise. Better paint it out, and
/// hand it over as a directional light.
///
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT or BGI_ERROR_INVALID_STRUCTURE.
BgiResult bgiSetSkyImage(BgiContext context,
                         const struct BgiSkyImage *image);

/// All light is wrong: the sun has jumped, a level has loaded. Averages over time start over, those of the views too. What
/// changes through bgiSetLights and bgiUpdateMeshes needs no such hint. Records nothing.
///
/// @return BGI_SUCCESS or BGI_ERROR_INVALID_HANDLE.
BgiResult bgiInvalidateLighting(BgiContext context);

/// Replaces all lights and the sky for the following dispatches. Records nothing. The first call with any light, with
/// spheres or rectangles, and with more than directLights, creates a pipeline each.
///
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT, BGI_ERROR_INVALID_STRUCTURE,
/// BGI_ERROR_OUT_OF_MEMORY, BGI_ERROR_DEVICE_LOST or BGI_ERROR_VULKAN.
BgiResult bgiSetLights(BgiContext context, const struct BgiLighting *lighting);

/// Replaces the host's shadow maps for the following dispatches; none: each shadow is a ray. Where a map covers a point that
/// is lit, a texel takes the ray's place. Cheap, and meant to be called each frame, as cascades follow the camera: averages
/// do not start over. Call it after bgiSetLights where both change. Records nothing.
///
/// While lighting sleeps, because nothing changes, no map is read. A sun that moves wakes it through bgiSetLights, and a
/// caster through bgiUpdateMeshes; where casters move that are not among the meshes, and where maps are given or taken away
/// for good, bgiInvalidateLighting does.
///
/// The views stay valid until the GPU has finished with the command buffers of all dispatches before they were replaced.
///
/// The first call with any map creates a pipeline.
///
/// @param maps count maps. Copied.
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT, BGI_ERROR_INVALID_STRUCTURE,
/// BGI_ERROR_OUT_OF_MEMORY, BGI_ERROR_DEVICE_LOST or BGI_ERROR_VULKAN.
BgiResult bgiSetShadowMaps(BgiContext context,
                           uint32_t count,
                           const struct BgiShadowMap *maps);

/// Creates a view: probes and history for images of up to the given size. Needs a camera (bgiSetCamera) before its
/// first dispatch.
///
/// @param view Receives the handle; NULL where the call fails. The context owns it.
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT, BGI_ERROR_INVALID_STRUCTURE,
/// BGI_ERROR_OUT_OF_MEMORY, BGI_ERROR_DEVICE_LOST or BGI_ERROR_VULKAN.
BgiResult bgiCreateView(BgiContext context, const struct BgiViewCreateInfo *info, BgiView *view);

/// Destroys a view and frees its memory. The GPU must have finished with every command buffer into which bgiDispatch
/// recorded it.
///
/// @return BGI_SUCCESS or BGI_ERROR_INVALID_HANDLE.
BgiResult bgiDestroyView(BgiContext context, BgiView view);

/// Sets a view's camera for its following dispatches. Records nothing.
///
/// @return BGI_SUCCESS, BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT or BGI_ERROR_INVALID_STRUCTURE.
BgiResult bgiSetCamera(BgiContext context, BgiView view, const struct BgiCamera *camera);

/// Records one view's frame into the host's command buffer: copies of pending meshes, queued bricks, lighting, probes,
/// resolve. Compute and copies only; valid in secondary command buffers; no queue is touched and nothing is waited for.
/// Clobbered and not restored: the compute pipeline, compute descriptor sets and push constants. Barriers for the library's
/// own buffers are its own. The first call with an outputFormat creates its pipelines. The handles in `info` and the buffers of pending meshes must stay valid until the GPU has
/// finished with the command buffer.
///
/// @return BGI_SUCCESS; BGI_WARNING_WORLD_INCOMPLETE, after all its work, where bricks are left out for lack of memory
/// (the log says so once, when it begins); BGI_ERROR_INVALID_HANDLE, BGI_ERROR_INVALID_ARGUMENT, BGI_ERROR_INVALID_STRUCTURE,
/// BGI_ERROR_OUT_OF_MEMORY, BGI_ERROR_DEVICE_LOST or BGI_ERROR_VULKAN. After an error the host submits the command
/// buffer or drops it as it likes.
BgiResult bgiDispatch(BgiContext context,
                      const struct BgiDispatchInfo *info);

/// Reports without waiting for the GPU.
///
/// @return BGI_SUCCESS; BGI_INCOMPLETE where an array was too small; BGI_ERROR_INVALID_HANDLE,
/// BGI_ERROR_INVALID_ARGUMENT or BGI_ERROR_INVALID_STRUCTURE.
BgiResult bgiGetStats(BgiContext context, struct BgiStats *stats);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BRICKGI_H */
