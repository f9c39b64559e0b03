//! A case that does not end: a line that names it, and the end of the process.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::{Case, Limits};

/// Watches the thread that made it.
pub(super) struct Watch {
    current: Arc<Mutex<Option<(Case, Instant)>>>,
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Watch {
    pub(super) fn new() -> Self {
        let current = Arc::new(Mutex::new(None::<(Case, Instant)>));
        let over = Arc::new(AtomicBool::new(false));
        let (seen, end) = (Arc::clone(&current), Arc::clone(&over));
        let thread = std::thread::spawn(move || {
            while !end.load(Ordering::Relaxed) {
                std::thread::park_timeout(Duration::from_millis(500));
                let now = *seen.lock().unwrap_or_else(PoisonError::into_inner);
                if let Some((case, since)) = now
                    && since.elapsed().as_secs() > Limits::HANG_SECONDS
                {
                    eprintln!("{case}: hangs");
                    std::process::abort();
                }
            }
        });
        Self {
            current,
            over,
            thread: Some(thread),
        }
    }

    /// From now on this case.
    pub(super) fn begin(&self, case: Case) {
        let mut current = self.current.lock().unwrap_or_else(PoisonError::into_inner);
        *current = Some((case, Instant::now()));
    }

    /// Nothing runs.
    pub(super) fn end(&self) {
        *self.current.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            let _ = thread.join();
        }
    }
}
