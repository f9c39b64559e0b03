//! The bounds of a node's lanes from the vertices below them (docs/design/guarantees.md).

use bdtree_format::{
    LANES, ModePair, ROW_CENTER_X, ROW_RADIUS, Row, pair_count, pair_row, row_count,
};

use super::ball::smallest_ball;
use super::grid::Grid;
use super::round::{norm_above, norm_up, round_nearest};
use super::set_mode_pair;
use super::stored::StoredShape;
use crate::vec3::{dot, norm2, sub};

/// Relative and absolute guards of d, e and x·w (SPEC 5.7).
const GUARD_SQUARE: f64 = 1.0 / (1u64 << 48) as f64;
const GUARD_PRODUCT: f64 = 1.0 / (1u64 << 40) as f64;

/// Ū_j, ΔR_j, b⁺_j and b⁻_j of a lane at q_j = `q_limit`_j: Ū_j as stored, ΔR_j as stored once
/// all of the node are known, b± before their rounding.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct ModeBound {
    center: [f64; 3],
    growth: f64,
    cross: [f64; 2],
}

/// The modes that act on a node, and the shape whose they are.
#[derive(Clone, Copy)]
struct Fields<'s> {
    shape: &'s StoredShape,
    modes: &'s [u16],
}

/// Memory of one lane, used again from node to node.
#[derive(Debug, Default)]
pub(super) struct Lane {
    /// Vertices below the lane, each once; none when it is empty.
    pub(super) vertices: Vec<u32>,
    /// R, as stored.
    radius: f64,
    /// x_i = p_i − c.
    arms: Vec<[f64; 3]>,
    /// √d_i, from below.
    depth_roots: Vec<f64>,
    /// Per mode, the center of the displacements' smallest ball and their mean.
    centers: Vec<[[f64; 3]; 2]>,
    /// Per mode, the bounds about the two, until one of them is chosen.
    candidates: Vec<[ModeBound; 2]>,
    bounds: Vec<ModeBound>,
}

/// Memory that is used again from node to node.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pub(super) lanes: [Lane; LANES],
    points: Vec<[f64; 3]>,
}

/// Writes the rows of a node with the modes `modes`, whose vertices `scratch` holds, and returns
/// the exponents of the units that its mode rows count; `step_bounds` are the two δR of each
/// vertex.
///
/// Ū is rounded first, then ΔR about it, then b± for both: whatever a rounding did is in the
/// bounds that follow it.
pub(super) fn write_node(
    shape: &StoredShape,
    modes: &[u16],
    step_bounds: &[[f32; 2]],
    scratch: &mut Scratch,
    rows: &mut [Row],
) -> [i8; 3] {
    debug_assert!(rows.len() == row_count(modes.len()));
    let fields = Fields { shape, modes };
    let Scratch { lanes, points } = scratch;
    let mut used: Vec<(usize, &mut Lane)> = lanes
        .iter_mut()
        .enumerate()
        .filter(|(_, lane)| !lane.vertices.is_empty())
        .collect();

    for (k, lane) in &mut used {
        let center = lane.set_rest(shape, points);
        for (axis, x) in center.into_iter().enumerate() {
            rows[ROW_CENTER_X + axis][*k] = x;
        }
        rows[ROW_RADIUS][*k] = lane.radius as f32; // made from an f32
        for which in 0..2 {
            rows[pair_row(pair_count(modes.len())) + which][*k] = lane
                .vertices
                .iter()
                .map(|&i| step_bounds[i as usize][which])
                .fold(0.0, f32::max);
        }
        lane.set_centers(fields, points);
    }

    let centers = used.iter().flat_map(|(_, lane)| &lane.centers);
    let center_grid = Grid::covering(largest(centers.flatten().flatten().copied()));
    for (_, lane) in &mut used {
        lane.choose_bounds(fields, center_grid, points);
    }
    let bounds = used.iter().flat_map(|(_, lane)| &lane.bounds);
    let growth_grid = Grid::covering(largest(bounds.map(|b| b.growth)));
    for (_, lane) in &mut used {
        lane.round_growths(fields, growth_grid, points);
    }
    let bounds = used.iter().flat_map(|(_, lane)| &lane.bounds);
    let cross_grid = Grid::covering(largest(bounds.flat_map(|b| b.cross)));

    for pair in 0..pair_count(modes.len()) {
        let mut out = ModePair::default();
        for (lane, scratch) in &used {
            for (which, bound) in scratch.bounds[2 * pair..].iter().take(2).enumerate() {
                for (row, x) in out.center.iter_mut().zip(bound.center) {
                    row[*lane][which] = center_grid.nearest(x); // on the grid already
                }
                out.growth[*lane][which] = growth_grid.up(bound.growth); // the same
                for (row, b) in out.cross.iter_mut().zip(bound.cross) {
                    row[*lane][which] = cross_grid.up(b);
                }
            }
        }
        set_mode_pair(rows, pair, &out);
    }
    [center_grid, growth_grid, cross_grid].map(Grid::exponent)
}

/// The largest magnitude.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |m, x| m.max(x.abs()))
}

impl Lane {
    /// R, x_i and √d_i about the smallest ball's center as stored, which is returned.
    fn set_rest(&mut self, shape: &StoredShape, points: &mut Vec<[f64; 3]>) -> [f32; 3] {
        points.clear();
        points.extend(self.vertices.iter().map(|&i| shape.position(i)));
        let center = smallest_ball(points).center.map(round_nearest);
        let wide = center.map(f64::from);
        self.arms.clear();
        self.arms.extend(points.iter().map(|&p| sub(p, wide)));
        let square = self.arms.iter().map(|&x| norm2(x)).fold(0.0, f64::max);
        let radius = f64::from(norm_up(square));
        self.depth_roots.clear();
        self.depth_roots
            .extend(self.arms.iter().map(|&x| excess_root(radius, norm2(x))));
        self.radius = radius;
        center
    }

