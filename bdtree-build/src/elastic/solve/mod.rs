//! The lowest modes of all components together.

pub(crate) mod canonical;
pub(crate) mod factor;
pub(crate) mod krylov;
pub(crate) mod rigid;
#[cfg(test)]
pub(crate) mod tests;

use faer::Mat;

use crate::elastic::assemble::system::{Pattern, System};
use crate::elastic::solve::canonical::{CLUSTER_GAP, clusters, turn_clusters};
use crate::elastic::solve::factor::{FactorError, Symbolic};
use crate::elastic::solve::krylov::{Inverse, Modes, RESIDUAL_MAX, lowest_modes};
use crate::elastic::solve::rigid::{rigid_motions, support};
use crate::progress::Progress;

/// Steps of the stage in which modes are solved for.
const STEPS: u64 = 1000;

/// Shares of a component's time that are over when its stiffness is factored and when the iteration has converged;
/// the rest is the inertia count. Measured on solids of 9000 to 56 000 unknowns, where both factors take about a sixth.
const FACTORED: f64 = 0.17;
const ITERATED: f64 = 0.83;

/// More modes than asked for are found, so that a cluster at the end is met whole.
const EXTRA: usize = 4;

/// A mode of one component.
#[derive(Debug, Clone)]
pub(crate) struct ComponentMode {
    /// Component.
    pub component: usize,
    /// Eigenvalue in the system's units.
    pub value: f64,
    /// Displacement per unknown of the component's nodes, unit modal mass in the system's
    /// units.
    pub vector: Vec<f64>,
}

/// The lowest modes, and how they were found.
#[derive(Debug, Clone, Default)]
pub(crate) struct Solution {
    /// Ascending; at most as many as asked for.
    pub modes: Vec<ComponentMode>,
    /// Worst residual of [`Modes`].
    pub residual: f64,
    /// Whether an inertia count confirmed every component's number of modes.
    pub checked: bool,
    /// Largest memory a component was predicted to take.
    pub bytes: u64,
    /// Elastic modes that the body has, at most; meaningful when fewer than asked for exist.
    pub available: usize,
}

/// Why there is no solution.
#[derive(Debug, Clone)]
pub(crate) enum SolveError {
    /// Predicted bytes beyond the limit.
    Memory(u64),
    /// The allocation or a pivot failed in this component.
    Factor(usize, FactorError),
    /// The inertia count of this component contradicts the modes found: (component, counted, found).
    Missed(usize, usize, usize),
    /// The worst residual reached.
    Residual(f64),
    /// This element of this component has no stiffness: (component, element).
    Element(usize, usize),
}

/// What bounds the work.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// Modes wanted in all.
    pub wanted: usize,
    /// Memory limit.
    pub bytes: u64,
    /// Components up to this many unknowns get an inertia count.
    pub verify_dof_max: usize,
    /// Threads to work with; the modes do not depend on it.
    pub threads: usize,
}

/// Solves component after component, the largest first: once enough modes are known, an inertia
/// count tells cheaply that a further component has none below them.
///
/// `sizes` are the components' numbers of nodes; `system` makes the system of one, or names an
/// element that cannot be.
pub(crate) fn solve(
    sizes: &[usize],
    system: impl Fn(usize) -> Result<System, usize>,
    limits: Limits,
    progress: &dyn Progress,
) -> Result<Solution, SolveError> {
    let order = largest_first(sizes);
    let mut solution = Solution {
        checked: true,
        ..Solution::default()
    };
    let work = |c: usize| (sizes[c] as f64).powf(1.5);
    let total: f64 = (0..sizes.len()).map(work).sum();
    progress.stage("modes", Some(STEPS));
    let mut done = Done {
        progress,
        told: 0,
        begin: 0.0,
        share: 0.0,
    };
    for c in order {
        done.begin += done.share;
        done.share = work(c) / total;
        let mut system = system(c).map_err(|element| SolveError::Element(c, element))?;
        system.threads = limits.threads;
        let found = solve_component(c, &system, limits, &mut solution, &mut done)?;
        for (j, &value) in found.values.iter().enumerate().take(limits.wanted) {
            let vector = (0..system.size())
                .map(|i| found.vectors[(3 * system.place[i / 3] as usize + i % 3, j)])
                .collect();
            solution.modes.push(ComponentMode {
                component: c,
                value,
                vector,
            });
        }
        sort(&mut solution.modes);
        solution.modes.truncate(limits.wanted);
        done.reach(1.0);
    }
    if solution.residual.is_nan() || solution.residual > RESIDUAL_MAX {
        return Err(SolveError::Residual(solution.residual));
    }
    Ok(solution)
}

/// What [`solve`] would take.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Needs {
    /// Largest memory that a component is predicted to take.
    pub bytes: u64,
    /// Elastic modes that the body has, at most.
    pub available: usize,
}

/// What [`solve`] finds out before it computes anything: it refuses a component here for the same memory.
pub(crate) fn needs(
    sizes: &[usize],
    system: impl Fn(usize) -> Result<System, usize>,
    limits: Limits,
) -> Result<Needs, SolveError> {
    let mut needs = Needs::default();
    for c in largest_first(sizes) {
        let system = system(c).map_err(|element| SolveError::Element(c, element))?;
        let available = available(&system, rigid_motions(&system).ncols());
        needs.available += available;
        if available > 0 {
            needs.bytes = needs.bytes.max(analyse(c, &system, limits)?.bytes);
        }
    }
    Ok(needs)
}

/// The order in which components are solved.
fn largest_first(sizes: &[usize]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&c| (usize::MAX - sizes[c], c));
    order
}

