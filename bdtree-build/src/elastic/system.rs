//! Stiffness and mass of one component, in cell units and in order of elimination.

use faer::{Mat, MatRef};

use super::element::{Element, FUNCTIONS};
use super::factor::Pattern;
use super::hold::Grip;
use super::lattice::Component;
use super::ordering::nested_dissection;

/// Stiffness of the springs at held points, per cell, in units of Young's modulus times the cell
/// size: they give way by a thousandth of what the cell itself does.
const GRIP: f64 = 1e3;

/// Columns that a product takes at once.
const COLUMNS: usize = 8;
/// A node's three unknowns in these columns.
type NodeColumns = [[f64; COLUMNS]; 3];

/// `K` in 3 × 3 blocks and `M` as a scalar per pair of nodes: both share one pattern.
#[derive(Debug, Clone)]
pub(crate) struct System {
    /// Place of each of the component's nodes in the order of elimination.
    pub place: Vec<u32>,
    /// Cell of each node, in that order.
    pub nodes: Vec<[i32; 3]>,
    /// Points that are held, with their nodes in that order.
    pub grips: Vec<Grip>,
    starts: Vec<usize>,
    rows: Vec<u32>,
    stiffness: Vec<[f64; 9]>,
    mass: Vec<f64>,
}

impl System {
    /// Adds up the cells of a component and the springs at its held points.
    pub(crate) fn new(component: &Component, element: &Element, grips: &[Grip]) -> Self {
        let order = nested_dissection(&component.nodes).order;
        let mut place = vec![0u32; order.len()];
        for (n, &old) in order.iter().enumerate() {
            place[old as usize] = n as u32;
        }
        let cells: Vec<[u32; FUNCTIONS]> = component
            .cells
            .iter()
            .map(|c| c.map(|n| place[n as usize]))
            .collect();
        let (starts, rows) = adjacency(&cells, order.len());
        let mut system = Self {
            nodes: order.iter().map(|&n| component.nodes[n as usize]).collect(),
            grips: grips.to_vec(),
            place,
            stiffness: vec![[0.0; 9]; rows.len()],
            mass: vec![0.0; rows.len()],
            starts,
            rows,
        };
        for (cell, moments) in cells.iter().zip(&component.moments) {
            let own = element.matrices(moments);
            system.for_each_pair(cell, |system, at, a, b| {
                system.mass[at] += own.mass[FUNCTIONS * a + b];
                let block = &own.stiffness[FUNCTIONS * a + b];
                for (sum, k) in system.stiffness[at].iter_mut().zip(block) {
                    *sum += k;
                }
            });
        }
        for n in 0..system.grips.len() {
            let grip = &mut system.grips[n];
            grip.anchor.nodes = grip.anchor.nodes.map(|node| system.place[node as usize]);
            let Grip {
                anchor,
                axes,
                share,
            } = grip.clone();
            system.for_each_pair(&anchor.nodes, |system, at, a, b| {
                let spring = GRIP * share * anchor.weights[a] * anchor.weights[b];
                for (axis, held) in axes.iter().enumerate() {
                    system.stiffness[at][4 * axis] += if *held { spring } else { 0.0 };
                }
            });
        }
        system
    }

    /// Calls `add(self, entry, row, column)` for the lower triangle's pairs of a cell's functions.
    fn for_each_pair(
        &mut self,
        cell: &[u32; FUNCTIONS],
        mut add: impl FnMut(&mut Self, usize, usize, usize),
    ) {
        for (b, &column) in cell.iter().enumerate() {
            let range = self.starts[column as usize]..self.starts[column as usize + 1];
            for (a, &row) in cell.iter().enumerate() {
                if row >= column
                    && let Ok(at) = self.rows[range.clone()].binary_search(&row)
                {
                    add(self, range.start + at, a, b);
                }
            }
        }
    }

