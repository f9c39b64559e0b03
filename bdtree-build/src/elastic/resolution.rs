//! How many cells: as asked for, or as many as a budget of nodes allows.

use super::lattice::{Lattice, Subject};
use crate::error::BakeError;

/// Nodes that the default resolution may use.
pub const NODE_BUDGET: usize = 20_000;
/// Cells along the longest side at most.
pub const RESOLUTION_MAX: u32 = 1024;
/// The default resolution does not go beyond this many cells along the longest side.
const AUTO_RESOLUTION_MAX: f64 = 256.0;
/// A cell with its matrices, nodes and tables takes about this much.
pub(crate) const BYTES_PER_CELL: u64 = 4096;
/// The lattice asked for, or the finest one within the node budget.
pub(crate) fn choose_lattice(
    subject: &Subject<'_>,
    asked: Option<u32>,
    memory_limit_bytes: u64,
) -> Result<(Lattice, u32), BakeError> {
    let cell_limit = (memory_limit_bytes / BYTES_PER_CELL).min(2_000_000) as usize;
    if let Some(resolution) = asked {
        return match subject.lattice(f64::from(resolution), cell_limit) {
            Ok(lattice) => nonempty(subject, lattice, resolution),
            Err(_) => Err(BakeError::one(
                "basis",
                "--resolution",
                format!(
                    "{resolution} cells along the longest side make more than {cell_limit} cells, \
                     which do not fit in {} MB",
                    memory_limit_bytes >> 20
                ),
            )),
        };
    }
    let mut best: Option<(Lattice, u32)> = None;
    let (mut resolution, mut low, mut high) = (24u32, 0u32, AUTO_RESOLUTION_MAX as u32 + 1);
    for _ in 0..8 {
        let nodes = match subject.lattice(f64::from(resolution), 2 * NODE_BUDGET) {
            Ok(lattice) => {
                let nodes = lattice.node_count();
                if nodes <= NODE_BUDGET {
                    low = resolution;
                    best = Some((lattice, resolution));
                } else {
                    high = resolution;
                }
                nodes
            }
            Err(_) => {
                high = resolution;
                4 * NODE_BUDGET
            }
        };
        if high - low <= 1 || (low == resolution && nodes * 10 >= NODE_BUDGET * 9) {
            break;
        }
        // Nodes grow with a power of the resolution between 2 (thin) and 3 (stout).
        let factor = (0.95 * NODE_BUDGET as f64 / nodes.max(1) as f64).powf(0.4);
        let guess = (f64::from(resolution) * factor).round() as u32;
        resolution = guess.clamp(low + 1, high - 1);
    }
    match best {
        Some((lattice, resolution)) => nonempty(subject, lattice, resolution),
        // Even one cell per piece is more than the budget: as coarse as it goes.
        None => match subject.lattice(1.0, cell_limit) {
            Ok(lattice) => nonempty(subject, lattice, 1),
            Err(_) => Err(BakeError::one(
                "basis",
                subject.mesh.name.clone(),
                "its pieces fill more cells than memory allows",
            )),
        },
    }
}

fn nonempty(
    subject: &Subject<'_>,
    lattice: Lattice,
    resolution: u32,
) -> Result<(Lattice, u32), BakeError> {
    if lattice.keys.is_empty() {
        return Err(BakeError::one(
            "basis",
            subject.mesh.name.clone(),
            "no cell of the lattice holds mass; raise --resolution or --thickness",
        ));
    }
    Ok((lattice, resolution))
}
