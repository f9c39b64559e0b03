//! The file's animation in time.
//!
//! What lies between two frames is the runtime's ([`Asset::sample_between`]); here is when each is shown, also
//! where the file does not say. Every frame's q is within the limits, so what lies between is too.

use bdtree_runtime::{Asset, Transform};

use super::clock::Clock;

/// Frames per second where the file does not say when frames are shown.
pub(super) const FRAMES_PER_S: f64 = 30.0;

/// Where in the animation we are.
#[derive(Debug, Clone)]
pub struct Playback {
    /// When each frame is shown, in seconds, ascending from 0.
    times_s: Vec<f64>,
    /// Whether the file says when frames are shown.
    pub is_timed: bool,
    /// The moment; it begins with the first frame.
    pub clock: Clock,
}

impl Playback {
    /// At the first frame, halted.
    pub fn new(asset: &Asset<'_>) -> Self {
        let count = asset.frame_count();
        let of_file = (0..count).map(|i| asset.frame(i)?.time_s());
        Self::of_times(of_file.collect::<Option<Vec<f64>>>(), count)
    }

    fn of_times(of_file: Option<Vec<f64>>, count: usize) -> Self {
        // In a file that nobody has verified times may be anything.
        let is_sound = |times: &Vec<f64>| {
            times.iter().all(|t| t.is_finite()) && times.windows(2).all(|t| t[0] <= t[1])
        };
        let of_file = of_file.filter(is_sound);
        let is_timed = of_file.is_some();
        let mut times_s =
            of_file.unwrap_or_else(|| (0..count).map(|i| i as f64 / FRAMES_PER_S).collect());
        let first = times_s.first().copied().unwrap_or(0.0);
        times_s.iter_mut().for_each(|t| *t -= first);
        Self {
            times_s,
            is_timed,
            clock: Clock::new(),
        }
    }

    /// How many frames there are.
    pub fn frame_count(&self) -> usize {
        self.times_s.len()
    }

    /// When the last frame is shown, in seconds.
    pub fn duration_s(&self) -> f64 {
        self.times_s.last().copied().unwrap_or(0.0)
    }

    /// The frame that is shown and how far it is to the next one, 0 to 1.
    pub fn position(&self) -> (usize, f64) {
        let after = self.times_s.partition_point(|t| *t <= self.clock.time_s);
        let frame = after.saturating_sub(1);
        match (self.times_s.get(frame), self.times_s.get(frame + 1)) {
            (Some(from), Some(to)) => (
                frame,
                ((self.clock.time_s - from) / (to - from)).clamp(0.0, 1.0),
            ),
            _ => (frame, 0.0),
        }
    }

    /// Goes to a frame, to the last one where there are fewer.
    pub fn go_to(&mut self, frame: usize) {
        let last = self.times_s.len().saturating_sub(1);
        self.clock.time_s = self.times_s.get(frame.min(last)).copied().unwrap_or(0.0);
    }

    /// Lets `dt_s` seconds pass, if it is playing. Returns whether another moment is shown.
    pub fn advance(&mut self, dt_s: f64) -> bool {
        self.clock.advance(dt_s, self.duration_s())
    }

    /// q and the rigid motion of the moment; `None` where there is no frame.
    pub fn posture(&self, asset: &Asset<'_>) -> Option<(Vec<f32>, Transform)> {
        let (frame, share) = self.position();
        let next = (frame + 1).min(self.frame_count().saturating_sub(1));
        let mut q = vec![0.0; asset.mode_count()];
        let transform = asset.sample_between([frame, next], share, &mut q).ok()?;
        Some((q, transform))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_passes_at_the_files_pace_and_starts_again() {
        let mut playback = Playback::of_times(Some(vec![2.0, 2.5, 4.0]), 3);
        assert_eq!(playback.duration_s(), 2.0, "from the first frame on");
        assert!(!playback.advance(1.0), "halted");
        playback.clock.is_playing = true;
        assert!(playback.advance(0.25));
        assert_eq!(playback.position(), (0, 0.5));
        playback.clock.speed = 2.0;
        playback.advance(0.5);
        assert_eq!(playback.position(), (1, 0.5));
        playback.advance(0.5);
        assert_eq!(
            playback.position(),
            (0, 0.5),
            "after the end comes the beginning"
        );
        playback.clock.speed = -1.0;
        playback.advance(0.5);
        assert_eq!(playback.clock.time_s, 1.75, "backwards");
        playback.go_to(7);
        assert_eq!(playback.position(), (2, 0.0));
    }

    #[test]
    fn odd_times_are_not_taken() {
        for times in [None, Some(vec![0.0, f64::NAN]), Some(vec![1.0, 0.5])] {
            let playback = Playback::of_times(times, 2);
            assert!(!playback.is_timed);
            assert_eq!(playback.duration_s(), 1.0 / FRAMES_PER_S);
        }
        for times in [vec![], vec![3.0], vec![1.0, 1.0]] {
            let count = times.len();
            let mut playback = Playback::of_times(Some(times), count);
            playback.clock.is_playing = true;
            assert!(!playback.advance(1.0), "nothing moves");
            assert_eq!(playback.position().1, 0.0);
        }
    }
}