    /// Number of unknowns.
    pub(crate) fn size(&self) -> usize {
        3 * self.nodes.len()
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

    /// Values of `K − shift · M` on the pattern; unknowns in `pins` are cut off and get a positive
    /// diagonal.
    pub(crate) fn values(&self, shift: f64, pins: &[usize]) -> Vec<f64> {
        let mut off = vec![false; self.size()];
        for &p in pins {
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

    /// `K x`.
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

    /// `M x`.
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

    /// Runs `add(entry, input, output, row, column)` over the lower triangle, for so many columns of
    /// x at once that the matrix is read once for a block.
    fn apply(
        &self,
        x: MatRef<'_, f64>,
        add: impl Fn(usize, &[NodeColumns], &mut [NodeColumns], usize, usize),
    ) -> Mat<f64> {
        let mut result = Mat::zeros(x.nrows(), x.ncols());
        let mut input = vec![[[0.0; COLUMNS]; 3]; self.nodes.len()];
        let mut output = input.clone();
        for first in (0..x.ncols()).step_by(COLUMNS) {
            let count = COLUMNS.min(x.ncols() - first);
            for (i, values) in input.as_flattened_mut().iter_mut().enumerate() {
                for (c, v) in values.iter_mut().enumerate() {
                    *v = if c < count { x[(i, first + c)] } else { 0.0 };
                }
            }
            output.fill([[0.0; COLUMNS]; 3]);
            for node in 0..self.nodes.len() {
                for at in self.starts[node]..self.starts[node + 1] {
                    add(at, &input, &mut output, self.rows[at] as usize, node);
                }
            }
            for (i, values) in output.as_flattened().iter().enumerate() {
                for (c, &v) in values[..count].iter().enumerate() {
                    result[(i, first + c)] = v;
                }
            }
        }
        result
    }

    /// Diagonal of the mass per node.
    pub(crate) fn mass_diagonal(&self, node: usize) -> f64 {
        self.mass[self.starts[node]]
    }
}

/// Lower adjacency of the nodes by columns: the node itself first, then its later neighbours.
fn adjacency(cells: &[[u32; FUNCTIONS]], count: usize) -> (Vec<usize>, Vec<u32>) {
    let mut first = vec![0usize; count + 1];
    for n in cells.iter().flatten() {
        first[*n as usize + 1] += 1;
    }
    for n in 0..count {
        first[n + 1] += first[n];
    }
    let mut cursor = first.clone();
    let mut cells_of = vec![0u32; first[count]];
    for (c, cell) in cells.iter().enumerate() {
        for &n in cell {
            cells_of[cursor[n as usize]] = c as u32;
            cursor[n as usize] += 1;
        }
    }
    let mut starts = Vec::with_capacity(count + 1);
    let mut rows = Vec::new();
    let mut own = Vec::new();
    starts.push(0);
    for n in 0..count {
        own.clear();
        own.push(n as u32);
        for &c in &cells_of[first[n]..first[n + 1]] {
            own.extend(cells[c as usize].iter().filter(|&&m| m > n as u32));
        }
        own.sort_unstable();
        own.dedup();
        rows.extend_from_slice(&own);
        starts.push(rows.len());
    }
    (starts, rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elastic::factor::Symbolic;
    use crate::elastic::locate::Anchor;
    use crate::elastic::moments::full_cell;

    /// A row of full cells.
    fn bar(cells: i32) -> Component {
        let mut c = Component::default();
        for x in -1..=cells {
            for n in 0..9 {
                c.nodes.push([x, n % 3 - 1, n / 3 - 1]);
            }
        }
        for x in 0..cells as u32 {
            let at = |i: u32| 9 * (x + i % 3) + i / 3;
            c.cells.push(std::array::from_fn(|i| at(i as u32)));
            c.moments.push(full_cell());
        }
        c
    }

    #[test]
    fn order_is_a_permutation_and_solves_match_products() {
        let component = bar(30);
        let grips: Vec<Grip> = (0..9)
            .map(|n| Grip {
                anchor: Anchor {
                    component: 0,
                    nodes: component.cells[0],
                    weights: std::array::from_fn(|i| f64::from(i == n)),
                },
                axes: [true; 3],
                share: 1.0,
            })
            .collect();
        let system = System::new(&component, &Element::new(0.3), &grips);
        let mut seen = system.place.clone();
        seen.sort_unstable();
        assert!(seen.iter().enumerate().all(|(i, &p)| i == p as usize));
        let pattern = system.pattern();
        let symbolic = Symbolic::new(&pattern).expect("memory");
        let factor = symbolic
            .factorize(&pattern, &system.values(0.0, &[]))
            .expect("positive definite");
        let x = Mat::from_fn(system.size(), 2, |i, j| ((i * 7 + j * 3) % 11) as f64 - 5.0);
        let mut y = system.apply_stiffness(x.as_ref());
        factor.solve(y.as_mut()).expect("memory");
        for i in 0..system.size() {
            assert!((y[(i, 0)] - x[(i, 0)]).abs() < 1e-6);
        }
    }

    #[test]
    fn negative_pivots_count_eigenvalues() {
        let component = bar(12);
        let system = System::new(&component, &Element::new(0.3), &[]);
        let modes = crate::elastic::dense::all_modes(&system, 6).expect("eigenvalues");
        let pattern = system.pattern();
        let symbolic = Symbolic::new(&pattern).expect("memory");
        for n in 1..80 {
            if modes.values[n] < 1.001 * modes.values[n - 1] {
                continue; // one of the square section's pairs
            }
            let between = 0.5 * (modes.values[n - 1] + modes.values[n]);
            let count = symbolic.negative_count(&pattern, &system.values(between, &[]));
            assert_eq!(count, Ok(n + 6));
        }
    }
}
