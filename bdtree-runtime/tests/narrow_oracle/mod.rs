//! Slow exact twins of the narrow phase in rational numbers, and generators of nasty triangles.

#![allow(dead_code, unreachable_pub)] // each test file uses its part

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Num, One, RefNum, Signed, ToPrimitive, Zero};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64;

pub type Triangle = [[f64; 3]; 3];
pub const U: f64 = f64::EPSILON / 2.0;

pub fn rng(seed: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed)
}

pub fn exact(x: f64) -> BigRational {
    BigRational::from_float(x).expect("finite")
}

pub fn exact_point(p: [f64; 3]) -> [BigRational; 3] {
    p.map(exact)
}

/// Whether the convex hulls share a point: the linear program Σλ = Σμ = 1, Σλa = Σμb, λ, μ ≥ 0 by
/// the simplex method with Bland's rule. Knows nothing of planes, sides or special cases.
pub fn share_point(a: &[Point; 3], b: &[Point; 3]) -> bool {
    let (points, _) = whole(&[a.as_slice(), b.as_slice()].concat());
    let [a, b] = [0, 3].map(|i| [0, 1, 2].map(|n| points[i + n].clone()));
    share_whole(&a, &b)
}

/// [`share_point`] of triangles whose corners are small whole numbers.
pub fn share_small(a: &Triangle, b: &Triangle) -> bool {
    let [a, b] = [a, b].map(|t| t.map(|p| p.map(|x| x as i128)));
    share_whole(&a, &b)
}

/// Whole numbers stay whole: all rows are kept times the last pivot, which divides what the next one makes of them
/// (Edmonds 1967).
fn share_whole<N>(a: &[[N; 3]; 3], b: &[[N; 3]; 3]) -> bool
where
    N: Num + Signed + Clone + PartialOrd,
{
    // Rows: x, y, z, Σλ, Σμ. Columns: λ, μ, right side. Artificial basis; signs make the right ≥ 0.
    let mut rows: Vec<Vec<N>> = Vec::new();
    for k in 0..3 {
        let mut row: Vec<N> = a.iter().map(|p| p[k].clone()).collect();
        row.extend(b.iter().map(|p| -p[k].clone()));
        row.push(N::zero());
        rows.push(row);
    }
    for block in 0..2 {
        let mut row: Vec<N> = (0..6)
            .map(|c| if c / 3 == block { N::one() } else { N::zero() })
            .collect();
        row.push(N::one());
        rows.push(row);
    }
    // Gain of each column: the sum of the artificial variables that it removes.
    let mut gain: Vec<N> = (0..7)
        .map(|c| rows.iter().fold(N::zero(), |s, r| s + r[c].clone()))
        .collect();
    let mut basis = [6, 7, 8, 9, 10];
    let mut last = N::one();
    while let Some(c) = (0..6).find(|&c| gain[c].is_positive()) {
        let mut leave: Option<usize> = None;
        for r in (0..5).filter(|&r| rows[r][c].is_positive()) {
            // Right sides over entries of the column, both of which are compared by their products.
            let better = leave.is_none_or(|l| {
                let new = rows[r][6].clone() * rows[l][c].clone();
                let old = rows[l][6].clone() * rows[r][c].clone();
                new < old || (new == old && basis[r] < basis[l])
            });
            if better {
                leave = Some(r);
            }
        }
        let l = leave.expect("bounded");
        let pivot_row = rows[l].clone();
        let pivot = pivot_row[c].clone();
        let eliminate = |row: &mut Vec<N>| {
            let f = row[c].clone();
            for (v, p) in row.iter_mut().zip(&pivot_row) {
                *v = (v.clone() * pivot.clone() - f.clone() * p.clone()) / last.clone();
            }
        };
        for (r, row) in rows.iter_mut().enumerate() {
            if r != l {
                eliminate(row);
            }
        }
        eliminate(&mut gain);
        basis[l] = c;
        last = pivot;
    }
    gain[6].is_zero()
}

pub type Point = [BigRational; 3];

pub fn minus<N>(a: &[N; 3], b: &[N; 3]) -> [N; 3]
where
    for<'n> &'n N: RefNum<N>,
{
    [0, 1, 2].map(|k| &a[k] - &b[k])
}

pub fn plus_scaled(a: &Point, k: &BigRational, b: &Point) -> Point {
    [0, 1, 2].map(|i| &a[i] + k * &b[i])
}

