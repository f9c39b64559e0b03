//! `triangles_intersect` against the exact linear program.

use crate::narrow_oracle::*;
use bdtree_runtime::narrow::triangles_intersect;
use rand::RngExt;

const ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [0, 2, 1],
    [2, 1, 0],
    [1, 0, 2],
];

/// The answer, the same in all 72 orders of corners and triangles.
fn intersect_in_every_order(a: &Triangle, b: &Triangle) -> bool {
    let answer = triangles_intersect(a, b);
    for x in ORDERS {
        for y in ORDERS {
            let (c, d) = (x.map(|i| a[i]), y.map(|i| b[i]));
            assert_eq!(answer, triangles_intersect(&c, &d), "{c:?} {d:?}");
            assert_eq!(answer, triangles_intersect(&d, &c), "{d:?} {c:?}");
        }
    }
    answer
}

#[test]
fn agrees_on_small_grids() {
    let mut r = rng(1);
    let mut hits = 0;
    for case in 0..16_000 {
        let n = 2 + case % 4;
        let flat = case % 3 == 0;
        let mut point = || {
            let mut p = grid_point(&mut r, n);
            p[2] = if flat { p[0] + p[1] } else { p[2] };
            p
        };
        let a = [point(), point(), point()];
        let b = [point(), point(), point()];
        let expected = share_small(&a, &b);
        assert_eq!(intersect_in_every_order(&a, &b), expected, "{a:?} {b:?}");
        hits += usize::from(expected);
    }
    println!("{hits} of 16000 grid pairs share a point");
    assert!((1_600..14_400).contains(&hits));
}

#[test]
fn agrees_on_nasty_floats() {
    let mut r = rng(2);
    let mut hits = 0;
    for _ in 0..2_500 {
        let place = placement(&mut r);
        let a = nasty_triangle(&mut r);
        let b = partner(&mut r, &a);
        let (a, b) = (a.map(&place), b.map(&place));
        let expected = share_point(&big(&a), &big(&b));
        assert_eq!(intersect_in_every_order(&a, &b), expected, "{a:?} {b:?}");
        hits += usize::from(expected);
    }
    println!("{hits} of 2500 float pairs share a point");
    assert!((250..2_250).contains(&hits));
}

#[test]
fn agrees_on_flat_floats() {
    let mut r = rng(3);
    let mut hits = 0;
    for _ in 0..1_500 {
        // Exactly coplanar in a skew plane: small integer multiples of two dyadic vectors.
        let [e, g] = [(); 2].map(|()| [0; 3].map(|_| f64::from(r.random_range(-999..999)) / 64.0));
        let mut point = || {
            let [i, j] = [0; 2].map(|_| f64::from(r.random_range(-3..4)));
            [0, 1, 2].map(|k| 1e6 + i * e[k] + j * g[k])
        };
        let a = [point(), point(), point()];
        let b = [point(), point(), point()];
        let expected = share_point(&big(&a), &big(&b));
        assert_eq!(intersect_in_every_order(&a, &b), expected, "{a:?} {b:?}");
        hits += usize::from(expected);
    }
    println!("{hits} of 1500 coplanar pairs share a point");
    assert!((150..1_350).contains(&hits));
}

#[test]
fn exact_at_the_ends_of_the_range() {
    let mut r = rng(4);
    for exponent in [-290, -180, 100, 290] {
        let unit = 2.0_f64.powi(exponent);
        for _ in 0..300 {
            let a = nasty_triangle(&mut r);
            let b = partner(&mut r, &a);
            // Inside the range: nothing below 2⁻³⁰⁰.
            let fit = |p: [f64; 3]| p.map(|x| if x.abs() < 1e-3 { 0.0 } else { x * unit });
            let (a, b) = (a.map(fit), b.map(fit));
            let expected = share_point(&big(&a), &big(&b));
            assert_eq!(triangles_intersect(&a, &b), expected, "{a:?} {b:?}");
        }
    }
}

#[test]
fn survives_everything() {
    let mut r = rng(5);
    let odd = [
        0.0,
        -0.0,
        5e-324,
        1e-308,
        -1e-200,
        1.0,
        -1.0,
        1e200,
        f64::MAX,
        f64::MIN,
        f64::INFINITY,
        f64::NAN,
    ];
    for _ in 0..100_000 {
        let mut point = || [0; 3].map(|_| odd[r.random_range(0..odd.len())]);
        let a = [point(), point(), point()];
        let b = [point(), point(), point()];
        triangles_intersect(&a, &b);
        bdtree_runtime::narrow::triangle_distance(&a, &b);
        bdtree_runtime::narrow::closest_point(a[0], &b);
        let ray = bdtree_runtime::narrow::PreparedRay::new(a[0], a[1]);
        bdtree_runtime::narrow::ray_hit(&ray, &b, 1e300);
    }
}
