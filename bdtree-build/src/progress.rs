//! How a long bake tells its caller where it is: libraries print nothing.

/// Receives the stages of a bake as they begin. Called from the baking thread only.
pub trait Progress {
    /// A stage begins. `steps` is how many [`Progress::advance`] steps it will take, if known.
    fn stage(&self, name: &str, steps: Option<u64>);
    /// The current stage has done `steps` more.
    fn advance(&self, steps: u64);
}

/// Ignores all progress.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn stage(&self, _name: &str, _steps: Option<u64>) {}
    fn advance(&self, _steps: u64) {}
}
