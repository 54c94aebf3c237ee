//! Everything that can go wrong in the host, as values with context.

use std::path::{Path, PathBuf};

/// Why the host could not do what was asked.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file is missing or unreadable.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A file was read but does not describe a usable scene.
    #[error("{}: {reason}", path.display())]
    Scene {
        /// The scene file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The scene has no camera of that name.
    #[error("no camera {wanted:?}; the scene has: {known}")]
    UnknownCamera {
        /// The name asked for.
        wanted: String,
        /// The names that exist.
        known: String,
    },
    /// An option is outside its range.
    #[error("invalid option: {0}")]
    InvalidOption(String),
    /// No device, or none that offers what is needed.
    #[error("no usable Vulkan device: {0}")]
    NoDevice(String),
    /// A Vulkan call failed.
    #[error("{call} failed: {reason}")]
    Gpu {
        /// What was attempted.
        call: &'static str,
        /// What the driver said.
        reason: String,
    },
    /// An image file could not be read or written.
    #[error("image {}: {reason}", path.display())]
    Image {
        /// The image file.
        path: PathBuf,
        /// What went wrong.
        reason: String,
    },
    /// brickgi refused or failed.
    #[error("brickgi: {0}")]
    Gi(#[from] brickgi::Error),
}

impl Error {
    pub(crate) fn scene(path: &Path, reason: impl ToString) -> Self {
        Self::Scene { path: path.to_owned(), reason: reason.to_string() }
    }

    /// For `map_err`: names the image file.
    pub(crate) fn image<E: ToString>(path: &Path) -> impl FnOnce(E) -> Self {
        move |reason| Self::Image { path: path.to_owned(), reason: reason.to_string() }
    }

    /// For `map_err`: names the GPU operation.
    pub(crate) fn gpu<E: ToString>(call: &'static str) -> impl FnOnce(E) -> Self {
        move |reason| Self::Gpu { call, reason: reason.to_string() }
    }
}

/// Shorthand used by the whole crate.
pub type Result<T> = std::result::Result<T, Error>;
