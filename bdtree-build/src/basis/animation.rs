//! q over time: what the file's animation sections hold.

/// The frames of an animation in reduced coordinates.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Animation {
    /// Number of frames T.
    pub frame_count: usize,
    /// Seconds of each frame, ascending (equal neighbours allowed); `None` where the source does
    /// not say.
    pub times_s: Option<Vec<f64>>,
    /// `q[t * M + j]` is q_j of frame t; M is the basis's number of modes.
    pub q: Vec<f64>,
    /// The rigid motion that was taken out of each frame and that playback puts back; empty when
    /// none was.
    pub motions: Vec<RigidMotion>,
}

/// x ↦ R x + t, in mesh units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidMotion {
    /// R as a unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
    /// t.
    pub translation: [f64; 3],
}

impl RigidMotion {
    /// No motion.
    pub const IDENTITY: Self = Self {
        rotation: [0.0, 0.0, 0.0, 1.0],
        translation: [0.0; 3],
    };
}
