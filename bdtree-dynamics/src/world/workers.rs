//! What threads work with, and how work is shared: each takes the next part of the tasks, and results are put together in
//! their order, so that they do not depend on the number of threads. A cache serves the thread that has its body; it changes
//! no result either.

use alloc::vec::Vec;

use bdtree_runtime::{LaneId, Workspace};

use super::contact::Contact;
use crate::error::DynamicsError;

#[derive(Debug)]
pub(super) struct Worker {
    pub(super) workspace: Workspace<'static>,
    pub(super) lanes: Vec<LaneId>,
    pub(super) pairs: Vec<[LaneId; 2]>,
    pub(super) contacts: Vec<Contact>,
    pub(super) candidates: u64,
    pub(super) nodes_visited: u64,
    pub(super) nodes_updated: u64,
    pub(super) error: Option<DynamicsError>,
}

impl Default for Worker {
    fn default() -> Self {
        Self {
            workspace: Workspace::new(),
            lanes: Vec::new(),
            pairs: Vec::new(),
            contacts: Vec::new(),
            candidates: 0,
            nodes_visited: 0,
            nodes_updated: 0,
            error: None,
        }
    }
}

/// Calls `work` with each worker, its part of the tasks and the caches of the bodies that are first in them. Tasks are sorted
/// by their first body; `first` says which it is.
pub(super) fn share<T: Sync, C: Send>(
    workers: &mut [Worker],
    tasks: &[T],
    caches: &mut [C],
    first: impl Fn(&T) -> usize,
    work: impl Fn(&mut Worker, &[T], Own<'_, C>) + Sync,
) {
    #[cfg(feature = "threads")]
    if workers.len() > 1 {
        let each = tasks.len().div_ceil(workers.len()).max(1);
        std::thread::scope(|scope| {
            let (mut tasks, mut caches, mut begin) = (tasks, caches, 0);
            for worker in workers {
                // All tasks of a body go to the same worker.
                let mut count = each.min(tasks.len());
                while count > 0
                    && count < tasks.len()
                    && first(&tasks[count]) == first(&tasks[count - 1])
                {
                    count += 1;
                }
                let (part, rest) = tasks.split_at(count);
                let end = rest.first().map_or(begin + caches.len(), &first);
                let (own, others) = core::mem::take(&mut caches).split_at_mut(end - begin);
                let own = Own {
                    first: begin,
                    caches: own,
                };
                (tasks, caches, begin) = (rest, others, end);
                let work = &work;
                scope.spawn(move || work(worker, part, own));
            }
        });
        return;
    }
    let _ = first;
    if let Some(worker) = workers.first_mut() {
        work(worker, tasks, Own { first: 0, caches });
    }
}

/// The caches of consecutive bodies.
pub(super) struct Own<'c, C> {
    first: usize,
    caches: &'c mut [C],
}

impl<C> Own<'_, C> {
    /// Those of two bodies, as far as they are here.
    pub(super) fn both(&mut self, [a, b]: [usize; 2]) -> [Option<&mut C>; 2] {
        let [a, b] = [a, b].map(|body| {
            body.checked_sub(self.first)
                .filter(|at| *at < self.caches.len())
        });
        match (a, b) {
            (Some(a), Some(b)) => match self.caches.get_disjoint_mut([a, b]) {
                Ok([a, b]) => [Some(a), Some(b)],
                Err(_) => [None, None],
            },
            (Some(a), None) => [self.caches.get_mut(a), None],
            (None, Some(b)) => [None, self.caches.get_mut(b)],
            (None, None) => [None, None],
        }
    }
}
