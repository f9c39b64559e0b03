//! What can be asked of a posed mesh: [`Query`] of one, [`PairQuery`] of two.
//! The crate's documentation lists all queries, options and rules for arguments, under *Queries*.

mod ball;
mod bone_box;
mod bounds;
mod budget;
mod capsule;
mod cuboid;
mod distance;
mod front;
mod frustum;
mod half_space;
mod level;
mod line;
mod manifold;
mod pair;
mod pairs;
mod project;
mod ray;
mod rays;
mod root_box;
mod side;
mod single;

pub use bounds::{Aabb, BoundingSphere};
pub use budget::{Budgeted, BudgetedContacts};
pub use front::PairFront;
pub(crate) use manifold::ManifoldSlot;
pub use manifold::{ContactManifold, ContactPoint};
pub use pairs::{BudgetedPairQuery, PairQuery};
pub use single::{BudgetedQuery, Query};

use crate::error::QueryError;
use crate::math::norm;
use crate::rounding::MARGIN;
use crate::simd::{Quad, add3, dot3};

/// Largest magnitude of a coordinate or length that queries take: 2^100.
pub(crate) const ARGUMENT_MAX: f64 = (1_u128 << 100) as f64;

/// A point whose coordinates are finite and at most 2^100.
fn point(x: [f64; 3], what: &'static str) -> Result<[f64; 3], QueryError> {
    if x.iter().all(|c| c.abs() <= ARGUMENT_MAX) {
        Ok(x)
    } else {
        Err(QueryError::Argument(what))
    }
}

/// A length that is not negative and at most 2^100.
pub(crate) fn length(x: f64, what: &'static str) -> Result<f64, QueryError> {
    if (0.0..=ARGUMENT_MAX).contains(&x) {
        Ok(x)
    } else {
        Err(QueryError::Argument(what))
    }
}

/// A largest distance. Nothing is farther than 2^100, so that what programs take for no limit is one, such as `f64::MAX`.
fn limit(max_distance: f64) -> Result<f64, QueryError> {
    if max_distance > ARGUMENT_MAX {
        Ok(f64::INFINITY)
    } else {
        length(max_distance, "max_distance: negative or NaN")
    }
}

/// A vector scaled to unit length; not finite and zero ones are refused.
#[inline(always)] // rays begin with it
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

/// Which of four triangles (of each corner, of each coordinate, that of the four) are certainly farther
/// than `reach` from a point (all in stored units): the plane through the point across the direction of
/// the corners' mean, moved by `reach`, leaves all corners beyond. Anything not proved is not beyond,
/// NaN included.
#[inline(always)]
fn beyond_four<Q: Quad>(corners: &[[[f32; 4]; 3]; 3], point: [f32; 3], reach: f64) -> u8 {
    let mut d = [[Q::splat(0.0); 3]; 3];
    for i in 0..3 {
        for k in 0..3 {
            d[i][k] = Q::widen(&corners[i][k]).sub(Q::splat(f64::from(point[k])));
        }
    }
    let n = add3(add3(d[0], d[1]), d[2]);
    // Squares cannot underflow.
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
