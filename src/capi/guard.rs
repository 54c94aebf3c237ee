//! The boundary: panics stop here, failures become a code, a text and a log line.

use super::handles::{self, State};
use super::types::*;
use crate::error::Error;
use ash::vk;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A refused or failed call: its code and its words.
#[derive(Clone, Debug)]
pub(super) struct Failure {
    pub code: BgiResult,
    pub text: String,
}

/// What the body of an exported function comes to.
pub(super) type Outcome = Result<BgiResult, Failure>;

impl Failure {
    pub fn new(code: BgiResult, text: impl Into<String>) -> Self {
        Self { code, text: text.into() }
    }

    pub fn argument(text: impl Into<String>) -> Self {
        Self::new(BGI_ERROR_INVALID_ARGUMENT, text)
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let code = match &error {
            Error::InvalidArgument(_) => BGI_ERROR_INVALID_ARGUMENT,
            Error::UnknownId(_) => BGI_ERROR_UNKNOWN_ID,
            Error::UnsupportedDevice(_) => BGI_ERROR_UNSUPPORTED_DEVICE,
            Error::OutOfMemory(_) => BGI_ERROR_OUT_OF_MEMORY,
            Error::Vulkan { result: vk::Result::ERROR_DEVICE_LOST, .. } => BGI_ERROR_DEVICE_LOST,
            Error::Vulkan {
                result: vk::Result::ERROR_OUT_OF_HOST_MEMORY | vk::Result::ERROR_OUT_OF_DEVICE_MEMORY,
                ..
            } => BGI_ERROR_OUT_OF_MEMORY,
            Error::Vulkan { .. } => BGI_ERROR_VULKAN,
        };
        Self::new(code, error.to_string())
    }
}

thread_local! {
    static LAST_ERROR: RefCell<String> = const { RefCell::new(String::new()) };
}

/// The text of this thread's latest failed call.
pub(super) fn thread_error() -> String {
    LAST_ERROR.try_with(|text| text.borrow().clone()).unwrap_or_default()
}

/// Runs the body of an exported function that has no context.
pub(super) fn guard(body: impl FnOnce() -> Outcome) -> BgiResult {
    match attempt(body) {
        Ok(code) => code,
        Err(failure) => {
            // A thread that is being torn down has nobody left to read the text.
            let _ = LAST_ERROR.try_with(|text| *text.borrow_mut() = failure.text);
            failure.code
        }
    }
}

/// Runs the body of an exported function on a live context, alone: other calls on that context wait.
pub(super) fn guard_context(handle: BgiContext, body: impl FnOnce(&mut State) -> Outcome) -> BgiResult {
    guard(|| {
        let entry = handles::find(handle)?;
        let mut warnings = Vec::new();
        let outcome = attempt(|| {
            entry.with_state(|state| {
                let outcome = body(state);
                warnings = state.context.take_warnings();
                outcome
            })
        });
        // The lock has been let go of, so that a log callback may call the library.
        warnings.iter().for_each(|text| entry.warn(text));
        outcome.inspect_err(|failure| entry.report(failure))
    })
}

fn attempt(body: impl FnOnce() -> Outcome) -> Outcome {
    // Unwind safety: a context whose call panicked is poisoned by its own mutex and refuses every later call.
    catch_unwind(AssertUnwindSafe(body)).unwrap_or_else(|payload| {
        let text = payload.downcast_ref::<&str>().copied();
        let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message");
        Err(Failure::new(BGI_ERROR_INTERNAL, format!("internal fault: {text}")))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panic_becomes_a_code_and_a_text() {
        assert_eq!(guard(|| panic!("brick {} is on fire", 7)), BGI_ERROR_INTERNAL);
        assert!(thread_error().contains("brick 7 is on fire"));
    }

    #[test]
    fn vulkan_failures_keep_their_meaning() {
        let code = |result| Failure::from(Error::Vulkan { call: "vkTest", result }).code;
        assert_eq!(code(vk::Result::ERROR_DEVICE_LOST), BGI_ERROR_DEVICE_LOST);
        assert_eq!(code(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY), BGI_ERROR_OUT_OF_MEMORY);
        assert_eq!(code(vk::Result::ERROR_OUT_OF_HOST_MEMORY), BGI_ERROR_OUT_OF_MEMORY);
        assert_eq!(code(vk::Result::ERROR_INITIALIZATION_FAILED), BGI_ERROR_VULKAN);
    }
}
