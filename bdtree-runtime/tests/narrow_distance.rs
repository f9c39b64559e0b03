//! Distances against exact rational arithmetic, and their points against the triangles.

use crate::narrow_oracle::*;
use bdtree_runtime::narrow::{closest_point, triangle_distance, triangles_intersect};
use rand::RngExt;

/// Stated bounds, in units of u L.
const BELOW: f64 = -32.0;
const ABOVE: f64 = 64.0;

fn check_weights(w: [f64; 3]) {
    assert!(w.iter().all(|&x| (0.0..=1.0).contains(&x)), "{w:?}");
    assert!((w[0] + w[1] + w[2] - 1.0).abs() <= 4.0 * U, "{w:?}");
}

/// Σ w_i corner_i in exact arithmetic lies near the computed point, relative to the coordinates.
fn check_point(point: [f64; 3], w: [f64; 3], tri: &Triangle) {
    let size = tri
        .as_flattened()
        .iter()
        .fold(0.0_f64, |m, x| m.max(x.abs()));
    for k in 0..3 {
        let sum = exact(w[0]) * exact(tri[0][k])
            + exact(w[1]) * exact(tri[1][k])
            + exact(w[2]) * exact(tri[2][k]);
        let off = num_traits::ToPrimitive::to_f64(&(sum - exact(point[k]))).expect("in range");
        assert!(off.abs() <= 16.0 * U * size, "{off} {tri:?} {w:?}");
    }
}

#[test]
fn point_triangle_within_stated_error() {
    let mut r = rng(11);
    let mut range = [0.0_f64; 2];
    for case in 0..5_000 {
        let place = placement(&mut r);
        let tri = nasty_triangle(&mut r);
        let thin = 10.0_f64.powf(r.random_range(-17.0..3.0));
        let mut p = mix(mix(tri[0], tri[1], 0.3), tri[2], r.random_range(0.0..1.0));
        let q = random_point(&mut r);
        match case % 4 {
            0 => p = q,
            1 => p = p.map(|x| x + thin * q[0]),
            2 => p = [0, 1, 2].map(|k| p[k] + thin * q[k]),
            _ => {}
        }
        let (tri, p) = (tri.map(&place), place(p));
        let c = closest_point(p, &tri);
        let l = largest_difference(&[p], &tri);
        let e = error_in_ul(c.distance, &point_squared(&exact_point(p), &big(&tri)), l);
        assert!((BELOW..=ABOVE).contains(&e), "{e} uL: {p:?} {tri:?} {c:?}");
        range = [range[0].min(e), range[1].max(e)];
        check_weights(c.barycentric);
        check_point(c.point, c.barycentric, &tri);
    }
    println!("point-triangle: error {range:?} u L");
}

#[test]
fn triangle_triangle_within_stated_error() {
    let mut r = rng(12);
    let mut range = [0.0_f64; 2];
    let (mut touching, mut gap) = (0, 0.0_f64);
    for _ in 0..1_500 {
        let place = placement(&mut r);
        let a = nasty_triangle(&mut r);
        let b = partner(&mut r, &a);
        let (a, b) = (a.map(&place), b.map(&place));
        let d = triangle_distance(&a, &b);
        let l = largest_difference(&a, &b);
        let squared = triangle_squared(&big(&a), &big(&b));
        check_weights(d.barycentric1);
        check_weights(d.barycentric2);
        check_point(d.point1, d.barycentric1, &a);
        assert_eq!(d.distance == 0.0, is_zero(&squared), "{a:?} {b:?}");
        assert_eq!(triangles_intersect(&a, &b), is_zero(&squared));
        if is_zero(&squared) {
            touching += 1;
            assert_eq!(d.point1, d.point2);
            let off = closest_point(d.point2, &b).distance;
            let size = a.as_flattened().iter().fold(l, |m, x| m.max(x.abs()));
            gap = gap.max(off / (U * size));
        } else {
            check_point(d.point2, d.barycentric2, &b);
            let e = error_in_ul(d.distance, &squared, l);
            assert!((BELOW..=ABOVE).contains(&e), "{e} uL: {a:?} {b:?} {d:?}");
            range = [range[0].min(e), range[1].max(e)];
        }
    }
    println!("triangle-triangle: error {range:?} u L; {touching} touching, worst gap {gap} u");
    assert!(touching > 300);
}

#[test]
fn crossing_edges_and_near_parallel_edges() {
    // Long thin triangles like crossed needles at shrinking angles: where normal equations fail.
    let mut r = rng(13);
    let mut worst = 0.0_f64;
    for _ in 0..1_000 {
        let angle = 10.0_f64.powf(r.random_range(-16.0..0.0));
        let lift = 10.0_f64.powf(r.random_range(-17.0..0.0));
        let [p, q, v] = [(); 3].map(|()| random_point(&mut r));
        let m = mix(p, q, r.random_range(0.1..0.9));
        let e = [0, 1, 2].map(|k| (q[k] - p[k]) * 0.7 + angle * v[k]);
        let up = random_point(&mut r).map(|x| x * lift);
        let a = [p, q, [0, 1, 2].map(|k| p[k] - 0.5 * up[k])];
        let b = [
            [0, 1, 2].map(|k| m[k] + e[k] + up[k]),
            [0, 1, 2].map(|k| m[k] - e[k] + up[k]),
            [0, 1, 2].map(|k| m[k] + 2.0 * up[k]),
        ];
        let d = triangle_distance(&a, &b);
        let l = largest_difference(&a, &b);
        let e = error_in_ul(d.distance, &triangle_squared(&big(&a), &big(&b)), l);
        assert!((BELOW..=ABOVE).contains(&e), "{e} uL: {a:?} {b:?} {d:?}");
        worst = worst.max(e.abs());
    }
    println!("near-parallel edges: error {worst} u L");
}

#[test]
fn never_beaten_by_sampling() {
    let mut r = rng(14);
    for _ in 0..300 {
        let (a, b) = (nasty_triangle(&mut r), nasty_triangle(&mut r));
        let d = triangle_distance(&a, &b).distance;
        for _ in 0..300 {
            let mut sample = |t: &Triangle| {
                let (u, v) = (r.random_range(0.0..1.0), r.random_range(0.0..1.0));
                mix(mix(t[0], t[1], u), t[2], v)
            };
            let (p, q) = (sample(&a), sample(&b));
            let s = (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt();
            assert!(d <= s + 1e-13, "{d} {s} {a:?} {b:?}");
        }
    }
}
