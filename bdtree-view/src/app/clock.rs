//! Time that passes and halts, for frames as for clips.

/// A moment of what begins again when it ends.
#[derive(Debug, Clone)]
pub struct Clock {
    /// Whether time goes on.
    pub is_playing: bool,
    /// 1: as fast as the file says.
    pub speed: f64,
    /// Seconds since the beginning.
    pub time_s: f64,
}

impl Clock {
    /// At the beginning, halted.
    pub(super) fn new() -> Self {
        Self {
            is_playing: false,
            speed: 1.0,
            time_s: 0.0,
        }
    }

    /// Lets `dt_s` seconds pass, if it is playing, of what lasts `duration_s`: after the end comes the beginning. Returns
    /// whether another moment is shown.
    pub(super) fn advance(&mut self, dt_s: f64, duration_s: f64) -> bool {
        let step = dt_s * self.speed;
        if !self.is_playing || !(duration_s > 0.0) || !step.is_finite() {
            return false;
        }
        let before = self.time_s;
        self.time_s = (self.time_s + step).rem_euclid(duration_s);
        self.time_s != before
    }
}
