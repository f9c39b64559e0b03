//! Work that does not depend on its order, on several threads.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

use crate::progress::{Progress, Silent};

/// Calls `work` for each of `jobs`, on a thread for each of `states` at most. Jobs begin in their order: with the
/// longest first, threads end at about the same time.
pub(crate) fn for_each<J: Send, S: Send>(
    jobs: impl ExactSizeIterator<Item = J> + Send,
    states: &mut [S],
    work: impl Fn(&mut S, J) + Sync,
) {
    for_each_told(jobs, states, work, &Silent);
}

/// [`for_each`] that advances `progress`, from the calling thread, by a step for each job.
pub(crate) fn for_each_told<J: Send, S: Send>(
    jobs: impl ExactSizeIterator<Item = J> + Send,
    states: &mut [S],
    work: impl Fn(&mut S, J) + Sync,
    progress: &dyn Progress,
) {
    let threads = states.len().min(jobs.len());
    let Some((own, others)) = states[..threads].split_first_mut() else {
        return;
    };
    if others.is_empty() {
        for job in jobs {
            work(own, job);
            progress.advance(1);
        }
        return;
    }
    let jobs = Mutex::new(jobs);
    let take = || jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
    // What other threads have done since the calling one last told.
    let done = AtomicU64::new(0);
    std::thread::scope(|scope| {
        for state in others {
            scope.spawn(|| {
                while let Some(job) = take() {
                    work(state, job);
                    done.fetch_add(1, Relaxed);
                }
            });
        }
        while let Some(job) = take() {
            work(own, job);
            progress.advance(1 + done.swap(0, Relaxed));
        }
    });
    progress.advance(done.into_inner());
}

/// A state for each of `threads` threads, one at least.
pub(crate) fn states<S>(threads: usize, state: impl Fn() -> S) -> Vec<S> {
    (0..threads.max(1)).map(|_| state()).collect()
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::{Progress, for_each_told, states};

    #[test]
    fn every_job_is_told_once() {
        struct Told(Cell<u64>);
        impl Progress for Told {
            fn stage(&self, _: &str, _: Option<u64>) {}
            fn advance(&self, steps: u64) {
                self.0.set(self.0.get() + steps);
            }
        }
        for threads in [1, 2, 5] {
            let told = Told(Cell::new(0));
            let mut sums = states(threads, || 0_u64);
            let add = |sum: &mut u64, job: u32| *sum += u64::from(job);
            for_each_told(0..1000_u32, &mut sums, add, &told);
            assert_eq!((told.0.get(), sums.iter().sum::<u64>()), (1000, 499_500));
        }
    }
}
