//! Spheres that hold those below them at every q, as an option: the paper's enlarged coarse nodes (3.4),
//! proved instead of hoped for.

use bdtree_format::{LANES, NodeRecord, ROW_CENTER_X, ROW_RADIUS};

use super::grid::Grid;
use super::round::{norm_above, round_up};
use super::units::power;
use super::{WrappedTree, mode_pair, modes_of, set_mode_pair};
use crate::vec3::{norm2, sub};

/// What a sum in f64 may lose, with room to spare.
const ABOVE: f64 = 1.0 + f64::EPSILON * 4.0;

/// Enlarges every lane that leads to a node, from the leaves up: with c, R, Ū_j and ΔR_j as stored, k
/// running over the lanes of the node below,
///
/// ```text
/// R ≥ ‖c_k − c‖ + R_k     ΔR_j ≥ ‖Ū_kj − Ū_j‖ + ΔR_kj     b⁺_j, b⁻_j ≥ R ΔR_j
/// ```
///
/// so that R'(q) ≥ R + Σ ΔR_j |q_j| ≥ ‖c'_k(q) − c'(q)‖ + R'_k(q): the paper's bound there, since the
/// second-order one of a lane need not be above that of the lanes below. Centers, leaf lanes and the
/// bounds of steps stay. O(nodes · M).
pub fn nest(tree: &mut WrappedTree) {
    for i in (0..tree.nodes.len()).rev() {
        let node = tree.nodes[i];
        if node.inner_mask == 0 {
            continue;
        }
        let mut lanes = Lanes::of(tree, &node);
        let inner = (0..LANES).filter(|k| node.inner_mask >> k & 1 == 1);
        for (child, lane) in (node.first_child as usize..).zip(inner) {
            let below = tree.nodes[child];
            lanes.hold(lane, &Lanes::of(tree, &below), used(&below));
        }
        lanes.store(tree, i);
    }
}

fn used(node: &NodeRecord) -> u8 {
    node.inner_mask | node.leaf_mask
}

/// The numbers of a node's lanes; those of modes for q_j at its limit.
struct Lanes {
    center: [[f64; 3]; LANES],
    radius: [f64; LANES],
    /// Ascending.
    modes: Vec<LaneMode>,
}

/// One mode of all lanes.
#[derive(Clone, Copy)]
struct LaneMode {
    mode: u16,
    center: [[f64; 3]; LANES],
    growth: [f64; LANES],
    cross: [[f64; 2]; LANES],
}

impl Lanes {
    fn of(tree: &WrappedTree, node: &NodeRecord) -> Self {
        let rows = &tree.rows[node.row_start as usize..];
        let modes = modes_of(&tree.mode_lists, node);
        let [c, g, b] = node.scale_exponents.map(|e| power(e.into()));
        let of_mode = |(j, &mode): (usize, &u16)| {
            let pair = mode_pair(rows, j / 2);
            let numbers: [[f64; 6]; LANES] = std::array::from_fn(|k| {
                let [x, y, z, growth, plus, minus] = pair.numbers(j, k).map(f64::from);
                [x * c, y * c, z * c, growth * g, plus * b, minus * b]
            });
            LaneMode {
                mode,
                center: numbers.map(|[x, y, z, ..]| [x, y, z]),
                growth: numbers.map(|[_, _, _, growth, ..]| growth),
                cross: numbers.map(|[.., plus, minus]| [plus, minus]),
            }
        };
        let center = |k: usize| [0, 1, 2].map(|axis| f64::from(rows[ROW_CENTER_X + axis][k]));
        Self {
            center: std::array::from_fn(center),
            radius: rows[ROW_RADIUS].map(f64::from),
            modes: modes.iter().enumerate().map(of_mode).collect(),
        }
    }

    /// Enlarges a lane so that it holds the lanes `mask` of the node below it, whose modes are among
    /// its own.
    fn hold(&mut self, lane: usize, below: &Lanes, mask: u8) {
        let held = || (0..LANES).filter(|k| mask >> k & 1 == 1);
        let center = self.center[lane];
        let mut radius = self.radius[lane];
        for k in held() {
            let apart = norm_above(norm2(sub(below.center[k], center)));
            radius = radius.max((apart + below.radius[k]) * ABOVE);
        }
        self.radius[lane] = f64::from(round_up(radius));
        for own in &mut self.modes {
            let other = below.modes.iter().find(|m| m.mode == own.mode);
            let center = own.center[lane];
            for k in held() {
                // A mode that a node leaves out moves nothing there.
                let (there, growth) = other.map_or(([0.0; 3], 0.0), |m| (m.center[k], m.growth[k]));
                let reach = norm_above(norm2(sub(there, center))) + growth;
                own.growth[lane] = own.growth[lane].max(reach * ABOVE);
            }
            own.cross[lane] = [f64::INFINITY; 2]; // once ΔR is rounded
        }
    }

    /// Writes R and the modes' rows, ΔR and b± rounded up.
    fn store(&mut self, tree: &mut WrappedTree, node: usize) {
        let record = &mut tree.nodes[node];
        let rows = &mut tree.rows[record.row_start as usize..];
        for lane in (0..LANES).filter(|k| record.inner_mask >> k & 1 == 1) {
            rows[ROW_RADIUS][lane] = self.radius[lane] as f32; // made from an f32
        }
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let growths = &mut self.modes.iter().flat_map(|m| m.growth);
        let growth_grid = Grid::covering(largest(growths));
        for own in &mut self.modes {
            own.growth = own.growth.map(|x| growth_grid.value(growth_grid.up(x)));
            for lane in (0..LANES).filter(|k| record.inner_mask >> k & 1 == 1) {
                // Exact: 24 bits times 16.
                own.cross[lane] = [self.radius[lane] * own.growth[lane]; 2];
            }
        }
        let crosses = self.modes.iter().flat_map(|m| m.cross).flatten();
        let cross_grid = Grid::covering(largest(&mut crosses.map(f64::abs)));
        for (j, pair) in self.modes.chunks(2).enumerate() {
            let mut out = mode_pair(rows, j);
            for (which, own) in pair.iter().enumerate() {
                for lane in 0..LANES {
                    // On the grid already.
                    out.growth[lane][which] = growth_grid.up(own.growth[lane]);
                    for sign in 0..2 {
                        out.cross[sign][lane][which] = cross_grid.up(own.cross[lane][sign]);
                    }
                }
            }
            set_mode_pair(rows, j, &out);
        }
        record.scale_exponents[1] = growth_grid.exponent();
        record.scale_exponents[2] = cross_grid.exponent();
    }
}
