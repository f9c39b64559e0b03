//! Barycentric weights in a tetrahedron.

use super::face::triangle;
use super::{SMALLEST, reach};
use crate::input::volume::trilinear::inverse;
use crate::vec3::{add, dot, norm, scale, sub};

/// The weights of `p`; `None` outside, by more than rounding.
///
/// A point that only rounding puts outside gets the weights of the nearest point of the faces:
/// cutting negative weights off would move it along a flat element by far more.
pub(super) fn weights(corners: &[[f64; 3]; 4], p: [f64; 3]) -> Option<[f64; 4]> {
    let [a, b, c, d] = *corners;
    let edges = [b, c, d].map(|corner| sub(corner, a));
    let rows = inverse(edges)?;
    let r = sub(p, a);
    let first = rows.map(|row| dot(row, r));
    // Once refined, the weights reproduce p to rounding in flat elements too.
    let found = edges
        .iter()
        .zip(first)
        .fold([0.0; 3], |sum, (&e, w)| add(sum, scale(e, w)));
    let left = sub(r, found);
    let [second, third, fourth] = [0, 1, 2].map(|k| first[k] + dot(rows[k], left));
    let weights = [1.0 - second - third - fourth, second, third, fourth];

    let lost = 64.0 * f64::EPSILON * reach(corners, p);
    let slope = add(add(rows[0], rows[1]), rows[2]);
    let slopes = [norm(slope), norm(rows[0]), norm(rows[1]), norm(rows[2])];
    let is_near = weights
        .iter()
        .zip(slopes)
        .all(|(&w, slope)| w >= -lost * slope - SMALLEST);
    if !is_near {
        return None;
    }
    if weights.iter().all(|&w| w >= 0.0) {
        return Some(weights.map(|w| if w > SMALLEST { w } else { 0.0 }));
    }
    let (place, square) = nearest(corners, p);
    (square.sqrt() <= 4.0 * lost).then_some(place)
}

/// The point of the faces nearest to `p`: its weights, and the square of the distance.
fn nearest(corners: &[[f64; 3]; 4], p: [f64; 3]) -> ([f64; 4], f64) {
    let faces = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]].map(|face| {
        let (weights, square) = triangle(face.map(|i| corners[i]), p);
        let mut all = [0.0; 4];
        for (i, weight) in face.into_iter().zip(weights) {
            all[i] = weight;
        }
        (all, square)
    });
    let [first, others @ ..] = faces;
    others
        .into_iter()
        .fold(first, |x, y| if y.1 < x.1 { y } else { x })
}
