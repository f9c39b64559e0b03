//! Exact signs: orientation in space and in the coordinate planes, collinearity, 2 × 2 determinants.
//!
//! The `robust` crate transcribes Shewchuk's adaptive predicates ("Adaptive Precision
//! Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997). They are exact while
//! no product underflows or overflows: a product of three differences is a multiple of
//! 2^(3 g) when the coordinates are multiples of 2^g, so numbers that are 0 or between 2⁻³⁰⁰ (g =
//! −352, 3 g > −1074) and 2³⁰⁰ are safe. [`tame`] brings all others there.

use robust::{Coord, Coord3D, orient2d, orient3d};

use super::Triangle;
use crate::math::{cross, dot, sub};
use crate::rounding::HEIGHT_ROUNDING;

/// Smallest and largest magnitude, besides 0, for which the predicates are exact: 2^∓300.
pub(super) const TINY: f64 = f64::from_bits((1023 - 300) << 52);
pub(super) const HUGE: f64 = f64::from_bits((1023 + 300) << 52);
/// 2⁻⁸⁰⁰ brings any finite number below 2³⁰⁰.
const SCALE_DOWN: f64 = f64::from_bits((1023 - 800) << 52);

/// Returns the triangles with coordinates inside the exact range, themselves as a rule.
///
/// Numbers below 2⁻³⁰⁰ become 0. If any is above 2³⁰⁰, all are scaled down first, which is not
/// exact, only safe.
#[inline]
pub(super) fn tame<const N: usize>(tris: [Triangle; N]) -> [Triangle; N] {
    let mut fine = true;
    for x in tris.as_flattened().as_flattened() {
        let m = x.abs();
        fine &= m == 0.0 || (TINY..=HUGE).contains(&m);
    }
    if fine { tris } else { force(tris) }
}

#[cold]
fn force<const N: usize>(mut tris: [Triangle; N]) -> [Triangle; N] {
    let numbers = tris.as_flattened_mut().as_flattened_mut();
    let factor = if numbers.iter().any(|x| x.abs() > HUGE) {
        SCALE_DOWN
    } else {
        1.0
    };
    for x in numbers {
        let y = *x * factor;
        // NaN fails the comparison and becomes 0 too.
        *x = if y.abs() >= TINY { y } else { 0.0 };
    }
    tris
}

#[inline]
fn sign(x: f64) -> i8 {
    i8::from(x > 0.0) - i8::from(x < 0.0)
}

#[inline]
fn coord3([x, y, z]: [f64; 3]) -> Coord3D<f64> {
    Coord3D { x, y, z }
}

/// Returns [`above`] for each corner of `tri` over the plane of `base`.
#[inline]
pub(super) fn sides(base: &Triangle, tri: &Triangle) -> [i8; 3] {
    let [a, b, c] = *base;
    let (e, f) = (sub(b, a), sub(c, a));
    let normal = cross(e, f);
    let (e, f) = (magnitudes(e), magnitudes(f));
    let size = [
        e[1] * f[2] + e[2] * f[1],
        e[2] * f[0] + e[0] * f[2],
        e[0] * f[1] + e[1] * f[0],
    ];
    let mut sides = [0; 3];
    for k in 0..3 {
        let d = sub(tri[k], a);
        let fast = dot(normal, d);
        let error = HEIGHT_ROUNDING * dot(size, magnitudes(d));
        sides[k] = if fast > error {
            1
        } else if fast < -error {
            -1
        } else if k > 0 && tri[k] == tri[k - 1] {
            sides[k - 1]
        } else {
            above_or_in(*base, tri[k])
        };
    }
    sides
}

/// [`above`] where it is likely 0. Segments and points come as triangles with repeated corners: those make it 0 without
/// exact arithmetic, which takes longest there.
#[cold]
fn above_or_in([a, b, c]: Triangle, d: [f64; 3]) -> i8 {
    if a == b || b == c || c == a {
        return 0;
    }
    above(a, b, c, d)
}

