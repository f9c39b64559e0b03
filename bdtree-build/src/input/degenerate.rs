//! Whether a triangle has an area.

use crate::vec3::{cross, norm2};

/// True if the triangle's area is zero as far as f64 can tell: the cross product of two edges is
/// no longer than its own rounding error.
pub(super) fn is_degenerate(corners: [[f64; 3]; 3]) -> bool {
    // Relative to the product of the edges; the cross product's rounding error is below 4 ε of it.
    const TOLERANCE: f64 = 8.0 * f64::EPSILON;
    let [a, b, c] = corners;
    // Quarter lengths: a difference of finite numbers then stays finite.
    let edge = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|k| 0.25 * q[k] - 0.25 * p[k]);
    let (mut e, mut f) = (edge(a, b), edge(a, c));
    // To unit size, so that neither tiny nor huge meshes leave the range of f64.
    for v in [&mut e, &mut f] {
        let size = v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if size == 0.0 {
            return true;
        }
        *v = v.map(|x| x / size);
    }
    norm2(cross(e, f)) <= TOLERANCE * TOLERANCE * norm2(e) * norm2(f)
}
