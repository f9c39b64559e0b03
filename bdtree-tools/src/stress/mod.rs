//! Whether an asset's bounds hold, tried: every deformed vertex against the spheres above it, at q
//! that is made to break them, decided in exact arithmetic.
//!
//! A *case* is a node at a q. Half of them are sweeps: hard q of nine kinds, nodes in order, all
//! vertices below all lanes. The other half are steps of searches that bring some vertices of one
//! lane as close to its surface as they can, beginning with the closest of the sweep. Vertices
//! are those of the leaf arithmetic (SPEC 5.5), spheres those of each kernel of this processor in
//! turn.

mod below;
mod certainty;
mod exact;
mod poses;
mod report;
mod search;
mod summary;
mod trial;

pub use report::{Report, Tight};
pub(crate) use summary::Stressed;
pub use summary::{Summary, Tightest};

use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use bdtree_runtime::{Asset, FormatError, Kernel};

use below::Below;
use poses::HardPoses;
use search::search;
use trial::Trial;

/// Least number of cases that a round sweeps.
const SWEPT_MIN: u64 = 512;

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

/// What certainty costs, as a share of the mean radius at q within ± `q_range`.
///
/// # Errors
/// As [`run`].
pub fn certainty(asset: &Asset<'_>, seed: u64) -> Result<f64, FormatError> {
    certainty::certainty(asset, seed)
}

/// All nodes at one q, with every kernel; q must be within the limits.
///
/// # Errors
/// As [`run`].
///
/// # Panics
/// As [`run`].
pub fn at(asset: &Asset<'_>, q: &[f32]) -> Result<Report, FormatError> {
    let below = Below::of(asset);
    let mut trial = Trial::new(*asset, &below);
    let mut report = Report::default();
    for kernel in kernels() {
        trial.use_kernel(kernel);
        trial.sweep(q, 0..asset.node_count(), &mut report)?;
    }
    Ok(report)
}

/// Tries `options.cases` cases on all processors; `advance` is told how many are done.
///
/// The report does not depend on the number of processors.
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
    let work = || {
        let mut trial = Trial::new(*asset, &below);
        let mut done = Vec::new();
        loop {
            let round = next.fetch_add(1, Ordering::Relaxed);
            if round >= rounds.count {
                return Ok(done);
            }
            // Every kernel meets every kind of q.
            let (turn, kernel) = (round / kernels.len() as u64, round % kernels.len() as u64);
            trial.use_kernel(kernels[kernel as usize]);
            let mut poses = HardPoses::new(*asset, options.seed, round);
            let left = rounds.cases - 2 * rounds.swept * round;
            let report = rounds.run(left, turn, &mut trial, &mut poses)?;
            advance(report.cases);
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

/// The cases in portions: a sweep of some q over all nodes, then a search from where it was tightest.
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
        let swept = nodes * SWEPT_MIN.div_ceil(nodes);
        Self {
            nodes,
            cases,
            swept,
            count: cases.div_ceil(2 * swept),
        }
    }

    /// One round, of at most `left` cases; it begins with q of kind `kind`.
    fn run(
        &self,
        left: u64,
        kind: u64,
        trial: &mut Trial<'_, '_>,
        poses: &mut HardPoses<'_>,
    ) -> Result<Report, FormatError> {
        let mut report = Report::default();
        // The last round is as short as need be, half and half.
        let left = left.min(2 * self.swept);
        let swept = left.div_ceil(2);
        let (full, rest) = (swept / self.nodes, swept % self.nodes);
        for k in 0..full + u64::from(rest > 0) {
            let q = poses.kind(kind + k);
            let nodes = if k < full { self.nodes } else { rest };
            trial.sweep(&q, 0..nodes as usize, &mut report)?;
        }
        let tightest = report.tightest.clone();
        search(trial, poses, tightest, left - swept, &mut report)?;
        Ok(report)
    }
}
