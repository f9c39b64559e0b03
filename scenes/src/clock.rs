//! Time that a busy machine does not take away.

use std::time::Instant;

use cpu_time::ThreadTime;

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

    /// Seconds since the start.
    pub fn seconds(&self) -> f64 {
        let wall = self.wall.elapsed();
        wall.min(self.thread.elapsed()).as_secs_f64()
    }
}
