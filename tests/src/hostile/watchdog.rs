//! A thread that ends the process when a case takes too long: a hang cannot be caught any other way.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Nothing is being examined.
const IDLE: u64 = u64::MAX;

/// What a worker is at: the case, and when it began.
#[derive(Debug)]
struct Work {
    case: AtomicU64,
    /// Milliseconds since the watchdog was set.
    since: AtomicU64,
}

/// Watches workers; ends when it is dropped.
#[derive(Debug)]
pub struct Watchdog {
    begin: Instant,
    works: Arc<Vec<Work>>,
    end: Arc<(Mutex<bool>, Condvar)>,
    thread: Option<JoinHandle<()>>,
}

impl Watchdog {
    /// Watches `workers` workers, none of which may stay at one case for longer than `limit`; after
    /// that the process says which case it was and ends with code 2.
    pub fn set(workers: usize, limit: Duration) -> Self {
        let begin = Instant::now();
        let work = || Work {
            case: AtomicU64::new(IDLE),
            since: AtomicU64::new(0),
        };
        let works: Arc<Vec<Work>> = Arc::new((0..workers).map(|_| work()).collect());
        let end = Arc::new((Mutex::new(false), Condvar::new()));
        let (watched, ended) = (Arc::clone(&works), Arc::clone(&end));
        let thread = std::thread::spawn(move || {
            let (lock, condition) = &*ended;
            let mut done = lock.lock().expect("no worker holds it while it panics");
            while !*done {
                let wait = condition.wait_timeout(done, limit / 8);
                done = wait.expect("as above").0;
                for work in &*watched {
                    let case = work.case.load(Ordering::Acquire);
                    let since = Duration::from_millis(work.since.load(Ordering::Acquire));
                    if case != IDLE && begin.elapsed().saturating_sub(since) > limit {
                        eprintln!("case {case} has taken longer than {limit:?}");
                        std::process::exit(2);
                    }
                }
            }
        });
        Self {
            begin,
            works,
            end,
            thread: Some(thread),
        }
    }

    /// Notes that a worker begins a case.
    pub fn begin(&self, worker: usize, case: u64) {
        let now = self.begin.elapsed().as_millis() as u64;
        self.works[worker].since.store(now, Ordering::Release);
        self.works[worker].case.store(case, Ordering::Release);
    }

    /// Notes that a worker has ended its case.
    pub fn end(&self, worker: usize) {
        self.works[worker].case.store(IDLE, Ordering::Release);
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        if let Ok(mut done) = self.end.0.lock() {
            *done = true;
        }
        self.end.1.notify_all();
        if let Some(thread) = self.thread.take() {
            // It cannot have panicked without the process's end.
            let _ = thread.join();
        }
    }
}
