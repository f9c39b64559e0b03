//! Distances in rational arithmetic, to measure what f64 and f32 lose.

use bdtree_runtime::narrow::Triangle;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

type Point = [BigRational; 3];

fn exact(p: [f64; 3]) -> Point {
    p.map(|x| BigRational::from_float(x).expect("finite"))
}

fn minus(a: &Point, b: &Point) -> Point {
    [0, 1, 2].map(|k| &a[k] - &b[k])
}

fn dot(a: &Point, b: &Point) -> BigRational {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &Point, b: &Point) -> Point {
    [0, 1, 2].map(|k| &a[(k + 1) % 3] * &b[(k + 2) % 3] - &a[(k + 2) % 3] * &b[(k + 1) % 3])
}

/// ‖p − (a + t (b − a))‖² at its least for t in 0..=1.
fn to_segment(p: &Point, a: &Point, b: &Point) -> BigRational {
    let (e, w) = (minus(b, a), minus(p, a));
    let (ee, ew) = (dot(&e, &e), dot(&w, &e));
    let far = |x: &Point| dot(x, x);
    if ee.is_zero() || !ew.is_positive() {
        far(&w)
    } else if ew >= ee {
        far(&minus(p, b))
    } else {
        far(&w) - &ew * &ew / ee
    }
}

/// The squared distance of a point and a triangle, which may be without area, as a segment or point.
pub fn squared_distance(to: [f64; 3], triangle: &Triangle) -> BigRational {
    let p = exact(to);
    let [a, b, c] = triangle.map(exact);
    let n = cross(&minus(&b, &a), &minus(&c, &a));
    let sides = [(&a, &b), (&b, &c), (&c, &a)];
    // Inside where the normal's prism holds the point.
    let is_above = sides
        .iter()
        .all(|(u, v)| !dot(&cross(&n, &minus(v, u)), &minus(&p, u)).is_negative());
    let nn = dot(&n, &n);
    if !nn.is_zero() && is_above {
        let height = dot(&n, &minus(&p, &a));
        return &height * &height / nn;
    }
    let [ab, bc, ca] = sides.map(|(u, v)| to_segment(&p, u, v));
    ab.min(bc).min(ca)
}

/// The distance of a point and the nearest triangle, exact but for the root and a last rounding to f64.
/// Triangles whose corners in f64 say that they are plainly farther than `near` are passed over.
///
/// # Panics
/// When nothing is left, so `near` was too small.
pub fn distance(to: [f64; 3], triangles: &[Triangle], near: f64) -> f64 {
    let limit = near * (1.0 + 1e-6);
    let beyond = |t: &&Triangle| {
        let apart = |k: usize| {
            let low = t.iter().map(|x| x[k]).fold(f64::INFINITY, f64::min);
            let high = t.iter().map(|x| x[k]).fold(f64::NEG_INFINITY, f64::max);
            (low - to[k]).max(to[k] - high)
        };
        apart(0).max(apart(1)).max(apart(2)) <= limit
    };
    let least = triangles
        .iter()
        .filter(beyond)
        .map(|t| squared_distance(to, t))
        .min();
    root(&least.expect("a triangle that is near"))
}

/// The square root, from a number scaled by an even power of two so that f64 can hold it.
pub fn root(square: &BigRational) -> f64 {
    if square.is_zero() {
        return 0.0;
    }
    let bits = |x: &num_bigint::BigInt| x.bits() as i64;
    let half = (bits(square.numer()) - bits(square.denom())).div_euclid(2);
    let two = BigRational::from_float(2.0).expect("finite");
    let scaled = square / two.pow(i32::try_from(2 * half).expect("an exponent of f64"));
    let mantissa = scaled.to_f64().expect("near 1").sqrt();
    mantissa * 2_f64.powi(half as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_known_by_hand() {
        let t: Triangle = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let cases = [
            ([1.0, 1.0, 3.0], t, 3.0),
            ([1.0, 1.0, 0.0], t, 0.0),
            ([-3.0, -4.0, 0.0], t, 5.0),
            ([2.0, -3.0, 4.0], t, 5.0),
            ([4.0, 4.0, 1.0], t, 3.0),
            ([8.0, 3.0, 0.0], t, 5.0),
            ([1.0, 2.0, 2.0], [[0.0; 3]; 3], 3.0),
            (
                [2.0, 3.0, 4.0],
                [[0.0; 3], [4.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
                5.0,
            ),
        ];
        for (p, t, expected) in cases {
            for turn in 0..3 {
                let t = [t[turn], t[(turn + 1) % 3], t[(turn + 2) % 3]];
                assert_eq!(root(&squared_distance(p, &t)), expected, "{p:?} {t:?}");
                let flipped = [t[1], t[0], t[2]];
                assert_eq!(root(&squared_distance(p, &flipped)), expected);
                let scale = |p: [f64; 3]| p.map(|x| x * 1e-200);
                let small = root(&squared_distance(scale(p), &t.map(scale)));
                assert!((small - 1e-200 * expected).abs() <= 1e-214, "{small}");
            }
        }
    }
}
