//! The registry of live contexts. A handle is a token that is looked up here and never dereferenced, so that a stale,
//! foreign or made-up one is an error and not a crash.

use super::guard::{Failure, Outcome};
use super::types::*;
use crate::context::{Context, ViewId};
use std::collections::BTreeMap;
use std::ffi::{CString, c_void};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

/// What calls on a context work with.
pub(super) struct State {
    pub context: Context,
    views: BTreeMap<usize, ViewId>,
}

impl State {
    pub fn new(context: Context) -> Self {
        Self { context, views: BTreeMap::new() }
    }

    /// Makes a handle for a new view.
    pub fn insert_view(&mut self, view: ViewId) -> BgiView {
        let token = next_token();
        self.views.insert(token, view);
        std::ptr::without_provenance_mut(token)
    }

    /// The view of a handle of this context.
    pub fn view(&self, handle: BgiView) -> Result<ViewId, Failure> {
        self.views.get(&handle.addr()).copied().ok_or_else(|| {
            let what = if handle.is_null() { "view is NULL" } else { "view is not a live view of this context" };
            Failure::new(BGI_ERROR_INVALID_HANDLE, what)
        })
    }

    /// Forgets the handle of a destroyed view.
    pub fn remove_view(&mut self, handle: BgiView) {
        self.views.remove(&handle.addr());
    }
}

/// The host's log callback; may be called from any thread that calls the library.
#[derive(Clone, Copy)]
pub(super) struct Log {
    callback: BgiLogCallback,
    user_data: *mut c_void,
}

// SAFETY: the user data is never read here, only handed back; the header tells the host on which threads.
unsafe impl Send for Log {}
// SAFETY: as above.
unsafe impl Sync for Log {}

impl Log {
    pub fn new(callback: BgiLogCallback, user_data: *mut c_void) -> Self {
        Self { callback, user_data }
    }

    pub fn line(&self, severity: BgiLogSeverity, text: &str) {
        let Some(callback) = self.callback else { return };
        let text = CString::new(text.replace(['\0', '\n'], " ")).unwrap_or_default();
        // SAFETY: the host handed in this function with this user data; the text outlives the call.
        unsafe { callback(self.user_data, severity, text.as_ptr()) }
    }
}

/// A live context. `state` is empty once it is being destroyed.
pub(super) struct Entry {
    state: Mutex<Option<State>>,
    last_error: Mutex<String>,
    log: Log,
}

impl Entry {
    /// Runs `body` on the context, alone.
    pub fn with_state(&self, body: impl FnOnce(&mut State) -> Outcome) -> Outcome {
        let mut state = self.state.lock().map_err(|_| {
            Failure::new(BGI_ERROR_INTERNAL, "an earlier call on this context hit an internal fault: destroy it")
        })?;
        body(state.as_mut().ok_or_else(unknown_context)?)
    }

    /// Makes a failure this context's last error and logs it.
    pub fn report(&self, failure: &Failure) {
        self.last_error.lock().unwrap_or_else(PoisonError::into_inner).clone_from(&failure.text);
        self.log.line(BGI_LOG_ERROR, &failure.text);
    }

    /// Logs what is not a failure.
    pub fn warn(&self, text: &str) {
        self.log.line(BGI_LOG_WARNING, text);
    }

    /// The text of the latest failed call on this context.
    pub fn last_error(&self) -> String {
        self.last_error.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

static CONTEXTS: RwLock<BTreeMap<usize, Arc<Entry>>> = RwLock::new(BTreeMap::new());

/// Registers a new context.
pub(super) fn insert(state: State, log: Log) -> BgiContext {
    let token = next_token();
    let entry = Entry { state: Mutex::new(Some(state)), last_error: Mutex::default(), log };
    CONTEXTS.write().unwrap_or_else(PoisonError::into_inner).insert(token, Arc::new(entry));
    std::ptr::without_provenance_mut(token)
}

/// Looks a handle up.
pub(super) fn find(handle: BgiContext) -> Result<Arc<Entry>, Failure> {
    if handle.is_null() {
        return Err(Failure::new(BGI_ERROR_INVALID_HANDLE, "context is NULL"));
    }
    let contexts = CONTEXTS.read().unwrap_or_else(PoisonError::into_inner);
    contexts.get(&handle.addr()).cloned().ok_or_else(unknown_context)
}

/// Ends a handle; waits for calls on other threads, then drops the context, a poisoned one too.
pub(super) fn remove(handle: BgiContext) -> Result<(), Failure> {
    let entry = find(handle)?;
    let removed = CONTEXTS.write().unwrap_or_else(PoisonError::into_inner).remove(&handle.addr());
    removed.ok_or_else(unknown_context)?;
    let state = entry.state.lock().unwrap_or_else(PoisonError::into_inner).take();
    drop(state);
    Ok(())
}

fn unknown_context() -> Failure {
    Failure::new(BGI_ERROR_INVALID_HANDLE, "context is not a live context: never created, or destroyed already")
}

/// A number that no handle has had before. Multiplying by an odd constant is one-to-one and scatters the tokens, so
/// that small integers and stray addresses do not meet one by chance.
fn next_token() -> usize {
    static NEXT: AtomicUsize = AtomicUsize::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed).wrapping_mul(0x9e37_79b9_7f4a_7c15_u64 as usize)
}
