//! Time that a busy machine does not take away.

use std::sync::OnceLock;
use std::time::Instant;

use cpu_time::ThreadTime;

use crate::stats::median;

/// Measures from where it is started.
///
/// Two clocks run: the thread's own, which stands while others have the processor but takes a
/// fraction of a microsecond to read, and the wall's. The lesser is right: the thread's for long
/// spans, the wall's for short ones, which are seldom interrupted.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    thread: ThreadTime,
    wall: Instant,
}

impl Clock {
    /// Begins now.
    pub fn start() -> Self {
        Self {
            thread: ThreadTime::now(),
            wall: Instant::now(),
        }
    }

    /// Seconds since the start, without what looking at the clocks takes.
    pub fn seconds(&self) -> f64 {
        (self.with_reading() - own_time()).max(0.0)
    }

    fn with_reading(&self) -> f64 {
        let wall = self.wall.elapsed();
        wall.min(self.thread.elapsed()).as_secs_f64()
    }
}

/// What a span takes in which nothing happens: the median of many, measured once.
fn own_time() -> f64 {
    const SPANS: usize = 1001;
    static OWN: OnceLock<f64> = OnceLock::new();
    *OWN.get_or_init(|| {
        let spans: Vec<f64> = (0..SPANS).map(|_| Clock::start().with_reading()).collect();
        median(&spans)
    })
}
