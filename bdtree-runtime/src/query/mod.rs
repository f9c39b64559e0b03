//! The public questions: what a ball, a plane, a ray, a point or another deforming mesh touches.
//!
//! Every query takes an asset, a pose and the caller's stack ([`Asset::stack_len`](crate::Asset::stack_len) or
//! [`Asset::pair_stack_len`](crate::Asset::pair_stack_len) entries), speaks world coordinates and answers exactly what testing
//! every triangle with the same leaf arithmetic would. Triangles are closed, two-sided; those of
//! zero area act as segment or point. Limits are inclusive.

mod ball;
mod closest;
mod pair;
mod plane;
mod ray;

pub use ball::ball;
pub use closest::closest;
pub use pair::pair;
pub use plane::plane;
pub use ray::ray;

use crate::error::QueryError;
use crate::math::{add, dot, norm};
use crate::simd::{Quad, add3, dot3};

/// What a query did besides reporting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outcome {
    /// Node bounds evaluated.
    pub nodes_visited: u64,
    /// The sink had no room for everything: what it took is part of the answer.
    pub truncated: bool,
}

/// The answer of a query that looks for one best triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest<T> {
    /// The best one, if there is any within the limit.
    pub hit: Option<T>,
    /// Node bounds evaluated.
    pub nodes_visited: u64,
}

/// Largest magnitude of a coordinate or length that queries take: 2^100.
const ARGUMENT_MAX: f64 = (1_u128 << 100) as f64;

/// Relative error of a squared f32 distance, and of a sum of radii, with room to spare.
const SKIP: f32 = 1.0 - 1.0 / (1 << 20) as f32;

/// A point whose coordinates are finite and at most 2^100.
fn point(x: [f64; 3], what: &'static str) -> Result<[f64; 3], QueryError> {
    if x.iter().all(|c| c.abs() <= ARGUMENT_MAX) {
        Ok(x)
    } else {
        Err(QueryError::Argument(what))
    }
}

/// A length that is not negative and at most 2^100.
fn length(x: f64, what: &'static str) -> Result<f64, QueryError> {
    if (0.0..=ARGUMENT_MAX).contains(&x) {
        Ok(x)
    } else {
        Err(QueryError::Argument(what))
    }
}

/// A limit that may be infinite.
fn limit(x: f64, what: &'static str) -> Result<f64, QueryError> {
    if x == f64::INFINITY {
        Ok(x)
    } else {
        length(x, what)
    }
}

/// A vector scaled to unit length; not finite and zero ones are refused.
fn unit(v: [f64; 3], what: &'static str) -> Result<[f64; 3], QueryError> {
    let largest = v.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    if !v.iter().all(|c| c.is_finite()) || largest == 0.0 {
        return Err(QueryError::Argument(what));
    }
    // Dividing first keeps the squares from under- or overflowing.
    let v = v.map(|c| c / largest);
    let n = norm(v);
    Ok(v.map(|c| c / n))
}

/// f64: a few roundings of 2⁻⁵³ per term, against 2⁻⁴⁰ taken off; squares cannot underflow.
const MARGIN: f64 = 1.0 / (1_u64 << 40) as f64;

/// Whether a triangle is certainly farther than `reach` from a point (all in stored units): the
/// plane through the point across the direction of the corners' mean, moved by `reach`, leaves
/// all corners beyond. Anything not proved is not beyond, NaN included.
#[inline(always)]
fn beyond(corners: &[[f32; 3]; 3], point: [f32; 3], reach: f64) -> bool {
    let mut d = [[0.0; 3]; 3];
    for i in 0..3 {
        for k in 0..3 {
            d[i][k] = f64::from(corners[i][k]) - f64::from(point[k]);
        }
    }
    let n = add(add(d[0], d[1]), d[2]);
    let limit = reach * reach * dot(n, n) * (1.0 + MARGIN);
    let mut beyond = true;
    for d in d {
        let size = (d[0] * n[0]).abs() + (d[1] * n[1]).abs() + (d[2] * n[2]).abs();
        let low = dot(d, n) - MARGIN * size;
        beyond &= (low > 0.0) & (low * low > limit);
    }
    beyond
}

/// [`beyond`] for four triangles (of each corner, of each coordinate, that of the four).
#[inline(always)]
fn beyond_four<Q: Quad>(corners: &[[[f32; 4]; 3]; 3], point: [f32; 3], reach: f64) -> u8 {
    let mut d = [[Q::splat(0.0); 3]; 3];
    for i in 0..3 {
        for k in 0..3 {
            d[i][k] = Q::widen(&corners[i][k]).sub(Q::splat(f64::from(point[k])));
        }
    }
    let n = add3(add3(d[0], d[1]), d[2]);
    let limit = dot3(n, n).mul(Q::splat(reach * reach * (1.0 + 4.0 * MARGIN)));
    let mut all = Q::splat(1.0).above(Q::splat(0.0));
    for d in d {
        let terms = [d[0].mul(n[0]), d[1].mul(n[1]), d[2].mul(n[2])];
        let size = terms[0].abs().add(terms[1].abs()).add(terms[2].abs());
        let sum = terms[0].add(terms[1]).add(terms[2]);
        let low = sum.sub(size.mul(Q::splat(MARGIN)));
        all = Q::both(all, low.above(Q::splat(0.0)));
        all = Q::both(all, low.mul(low).above(limit));
    }
    Q::bits(all)
}