pub fn product<N: Num>(a: &[N; 3], b: &[N; 3]) -> N
where
    for<'n> &'n N: RefNum<N>,
{
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

pub fn cross(a: &Point, b: &Point) -> Point {
    [0, 1, 2].map(|k| &a[(k + 1) % 3] * &b[(k + 2) % 3] - &a[(k + 2) % 3] * &b[(k + 1) % 3])
}

/// In whole multiples of one unit: rational numbers would look for common divisors after each operation.
type Whole = [BigInt; 3];

/// A numerator and a denominator above zero.
type Fraction = (BigInt, BigInt);

/// The points in multiples of the unit whose inverse is returned too.
fn whole(points: &[Point]) -> (Vec<Whole>, BigInt) {
    let common = |m: BigInt, d: &BigInt| {
        if (&m % d).is_zero() {
            m
        } else if (d % &m).is_zero() {
            d.clone()
        } else {
            m * d
        }
    };
    let divisors = points.iter().flatten().map(BigRational::denom);
    let per_unit = divisors.fold(BigInt::one(), common);
    let number = |x: &BigRational| x.numer() * (&per_unit / x.denom());
    let points = points.iter().map(|p| p.each_ref().map(number)).collect();
    (points, per_unit)
}

fn less((n, d): Fraction, (m, e): Fraction) -> Fraction {
    if &n * &e <= &m * &d { (n, d) } else { (m, e) }
}

/// ‖(d w + s e + t g) / d‖².
fn square([w, e, g]: [&Whole; 3], d: &BigInt, s: &BigInt, t: &BigInt) -> Fraction {
    let q = [0, 1, 2].map(|k| d * &w[k] + s * &e[k] + t * &g[k]);
    (product(&q, &q), d * d)
}

fn segment_squared(p: &Whole, a: &Whole, b: &Whole) -> Fraction {
    let (e, w) = (minus(b, a), minus(a, p));
    let ee = product(&e, &e);
    let zero = BigInt::zero();
    if ee.is_zero() {
        return (product(&w, &w), BigInt::one());
    }
    let s = (-product(&w, &e)).clamp(zero.clone(), ee.clone());
    square([&w, &e, &e], &ee, &s, &zero)
}

/// Squared minimum of |w + s e + t g| if it is taken where `inside(s, t, 1)`, all three times a number above zero.
fn plane_squared(
    w: &Whole,
    e: &Whole,
    g: &Whole,
    inside: impl Fn(&BigInt, &BigInt, &BigInt) -> bool,
) -> Option<Fraction> {
    let (ee, eg, gg) = (product(e, e), product(e, g), product(g, g));
    let (we, wg) = (product(w, e), product(w, g));
    // Not below zero, as Cauchy and Schwarz found.
    let det = &ee * &gg - &eg * &eg;
    if det.is_zero() {
        return None;
    }
    let s = &eg * &wg - &gg * &we;
    let t = &eg * &we - &ee * &wg;
    inside(&s, &t, &det).then(|| square([w, e, g], &det, &s, &t))
}

fn point_whole(p: &Whole, [a, b, c]: [&Whole; 3]) -> Fraction {
    let mut best = segment_squared(p, a, b);
    best = less(best, segment_squared(p, b, c));
    best = less(best, segment_squared(p, c, a));
    let inside = |s: &BigInt, t: &BigInt, one: &BigInt| {
        !s.is_negative() && !t.is_negative() && s + t <= *one
    };
    let (w, e, g) = (minus(a, p), minus(b, a), minus(c, a));
    match plane_squared(&w, &e, &g, inside) {
        Some(d) => less(best, d),
        None => best,
    }
}

/// Exact squared distance of point and triangle.
pub fn point_squared(p: &Point, tri: &[Point; 3]) -> BigRational {
    let (points, per_unit) = whole(&[std::slice::from_ref(p), tri.as_slice()].concat());
    let [p, a, b, c] = [0, 1, 2, 3].map(|i| &points[i]);
    let (n, d) = point_whole(p, [a, b, c]);
    BigRational::new(n, d * &per_unit * per_unit)
}

/// Exact squared distance of two triangles.
pub fn triangle_squared(a: &[Point; 3], b: &[Point; 3]) -> BigRational {
    if share_point(a, b) {
        return BigRational::zero();
    }
    let (points, per_unit) = whole(&[a.as_slice(), b.as_slice()].concat());
    let [a, b] = [0, 3].map(|i| [0, 1, 2].map(|n| &points[i + n]));
    let mut best = point_whole(a[0], b);
    for i in 0..3 {
        best = less(best, point_whole(a[i], b));
        best = less(best, point_whole(b[i], a));
        for j in 0..3 {
            let w = minus(a[i], b[j]);
            let (e, g) = (minus(a[(i + 1) % 3], a[i]), minus(b[j], b[(j + 1) % 3]));
            let unit = |x: &BigInt, one: &BigInt| !x.is_negative() && x <= one;
            let inside = |s: &BigInt, t: &BigInt, one: &BigInt| unit(s, one) && unit(t, one);
            if let Some(d) = plane_squared(&w, &e, &g, inside) {
                best = less(best, d);
            }
        }
    }
    let (n, d) = best;
    BigRational::new(n, d * &per_unit * per_unit)
}

/// Computed minus exact distance, in units of u times `largest`.
pub fn error_in_ul(computed: f64, squared: &BigRational, largest: f64) -> f64 {
    let c = exact(computed);
    // One power of two out of both keeps the numbers inside f64.
    let unit = exact(if largest > 0.0 { largest } else { 1.0 });
    let c = c / &unit;
    let squared = squared / (&unit * &unit);
    let difference = (&c * &c - &squared).to_f64().expect("in range");
    if difference == 0.0 {
        return 0.0;
    }
    let sum = c.to_f64().expect("in range") + squared.to_f64().expect("in range").sqrt();
    difference / sum / U
}

pub fn largest_difference(from: &[[f64; 3]], to: &[[f64; 3]]) -> f64 {
    let mut m = 0.0_f64;
    for a in from {
        for b in to {
            for k in 0..3 {
                m = m.max((a[k] - b[k]).abs());
            }
        }
    }
    m
}

pub fn random_point(r: &mut impl Rng) -> [f64; 3] {
    [0; 3].map(|_| r.random_range(-1.0..1.0))
}

pub fn grid_point(r: &mut impl Rng, n: i32) -> [f64; 3] {
    [0; 3].map(|_| f64::from(r.random_range(0..n)))
}

fn near(r: &mut impl Rng, p: [f64; 3], size: f64) -> [f64; 3] {
    p.map(|x| x + r.random_range(-size..size))
}

pub fn mix(p: [f64; 3], q: [f64; 3], s: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| p[k] + s * (q[k] - p[k]))
}

