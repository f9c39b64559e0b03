//! The point of a face nearest to a point in space.

use crate::elastic::vec3::{add, cross, dot, scale, sub};

/// The weights of the corners at the point of a triangle nearest to `p`, and the square of the
/// distance.
pub(super) fn triangle(corners: [[f64; 3]; 3], p: [f64; 3]) -> ([f64; 3], f64) {
    let [a, b, c] = corners;
    let (u, v, r) = (sub(b, a), sub(c, a), sub(p, a));
    let normal = cross(u, v);
    let square = dot(normal, normal);
    // The weights of b and c at the foot of the perpendicular.
    let second = dot(cross(r, v), normal) / square;
    let third = dot(cross(u, r), normal) / square;
    let weights = [1.0 - second - third, second, third];
    if weights.iter().all(|&w| w >= 0.0) {
        return (weights, square_distance(&corners, &weights, p));
    }
    // Else, and for a triangle without area, on the nearest edge.
    let edge = |i: usize, j: usize| {
        let along = sub(corners[j], corners[i]);
        let t = dot(sub(p, corners[i]), along) / dot(along, along);
        let t = if t.is_finite() {
            t.clamp(0.0, 1.0)
        } else {
            0.0
        };
        let mut weights = [0.0; 3];
        weights[i] = 1.0 - t;
        weights[j] = t;
        (weights, square_distance(&corners, &weights, p))
    };
    let (first, others) = (edge(0, 1), [edge(1, 2), edge(2, 0)]);
    let nearer = |x: ([f64; 3], f64), y: ([f64; 3], f64)| if y.1 < x.1 { y } else { x };
    others.into_iter().fold(first, nearer)
}

/// The same for the bilinear surface through four corners.
///
/// Starts from the nearer of the two triangles (exact for parallelograms) and descends by
/// Gauss-Newton steps, kept inside the face: a local minimum, which for faces that are not folded is
/// the nearest point.
pub(super) fn quadrilateral(corners: [[f64; 3]; 4], p: [f64; 3]) -> ([f64; 4], f64) {
    let [a, b, c, d] = corners;
    let (lower, upper) = (triangle([a, b, c], p), triangle([a, c, d], p));
    // Corners lie at (0, 0), (1, 0), (1, 1), (0, 1).
    let start = if lower.1 <= upper.1 {
        let [_, b, c] = lower.0;
        [b + c, c]
    } else {
        let [_, c, d] = upper.0;
        [c, c + d]
    };
    let mut best = start.map(|x| x.clamp(0.0, 1.0));
    let mut square = square_distance(&corners, &bilinear(best), p);
    for _ in 0..32 {
        let Some(next) = step(&corners, best, p) else {
            break;
        };
        let found = square_distance(&corners, &bilinear(next), p);
        if !(found < square) {
            break;
        }
        (best, square) = (next, found);
    }
    (bilinear(best), square)
}

fn bilinear([s, t]: [f64; 2]) -> [f64; 4] {
    [(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t]
}

/// One Gauss-Newton step for |x(s, t) − p|², with the parameters held that would leave the face.
fn step(corners: &[[f64; 3]; 4], at: [f64; 2], p: [f64; 3]) -> Option<[f64; 2]> {
    let [a, b, c, d] = *corners;
    let [s, t] = at;
    let mix = |x, y, w: f64| add(scale(x, 1.0 - w), scale(y, w));
    let along = [mix(sub(b, a), sub(c, d), t), mix(sub(d, a), sub(c, b), s)];
    let off = sub(mix(mix(a, b, s), mix(d, c, s), t), p);
    let slope = along.map(|x| dot(x, off));
    let is_held = |k: usize| (at[k] <= 0.0 && slope[k] > 0.0) || (at[k] >= 1.0 && slope[k] < 0.0);
    let (ss, st, tt) = (
        dot(along[0], along[0]),
        dot(along[0], along[1]),
        dot(along[1], along[1]),
    );
    let delta = match (is_held(0), is_held(1)) {
        (true, true) => return None,
        (true, false) => [0.0, -slope[1] / tt],
        (false, true) => [-slope[0] / ss, 0.0],
        (false, false) => {
            let whole = ss * tt - st * st;
            [
                (st * slope[1] - tt * slope[0]) / whole,
                (st * slope[0] - ss * slope[1]) / whole,
            ]
        }
    };
    let next = [0, 1].map(|k| (at[k] + delta[k]).clamp(0.0, 1.0));
    next.iter().all(|x| x.is_finite()).then_some(next)
}

fn square_distance<const N: usize>(
    corners: &[[f64; 3]; N],
    weights: &[f64; N],
    p: [f64; 3],
) -> f64 {
    let pairs = corners.iter().zip(weights);
    let off = pairs.fold(scale(p, -1.0), |sum, (&x, &w)| add(sum, scale(x, w)));
    dot(off, off)
}
