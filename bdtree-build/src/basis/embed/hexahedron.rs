//! Trilinear weights in a hexahedron: the inverse of the map from the unit cube.

use crate::input::volume::trilinear::{self, CORNERS, at, inverse, tangents};
use crate::vec3::{dot, norm, sub};

/// Sub-boxes that are looked at, at most, before a point counts as outside.
const BOXES: usize = 4096;

/// Sub-boxes are not halved below this side.
const SMALLEST: f64 = 1.0 / 1024.0;

/// The weights of `p`; `None` outside, by more than rounding.
pub(super) fn weights(corners: &[[f64; 3]; 8], p: [f64; 3]) -> Option<[f64; 8]> {
    let frame = tangents(corners, [0.5; 3]);
    let rows = inverse(frame)?;
    // In the frame of the middle the map is near ξ − ξ(p): bounds are tight, Newton is at home.
    let local = corners.map(|x| rows.map(|row| dot(row, sub(x, p))));
    let reach = corners
        .iter()
        .flatten()
        .fold(0.0_f64, |m, x| m.max(x.abs()));
    let steepest = rows.iter().fold(0.0_f64, |m, &row| m.max(norm(row)));
    let zero = 64.0 * f64::EPSILON * (1.0 + reach * steepest);
    let xi = solve(&local, zero)?;
    let weights = trilinear::weights(xi.map(|x| {
        // As for a tetrahedron's weights.
        let near_end = |end: f64| (x - end).abs() <= 4.0 * f64::EPSILON;
        if near_end(0.0) {
            0.0
        } else if near_end(1.0) {
            1.0
        } else {
            x.clamp(0.0, 1.0)
        }
    }));
    Some(weights)
}

/// The ξ in the unit cube at which the trilinear map with these corner values is zero, to `zero`.
///
/// Newton's method from the middle; where that does not end inside, the cube is halved: values in a
/// sub-box lie between those at its corners, so most of them are ruled out at once.
fn solve(values: &[[f64; 3]; 8], zero: f64) -> Option<[f64; 3]> {
    let inside = |xi: &[f64; 3]| xi.iter().all(|&x| x >= -zero && x <= 1.0 + zero);
    if !may_vanish(values, zero) {
        return None;
    }
    let found = newton(values, [0.5; 3], zero).filter(inside);
    if found.is_some() || is_affine(values) {
        return found;
    }
    let mut boxes = vec![([0.0; 3], 1.0)];
    for _ in 0..BOXES {
        let (low, side): ([f64; 3], f64) = boxes.pop()?;
        let place = |corner: [f64; 3]| [0, 1, 2].map(|a| low[a] + side * corner[a]);
        if !may_vanish(&CORNERS.map(|corner| at(values, place(corner))), zero) {
            continue;
        }
        let found = newton(values, place([0.5; 3]), zero).filter(inside);
        if found.is_some() {
            return found;
        }
        if side > SMALLEST {
            let half = 0.5 * side;
            boxes
                .extend(CORNERS.map(|corner| ([0, 1, 2].map(|a| low[a] + half * corner[a]), half)));
        }
    }
    None
}

/// No component has one sign at all corners.
fn may_vanish(values: &[[f64; 3]; 8], zero: f64) -> bool {
    (0..3).all(|a| values.iter().any(|v| v[a] <= zero) && values.iter().any(|v| v[a] >= -zero))
}

/// The map has no products of coordinates: a parallelepiped, where Newton's first step is exact.
fn is_affine(values: &[[f64; 3]; 8]) -> bool {
    let [o, x, xy, y, z, xz, xyz, yz] = *values;
    (0..3).all(|a| {
        let (dx, dy, dz) = (x[a] - o[a], y[a] - o[a], z[a] - o[a]);
        let near = |found: f64, sum: f64| (found - o[a] - sum).abs() <= 1e-12;
        near(xy[a], dx + dy)
            && near(xz[a], dx + dz)
            && near(yz[a], dy + dz)
            && near(xyz[a], dx + dy + dz)
    })
}

fn newton(values: &[[f64; 3]; 8], start: [f64; 3], zero: f64) -> Option<[f64; 3]> {
    let mut xi = start;
    for _ in 0..20 {
        let rows = inverse(tangents(values, xi))?;
        let value = at(values, xi);
        let step = rows.map(|row| dot(row, value));
        xi = sub(xi, step);
        // The roots wanted are near the cube.
        if !xi.iter().all(|x| x.abs() < 4.0) {
            return None;
        }
        if step.iter().all(|s| s.abs() <= f64::EPSILON) {
            break;
        }
    }
    at(values, xi).iter().all(|f| f.abs() <= zero).then_some(xi)
}
