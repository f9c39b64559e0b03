//! The point of a face nearest to a point in space.

use crate::vec3::{add, cross, dot, scale, sub};

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
    let edges = [0, 1, 2].map(|i| {
        let j = (i + 1) % 3;
        let mut weights = [0.0; 3];
        [weights[i], weights[j]] = segment(corners[i], corners[j], p);
        (weights, square_distance(&corners, &weights, p))
    });
    let [first, others @ ..] = edges;
    others.into_iter().fold(first, nearer)
}

/// The same for the bilinear surface through four corners.
///
/// The nearest point lies on an edge, which is straight, or inside, where steps lead to it from
/// one of [`STARTS`].
pub(super) fn quadrilateral(corners: [[f64; 3]; 4], p: [f64; 3]) -> ([f64; 4], f64) {
    let [a, b, c, d] = corners;
    let twist = sub(add(a, c), add(b, d));
    let diagonal = sub(c, a);
    if dot(twist, twist) <= FLAT * dot(diagonal, diagonal) {
        // A parallelogram: two triangles are the face.
        let (lower, upper) = (triangle([a, b, c], p), triangle([a, c, d], p));
        let place = if lower.1 <= upper.1 {
            [lower.0[1] + lower.0[2], lower.0[2]]
        } else {
            [upper.0[1], upper.0[1] + upper.0[2]]
        };
        let weights = bilinear(place.map(|x| x.clamp(0.0, 1.0)));
        return (weights, square_distance(&corners, &weights, p));
    }
    let edges = [0, 1, 2, 3].map(|i| {
        let j = (i + 1) % 4;
        let mut weights = [0.0; 4];
        [weights[i], weights[j]] = segment(corners[i], corners[j], p);
        (weights, square_distance(&corners, &weights, p))
    });
    let inside = STARTS.map(|start| descend(&corners, start, p));
    let [first, others @ ..] = edges;
    others.into_iter().chain(inside).fold(first, nearer)
}

/// With fewer, nearest points were missed on faces as twisted as are read at all.
const STARTS: [[f64; 2]; 5] = [[0.5, 0.5], [0.2, 0.2], [0.8, 0.2], [0.8, 0.8], [0.2, 0.8]];

/// Squares of lengths, one over the other, by which a face may differ from a parallelogram.
const FLAT: f64 = 1e-28;

fn nearer<W>(x: (W, f64), y: (W, f64)) -> (W, f64) {
    if y.1 < x.1 { y } else { x }
}

/// The weights of the ends at the point of a segment nearest to `p`.
fn segment(a: [f64; 3], b: [f64; 3], p: [f64; 3]) -> [f64; 2] {
    let along = sub(b, a);
    let t = dot(sub(p, a), along) / dot(along, along);
    // A segment without length is its first end.
    let t = if t.is_finite() {
        t.clamp(0.0, 1.0)
    } else {
        0.0
    };
    [1.0 - t, t]
}

/// Goes down from `start` as far as steps lead, kept inside the face.
fn descend(corners: &[[f64; 3]; 4], start: [f64; 2], p: [f64; 3]) -> ([f64; 4], f64) {
    let mut best = start.map(|x| x.clamp(0.0, 1.0));
    let mut square = square_distance(corners, &bilinear(best), p);
    for _ in 0..32 {
        let Some(delta) = step(corners, best, p) else {
            break;
        };
        // The whole step, or a part of it where the surface bends too much.
        let nearer = [1.0, 0.5, 0.25, 0.125].into_iter().find_map(|part| {
            let next = [0, 1].map(|k| (best[k] + part * delta[k]).clamp(0.0, 1.0));
            let found = square_distance(corners, &bilinear(next), p);
            (found < square).then_some((next, found))
        });
        let Some(nearer) = nearer else {
            break;
        };
        (best, square) = nearer;
    }
    (bilinear(best), square)
}

/// Corners lie at (0, 0), (1, 0), (1, 1), (0, 1).
fn bilinear([s, t]: [f64; 2]) -> [f64; 4] {
    [(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t]
}

/// One step for |x(s, t) − p|²: Newton's where the second derivatives have a minimum, else that of
/// Gauss and Newton, which leaves out the twist of the surface.
fn step(corners: &[[f64; 3]; 4], [s, t]: [f64; 2], p: [f64; 3]) -> Option<[f64; 2]> {
    let [a, b, c, d] = *corners;
    let mix = |x, y, w: f64| add(scale(x, 1.0 - w), scale(y, w));
    let (along_s, along_t) = (mix(sub(b, a), sub(c, d), t), mix(sub(d, a), sub(c, b), s));
    let off = sub(mix(mix(a, b, s), mix(d, c, s), t), p);
    let twist = sub(add(a, c), add(b, d));
    let (f, g) = (dot(along_s, off), dot(along_t, off));
    let (ss, st, tt) = (
        dot(along_s, along_s),
        dot(along_s, along_t),
        dot(along_t, along_t),
    );
    let newton = st + dot(twist, off);
    let st = if newton * newton < ss * tt {
        newton
    } else {
        st
    };
    let whole = ss * tt - st * st;
    let delta = [(st * g - tt * f) / whole, (st * f - ss * g) / whole];
    delta.iter().all(|x| x.is_finite()).then_some(delta)
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