#[inline]
fn magnitudes([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x.abs(), y.abs(), z.abs()]
}

/// Returns 1 if `d` is above the plane of `a, b, c` (seen from there they turn left), −1 below, 0 in it.
#[inline]
pub(super) fn above(a: [f64; 3], b: [f64; 3], c: [f64; 3], d: [f64; 3]) -> i8 {
    sign(height(a, b, c, d))
}

/// Returns six times the signed volume under `d` over `a, b, c`; only its sign is exact.
#[inline]
pub(super) fn height(a: [f64; 3], b: [f64; 3], c: [f64; 3], d: [f64; 3]) -> f64 {
    -orient3d(coord3(a), coord3(b), coord3(c), coord3(d))
}

/// Returns 1 if `a, b, c` turn left in the coordinate plane without `axis`, −1 right, 0 if collinear there.
#[inline]
pub(super) fn turn(axis: usize, a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> i8 {
    let flat = |p: [f64; 3]| Coord {
        x: p[(axis + 1) % 3],
        y: p[(axis + 2) % 3],
    };
    sign(orient2d(flat(a), flat(b), flat(c)))
}

/// Returns whether `p` is in the closed triangle, seen along `axis`.
#[inline]
pub(super) fn encloses(axis: usize, [a, b, c]: Triangle, p: [f64; 3]) -> bool {
    let turns = [
        turn(axis, a, b, p),
        turn(axis, b, c, p),
        turn(axis, c, a, p),
    ];
    !turns.contains(&1) || !turns.contains(&-1)
}

/// Returns the first axis whose coordinate plane shows `a, b, c` with an area, none if collinear.
#[inline]
pub(super) fn open_axis(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> Option<usize> {
    (0..3).find(|&axis| turn(axis, a, b, c) != 0)
}

/// Returns `x1 y2 − x2 y1` with the exact sign and a relative error of at most 6 u.
///
/// Products must not underflow: arguments 0 or between 2⁻³⁰⁰ and 2³⁰⁰.
#[inline]
pub(super) fn det2([x1, y1]: [f64; 2], [x2, y2]: [f64; 2]) -> f64 {
    let p = x1 * y2;
    let q = x2 * y1;
    let fast = p - q;
    // Little cancellation: the rounding of the products stays small against the result.
    if fast.abs() * 4.0 > p.abs() + q.abs() {
        return fast;
    }
    // p and q are within a factor of two of each other (or both 0): p − q is exact (Sterbenz), and
    // so is each later sum that cancels.
    let (tail_p, tail_q) = (product_tail(x1, y2, p), product_tail(x2, y1, q));
    let (tail, rest) = two_difference(tail_p, tail_q);
    let (head, more) = two_sum(fast, tail);
    head + (more + rest)
}

/// Returns the exact sign of `normal · x + offset`.
///
/// Products must not under- or overflow: arguments 0 or between 2⁻⁴⁰⁰ and 2⁵⁰⁰.
#[inline]
pub(super) fn plane_side(normal: [f64; 3], offset: f64, x: [f64; 3]) -> i8 {
    let products = [0, 1, 2].map(|k| normal[k] * x[k]);
    let [p, q, r] = products;
    let fast = ((p + q) + r) + offset;
    // Four roundings per term at most, and of the products one.
    let lost = 4.0 * f64::EPSILON * ((p.abs() + q.abs()) + r.abs() + offset.abs());
    if fast.abs() > lost {
        return sign(fast);
    }
    let mut terms = [0.0; 7];
    for k in 0..3 {
        terms[2 * k] = products[k];
        terms[2 * k + 1] = product_tail(normal[k], x[k], products[k]);
    }
    terms[6] = offset;
    sign_of_sum(terms)
}

/// Returns the exact sign of a sum (Shewchuk's grow-expansion: the parts never overlap and grow
/// in magnitude, so the last one that is not 0 decides).
#[cold]
fn sign_of_sum<const N: usize>(terms: [f64; N]) -> i8 {
    let mut parts = [0.0; N];
    for (count, term) in terms.into_iter().enumerate() {
        let mut sum = term;
        for part in &mut parts[..count] {
            (sum, *part) = two_sum(sum, *part);
        }
        parts[count] = sum;
    }
    let last = parts.iter().rev().find(|x| **x != 0.0);
    last.map_or(0, |x| sign(*x))
}

/// Returns the rounding error of `product = a · b` (Dekker, Veltkamp): no fused operation.
#[inline]
fn product_tail(a: f64, b: f64, product: f64) -> f64 {
    let (a1, a2) = split(a);
    let (b1, b2) = split(b);
    a2 * b2 - (((product - a1 * b1) - a2 * b1) - a1 * b2)
}

#[inline]
fn split(a: f64) -> (f64, f64) {
    let c = 134_217_729.0 * a;
    let high = c - (c - a);
    (high, a - high)
}

#[inline]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let x = a + b;
    let b_part = x - a;
    let a_part = x - b_part;
    (x, (a - a_part) + (b - b_part))
}

#[inline]
fn two_difference(a: f64, b: f64) -> (f64, f64) {
    two_sum(a, -b)
}

#[cfg(test)]
mod tests {
    use num_rational::BigRational;
    use num_traits::{Signed, ToPrimitive, Zero};
    use rand::{RngExt, SeedableRng};

    use super::{det2, plane_side};

    #[test]
    fn det2_has_the_exact_sign_and_full_precision() {
        let exact = |x: f64| BigRational::from_float(x).expect("finite");
        let mut r = rand_pcg::Pcg64::seed_from_u64(1);
        for case in 0..20_000 {
            let mut number = || {
                let x: f64 = r.random_range(-1.0..1.0);
                // Few digits make exact zeros.
                if case % 3 == 0 { (x * 8.0).round() } else { x }
            };
            let [x, y, k] = [number(), number(), number()];
            // Nearly dependent, up to a few units in the last place.
            let nudge = |v: f64| v * (1.0 + f64::from(case % 5 - 2) * f64::EPSILON);
            let (p, q) = ([x, y], [nudge(x * k), y * k]);
            let truth = exact(p[0]) * exact(q[1]) - exact(q[0]) * exact(p[1]);
            let got = det2(p, q);
            assert_eq!(got, -det2(q, p), "antisymmetric");
            if truth.is_zero() {
                assert_eq!(got, 0.0);
            } else {
                let error = ((exact(got) - &truth) / &truth).abs();
                assert!(error.to_f64().expect("in range") <= 3.0 * f64::EPSILON);
            }
        }
    }

    #[test]
    fn plane_side_has_the_exact_sign() {
        let exact = |x: f64| BigRational::from_float(x).expect("finite");
        let mut r = rand_pcg::Pcg64::seed_from_u64(2);
        let mut zeros = 0;
        for case in 0..20_000 {
            let mut number = || {
                let x: f64 = r.random_range(-1.0..1.0);
                if case % 3 == 0 { (x * 8.0).round() } else { x }
            };
            let normal = [number(), number(), number()];
            let x = [number(), number(), number()];
            // On the plane up to a few units in the last place.
            let height = normal[0] * x[0] + normal[1] * x[1] + normal[2] * x[2];
            let offset = -height * (1.0 + f64::from(case % 5 - 2) * f64::EPSILON);
            let mut truth = exact(offset);
            for k in 0..3 {
                truth += exact(normal[k]) * exact(x[k]);
            }
            let expected = i8::from(truth.is_positive()) - i8::from(truth.is_negative());
            assert_eq!(plane_side(normal, offset, x), expected);
            zeros += i32::from(expected == 0);
        }
        assert!(zeros > 1000, "{zeros}");
    }
}