/// Elastic modes of a component, at most.
fn available(system: &System, rigid_count: usize) -> usize {
    system.free_count().saturating_sub(rigid_count)
}

/// A component's pattern, where the numbers of its factor will be, and what the numeric step takes.
struct Analysis {
    pattern: Pattern,
    symbolic: Symbolic,
    bytes: u64,
}

/// Analyses a component; refuses it if it takes more than the limit.
fn analyse(c: usize, system: &System, limits: Limits) -> Result<Analysis, SolveError> {
    let pattern = system.pattern();
    let symbolic = Symbolic::new(&pattern).map_err(|e| SolveError::Factor(c, e))?;
    let bytes = predicted_bytes(system, &symbolic, limits.wanted);
    if bytes > limits.bytes {
        return Err(SolveError::Memory(bytes));
    }
    Ok(Analysis {
        pattern,
        symbolic,
        bytes,
    })
}

/// How much of the stage is over, told in whole steps.
struct Done<'a> {
    progress: &'a dyn Progress,
    told: u64,
    /// Where the component begins, and its share of the whole.
    begin: f64,
    share: f64,
}

impl Done<'_> {
    /// So much of the component is over.
    fn reach(&mut self, fraction: f64) {
        let whole = self.begin + self.share * fraction;
        let steps = (STEPS as f64 * whole.min(1.0)) as u64;
        self.progress.advance(steps.saturating_sub(self.told));
        self.told = self.told.max(steps);
    }
}

/// By value; within a cluster by component, for rounding must not order equal bodies.
fn sort(modes: &mut [ComponentMode]) {
    modes.sort_by(|a, b| a.value.total_cmp(&b.value));
    let values: Vec<f64> = modes.iter().map(|mode| mode.value).collect();
    for cluster in clusters(&values) {
        modes[cluster].sort_by_key(|m| m.component);
    }
}

fn solve_component(
    c: usize,
    system: &System,
    limits: Limits,
    solution: &mut Solution,
    done: &mut Done<'_>,
) -> Result<Modes, SolveError> {
    let none = Modes {
        values: Vec::new(),
        vectors: Mat::zeros(system.size(), 0),
        residual: 0.0,
    };
    let fail = |e| SolveError::Factor(c, e);
    let rigid = rigid_motions(system);
    let rigid_count = rigid.ncols();
    let available = available(system, rigid_count);
    solution.available += available;
    if available == 0 {
        return Ok(none);
    }
    let Analysis {
        pattern,
        symbolic,
        bytes,
    } = analyse(c, system, limits)?;
    solution.bytes = solution.bytes.max(bytes);
    let count = |below: f64| -> Result<usize, SolveError> {
        let values = system.values(below, &[]);
        let negative = symbolic.negative_count(&pattern, &values).map_err(fail)?;
        Ok(negative.saturating_sub(rigid_count))
    };
    let mut wanted = limits.wanted;
    let mut counted = None;
    if solution.modes.len() == limits.wanted {
        // A sound bound however the modes found so far came about.
        let bound = solution.modes[limits.wanted - 1].value * (1.0 + 10.0 * CLUSTER_GAP);
        let below = count(bound)?;
        if below == 0 {
            return Ok(none);
        }
        wanted = wanted.min(below);
        counted = Some((bound, below));
    }
    let pins = support(system, rigid.as_ref());
    let mut more = EXTRA;
    let mut modes = loop {
        let found = {
            let values = system.values(0.0, &pins);
            let factor = symbolic.factorize(&pattern, &values).map_err(fail)?;
            drop(values);
            done.reach(FACTORED);
            let mut rounds = |share| done.reach(FACTORED + (ITERATED - FACTORED) * share);
            let rigid_mass = system.apply_mass(rigid.as_ref());
            let inverse = Inverse {
                system,
                factor: &factor,
                pins: &pins,
                rigid: rigid.as_ref(),
                rigid_mass: rigid_mass.as_ref(),
            };
            lowest_modes(&inverse, wanted + more, &mut rounds).map_err(fail)?
        };
        if system.size() > limits.verify_dof_max && counted.is_none() {
            solution.checked = false;
            break found;
        }
        let (bound, below) = match counted {
            Some(known) => known,
            None => {
                let bound = gap_after(&found.values, wanted);
                (bound, count(bound)?)
            }
        };
        let seen = found.values.iter().filter(|v| **v < bound).count();
        if seen >= below.min(wanted) && (counted.is_some() || seen == below) {
            break found;
        }
        if more > EXTRA {
            return Err(SolveError::Missed(c, below, seen));
        }
        more = EXTRA + 16; // once more with a larger space
    };
    solution.residual = solution.residual.max(modes.residual);
    turn_clusters(system, &mut modes.vectors, &modes.values);
    Ok(modes)
}

/// A value in the widest gap at or after the last wanted mode.
fn gap_after(values: &[f64], wanted: usize) -> f64 {
    let first = wanted.min(values.len()).saturating_sub(1);
    let mut best = (0.0, values.last().map_or(0.0, |v| v * (1.0 + CLUSTER_GAP)));
    for i in first..values.len().saturating_sub(1) {
        let gap = values[i + 1] / values[i] - 1.0;
        if gap > best.0 {
            best = (gap, (values[i + 1] * values[i]).sqrt());
        }
    }
    best.1
}

/// Memory of the numeric step: factor, matrix in three forms, Krylov basis.
fn predicted_bytes(system: &System, symbolic: &Symbolic, wanted: usize) -> u64 {
    let (n, entries) = (system.size() as u64, system.entry_count() as u64);
    let basis = 8 * n * (24 * 8 + 4 * wanted as u64);
    symbolic.factor_bytes() + entries * 60 + basis + n * 200
}
