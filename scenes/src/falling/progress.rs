//! How far a run is, and the time left, on stderr: a line that is written over on a terminal, else one every half minute.

use std::io::{IsTerminal, Write, stderr};
use std::time::{Duration, Instant};

/// Of the last step's time, so much counts in the mean: the time left follows a heap that grows.
const SHARE: f64 = 0.02;

pub(crate) struct Progress {
    is_terminal: bool,
    told: Instant,
    last: Instant,
    mean: Option<f64>,
}

impl Progress {
    pub(crate) fn new() -> Self {
        let now = Instant::now();
        Self {
            is_terminal: stderr().is_terminal(),
            told: now,
            last: now,
            mean: None,
        }
    }

    /// After each step, with all that belongs to it.
    pub(crate) fn tell(&mut self, step: u64, of: u64, bodies: usize, events: f64) {
        let now = Instant::now();
        let took = (now - self.last).as_secs_f64();
        self.last = now;
        let mean = self.mean.map_or(took, |mean| mean + SHARE * (took - mean));
        self.mean = Some(mean);
        let every = if self.is_terminal { 200 } else { 30_000 };
        if now - self.told < Duration::from_millis(every) {
            return;
        }
        self.told = now;
        let left = time(mean * of.saturating_sub(step) as f64);
        let line = format!("step {step} of {of}, {bodies} bodies, {events} events, {left} left");
        // Whoever closed stderr does not want to know.
        let _ = match self.is_terminal {
            true => write!(stderr(), "\r\x1b[K{line}"),
            false => writeln!(stderr(), "{line}"),
        };
    }

    /// Removes the line from a terminal.
    pub(crate) fn end(&self) {
        if self.is_terminal {
            let _ = write!(stderr(), "\r\x1b[K");
        }
    }
}

fn time(seconds: f64) -> String {
    let whole = seconds as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min", whole.div_ceil(60)),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn times_are_read_at_a_glance() {
        let all = [3.9, 61.0, 3599.0, 53_000.0].map(super::time);
        assert_eq!(all, ["3 s", "2 min", "60 min", "14 h 43 min"]);
    }
}
