//! What every call shares: result codes, structure types, handles and limits.

use std::ffi::{c_char, c_void};

/// What a call returns: BGI_SUCCESS (0), a warning (positive: the call did its work) or an error (negative: it did
/// nothing). Test errors with `result < 0`. The words for it are in bgiGetLastError.
pub type BgiResult = i32;
/// Done.
pub const BGI_SUCCESS: BgiResult = 0;
/// Warning: an array or text of the caller was too small; what fits was written.
pub const BGI_INCOMPLETE: BgiResult = 1;
/// Warning: the world does not fit into the memory budget of the settings; the farthest bricks are left out. They come
/// back when memory is freed or the camera moves towards them.
pub const BGI_WARNING_WORLD_INCOMPLETE: BgiResult = 2;
/// A value is outside its documented range, or a required pointer is NULL or misaligned; the text names the field.
pub const BGI_ERROR_INVALID_ARGUMENT: BgiResult = -1;
/// A BgiContext or BgiView that is NULL, was never created, is destroyed already, or is another context's.
pub const BGI_ERROR_INVALID_HANDLE: BgiResult = -2;
/// A struct whose sType is not the expected one, or whose pNext chain this version does not know.
pub const BGI_ERROR_INVALID_STRUCTURE: BgiResult = -3;
/// A mesh, material, texture or instance id that does not exist (any more).
pub const BGI_ERROR_UNKNOWN_ID: BgiResult = -4;
/// The device lacks something that the library needs; the text names it.
pub const BGI_ERROR_UNSUPPORTED_DEVICE: BgiResult = -5;
/// Host or device memory, or the memory budget of the settings, is too small for what was asked.
pub const BGI_ERROR_OUT_OF_MEMORY: BgiResult = -6;
/// VK_ERROR_DEVICE_LOST came from the device. Destroy the context, then the device.
pub const BGI_ERROR_DEVICE_LOST: BgiResult = -7;
/// Another Vulkan call failed; the text names the call and its VkResult.
pub const BGI_ERROR_VULKAN: BgiResult = -8;
/// The header that the caller was compiled with has another ABI than the library.
pub const BGI_ERROR_INCOMPATIBLE_ABI: BgiResult = -9;
/// A fault of the library itself, stopped before it reached the caller. The context refuses everything from now on but
/// being destroyed.
pub const BGI_ERROR_INTERNAL: BgiResult = -10;

/// Says which struct a pointer leads to: one of BGI_STRUCTURE_TYPE_*. Values are never reused.
pub type BgiStructureType = u32;
/// BgiSettings
pub const BGI_STRUCTURE_TYPE_SETTINGS: BgiStructureType = 1;
/// BgiDeviceQuery
pub const BGI_STRUCTURE_TYPE_DEVICE_QUERY: BgiStructureType = 2;
/// BgiDeviceRequirements
pub const BGI_STRUCTURE_TYPE_DEVICE_REQUIREMENTS: BgiStructureType = 3;
/// BgiContextCreateInfo
pub const BGI_STRUCTURE_TYPE_CONTEXT_CREATE_INFO: BgiStructureType = 4;
/// BgiMeshUpdate
pub const BGI_STRUCTURE_TYPE_MESH_UPDATE: BgiStructureType = 5;
/// BgiTexture
pub const BGI_STRUCTURE_TYPE_TEXTURE: BgiStructureType = 6;
/// BgiMaterial
pub const BGI_STRUCTURE_TYPE_MATERIAL: BgiStructureType = 7;
/// BgiMesh
pub const BGI_STRUCTURE_TYPE_MESH: BgiStructureType = 8;
/// BgiInstance
pub const BGI_STRUCTURE_TYPE_INSTANCE: BgiStructureType = 9;
/// BgiLighting
pub const BGI_STRUCTURE_TYPE_LIGHTING: BgiStructureType = 10;
/// BgiLight
pub const BGI_STRUCTURE_TYPE_LIGHT: BgiStructureType = 11;
/// BgiViewCreateInfo
pub const BGI_STRUCTURE_TYPE_VIEW_CREATE_INFO: BgiStructureType = 12;
/// BgiCamera
pub const BGI_STRUCTURE_TYPE_CAMERA: BgiStructureType = 13;
/// BgiDispatchInfo
pub const BGI_STRUCTURE_TYPE_DISPATCH_INFO: BgiStructureType = 14;
/// BgiStats
pub const BGI_STRUCTURE_TYPE_STATS: BgiStructureType = 15;
/// BgiSky
pub const BGI_STRUCTURE_TYPE_SKY: BgiStructureType = 16;
/// BgiSkyImage
pub const BGI_STRUCTURE_TYPE_SKY_IMAGE: BgiStructureType = 17;
/// BgiShadowMap
pub const BGI_STRUCTURE_TYPE_SHADOW_MAP: BgiStructureType = 18;
/// BgiShadowLayer
pub const BGI_STRUCTURE_TYPE_SHADOW_LAYER: BgiStructureType = 19;

