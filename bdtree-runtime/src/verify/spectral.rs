//! Spectral norms of 3 × M blocks, compared with a bound.

use crate::rounding::CHECKED_STEP;

/// Whether the largest eigenvalue of a symmetric positive semidefinite matrix is at most
/// `bound²`, up to the guard: whether bound² I − G has no negative pivot. Pivots are the largest
/// diagonal entries left, so that rounding stays at a few times 2⁻⁵³ of bound², and a negative
/// eigenvalue −η leaves a last pivot of −η or less.
pub(super) fn at_most_square(g: &[[f64; 3]; 3], bound: f64) -> bool {
    let square = bound * bound;
    if g[0][0] + g[1][1] + g[2][2] <= square {
        return true; // the common case, and the trace bounds the largest eigenvalue
    }
    let slack = CHECKED_STEP * square;
    let mut a = *g;
    for (r, row) in a.iter_mut().enumerate() {
        for (c, x) in row.iter_mut().enumerate() {
            *x = if r == c { square - *x } else { -*x };
        }
    }
    let mut left = [true; 3];
    for _ in 0..3 {
        let open = |i: &usize| left[*i];
        let Some(p) = (0..3)
            .filter(open)
            .max_by(|i, j| a[*i][*i].total_cmp(&a[*j][*j]))
        else {
            break;
        };
        let pivot = a[p][p];
        if pivot <= slack {
            // What is left has no larger diagonal: only near zero is it not negative.
            return (0..3).filter(open).all(|i| {
                a[i][i] >= -slack
                    && (0..3)
                        .filter(open)
                        .all(|j| i == j || a[i][j].abs() <= slack)
            });
        }
        left[p] = false;
        for i in 0..3 {
            for j in 0..3 {
                if left[i] && left[j] {
                    a[i][j] -= a[i][p] * a[p][j] / pivot;
                }
            }
        }
    }
    true
}
