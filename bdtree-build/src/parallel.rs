//! Work that does not depend on its order, on several threads.

use std::sync::{Mutex, PoisonError};

/// Calls `work` for each of `jobs`, on a thread for each of `states` at most. Jobs begin in their order: with the
/// longest first, threads end at about the same time.
pub(crate) fn for_each<J: Send, S: Send>(
    jobs: impl ExactSizeIterator<Item = J> + Send,
    states: &mut [S],
    work: impl Fn(&mut S, J) + Sync,
) {
    let threads = states.len().min(jobs.len());
    let Some((own, others)) = states[..threads].split_first_mut() else {
        return;
    };
    if others.is_empty() {
        jobs.for_each(|job| work(own, job));
        return;
    }
    let jobs = Mutex::new(jobs);
    let run = |state: &mut S| {
        let take = || jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
        while let Some(job) = take() {
            work(state, job);
        }
    };
    std::thread::scope(|scope| {
        for state in others {
            scope.spawn(|| run(state));
        }
        run(own);
    });
}

/// A state for each of `threads` threads, one at least.
pub(crate) fn states<S>(threads: usize, state: impl Fn() -> S) -> Vec<S> {
    (0..threads.max(1)).map(|_| state()).collect()
}
