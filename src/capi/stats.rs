//! What a context holds and did.

use super::guard::guard_context;
use super::input::{self, structure_types};
use super::types::*;
use std::ffi::{c_char, c_void};

/// GPU time of one pass.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiPassTime {
    /// The pass; UTF-8, ends with a zero.
    pub name: [c_char; 64],
    /// Milliseconds by timestamps; all its dispatches of the frame summed.
    pub ms: f64,
}

/// A device allocation.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiResourceSize {
    /// What it holds; UTF-8, ends with a zero.
    pub name: [c_char; 64],
    /// Bytes allocated.
    pub bytes: u64,
}

/// What a context holds and did. Times are those of the latest frame whose results have arrived. Zero it, then set
/// sType and, where wanted, the arrays with their counts.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BgiStats {
    /// BGI_STRUCTURE_TYPE_STATS
    pub s_type: BgiStructureType,
    /// NULL
    pub p_next: *mut c_void,
    /// Out: GPU milliseconds of the whole recording; 0 without timestamps.
    pub frame_ms: f64,
    /// Out: CPU milliseconds of the latest bgiDispatch.
    pub cpu_ms: f64,
    /// Out: device memory of the world in bytes, upload buffers and what frames in flight still use included: what
    /// memoryBudget bounds.
    pub world_bytes: u64,
    /// Out: device memory of all views in bytes.
    pub view_bytes: u64,
    /// Out: rays traced in the frame; those to lights as if there were no shadow maps.
    pub rays: u64,
    /// Out: bgiDispatch calls so far.
    pub frames: u64,
    /// Out: bricks resident.
    pub bricks: u32,
    /// Out: bricks that should be resident and are not (waiting, or no memory).
    pub bricks_missing: u32,
    /// Out: those of the missing bricks that are left out because the world does not fit into memoryBudget.
    pub bricks_left_out: u32,
    /// Out: those of the missing bricks that are in view and nearer than 128 voxels, but for what is left out.
    pub bricks_missing_in_view: u32,
    /// Out: bricks that the latest bgiDispatch voxelises.
    pub bricks_voxelized: u32,
    /// Out: lit voxel faces resident.
    pub faces: u32,
    /// Out: voxel faces resident that are not lit, because neither light nor eye reaches them and memory is short.
    pub faces_unreached: u32,
    /// Out: how far the light of the faces has settled since lights or sky last changed, 0 to 1, times the share of the
    /// bricks that are resident. 1: all is loaded and settled, no lighting is recorded until something changes. What a
    /// loading screen waits for; light has come to every corner long before 1.
    pub convergence: f32,
    /// Out: allocation units of 32 bytes in use by bricks.
    pub pages: u32,
    /// Out: meshes in buffers that have not been read to the end yet: those handed over last. All is loaded where this and
    /// the missing bricks that are not left out are 0.
    pub meshes_pending: u32,
    /// In: elements at `passes`. Out: elements written, or available where `passes` is NULL.
    pub pass_count: u32,
    /// In: elements at `resources`. Out: elements written, or available where `resources` is NULL.
    pub resource_count: u32,
    /// Optional: receives GPU times by pass, in recording order; none without timestamps.
    pub passes: *mut BgiPassTime,
    /// Optional: receives every device allocation.
    pub resources: *mut BgiResourceSize,
    /// Out: triangles of all meshes, as the host handed them over.
    pub mesh_triangles: u64,
    /// Out: those that are kept of them; see simplifyVoxels.
    pub kept_triangles: u64,
    /// Out: screen probes that looked in the frame, 64 rays each.
    pub probes_traced: u32,
    /// Out: those of the frame before that have come to a tile of this one's: those that tiles keep, and
    /// those that they do not, since their turn to look has come or their pixels have not been seen for long.
    pub probes_carried: u32,
    /// Out: those that came to a tile where another has come.
    pub probe_conflicts: u32,
    /// Out: those given up, since another surface is in their place.
    pub probes_rejected: u32,
}

structure_types! { BgiStats = BGI_STRUCTURE_TYPE_STATS }

const _: () = assert!(BGI_NAME_SIZE == 64, "the array lengths above are written out for the header's sake");

/// Reports without waiting for the GPU.
///
/// @return BGI_SUCCESS; BGI_INCOMPLETE where an array was too small; BGI_ERROR_INVALID_HANDLE,
/// BGI_ERROR_INVALID_ARGUMENT or BGI_ERROR_INVALID_STRUCTURE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiGetStats(context: BgiContext, stats: *mut BgiStats) -> BgiResult {
    guard_context(context, |state| {
        // SAFETY: the header asks for a writable, zeroed struct.
        let out = unsafe { input::structure_mut(stats)? };
        let stats = state.context.stats();
        let passes = stats.passes.iter().map(|pass| BgiPassTime { name: name(pass.name), ms: pass.ms });
        let passes = passes.collect::<Vec<_>>();
        let resources = stats.resources.iter().map(|item| BgiResourceSize { name: name(item.name), bytes: item.bytes });
        let resources = resources.collect::<Vec<_>>();
        // SAFETY: the header asks for writable arrays as long as their counts say.
        let complete = unsafe {
            let passes = input::fill(out.passes, &mut out.pass_count, &passes, "passes")?;
            input::fill(out.resources, &mut out.resource_count, &resources, "resources")? && passes
        };
        *out = BgiStats {
            frame_ms: stats.frame_ms,
            cpu_ms: stats.cpu_ms,
            world_bytes: stats.world_bytes,
            view_bytes: stats.view_bytes,
            rays: stats.rays,
            frames: stats.frames,
            bricks: stats.bricks,
            bricks_missing: stats.bricks_missing,
            bricks_left_out: stats.bricks_left_out,
            bricks_missing_in_view: stats.bricks_missing_in_view,
            bricks_voxelized: stats.bricks_voxelized,
            faces: stats.faces,
            faces_unreached: stats.faces_unreached,
            convergence: stats.convergence,
            pages: stats.pages,
            meshes_pending: stats.meshes_pending,
            mesh_triangles: stats.mesh_triangles,
            kept_triangles: stats.kept_triangles,
            probes_traced: stats.probes_traced,
            probes_carried: stats.probes_carried,
            probe_conflicts: stats.probe_conflicts,
            probes_rejected: stats.probes_rejected,
            ..*out
        };
        Ok(if complete { BGI_SUCCESS } else { BGI_INCOMPLETE })
    })
}

/// A name in a fixed array, cut where it is too long, always with a zero at the end.
fn name(text: &str) -> [c_char; BGI_NAME_SIZE as usize] {
    let mut name = [0; BGI_NAME_SIZE as usize];
    let fits = text.floor_char_boundary(name.len() - 1);
    for (to, from) in name.iter_mut().zip(text[..fits].bytes()) {
        *to = from as c_char;
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_cut_between_characters_and_end_with_zero() {
        let long = name(&"é".repeat(40));
        assert_eq!(long.iter().position(|c| *c == 0), Some(62));
        assert_eq!(name("resolve")[..8].iter().map(|c| *c as u8).collect::<Vec<_>>(), b"resolve\0");
    }
}