/// A triangle of one of eight shapes: plain, grid, sliver, needle, tiny, zero-area, point, axis plane.
pub fn nasty_triangle(r: &mut impl Rng) -> Triangle {
    let thin = 10.0_f64.powf(r.random_range(-17.0..-1.0));
    let (p, q) = (random_point(r), random_point(r));
    match r.random_range(0..9) {
        0 | 1 => [p, q, random_point(r)],
        2 => [(); 3].map(|()| grid_point(r, 4)),
        3 => {
            let m = mix(p, q, r.random_range(0.0..1.0));
            [p, near(r, m, thin), q]
        }
        4 => [p, q, near(r, q, thin)],
        5 => [p, near(r, p, thin), near(r, p, thin)],
        6 => [p, q, mix(p, q, 0.5)],
        7 => [p, p, if r.random_range(0..2) == 0 { p } else { q }],
        _ => [(); 3].map(|()| [r.random_range(-1.0..1.0), r.random_range(-1.0..1.0), 0.25]),
    }
}

/// A second triangle that tends to touch, share, cross or just miss the first.
pub fn partner(r: &mut impl Rng, a: &Triangle) -> Triangle {
    let mut b = nasty_triangle(r);
    let [i, j] = [0; 2].map(|_| r.random_range(0..3));
    let thin = 10.0_f64.powf(r.random_range(-17.0..-1.0));
    match r.random_range(0..8) {
        0 | 1 => {}
        2 => b[i] = a[j],
        3 => {
            b[i] = a[j];
            b[(i + 1) % 3] = a[(j + 1) % 3];
        }
        4 => b[i] = mix(a[j], a[(j + 1) % 3], 0.5),
        5 => {
            let m = mix(a[0], a[1], 0.25);
            b[i] = mix(m, a[2], 0.375);
        }
        6 => {
            let m = mix(mix(a[0], a[1], r.random_range(0.0..1.0)), a[2], 0.4);
            b[i] = near(r, m, thin);
        }
        _ => b = a.map(|p| near(r, p, thin)),
    }
    b
}

/// A map that keeps the shape: identity, large offset, powers of two, decimal scale, f32 rounding.
pub fn placement(r: &mut Pcg64) -> impl Fn([f64; 3]) -> [f64; 3] + use<> {
    let kind = r.random_range(0..9);
    let offset = [1e6, -1e6, 999_999.9];
    move |p: [f64; 3]| match kind {
        0..=2 => p,
        3 => [0, 1, 2].map(|k| p[k] + offset[k]),
        4 => p.map(|x| x * 2.0_f64.powi(-100)),
        5 => p.map(|x| x * 1e-6),
        6 => p.map(|x| x * 2.0_f64.powi(99)),
        7 => p.map(|x| x * 2.0_f64.powi(-180)),
        _ => p.map(|x| f64::from(x as f32)),
    }
}

pub fn big(tri: &Triangle) -> [[BigRational; 3]; 3] {
    tri.map(exact_point)
}

pub fn is_zero(x: &BigRational) -> bool {
    x.numer() == &BigInt::zero()
}
