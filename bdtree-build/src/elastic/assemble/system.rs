//! Stiffness and mass of one component, in order of elimination.

use faer::{Mat, MatRef};

use crate::elastic::assemble::constraint::Constraint;
use crate::elastic::assemble::joints::Blocks;
use crate::parallel;

/// Columns that a thread takes at once: half of a block of the iteration's.
const COLUMNS: usize = 4;
/// A node's three unknowns in these columns.
type NodeColumns = [[f64; COLUMNS]; 3];

/// `K` in 3 × 3 blocks and `M` as a scalar per pair of nodes: both share one pattern.
///
/// Unknowns that are held stay in place with an identity row in `K` and a zero row in `M`, so a
/// vector that is zero there stays so.
#[derive(Debug, Clone, Default)]
pub(crate) struct System {
    /// Place of each of the component's nodes in the order of elimination.
    pub place: Vec<u32>,
    /// Where each node is, in that order, in units of about an element.
    pub nodes: Vec<[f64; 3]>,
    /// Points that springs hold, with their nodes in that order.
    pub constraints: Vec<Constraint>,
    /// Unknowns that are held, ascending, in that order.
    pub held: Vec<usize>,
    /// What of it is stiff in itself, nodes in that order.
    pub blocks: Blocks,
    /// Start of each node's entries, and their end.
    pub(super) starts: Vec<usize>,
    /// Row node of each entry: the lower triangle by columns, the diagonal first.
    pub(super) rows: Vec<u32>,
    pub(super) stiffness: Vec<[f64; 9]>,
    pub(super) mass: Vec<f64>,
    /// Threads that products are computed with; they do not depend on it.
    pub threads: usize,
}

/// The lower triangle of a symmetric sparse pattern, by columns, rows ascending.
#[derive(Debug, Clone)]
pub(crate) struct Pattern {
    /// Start of each column in `rows`, and its end.
    pub columns: Vec<usize>,
    /// Row of each entry.
    pub rows: Vec<usize>,
}

impl System {
    /// Number of unknowns.
    pub(crate) fn size(&self) -> usize {
        3 * self.nodes.len()
    }

    /// Number of unknowns that are not held.
    pub(crate) fn free_count(&self) -> usize {
        self.size() - self.held.len()
    }

    /// Number of entries in the lower triangle.
    pub(crate) fn entry_count(&self) -> usize {
        9 * self.rows.len() - 3 * self.nodes.len()
    }

    /// The lower triangle's pattern, for the factorisation.
    pub(crate) fn pattern(&self) -> Pattern {
        let mut columns = Vec::with_capacity(self.size() + 1);
        let mut rows = Vec::with_capacity(self.entry_count());
        columns.push(0);
        for node in 0..self.nodes.len() {
            for e in 0..3 {
                for at in self.starts[node]..self.starts[node + 1] {
                    let row = self.rows[at] as usize;
                    let first = if row == node { e } else { 0 };
                    rows.extend((first..3).map(|d| 3 * row + d));
                }
                columns.push(rows.len());
            }
        }
        Pattern { columns, rows }
    }

    /// Values of `K − shift · M` on the pattern; unknowns that are held or in `pins` are cut off
    /// and get a positive diagonal.
    pub(crate) fn values(&self, shift: f64, pins: &[usize]) -> Vec<f64> {
        let mut off = vec![false; self.size()];
        for &p in pins.iter().chain(&self.held) {
            off[p] = true;
        }
        let mut values = Vec::with_capacity(self.entry_count());
        for node in 0..self.nodes.len() {
            for e in 0..3 {
                let column = 3 * node + e;
                for at in self.starts[node]..self.starts[node + 1] {
                    let row = self.rows[at] as usize;
                    let first = if row == node { e } else { 0 };
                    for d in first..3 {
                        let i = 3 * row + d;
                        values.push(if i == column && off[i] {
                            1.0
                        } else if off[i] || off[column] {
                            0.0
                        } else {
                            let mass = if d == e { self.mass[at] } else { 0.0 };
                            self.stiffness[at][3 * d + e] - shift * mass
                        });
                    }
                }
            }
        }
        values
    }

    /// `K x`, for x that is zero where held.
    pub(crate) fn apply_stiffness(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        self.apply(x, |at, input, output, row, node| {
            let k = &self.stiffness[at];
            for d in 0..3 {
                for e in 0..3 {
                    let k = k[3 * d + e];
                    for c in 0..COLUMNS {
                        output[row][d][c] += k * input[node][e][c];
                    }
                    if row != node {
                        for c in 0..COLUMNS {
                            output[node][e][c] += k * input[row][d][c];
                        }
                    }
                }
            }
        })
    }

    /// `M x`, likewise.
    pub(crate) fn apply_mass(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        self.apply(x, |at, input, output, row, node| {
            let m = self.mass[at];
            for d in 0..3 {
                for c in 0..COLUMNS {
                    output[row][d][c] += m * input[node][d][c];
                }
                if row != node {
                    for c in 0..COLUMNS {
                        output[node][d][c] += m * input[row][d][c];
                    }
                }
            }
        })
    }

    /// Zeroes the rows of what is held.
    pub(crate) fn clear_held(&self, x: &mut Mat<f64>) {
        for &i in &self.held {
            for j in 0..x.ncols() {
                x[(i, j)] = 0.0;
            }
        }
    }

    /// Runs `add(entry, input, output, row, column)` over the lower triangle, for several columns of x at once, so
    /// that the matrix is read less often. Threads take columns, whose sums keep their order.
    fn apply(
        &self,
        x: MatRef<'_, f64>,
        add: impl Fn(usize, &[NodeColumns], &mut [NodeColumns], usize, usize) + Sync,
    ) -> Mat<f64> {
        let zero = || vec![[[0.0; COLUMNS]; 3]; self.nodes.len()];
        let starts = (0..x.ncols()).step_by(COLUMNS);
        let mut parts: Vec<_> = starts.map(|first| (first, Vec::new())).collect();
        let mut inputs = parallel::states(self.threads, zero);
        parallel::for_each(parts.iter_mut(), &mut inputs, |input, (first, output)| {
            for (i, values) in input.as_flattened_mut().iter_mut().enumerate() {
                for (c, v) in values.iter_mut().enumerate() {
                    let column = *first + c;
                    *v = if column < x.ncols() {
                        x[(i, column)]
                    } else {
                        0.0
                    };
                }
            }
            *output = zero();
            for node in 0..self.nodes.len() {
                for at in self.starts[node]..self.starts[node + 1] {
                    add(at, input, output, self.rows[at] as usize, node);
                }
            }
        });
        let mut result = Mat::zeros(x.nrows(), x.ncols());
        for (first, output) in parts {
            for (i, values) in output.as_flattened().iter().enumerate() {
                for (column, &v) in (first..x.ncols()).zip(values) {
                    result[(i, column)] = v;
                }
            }
        }
        self.clear_held(&mut result);
        result
    }

    /// Diagonal of the mass per node.
    pub(crate) fn mass_diagonal(&self, node: usize) -> f64 {
        self.mass[self.starts[node]]
    }
}
