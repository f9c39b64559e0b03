//! Whoever answers the questions of a workload, one adapter per contender and workload.

pub mod assets;
pub mod ours;
pub mod paper;
pub mod refitting;
pub mod spheres;

use bdtree_measure::clock::Clock;
use bdtree_measure::peers::Update;
use bdtree_measure::turns::Frame;

/// A frame of what was brought up to date in this time, and is asked now: what is found counts.
fn frame(update: Update, ask: impl FnOnce() -> usize) -> Frame {
    let start = Clock::start();
    let found = ask() as u64;
    Frame {
        update,
        query: start.seconds(),
        found,
        ..Frame::default()
    }
}
