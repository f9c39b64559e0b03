//! What threads work with, and how they share work: each takes the next group, and nothing depends on which thread had it.

use alloc::vec::Vec;

use bdtree_runtime::{Contact, ContactManifold, LaneId, LaneTriangle, Workspace};

use super::regions::Point;
use super::surface::Scratch;

/// What one thread works with.
#[derive(Debug)]
pub(super) struct Worker {
    pub(super) workspace: Workspace<'static>,
    pub(super) lanes: Vec<LaneId>,
    pub(super) pairs: Vec<[LaneId; 2]>,
    pub(super) lane_triangles: Vec<LaneTriangle>,
    pub(super) manifolds: Vec<ContactManifold>,
    pub(super) triangles: Vec<Contact>,
    pub(super) points: Vec<Point>,
    pub(super) scratch: Scratch,
}

impl Default for Worker {
    fn default() -> Self {
        Self {
            workspace: Workspace::new(),
            lanes: Vec::new(),
            pairs: Vec::new(),
            lane_triangles: Vec::new(),
            manifolds: Vec::new(),
            triangles: Vec::new(),
            points: Vec::new(),
            scratch: Scratch::default(),
        }
    }
}

/// A clock; without std it stands still.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock {
    #[cfg(feature = "std")]
    start: std::time::Instant,
}

impl Clock {
    pub(super) fn start() -> Self {
        Self {
            #[cfg(feature = "std")]
            start: std::time::Instant::now(),
        }
    }

    pub(super) fn seconds(self) -> f64 {
        #[cfg(feature = "std")]
        return self.start.elapsed().as_secs_f64();
        #[cfg(not(feature = "std"))]
        0.0
    }
}

/// Calls `work` with each item and the worker that has taken it.
#[cfg(feature = "threads")]
pub(super) fn each<T: Send>(
    workers: &mut [Worker],
    items: impl Iterator<Item = T> + Send,
    work: impl Fn(&mut Worker, T) + Sync,
) {
    let Some((worker, others)) = workers.split_first_mut() else {
        return;
    };
    if others.is_empty() {
        items.for_each(|item| work(worker, item));
        return;
    }
    let items = Lock::new(items);
    let take_all = |worker: &mut Worker| {
        while let Some(item) = items.with(Iterator::next) {
            work(worker, item);
        }
    };
    std::thread::scope(|scope| {
        for other in others {
            scope.spawn(|| take_all(other));
        }
        take_all(worker);
    });
}

/// Calls `work` with each item.
#[cfg(not(feature = "threads"))]
pub(super) fn each<T>(
    workers: &mut [Worker],
    items: impl Iterator<Item = T>,
    work: impl Fn(&mut Worker, T),
) {
    if let Some(worker) = workers.first_mut() {
        items.for_each(|item| work(worker, item));
    }
}

/// A value that threads take in turns; without std there is one thread.
#[derive(Debug, Default)]
pub(super) struct Lock<T> {
    #[cfg(feature = "std")]
    inner: std::sync::Mutex<T>,
    #[cfg(not(feature = "std"))]
    inner: core::cell::RefCell<T>,
}

#[cfg(feature = "std")]
impl<T> Lock<T> {
    pub(super) fn new(value: T) -> Self {
        Self {
            inner: std::sync::Mutex::new(value),
        }
    }

    pub(super) fn get_mut(&mut self) -> &mut T {
        match self.inner.get_mut() {
            Ok(value) => value,
            Err(poisoned) => poisoned.into_inner(),
        }
    }

    /// The value, when no other thread has it any more.
    #[cfg(feature = "threads")]
    pub(super) fn with<R>(&self, use_it: impl FnOnce(&mut T) -> R) -> R {
        let mut guard = match self.inner.lock() {
            Ok(guard) => guard,
            Err(poisoned) => poisoned.into_inner(),
        };
        use_it(&mut guard)
    }

    /// The value, unless another thread has it.
    pub(super) fn get(&self) -> Option<std::sync::MutexGuard<'_, T>> {
        self.inner.try_lock().ok()
    }
}

#[cfg(not(feature = "std"))]
impl<T> Lock<T> {
    pub(super) fn new(value: T) -> Self {
        Self {
            inner: core::cell::RefCell::new(value),
        }
    }

    pub(super) fn get_mut(&mut self) -> &mut T {
        self.inner.get_mut()
    }

    /// The value, unless it is in use.
    pub(super) fn get(&self) -> Option<core::cell::RefMut<'_, T>> {
        self.inner.try_borrow_mut().ok()
    }
}

/// Where threads wait for each other: a few thousand times in a step, so that they spin for a moment before they sleep.
#[cfg(feature = "threads")]
#[derive(Debug)]
pub(super) struct Barrier {
    count: usize,
    arrived: core::sync::atomic::AtomicUsize,
    round: core::sync::atomic::AtomicUsize,
}

#[cfg(feature = "threads")]
impl Barrier {
    pub(super) fn new(count: usize) -> Self {
        Self {
            count,
            arrived: core::sync::atomic::AtomicUsize::new(0),
            round: core::sync::atomic::AtomicUsize::new(0),
        }
    }

    /// Returns when all threads have come here; the last one calls `alone` before the others go on.
    pub(super) fn wait(&self, alone: impl FnOnce()) {
        use core::sync::atomic::Ordering::{AcqRel, Acquire, Relaxed, Release};
        const SPINS: usize = 4000;
        let round = self.round.load(Acquire);
        if self.arrived.fetch_add(1, AcqRel) + 1 == self.count {
            alone();
            self.arrived.store(0, Relaxed);
            self.round.store(round.wrapping_add(1), Release);
            return;
        }
        let mut spins = 0;
        while self.round.load(Acquire) == round {
            if spins < SPINS {
                spins += 1;
                core::hint::spin_loop();
            } else {
                std::thread::yield_now();
            }
        }
    }
}
