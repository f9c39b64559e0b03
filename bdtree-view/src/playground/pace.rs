//! How simulated time follows the clock: whole steps, as many as are due, but not more than a frame can bear.

/// The most simulated time of a frame, seconds: ten steps of 1/150 s. Where steps and drawing take longer, time goes slower.
const FRAME_MAX_S: f64 = 1.0 / 15.0;

/// Part of the last frame in what is shown.
const SHARE: f64 = 0.1;

/// Time that goes on or halts, and how fast.
#[derive(Debug, Clone, PartialEq)]
pub struct Pace {
    /// Whether it goes on.
    pub is_running: bool,
    /// Simulated seconds per second; below 1: slow motion.
    pub speed: f64,
    step_s: f64,
    /// Simulated time that is due.
    owed_s: f64,
    /// Steps that were asked for one by one.
    single: usize,
    /// Simulated seconds per second of the last frames.
    reached: Option<f64>,
}

impl Pace {
    /// Of a world's steps.
    pub fn new(step_s: f64) -> Self {
        Self {
            is_running: true,
            speed: 1.0,
            step_s,
            owed_s: 0.0,
            single: 0,
            reached: None,
        }
    }

    /// Goes on or halts.
    pub fn toggle(&mut self) {
        self.is_running = !self.is_running;
    }

    /// Halts.
    pub fn halt(&mut self) {
        self.is_running = false;
        self.single = 0;
        self.owed_s = 0.0;
    }

    /// What is due of a step counts no more: the next frame begins one.
    pub fn forget(&mut self) {
        self.owed_s = 0.0;
    }

    /// Halts, and makes one step in the next frame.
    pub fn step_once(&mut self) {
        self.halt();
        self.single = 1;
    }

    /// The number of steps of a frame that comes `dt_s` seconds after the one before.
    pub fn due(&mut self, dt_s: f64) -> usize {
        let single = std::mem::take(&mut self.single);
        if !self.is_running {
            self.owed_s = 0.0;
            self.reached = None;
            return single;
        }
        let dt_s = if dt_s.is_finite() { dt_s.max(0.0) } else { 0.0 };
        let wanted = self.owed_s + dt_s * self.speed;
        let most = FRAME_MAX_S.max(self.step_s);
        let now = wanted.min(most);
        // A step that is due but for rounding is due.
        let count = (now / self.step_s + 1e-9).floor();
        // What a slow machine has not simulated by now it never will.
        self.owed_s = (now - count * self.step_s).max(0.0);
        if dt_s > 0.0 {
            let reached = count * self.step_s / dt_s;
            let mean = self.reached.unwrap_or(reached);
            self.reached = Some(mean + SHARE * (reached - mean));
        }
        count as usize + single
    }

    /// Whether steps come by themselves.
    pub fn is_moving(&self) -> bool {
        self.is_running || self.single > 0
    }

    /// Simulated seconds per second of the last frames; nothing while it halts.
    pub fn reached(&self) -> Option<f64> {
        self.reached
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 1.0 / 150.0;

    #[test]
    fn steps_follow_the_clock() {
        let mut pace = Pace::new(STEP);
        for _ in 0..10 {
            assert_eq!(
                pace.due(1.0 / 30.0),
                5,
                "five steps a frame at 30 frames a second"
            );
        }
        // At 60 frames a second two and three take turns.
        let counts: Vec<usize> = (0..60).map(|_| pace.due(1.0 / 60.0)).collect();
        assert_eq!(counts.iter().sum::<usize>(), 150);
        assert!(counts.iter().all(|n| (2..=3).contains(n)), "{counts:?}");
        let reached = pace.reached().expect("it goes on");
        assert!((reached - 1.0).abs() < 0.05, "{reached}");
        pace.speed = 0.1;
        let slow: usize = (0..60).map(|_| pace.due(1.0 / 60.0)).sum();
        assert_eq!(slow, 15);
    }

    #[test]
    fn a_slow_machine_is_slow_and_does_not_fall_behind() {
        let mut pace = Pace::new(STEP);
        for _ in 0..5 {
            assert_eq!(pace.due(2.0), 10, "not 300");
        }
        assert_eq!(pace.due(1.0 / 30.0), 5, "nothing is made up for");
        assert!(pace.reached().expect("it goes on") < 0.2);
        for odd in [f64::NAN, f64::INFINITY, -1.0] {
            assert_eq!(pace.due(odd), 0);
        }
        // Steps longer than a frame's most are made one at a time.
        assert_eq!(Pace::new(0.5).due(0.6), 1);
    }

    #[test]
    fn halted_it_steps_when_asked() {
        let mut pace = Pace::new(STEP);
        pace.toggle();
        assert!(!pace.is_moving());
        assert_eq!(pace.due(1.0), 0);
        pace.step_once();
        assert!(pace.is_moving());
        assert_eq!([pace.due(1.0), pace.due(1.0)], [1, 0]);
        pace.toggle();
        assert_eq!(
            pace.due(STEP),
            1,
            "time that passed meanwhile does not count"
        );
        pace.step_once();
        assert!(!pace.is_running, "a single step halts");
    }
}
