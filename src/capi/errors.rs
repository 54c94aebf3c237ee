//! Words for what went wrong.

use super::guard::thread_error;
use super::handles;
use super::types::*;
use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Copies the text of the latest call that failed: on `context`, whichever thread made it; with NULL (or a handle that
/// is not live), the latest one that failed on this thread, on any context or none. Empty where there was none. A call
/// that succeeds does not clear it.
///
/// @param text Optional; receives UTF-8 that always ends with a zero, cut to `capacity`.
/// @param capacity Bytes at `text`.
/// @return Length of the whole text in bytes, without its terminating zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bgiGetLastError(context: BgiContext, text: *mut c_char, capacity: usize) -> usize {
    let latest = || handles::find(context).map_or_else(|_| thread_error(), |entry| entry.last_error());
    // Unwind safety: only strings are read.
    let latest = catch_unwind(AssertUnwindSafe(latest)).unwrap_or_default();
    if !text.is_null() && capacity > 0 {
        let fits = latest.floor_char_boundary(capacity - 1);
        // SAFETY: `fits` + 1 is at most `capacity`, which the header asks to be writable; bytes need no alignment.
        unsafe {
            std::ptr::copy_nonoverlapping(latest.as_ptr(), text.cast(), fits);
            text.add(fits).write(0);
        }
    }
    latest.len()
}

/// Name of a result code, for logs: "BGI_SUCCESS" and so on; "BGI_RESULT_UNKNOWN" for a code that this library does not
/// have. The text is static.
#[unsafe(no_mangle)]
pub extern "C" fn bgiResultName(result: BgiResult) -> *const c_char {
    result_name(result).as_ptr()
}

fn result_name(result: BgiResult) -> &'static CStr {
    match result {
        BGI_SUCCESS => c"BGI_SUCCESS",
        BGI_INCOMPLETE => c"BGI_INCOMPLETE",
        BGI_WARNING_WORLD_INCOMPLETE => c"BGI_WARNING_WORLD_INCOMPLETE",
        BGI_ERROR_INVALID_ARGUMENT => c"BGI_ERROR_INVALID_ARGUMENT",
        BGI_ERROR_INVALID_HANDLE => c"BGI_ERROR_INVALID_HANDLE",
        BGI_ERROR_INVALID_STRUCTURE => c"BGI_ERROR_INVALID_STRUCTURE",
        BGI_ERROR_UNKNOWN_ID => c"BGI_ERROR_UNKNOWN_ID",
        BGI_ERROR_UNSUPPORTED_DEVICE => c"BGI_ERROR_UNSUPPORTED_DEVICE",
        BGI_ERROR_OUT_OF_MEMORY => c"BGI_ERROR_OUT_OF_MEMORY",
        BGI_ERROR_DEVICE_LOST => c"BGI_ERROR_DEVICE_LOST",
        BGI_ERROR_VULKAN => c"BGI_ERROR_VULKAN",
        BGI_ERROR_INCOMPATIBLE_ABI => c"BGI_ERROR_INCOMPATIBLE_ABI",
        BGI_ERROR_INTERNAL => c"BGI_ERROR_INTERNAL",
        _ => c"BGI_RESULT_UNKNOWN",
    }
}