    /// The two candidates of each mode's Ū, before they are rounded.
    fn set_centers(&mut self, fields: Fields<'_>, points: &mut Vec<[f64; 3]>) {
        self.centers.clear();
        for &mode in fields.modes {
            self.load_field(fields.shape, mode, points);
            self.centers
                .push([smallest_ball(points).center, mean(points)]);
        }
    }

    /// Takes for each mode the better of its two candidates, rounded.
    fn choose_bounds(&mut self, fields: Fields<'_>, grid: Grid, points: &mut Vec<[f64; 3]>) {
        self.candidates.clear();
        for (k, &mode) in fields.modes.iter().enumerate() {
            self.load_field(fields.shape, mode, points);
            let bounds = self.centers[k].map(|center| {
                let center = center.map(|x| grid.value(grid.nearest(x)));
                let growth = growth_about(points, center);
                self.bound_mode(points, center, growth)
            });
            self.candidates.push(bounds);
        }
        let chosen = choose(&self.candidates, self.radius, |k| {
            let limits = fields.shape.limits[usize::from(fields.modes[k])];
            f64::from(limits.q_range) / f64::from(limits.q_limit)
        });
        self.bounds.clear();
        let pairs = self.candidates.iter().zip(chosen);
        self.bounds
            .extend(pairs.map(|(pair, which)| pair[usize::from(which)]));
    }

    /// Rounds ΔR up, which makes b± smaller.
    fn round_growths(&mut self, fields: Fields<'_>, grid: Grid, points: &mut Vec<[f64; 3]>) {
        for (k, &mode) in fields.modes.iter().enumerate() {
            self.load_field(fields.shape, mode, points);
            let ModeBound { center, growth, .. } = self.bounds[k];
            let growth = grid.value(grid.up(growth));
            self.bounds[k] = self.bound_mode(points, center, growth);
        }
    }

    /// U_ij `q_limit`_j of the vertices below: exact.
    fn load_field(&self, shape: &StoredShape, mode: u16, points: &mut Vec<[f64; 3]>) {
        let limit = f64::from(shape.limits[usize::from(mode)].q_limit);
        points.clear();
        points.extend(
            self.vertices
                .iter()
                .map(|&i| shape.displacement(i, mode).map(|x| x * limit)),
        );
    }

    /// The bound of one mode about a stored Ū with a ΔR that reaches every displacement.
    fn bound_mode(&self, field: &[[f64; 3]], center: [f64; 3], growth: f64) -> ModeBound {
        if self.radius == 0.0 || growth == 0.0 {
            return ModeBound {
                center,
                growth,
                cross: [0.0; 2],
            };
        }
        let (mut plus, mut minus) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        for ((&u, &x), &depth_root) in field.iter().zip(&self.arms).zip(&self.depth_roots) {
            let w = sub(u, center);
            let product = dot(x, w);
            let root = depth_root * excess_root(growth, norm2(w)) * (1.0 - GUARD_PRODUCT);
            plus = plus.max(product - root);
            minus = minus.max(-product - root);
        }
        let guard = GUARD_PRODUCT * self.radius * growth;
        ModeBound {
            center,
            growth,
            cross: [plus + guard, minus + guard],
        }
    }
}

/// max ‖u − center‖, from above.
fn growth_about(field: &[[f64; 3]], center: [f64; 3]) -> f64 {
    norm_above(
        field
            .iter()
            .map(|&u| norm2(sub(u, center)))
            .fold(0.0, f64::max),
    )
}

/// √(R² − ‖x‖²) from below: at least 0, at most the root.
fn excess_root(radius: f64, square: f64) -> f64 {
    let whole = radius * radius;
    (whole - square - GUARD_SQUARE * whole).max(0.0).sqrt()
}

fn mean(points: &[[f64; 3]]) -> [f64; 3] {
    let Some(&base) = points.first() else {
        return [0.0; 3];
    };
    let mut sum = [0.0; 3];
    for &point in points {
        for (s, d) in sum.iter_mut().zip(sub(point, base)) {
            *s += d;
        }
    }
    std::array::from_fn(|axis| base[axis] + sum[axis] / points.len() as f64)
}

/// Which of the two candidates each mode takes so that R'² is least, averaged over the signs of
/// q at |q_j| = q_range_j, given as shares of the limits: all the first, all the second, or a descent from the better of these.
fn choose(candidates: &[[ModeBound; 2]], radius: f64, q_range: impl Fn(usize) -> f64) -> Vec<bool> {
    let q: Vec<f64> = (0..candidates.len()).map(q_range).collect();
    let cross = |k: usize, which: bool| {
        let bound = candidates[k][usize::from(which)];
        (bound.cross[0] + bound.cross[1]) * q[k]
    };
    let growth = |k: usize, which: bool| candidates[k][usize::from(which)].growth * q[k];
    let total = |which: bool| {
        let range = 0..candidates.len();
        (
            range.clone().map(|k| cross(k, which)).sum::<f64>(),
            range.map(|k| growth(k, which)).sum::<f64>(),
        )
    };
    let square = |(b, s): (f64, f64)| radius * radius + b + s * s;
    let (ball, mean) = (total(false), total(true));
    let start = square(mean) < square(ball);
    let mut state = if start { mean } else { ball };
    let mut chosen = vec![start; candidates.len()];
    for (k, which) in chosen.iter_mut().enumerate() {
        let other = (
            state.0 - cross(k, *which) + cross(k, !*which),
            state.1 - growth(k, *which) + growth(k, !*which),
        );
        if square(other) < square(state) {
            state = other;
            *which = !*which;
        }
    }
    chosen
}
