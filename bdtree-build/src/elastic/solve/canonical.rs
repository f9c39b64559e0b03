//! One choice among equals: vectors within a cluster of equal frequencies, and signs.

use faer::{Mat, MatRef};

use crate::elastic::assemble::system::System;
use crate::vec3::{bounds, norm};

/// Neighbouring eigenvalues with a smaller relative gap form a cluster.
pub(crate) const CLUSTER_GAP: f64 = 1e-6;
/// Of test fields that a cluster follows nearly as well, the first one is taken.
const TIE: f64 = 0.99;

/// Ends of the clusters in ascending values.
pub(crate) fn clusters(values: &[f64]) -> Vec<std::ops::Range<usize>> {
    let mut result = Vec::new();
    let mut start = 0;
    for i in 1..=values.len() {
        if i == values.len() || values[i] - values[i - 1] > CLUSTER_GAP * values[i].abs() {
            result.push(start..i);
            start = i;
        }
    }
    result
}

/// Turns the vectors of each cluster so that they depend on the space they span alone: the first
/// is the projection of the fixed test field that the space follows best, the next one likewise
/// in what remains. The fields are the monomials up to third degree along each axis.
pub(crate) fn turn_clusters(system: &System, vectors: &mut Mat<f64>, values: &[f64]) {
    let clusters: Vec<_> = clusters(values)
        .into_iter()
        .filter(|c| c.len() > 1)
        .collect();
    if clusters.is_empty() {
        return;
    }
    let fields = test_fields(system);
    let weighted = system.apply_mass(fields.as_ref());
    let lengths: Vec<f64> = (0..fields.ncols())
        .map(|j| {
            (0..fields.nrows())
                .map(|i| fields[(i, j)] * weighted[(i, j)])
                .sum::<f64>()
                .sqrt()
        })
        .collect();
    for cluster in clusters {
        let x = vectors
            .as_ref()
            .subcols(cluster.start, cluster.len())
            .to_owned();
        let mut c = x.transpose() * &weighted;
        for j in 0..c.ncols() {
            for i in 0..c.nrows() {
                c[(i, j)] /= lengths[j].max(f64::MIN_POSITIVE);
            }
        }
        let turn = rotation(c);
        vectors
            .as_mut()
            .subcols_mut(cluster.start, cluster.len())
            .copy_from(x * turn);
    }
}

/// Orthogonal matrix whose columns follow the best columns of `c`, one after the other.
pub(crate) fn rotation(mut c: Mat<f64>) -> Mat<f64> {
    let d = c.nrows();
    let mut turn = Mat::<f64>::zeros(d, d);
    let mut done = 0;
    for _ in 0..d {
        let length = |c: MatRef<'_, f64>, j: usize| {
            (0..d).map(|i| c[(i, j)] * c[(i, j)]).sum::<f64>().sqrt()
        };
        let best = (0..c.ncols())
            .map(|j| length(c.as_ref(), j))
            .fold(0.0, f64::max);
        let found = (0..c.ncols()).find(|&j| length(c.as_ref(), j) >= TIE * best);
        let Some(j) = found.filter(|_| best > 1e-9) else {
            break;
        };
        let l = length(c.as_ref(), j);
        let axis: Vec<f64> = (0..d).map(|i| c[(i, j)] / l).collect();
        for (i, &a) in axis.iter().enumerate() {
            turn[(i, done)] = a;
        }
        done += 1;
        for j in 0..c.ncols() {
            let along: f64 = (0..d).map(|i| c[(i, j)] * axis[i]).sum();
            for (i, &a) in axis.iter().enumerate() {
                c[(i, j)] -= along * a;
            }
        }
    }
    complete(&mut turn, done);
    turn
}

/// Fills up an orthogonal matrix (no test field saw the rest: any completion will do).
fn complete(turn: &mut Mat<f64>, mut done: usize) {
    let d = turn.nrows();
    for unit in 0..d {
        if done == d {
            return;
        }
        let mut v: Vec<f64> = (0..d).map(|i| f64::from(i == unit)).collect();
        for _ in 0..2 {
            for k in 0..done {
                let along: f64 = (0..d).map(|i| turn[(i, k)] * v[i]).sum();
                for (i, x) in v.iter_mut().enumerate() {
                    *x -= along * turn[(i, k)];
                }
            }
        }
        let l = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if l > 1e-3 {
            for (i, x) in v.iter().enumerate() {
                turn[(i, done)] = x / l;
            }
            done += 1;
        }
    }
}

fn test_fields(system: &System) -> Mat<f64> {
    let (lo, hi) = bounds(system.nodes.iter().copied());
    let reach = (0..3).map(|a| hi[a] - lo[a]).fold(0.0, f64::max);
    let reach = if reach > 0.0 { reach } else { 1.0 };
    let mut exponents = Vec::new();
    for degree in 1..=3i32 {
        for a in (0..=degree).rev() {
            for b in (0..=degree - a).rev() {
                exponents.push([a, b, degree - a - b]);
            }
        }
    }
    let mut fields = Mat::from_fn(system.size(), 3 * exponents.len(), |i, j| {
        if i % 3 != j % 3 {
            return 0.0;
        }
        let node = system.nodes[i / 3];
        (0..3)
            .map(|a| {
                let middle = 0.5 * (lo[a] + hi[a]);
                (2.0 * (node[a] - middle) / reach).powi(exponents[j / 3][a])
            })
            .product()
    });
    system.clear_held(&mut fields);
    fields
}

/// Scales a field so that the farthest vertex moves by 1, its leading component positive; returns
/// the factor, or `None` if nothing moves.
pub(crate) fn normalise(field: &mut [[f64; 3]]) -> Option<f64> {
    let farthest = field.iter().map(|&v| norm(v)).fold(0.0, f64::max);
    if farthest.is_nan() || farthest <= 0.0 {
        return None;
    }
    let sign = leading_sign(field);
    let factor = sign / farthest;
    for v in field.iter_mut().flatten() {
        *v = *v * factor + 0.0; // + 0.0: no negative zeros
    }
    Some(factor)
}

/// 1, or −1 if the leading component of the field is negative: the first of the largest.
pub(crate) fn leading_sign(field: &[[f64; 3]]) -> f64 {
    let largest = field.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    // Symmetric bodies have several largest components; rounding must not choose among them.
    let lead = field
        .iter()
        .flatten()
        .find(|x| x.abs() >= (1.0 - 1e-6) * largest);
    if lead.is_some_and(|x| *x < 0.0) {
        -1.0
    } else {
        1.0
    }
}
