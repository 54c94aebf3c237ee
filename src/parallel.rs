//! Work spread over the host's threads.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Calls the task once for each index below the count, on any threads and in any order, and returns when all calls have.
pub type ParallelFor = Arc<dyn Fn(u32, &(dyn Fn(u32) + Sync)) + Send + Sync>;

/// The host's threads, or the calling one.
#[derive(Clone, Default)]
pub struct Workers(pub Option<ParallelFor>);

impl Workers {
    /// What `make` makes of each index, in their order. A panic is the caller's.
    pub fn map<R: Send>(&self, count: usize, make: impl Fn(usize) -> R + Sync) -> Vec<R> {
        let Some(parallel_for) = self.0.as_ref().filter(|_| count > 1) else { return (0..count).map(make).collect() };
        let taken: Vec<AtomicBool> = (0..count).map(|_| AtomicBool::new(false)).collect();
        let results: Vec<Mutex<Option<std::thread::Result<R>>>> = (0..count).map(|_| Mutex::new(None)).collect();
        let task = |index: u32| {
            let index = index as usize;
            // An index that is none, or that has been given before, is not the host's to give.
            if taken.get(index).is_some_and(|taken| !taken.swap(true, Ordering::Relaxed)) {
                let result = catch_unwind(AssertUnwindSafe(|| make(index)));
                *results[index].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            }
        };
        parallel_for(count as u32, &task);
        // Those that the host forgot.
        (0..count as u32).for_each(&task);
        let result = |slot: Mutex<_>| slot.into_inner().unwrap_or_else(PoisonError::into_inner);
        let made = results.into_iter().map(|slot| result(slot).expect("every index has been taken"));
        made.map(|made| made.unwrap_or_else(|panic| resume_unwind(panic))).collect()
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use std::sync::atomic::AtomicU32;

    /// As a host may do it: some threads that take the next index.
    pub fn threads(count: u32) -> Workers {
        Workers(Some(Arc::new(move |tasks, task| {
            let next = AtomicU32::new(0);
            std::thread::scope(|scope| {
                for _ in 0..count {
                    scope.spawn(|| {
                        loop {
                            match next.fetch_add(1, Ordering::Relaxed) {
                                index if index < tasks => task(index),
                                _ => break,
                            }
                        }
                    });
                }
            });
        })))
    }

    #[test]
    fn results_are_in_order() {
        let squares: Vec<usize> = (0..1000).map(|i| i * i).collect();
        for workers in [Workers::default(), threads(1), threads(4)] {
            assert_eq!(workers.map(1000, |i| i * i), squares);
        }
    }

    #[test]
    fn a_careless_host_changes_nothing() {
        let careless: ParallelFor = Arc::new(|count, task| [count, 7, 7, u32::MAX].into_iter().for_each(task));
        assert_eq!(Workers(Some(careless)).map(10, |i| i), (0..10).collect::<Vec<_>>());
    }

    #[test]
    fn a_panic_reaches_the_caller_once_all_is_done() {
        let done = AtomicU32::new(0);
        let run = || {
            threads(3).map(100, |i| {
                done.fetch_add(1, Ordering::Relaxed);
                assert_ne!(i, 50, "the fiftieth");
            })
        };
        let panic = catch_unwind(AssertUnwindSafe(run)).expect_err("a panic");
        assert!(panic.downcast_ref::<String>().is_some_and(|text| text.contains("the fiftieth")));
        assert_eq!(done.into_inner(), 100);
    }
}
