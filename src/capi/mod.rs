//! The C ABI: `include/brickgi.h` is generated from this module, and its doc comments are that header's manual.
//!
//! | file | concern |
//! | --- | --- |
//! | `types` | result codes, structure types, handles, limits |
//! | `vk` | Vulkan's own names for Vulkan's types |
//! | `version`, `device`, `settings`, `context`, `geometry`, `meshes`, `lights`, `shadows`, `sky`, `view`, `dispatch`, `stats`, `errors` | one call or family each, with the structs it reads |
//! | `input` | the only place where a caller's pointer becomes a reference |
//! | `handles` | the registry of live contexts: a handle is a token and is never dereferenced |
//! | `guard` | panics stop here; failures become codes, texts and log lines |
#![allow(non_camel_case_types, reason = "handle and function-pointer names follow Vulkan's")]
#![allow(non_snake_case, reason = "exported functions carry the header's names")]
#![allow(clippy::missing_safety_doc, reason = "each function's contract is the header's documentation")]

mod context;
mod device;
mod dispatch;
mod errors;
mod geometry;
mod guard;
mod handles;
mod input;
mod lights;
mod meshes;
mod parallel;
mod settings;
mod shadows;
mod sky;
mod stats;
mod types;
mod version;
mod view;
pub mod vk;

pub use context::*;
pub use device::*;
pub use dispatch::*;
pub use errors::*;
pub use geometry::*;
pub use lights::*;
pub use meshes::*;
pub use settings::*;
pub use shadows::*;
pub use sky::*;
pub use stats::*;
pub use types::*;
pub use version::*;
pub use view::*;