/// Most elements in any array handed in. A larger count is refused with BGI_ERROR_INVALID_ARGUMENT.
pub const BGI_MAX_COUNT: u32 = 67108864;
/// Largest edge of an image or texture in pixels.
pub const BGI_MAX_EXTENT: u32 = 16384;
/// Most layers of all shadow maps.
pub const BGI_MAX_SHADOW_LAYERS: u32 = 64;
/// Most different views of shadow maps.
pub const BGI_MAX_SHADOW_VIEWS: u32 = 4;
/// Bytes of a name in BgiPassTime and BgiResourceSize, its terminating zero included.
pub const BGI_NAME_SIZE: u32 = 64;

/// What a BgiContext pretends to point at; there is no such object.
pub struct BgiContext_T {
    _opaque: [u8; 0],
}

/// A context: the world (bricks, lighting) on one VkDevice. Made by bgiCreateContext, ended by bgiDestroyContext. A
/// token and not an address: the library looks it up before it touches anything, and never uses one again.
pub type BgiContext = *mut BgiContext_T;

/// What a BgiView pretends to point at; there is no such object.
pub struct BgiView_T {
    _opaque: [u8; 0],
}

/// A view: a camera with its own probes and history over the context's world. Made by bgiCreateView, ended by
/// bgiDestroyView or with its context. A token, as BgiContext is.
pub type BgiView = *mut BgiView_T;

/// Severity of a log line: one of BGI_LOG_*.
pub type BgiLogSeverity = u32;
/// A call failed; the line is what bgiGetLastError says.
pub const BGI_LOG_ERROR: BgiLogSeverity = 1;
/// Something works, but not as the host may expect.
pub const BGI_LOG_WARNING: BgiLogSeverity = 2;

/// Receives the library's log lines: one line of UTF-8 without a line feed, valid during the call only. Called on the
/// thread that made the API call, with no lock held: the library may be called from inside. Must return (no exception,
/// no longjmp).
pub type BgiLogCallback =
    Option<unsafe extern "C" fn(userData: *mut c_void, severity: BgiLogSeverity, message: *const c_char)>;

/// A piece of the library's work. Never throws; takes some ten microseconds to some milliseconds.
pub type BgiTask = unsafe extern "C" fn(taskData: *mut c_void, index: u32);

/// Calls task(taskData, index) once for each index below `count`, on any threads and in any order, at once or one after
/// the other, and returns when all these calls have. Called by bgiUpdateMeshes and bgiDispatch, on their thread, where
/// there is much to do. Neither it nor the tasks' threads may meanwhile call the library on that context. Must return (no
/// exception, no longjmp).
pub type BgiParallelFor =
    Option<unsafe extern "C" fn(userData: *mut c_void, count: u32, task: BgiTask, taskData: *mut c_void)>;
