//! The only place where a caller's pointer becomes a reference. Ranges and meanings are checked by the core, for C and
//! Rust alike; here is only what Rust's types rule out.

use super::guard::Failure;
use super::types::*;
use std::ffi::c_void;

/// The two fields that every struct of the API starts with.
#[repr(C)]
struct Head {
    s_type: BgiStructureType,
    p_next: *const c_void,
}

/// A struct that is handed in.
///
/// # Safety
/// The type must be `repr(C)` and start with `s_type: u32` and `p_next: *const c_void` (or `*mut`).
pub(super) unsafe trait Structure: Sized {
    /// The value that `s_type` must have.
    const TYPE: BgiStructureType;
    /// The name in the header, for error texts.
    const NAME: &'static str;
}

/// Says which `sType` belongs to which struct of the header.
macro_rules! structure_types {
    ($($name:ident = $value:ident),* $(,)?) => {$(
        // SAFETY: every struct of the header is repr(C) and has its head first; tests/abi.rs compares the offsets.
        unsafe impl $crate::capi::input::Structure for $name {
            const TYPE: BgiStructureType = $value;
            const NAME: &'static str = stringify!($name);
        }
    )*};
}
pub(super) use structure_types;

/// Reads a field that is 0 or 1.
pub(super) fn flag(value: u32, field: &str) -> Result<bool, Failure> {
    match value {
        0 => Ok(false),
        1 => Ok(true),
        other => Err(Failure::argument(format!("{field} is {other}; it must be 0 or 1"))),
    }
}

/// Reads a struct after checking its address and head.
///
/// # Safety
/// `pointer` is NULL, or leads to readable memory of the size of the struct that its `sType` names, unchanged for 'a.
pub(super) unsafe fn structure<'a, T: Structure>(pointer: *const T) -> Result<&'a T, Failure> {
    check_address(pointer, T::NAME)?;
    // SAFETY: not NULL and aligned (just checked); every struct of the API starts with a Head (caller, trait).
    unsafe { check_head::<T>(pointer.cast(), T::NAME)? };
    // SAFETY: sType says that it is a T, and the caller vouches for the memory.
    Ok(unsafe { &*pointer })
}

/// As [`structure`], for a struct that the library fills.
///
/// # Safety
/// As [`structure`]; the memory is writable, and nobody else looks at it for 'a.
pub(super) unsafe fn structure_mut<'a, T: Structure>(pointer: *mut T) -> Result<&'a mut T, Failure> {
    // SAFETY: the caller's promise; the shared reference is gone before the exclusive one is made.
    unsafe { structure(pointer.cast_const())? };
    // SAFETY: just checked; exclusive and writable by the caller's promise.
    Ok(unsafe { &mut *pointer })
}

/// Reads an array of structs after checking the head of each.
///
/// # Safety
/// As [`slice`], and each element is of the size of T.
pub(super) unsafe fn structures<'a, T: Structure>(
    pointer: *const T,
    count: u32,
    field: &str,
) -> Result<&'a [T], Failure> {
    // SAFETY: the caller's promise.
    let elements = unsafe { slice(pointer, count, field)? };
    for (index, element) in elements.iter().enumerate() {
        // SAFETY: a reference is aligned and readable; T starts with a Head (trait).
        unsafe { check_head::<T>(std::ptr::from_ref(element).cast(), &format!("{field}[{index}]"))? };
    }
    Ok(elements)
}

/// Reads an array; NULL is fine where the count is 0.
///
/// # Safety
/// `pointer` is NULL, or leads to `count` readable elements, unchanged for 'a; any bytes are a valid T.
pub(super) unsafe fn slice<'a, T>(pointer: *const T, count: u32, field: &str) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    if count > BGI_MAX_COUNT {
        return Err(Failure::argument(format!("{field}: {count} elements; at most {BGI_MAX_COUNT} are allowed")));
    }
    // SAFETY: the caller's promise.
    unsafe { memory(pointer, count as usize, field) }
}

