//! Whether an asset's bounds hold, tried: every deformed vertex against the spheres above it, at q
//! that is made to break them, decided in exact arithmetic.
//!
//! A *case* is a node at a q and, with a skin, bones of eight kinds. Half of them are sweeps: hard q of nine kinds, nodes in order, all
//! vertices below all lanes. The other half are steps of searches that bring some vertices of one
//! lane as close to its surface as they can, beginning with the closest of the sweep. Vertices
//! are those of the leaf arithmetic (SPEC 5.5), spheres those of each kernel of this processor in
//! turn.

mod below;
mod bones;
mod exact;
mod poses;
mod report;
mod search;
mod slack;
mod trial;

pub use report::{Report, Summary, Tight};
pub use slack::rounding_slack;

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::thread;

use bdtree_runtime::{Asset, FormatError, Kernel};

use below::Below;
use bones::hard_bones;
use poses::{HardPoses, KINDS};
use report::VIOLATIONS_MAX;
use search::search;
use trial::Trial;

/// Least number of cases that a round sweeps.
const SWEPT_MIN: u64 = 512;

/// Least number of rounds where there are cases enough: all kinds of q, with three kernels, twice.
const ROUNDS_MIN: u64 = 6 * KINDS;

/// How much is tried.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Number of cases.
    pub cases: u64,
    /// The same seed tries the same cases.
    pub seed: u64,
}

/// The kernels that this processor has.
pub fn kernels() -> Vec<Kernel> {
    let all = Kernel::ALL.into_iter();
    all.filter(|kernel| kernel.is_available()).collect()
}

/// All nodes at one q, with every kernel; q must be within the limits.
///
/// # Errors
/// As [`run`].
///
/// # Panics
/// As [`run`], and when q is not within the limits.
pub fn at(asset: &Asset<'_>, q: &[f32]) -> Result<Report, FormatError> {
    let below = Below::of(asset);
    let mut trial = Trial::new(*asset, &below);
    let mut report = Report::default();
    for kernel in kernels() {
        trial.use_kernel(kernel);
        trial.sweep(q, 0..asset.node_count(), &mut report)?;
    }
    assert!(report.poses > 0, "q is beyond the limits");
    Ok(report)
}

/// Tries `options.cases` cases on all processors; `advance` is told how many are done. Ends early
/// when 1000 vertices were found outside.
///
/// The report of a sound file does not depend on the number of processors, but on which kernels they have;
/// where it ends early, what was tried until then does.
///
/// # Errors
/// Nodes, rows or vertices outside their sections.
///
/// # Panics
/// May panic where [`Asset::verify`] finds a broken rule of nodes or triangles.
pub fn run(
    asset: &Asset<'_>,
    options: Options,
    advance: &(dyn Fn(u64) + Sync),
) -> Result<Report, FormatError> {
    let below = Below::of(asset);
    let rounds = Rounds::of(asset, options.cases);
    let kernels = kernels();
    let next = AtomicU64::new(0);
    let violations = AtomicUsize::new(0);
    let work = || {
        let mut trial = Trial::new(*asset, &below);
        let mut done: Vec<(u64, Report)> = Vec::new();
        let mut least = f64::INFINITY;
        loop {
            let round = next.fetch_add(1, Ordering::Relaxed);
            if round >= rounds.count || violations.load(Ordering::Relaxed) >= VIOLATIONS_MAX {
                return Ok(done);
            }
            // Every kernel meets every kind of q.
            let (turn, kernel) = (round / kernels.len() as u64, round % kernels.len() as u64);
            trial.use_kernel(kernels[kernel as usize]);
            let mut poses = HardPoses::new(*asset, options.seed, round);
            let mut report = rounds.run(round, turn, &mut trial, &mut poses)?;
            advance(report.cases);
            violations.fetch_add(report.violations.len(), Ordering::Relaxed);
            // Only what may be the tightest of all is remembered.
            match report.tightest.as_ref().map(|tight| tight.margin_slacks) {
                Some(margin) if margin < least => least = margin,
                _ => report.tightest = None,
            }
            done.push((round, report));
        }
    };
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let done: Result<Vec<_>, FormatError> = thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        let join = |worker: thread::ScopedJoinHandle<'_, _>| match worker.join() {
            Ok(done) => done,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        workers.into_iter().map(join).collect()
    });
    let mut done: Vec<(u64, Report)> = done?.into_iter().flatten().collect();
    done.sort_unstable_by_key(|(round, _)| *round);
    let mut report = Report::default();
    done.into_iter().for_each(|(_, later)| report.add(later));
    Ok(report)
}

/// The cases in portions: sweeps of some nodes, then a search from where they were tightest.
struct Rounds {
    nodes: u64,
    cases: u64,
    /// Cases that a round sweeps; it searches for as many.
    swept: u64,
    count: u64,
}

impl Rounds {
    fn of(asset: &Asset<'_>, cases: u64) -> Self {
        let nodes = asset.node_count() as u64;
        // All nodes, several times in a small tree; fewer of a large one, so that there are rounds for
        // all kinds of q with all kernels.
        let all = nodes * SWEPT_MIN.div_ceil(nodes);
        let swept = all.min((cases / (2 * ROUNDS_MIN)).max(SWEPT_MIN));
        Self {
            nodes,
            cases,
            swept,
            count: cases.div_ceil(2 * swept),
        }
    }

    /// One round; it begins with q of kind `kind`.
    fn run(
        &self,
        round: u64,
        kind: u64,
        trial: &mut Trial<'_, '_>,
        poses: &mut HardPoses<'_>,
    ) -> Result<Report, FormatError> {
        // A search begins where the sweep of its round was tightest, so a round has its bones throughout.
        trial.set_bones(hard_bones(&trial.asset, kind, poses.rng()));
        let mut report = Report::default();
        // The last round is as short as need be, half and half.
        let left = (self.cases - 2 * self.swept * round).min(2 * self.swept);
        let mut swept = left.div_ceil(2);
        let searched = left - swept;
        let first = self.swept * round % self.nodes;
        let mut kind = kind;
        while swept > 0 {
            let count = swept.min(self.nodes);
            let nodes = (first..first + count).map(|i| (i % self.nodes) as usize);
            trial.sweep(&poses.kind(kind), nodes, &mut report)?;
            swept -= count;
            kind += 1;
        }
        let tightest = report.tightest.clone();
        search(trial, poses, tightest, searched, &mut report)?;
        Ok(report)
    }
}
