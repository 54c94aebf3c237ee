//! The host's threads.

use super::types::*;
use crate::parallel::ParallelFor;
use std::ffi::c_void;
use std::sync::Arc;

/// What a task's data leads to.
type Task<'a> = &'a (dyn Fn(u32) + Sync);

/// The host's user data.
struct UserData(*mut c_void);

// SAFETY: it is never read here, only handed back on the thread that calls the library.
unsafe impl Send for UserData {}
// SAFETY: as above; a context's calls wait for each other.
unsafe impl Sync for UserData {}

/// The callback as the core takes it.
pub(super) fn parallel_for(callback: BgiParallelFor, user_data: *mut c_void) -> Option<ParallelFor> {
    let (callback, user_data) = (callback?, UserData(user_data));
    Some(Arc::new(move |count, task: Task| {
        let UserData(user_data) = &user_data;
        // SAFETY: the header's contract: all calls of `run` return before the callback does, while `task` lives.
        unsafe { callback(*user_data, count, run, (&raw const task).cast_mut().cast()) };
    }))
}

/// Panics do not come here: the core catches them in the task.
unsafe extern "C" fn run(task: *mut c_void, index: u32) {
    // SAFETY: `parallel_for` hands out a pointer to a `Task` that lives until its callback returns.
    let task = unsafe { *task.cast::<Task>() };
    task(index);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel::Workers;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// Threads of a host, which counts the calls.
    unsafe extern "C" fn host(calls: *mut c_void, count: u32, task: BgiTask, task_data: *mut c_void) {
        // SAFETY: the test hands out a counter that outlives the call.
        unsafe { &*calls.cast::<AtomicU32>() }.fetch_add(1, Ordering::Relaxed);
        let task_data = &UserData(task_data);
        std::thread::scope(|scope| {
            for first in 0..3 {
                scope.spawn(move || {
                    let UserData(task_data) = task_data;
                    for index in (first..count).step_by(3) {
                        // SAFETY: before the callback returns, and with the data that came with the task.
                        unsafe { task(*task_data, index) };
                    }
                });
            }
        });
    }

    #[test]
    fn work_is_done_on_the_hosts_threads() {
        let calls = AtomicU32::new(0);
        let workers = Workers(parallel_for(Some(host), std::ptr::from_ref(&calls).cast_mut().cast()));
        let own = std::thread::current().id();
        let made = workers.map(500, |i| (i * 3, std::thread::current().id() != own));
        assert!(made.into_iter().enumerate().all(|(i, made)| made == (i * 3, true)));
        assert_eq!(calls.into_inner(), 1);
        assert!(parallel_for(None, std::ptr::null_mut()).is_none());
    }
}
