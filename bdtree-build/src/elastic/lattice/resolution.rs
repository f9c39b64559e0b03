//! How many cells: as asked for, or as many as budgets of nodes and of work allow.

use crate::elastic::assemble::ordering::nested_dissection;
use crate::elastic::lattice::table::TooManyCells;
use crate::elastic::lattice::{Lattice, Subject};
use crate::error::{BakeError, Place};

/// Nodes that the default resolution may use.
pub const NODE_BUDGET: usize = 20_000;
/// Work of the factorisation that the default resolution may take, as [`nested_dissection`] counts
/// it: some seconds. It limits stout bodies, which need fewer cells than thin ones.
const WORK_BUDGET: f64 = 2e8;
/// Small triangles, beside four for each triangle, that the default resolution may integrate, as
/// [`Subject::surface_work`] counts them: some seconds. It limits many large triangles in one place.
const SURFACE_BUDGET: f64 = 4e6;
/// Cells along the longest side at most.
pub const RESOLUTION_MAX: u32 = 1024;
/// The default resolution does not go beyond this many cells along the longest side.
const AUTO_RESOLUTION_MAX: f64 = 256.0;
/// A cell with its fine cells, matrices, nodes and tables takes about this much.
pub(crate) const BYTES_PER_CELL: u64 = 8192;

/// Cells that a lattice which was asked for may have.
pub(crate) fn cell_limit(memory_limit_bytes: u64) -> usize {
    (memory_limit_bytes / BYTES_PER_CELL).min(2_000_000) as usize
}

/// Why there is no lattice.
#[derive(Debug)]
pub(crate) enum LatticeError {
    /// The resolution that was asked for, this one, makes more cells than [`cell_limit`].
    TooManyCells(u32),
    /// Anything else.
    Bake(BakeError),
}

/// The lattice asked for, or the finest one within the budgets.
pub(crate) fn choose_lattice(
    subject: &Subject<'_>,
    asked: Option<u32>,
    memory_limit_bytes: u64,
) -> Result<(Lattice, u32), LatticeError> {
    let cell_limit = cell_limit(memory_limit_bytes);
    if let Some(resolution) = asked {
        return match subject.lattice(f64::from(resolution), cell_limit) {
            Ok(lattice) => nonempty(subject, lattice, resolution),
            Err(_) => Err(LatticeError::TooManyCells(resolution)),
        };
    }
    // Only what is taken in the end is integrated.
    let mut best = None;
    let (mut resolution, mut low, mut high) = (24u32, 0u32, AUTO_RESOLUTION_MAX as u32 + 1);
    for _ in 0..8 {
        let work = subject.surface_work(f64::from(resolution));
        let attempt = if work <= SURFACE_BUDGET + 4.0 * subject.triangle_count() {
            subject.outline(f64::from(resolution), 2 * NODE_BUDGET)
        } else {
            Err(TooManyCells)
        };
        // Of its nodes and of its work, the larger share of the budget.
        let share = match attempt {
            Ok(lattice) => {
                let nodes = lattice.node_count() as f64 / NODE_BUDGET as f64;
                let work = lattice.components.iter();
                let work: f64 = work.map(|c| nested_dissection(&c.nodes).work).sum();
                // Work grows about as the square of the nodes.
                let share = nodes.max((work / WORK_BUDGET).sqrt());
                if share <= 1.0 {
                    low = resolution;
                    best = Some(resolution);
                } else {
                    high = resolution;
                }
                share
            }
            Err(_) => {
                high = resolution;
                4.0
            }
        };
        if high - low <= 1 || (low == resolution && share >= 0.9) {
            break;
        }
        // Nodes grow with a power of the resolution between 2 (thin) and 3 (stout).
        let factor = (0.95 / share.max(1e-6)).powf(0.4);
        let guess = (f64::from(resolution) * factor).round() as u32;
        resolution = guess.clamp(low + 1, high - 1);
    }
    // Even one cell per surface component is more than the budget: as coarse as it goes.
    let (resolution, limit) = best.map_or((1, cell_limit), |best| (best, 2 * NODE_BUDGET));
    match subject.lattice(f64::from(resolution), limit) {
        Ok(lattice) => nonempty(subject, lattice, resolution),
        Err(_) => Err(LatticeError::Bake(BakeError::one(
            "basis",
            Place::file(&subject.mesh.name),
            "its pieces fill more cells than memory allows",
        ))),
    }
}

fn nonempty(
    subject: &Subject<'_>,
    lattice: Lattice,
    resolution: u32,
) -> Result<(Lattice, u32), LatticeError> {
    if lattice.parts.is_empty() {
        return Err(LatticeError::Bake(BakeError::one(
            "basis",
            Place::file(&subject.mesh.name),
            "no cell of the lattice holds mass; raise --resolution or --thickness",
        )));
    }
    Ok((lattice, resolution))
}
