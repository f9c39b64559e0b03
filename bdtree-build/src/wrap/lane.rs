//! The bounds of one lane from the vertices below it (docs/guarantees.md).

use bdtree_format::{LANES, ROW_CENTRE_X, ROW_RADIUS, Row, mode_row, row_count};

use super::ball::{dot, norm2, smallest_ball, sub};
use super::round::{norm_up, round_nearest, round_up};
use super::stored::StoredShape;

/// Relative and absolute guards of d, e and x·w (SPEC 5.7).
const GUARD_SQUARE: f64 = 1.0 / (1u64 << 48) as f64;
const GUARD_PRODUCT: f64 = 1.0 / (1u64 << 40) as f64;

/// Ū_j, ΔR_j, b⁺_j and b⁻_j of a lane, as stored.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct ModeBound {
    pub(super) centre: [f32; 3],
    pub(super) growth: f32,
    pub(super) cross_plus: f32,
    pub(super) cross_minus: f32,
}

/// Memory that is used again from lane to lane.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// Vertices below the lane, each once.
    pub(super) vertices: Vec<u32>,
    points: Vec<[f64; 3]>,
    /// x_i = p_i − c.
    arms: Vec<[f64; 3]>,
    /// √d_i, from below.
    depth_roots: Vec<f64>,
    candidates: Vec<[ModeBound; 2]>,
}

/// Writes lane `lane` of a node with the modes `modes`: `rows` are the node's rows,
/// `step_bounds` the two δR of each vertex.
pub(super) fn write_lane(
    shape: &StoredShape,
    modes: &[u16],
    step_bounds: &[[f32; 2]],
    scratch: &mut Scratch,
    rows: &mut [Row],
    lane: usize,
) {
    debug_assert!(rows.len() == row_count(modes.len()) && lane < LANES);
    let vertices = &scratch.vertices;
    let (points, arms) = (&mut scratch.points, &mut scratch.arms);
    points.clear();
    points.extend(vertices.iter().map(|&i| shape.position(i)));
    let centre = smallest_ball(points).centre.map(round_nearest);
    let wide_centre = centre.map(f64::from);
    arms.clear();
    arms.extend(points.iter().map(|&p| sub(p, wide_centre)));
    let radius = norm_up(arms.iter().map(|&x| norm2(x)).fold(0.0, f64::max));
    let wide_radius = f64::from(radius);
    scratch.depth_roots.clear();
    scratch
        .depth_roots
        .extend(arms.iter().map(|&x| excess_root(wide_radius, norm2(x))));

    scratch.candidates.clear();
    for &mode in modes {
        points.clear();
        points.extend(vertices.iter().map(|&i| shape.displacement(i, mode)));
        let ball = smallest_ball(points).centre;
        let mean = mean(points);
        scratch.candidates.push(
            [ball, mean]
                .map(|centre| bound_mode(points, centre, arms, &scratch.depth_roots, wide_radius)),
        );
    }
    let chosen = choose(&scratch.candidates, wide_radius, |k| {
        shape.limits[usize::from(modes[k])].q_range
    });

    for (axis, &x) in centre.iter().enumerate() {
        rows[ROW_CENTRE_X + axis][lane] = x;
    }
    rows[ROW_RADIUS][lane] = radius;
    for (k, (pair, which)) in scratch.candidates.iter().zip(chosen).enumerate() {
        let bound = pair[usize::from(which)];
        let [x, y, z] = bound.centre;
        let values = [x, y, z, bound.growth, bound.cross_plus, bound.cross_minus];
        for (row, value) in rows[mode_row(k)..].iter_mut().zip(values) {
            row[lane] = value;
        }
    }
    for which in 0..2 {
        rows[mode_row(modes.len()) + which][lane] = vertices
            .iter()
            .map(|&i| step_bounds[i as usize][which])
            .fold(0.0, f32::max);
    }
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

/// The bound of one mode about `centre`, rounded first: whatever the rounding did is in ΔR and b.
fn bound_mode(
    field: &[[f64; 3]],
    centre: [f64; 3],
    arms: &[[f64; 3]],
    depth_roots: &[f64],
    radius: f64,
) -> ModeBound {
    let centre = centre.map(round_nearest);
    let wide = centre.map(f64::from);
    let growth = norm_up(
        field
            .iter()
            .map(|&u| norm2(sub(u, wide)))
            .fold(0.0, f64::max),
    );
    let wide_growth = f64::from(growth);
    if radius == 0.0 || growth == 0.0 {
        return ModeBound {
            centre,
            growth,
            ..ModeBound::default()
        };
    }
    let (mut plus, mut minus) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    for ((&u, &x), &depth_root) in field.iter().zip(arms).zip(depth_roots) {
        let w = sub(u, wide);
        let product = dot(x, w);
        let root = depth_root * excess_root(wide_growth, norm2(w)) * (1.0 - GUARD_PRODUCT);
        plus = plus.max(product - root);
        minus = minus.max(-product - root);
    }
    let guard = GUARD_PRODUCT * radius * wide_growth;
    ModeBound {
        centre,
        growth,
        cross_plus: round_up(plus + guard),
        cross_minus: round_up(minus + guard),
    }
}

/// Which of the two candidates each mode takes so that R'² is least, averaged over the signs of
/// q at |q_j| = q_range_j: all the first, all the second, or a descent from the better of these.
fn choose(candidates: &[[ModeBound; 2]], radius: f64, q_range: impl Fn(usize) -> f32) -> Vec<bool> {
    let q: Vec<f64> = (0..candidates.len())
        .map(|k| f64::from(q_range(k)))
        .collect();
    let cross = |k: usize, which: bool| {
        let bound = candidates[k][usize::from(which)];
        (f64::from(bound.cross_plus) + f64::from(bound.cross_minus)) * q[k]
    };
    let growth = |k: usize, which: bool| f64::from(candidates[k][usize::from(which)].growth) * q[k];
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