/// As [`slice`], for a length that has a limit of its own.
///
/// # Safety
/// As [`slice`].
pub(super) unsafe fn memory<'a, T>(pointer: *const T, len: usize, field: &str) -> Result<&'a [T], Failure> {
    check_address(pointer, field)?;
    if len.checked_mul(size_of::<T>()).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return Err(Failure::argument(format!("{field}: {len} elements are more than the address space holds")));
    }
    // SAFETY: not NULL, aligned, no larger than isize::MAX (just checked); readable by the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(pointer, len) })
}

/// Reads `len` bytes from `offset` bytes behind `pointer` on, where what needs so much alignment begins.
///
/// # Safety
/// `pointer` is NULL, or leads to `offset + len` readable bytes, unchanged for 'a.
pub(super) unsafe fn bytes<'a>(
    pointer: *const c_void,
    offset: u64,
    len: u64,
    alignment: u32,
    field: &str,
) -> Result<&'a [u8], Failure> {
    check_address(pointer.cast::<u8>(), &format!("{field}.data"))?;
    let end = offset.checked_add(len).and_then(|end| isize::try_from(end).ok());
    if end.is_none_or(|end| pointer.addr().checked_add(end as usize).is_none()) {
        let text = format!("{field}: {len} bytes from offset {offset} on are more than the address space holds");
        return Err(Failure::argument(text));
    }
    let first = pointer.cast::<u8>().wrapping_add(offset as usize);
    if !first.addr().is_multiple_of(alignment as usize) {
        return Err(Failure::argument(format!("{field} is misaligned: {alignment} bytes are needed")));
    }
    // SAFETY: not NULL, no larger than isize::MAX (just checked); readable by the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(first, len as usize) })
}

/// The count/array pattern of an output: with a NULL pointer `count` becomes how many there are, else as many as fit are
/// written and `count` becomes how many were. False where some did not fit.
///
/// # Safety
/// `pointer` is NULL, or leads to `count` writable elements that nobody else looks at meanwhile.
pub(super) unsafe fn fill<T: Copy>(
    pointer: *mut T,
    count: &mut u32,
    items: &[T],
    field: &str,
) -> Result<bool, Failure> {
    if pointer.is_null() {
        *count = items.len() as u32;
        return Ok(true);
    }
    check_address(pointer, field)?;
    let written = items.len().min(*count as usize);
    // SAFETY: not NULL and aligned (just checked); `written` is at most the caller's count and the items' length, and
    // the caller's array cannot overlap with the library's own.
    unsafe { std::ptr::copy_nonoverlapping(items.as_ptr(), pointer, written) };
    *count = written as u32;
    Ok(written == items.len())
}

/// Refuses a NULL or misaligned address.
pub(super) fn check_address<T>(pointer: *const T, name: &str) -> Result<(), Failure> {
    if pointer.is_null() {
        Err(Failure::argument(format!("{name} is NULL")))
    } else if !pointer.is_aligned() {
        Err(Failure::argument(format!("{name} is misaligned: {} bytes are needed", align_of::<T>())))
    } else {
        Ok(())
    }
}

/// # Safety
/// `head` leads to an aligned, readable Head.
unsafe fn check_head<T: Structure>(head: *const Head, name: &str) -> Result<(), Failure> {
    // SAFETY: the caller's promise.
    let Head { s_type, p_next } = unsafe { head.read() };
    if s_type != T::TYPE {
        let text = format!("{name}.sType is {s_type}; {} has {}", T::NAME, T::TYPE);
        return Err(Failure::new(BGI_ERROR_INVALID_STRUCTURE, text));
    }
    // This version defines no extension struct, so that any chain is unknown; it is refused without being followed.
    if !p_next.is_null() {
        let text = format!("{name}.pNext must be NULL: this version of the library knows no extension of {}", T::NAME);
        return Err(Failure::new(BGI_ERROR_INVALID_STRUCTURE, text));
    }
    Ok(())
}
