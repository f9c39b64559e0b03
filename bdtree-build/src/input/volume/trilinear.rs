//! The map from the unit cube onto a hexahedron: x(ξ) = Σ N_i(ξ) x_i.

use crate::vec3::{add, cross, dot, norm, scale, sub};

/// Where each corner of VTK's order lies in the unit cube.
pub(crate) const CORNERS: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];

/// The weights N_i(ξ) of the corners; they add up to 1.
pub(crate) fn weights(xi: [f64; 3]) -> [f64; 8] {
    CORNERS.map(|corner| {
        let side = |a: usize| {
            if corner[a] == 0.0 { 1.0 - xi[a] } else { xi[a] }
        };
        side(0) * side(1) * side(2)
    })
}

/// x(ξ).
pub(crate) fn at(corners: &[[f64; 3]; 8], xi: [f64; 3]) -> [f64; 3] {
    let weighted = corners.iter().zip(weights(xi));
    weighted.fold([0.0; 3], |sum, (&x, w)| add(sum, scale(x, w)))
}

/// ∂x/∂ξ_a for a = 0, 1, 2: the columns of the Jacobian matrix.
pub(crate) fn tangents(corners: &[[f64; 3]; 8], xi: [f64; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|a| {
        let end = |value: f64| {
            let mut end = xi;
            end[a] = value;
            at(corners, end)
        };
        sub(end(1.0), end(0.0))
    })
}

/// (a × b) · c.
pub(crate) fn determinant([a, b, c]: [[f64; 3]; 3]) -> f64 {
    dot(cross(a, b), c)
}

/// The rows of the inverse of the matrix of these columns; `None` if it has none.
pub(crate) fn inverse(columns: [[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let [a, b, c] = columns;
    let factor = 1.0 / determinant(columns);
    let rows = [cross(b, c), cross(c, a), cross(a, b)].map(|row| scale(row, factor));
    rows.iter().flatten().all(|x| x.is_finite()).then_some(rows)
}

/// How far from zero rounding can carry the determinant of `columns`: its own, and that of the
/// corners' coordinates, by which a flat element may seem to have a height.
pub(super) fn rounding(corners: &[[f64; 3]], columns: [[f64; 3]; 3]) -> f64 {
    let lengths = columns.map(norm);
    let longest = lengths.iter().fold(0.0_f64, |m, &l| m.max(l));
    let reach = corners
        .iter()
        .flatten()
        .fold(0.0_f64, |m, x| m.max(x.abs()));
    let own = 16.0 * lengths.iter().product::<f64>();
    f64::EPSILON * (own + 8.0 * reach * longest * longest)
}
