//! Everything that can go wrong, as values with context.

use ash::vk;

/// Why a call was refused or failed. Nothing in this crate panics on input.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An argument is outside its documented range; the text names the field.
    #[error("invalid argument: {0}")]
    InvalidArgument(String),
    /// A mesh, material, texture, instance or view id that does not exist (any more).
    #[error("unknown id: {0}")]
    UnknownId(String),
    /// The device lacks something that the library needs; the text names it.
    #[error("unsupported device: {0}")]
    UnsupportedDevice(String),
    /// A Vulkan call failed.
    #[error("{call} failed: {result}")]
    Vulkan {
        /// The Vulkan command.
        call: &'static str,
        /// What it returned.
        result: vk::Result,
    },
    /// The memory budget or the device's memory is too small for what was asked.
    #[error("out of memory: {0}")]
    OutOfMemory(String),
}

impl Error {
    pub(crate) fn invalid(text: impl Into<String>) -> Self {
        Self::InvalidArgument(text.into())
    }

    /// For `map_err`: wraps a Vulkan result with the name of the call.
    pub(crate) fn vulkan(call: &'static str) -> impl FnOnce(vk::Result) -> Self {
        move |result| Self::Vulkan { call, result }
    }
}

/// Shorthand used by the whole crate.
pub type Result<T> = std::result::Result<T, Error>;
