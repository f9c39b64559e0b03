//! Segments, oriented boxes and frustums against exact rational arithmetic.

use crate::narrow_oracle::*;
use bdtree_runtime::narrow::{
    Frustum, FrustumState, OrientedBox, closest_point, segment_triangle_distance,
};
use num_rational::BigRational;
use num_traits::Signed;
use rand::{Rng, RngExt};

/// Stated bounds of distances, in units of u L.
const BELOW: f64 = -32.0;
const ABOVE: f64 = 64.0;

/// A segment that tends to touch, run along or just miss a triangle; some have no length.
fn segment(r: &mut impl Rng, tri: &Triangle) -> [[f64; 3]; 2] {
    let b = partner(r, tri);
    let [p, q, _] = b;
    let through = mix(mix(tri[0], tri[1], 0.25), tri[2], 0.375);
    match r.random_range(0..6) {
        0 => [p, p],
        1 => [p, mix(p, through, 2.0)],
        2 => [tri[0], q],
        3 => [mix(tri[0], tri[1], -0.5), mix(tri[0], tri[1], 1.5)],
        _ => [p, q],
    }
}

#[test]
fn segment_triangle_within_stated_error() {
    let mut r = rng(31);
    let mut range = [0.0_f64; 2];
    let mut touching = 0;
    for _ in 0..800 {
        let place = placement(&mut r);
        let tri = nasty_triangle(&mut r);
        let ends = segment(&mut r, &tri).map(&place);
        let tri = tri.map(&place);
        let d = segment_triangle_distance(&ends, &tri);
        let l = largest_difference(&ends, &tri);
        let [p, q] = ends.map(exact_point);
        let squared = triangle_squared(&[p, q.clone(), q], &big(&tri));
        assert_eq!(d.distance == 0.0, is_zero(&squared), "{ends:?} {tri:?}");
        let size = ends.iter().chain(&tri).flatten();
        let size = size.fold(l, |m, x| m.max(x.abs()));
        let gap = largest_difference(&[d.on_segment], &[d.on_triangle]);
        if is_zero(&squared) {
            touching += 1;
            assert!(
                gap <= 64.0 * U * size,
                "{} u: {ends:?} {tri:?}",
                gap / U / size
            );
        } else {
            let e = error_in_ul(d.distance, &squared, l);
            assert!((BELOW..=ABOVE).contains(&e), "{e} uL: {ends:?} {tri:?}");
            range = [range[0].min(e), range[1].max(e)];
        }
        assert!((0.0..=1.0).contains(&d.parameter));
        assert!(d.barycentric.iter().all(|w| (0.0..=1.0).contains(w)));
        let on_segment = mix(ends[0], ends[1], d.parameter);
        assert!(largest_difference(&[on_segment], &[d.on_segment]) <= 16.0 * U * size);
        assert!(closest_point(d.on_triangle, &tri).distance <= 64.0 * U * size);
    }
    println!("segment-triangle: error {range:?} u L, {touching} touching");
    assert!(touching > 150, "{touching}");
}

/// Whether a triangle has a point where all linear functions, given by their values at the
/// corners, are not negative: exact cutting.
fn feasible(functions: &[[BigRational; 3]]) -> bool {
    let one = |k: usize| [0, 1, 2].map(|i| exact(if i == k { 1.0 } else { 0.0 }));
    let mut polygon: Vec<Point> = vec![one(0), one(1), one(2)];
    for f in functions {
        let at: Vec<BigRational> = polygon.iter().map(|v| product(v, f)).collect();
        let mut rest = Vec::new();
        for i in 0..polygon.len() {
            let j = (i + 1) % polygon.len();
            if !at[i].is_negative() {
                rest.push(polygon[i].clone());
            }
            if (&at[i] * &at[j]).is_negative() {
                let s = &at[i] / (&at[i] - &at[j]);
                rest.push(plus_scaled(
                    &polygon[i],
                    &s,
                    &minus(&polygon[j], &polygon[i]),
                ));
            }
        }
        polygon = rest;
    }
    !polygon.is_empty()
}

/// Whether a triangle in a box's axes touches the box, each side moved inwards by `less`.
fn box_touches(local: &Triangle, half: [f64; 3], less: f64) -> bool {
    let mut functions = Vec::new();
    for k in 0..3 {
        for sign in [1.0, -1.0] {
            let room = exact(half[k]) - exact(less);
            functions.push(local.map(|y| &room - exact(sign * y[k])));
        }
    }
    feasible(&functions)
}

/// A box that tends to touch a triangle with a corner, edge or face, or just not to; some have
/// no width.
fn nasty_box(r: &mut impl Rng, tri: &Triangle) -> OrientedBox {
    let rotation = match r.random_range(0..3) {
        0 => [0.0, 0.0, 0.0, 1.0],
        1 => [0.0, 0.6, 0.0, 0.8],
        _ => {
            let v = [0; 4].map(|_| r.random_range(-1.0..1.0_f64));
            let n = v.iter().map(|c| c * c).sum::<f64>().sqrt();
            v.map(|c| c / n)
        }
    };
    let mut half = [0; 3].map(|_| 10.0_f64.powf(r.random_range(-3.0..0.5)));
    for h in &mut half {
        if r.random_range(0..5) == 0 {
            *h = 0.0;
        }
    }
    let plain = OrientedBox::new([0.0; 3], rotation, half);
    // A point of the box on a point of the triangle, up to rounding or a little.
    let on_box = [0; 3].map(|_| [-1.0, -1.0, 0.3, 0.0, 1.0, 1.0][r.random_range(0..6)]);
    let on_triangle = match r.random_range(0..3) {
        0 => tri[0],
        1 => mix(tri[0], tri[1], 0.5),
        _ => mix(mix(tri[0], tri[1], 0.5), tri[2], 0.25),
    };
    let off = 10.0_f64.powf(r.random_range(-17.0..0.0)) * r.random_range(0.0..1.0);
    let mut center = on_triangle;
    for k in 0..3 {
        for (axis, c) in plain.axes()[k].into_iter().zip(&mut center) {
            *c -= (on_box[k] * half[k] + off * r.random_range(-1.0..1.0)) * axis;
        }
    }
    OrientedBox::new(center, rotation, half)
}

#[test]
fn box_triangle_is_exact_in_the_boxs_axes() {
    let mut r = rng(32);
    let (mut touching, mut apart, mut worst) = (0, 0, 0.0_f64);
    for case in 0..1_500 {
        let mut tri = nasty_triangle(&mut r);
        let mut shape = nasty_box(&mut r, &tri);
        if case % 4 == 0 {
            // Whole numbers: touching exactly.
            tri = [(); 3].map(|()| grid_point(&mut r, 5));
            let center = grid_point(&mut r, 4);
            shape = OrientedBox::new(center, [0.0, 0.0, 0.0, 1.0], grid_point(&mut r, 3));
        }
        let half = shape.half_extents();
        let local = tri.map(|x| shape.local(x));
        let expected = box_touches(&local, half, 0.0);
        let found = shape.contact(&tri);
        assert_eq!(found.is_some(), expected, "{shape:?} {tri:?}");
        let Some(contact) = found else {
            apart += 1;
            continue;
        };
        touching += 1;
        let l = largest_difference(&[shape.center()], &tri);
        let l = half.iter().fold(l, |m, h| m.max(*h));
        // The point told is rounded in the world.
        let size = tri.as_flattened().iter().fold(l, |m, x| m.max(x.abs()));
        let room = 64.0 * U * l;
        let world_room = 64.0 * U * size;
        // No deeper point, but one as deep, which is the one told.
        assert!(
            !box_touches(&local, half, contact.depth + room),
            "{contact:?} {shape:?} {tri:?}"
        );
        let y = shape.local(contact.point);
        let depth = (0..3)
            .map(|k| half[k] - y[k].abs())
            .fold(f64::INFINITY, f64::min);
        worst = worst.max((depth - contact.depth).abs() / size.max(f64::MIN_POSITIVE) / U);
        assert!(
            (depth - contact.depth).abs() <= world_room,
            "{contact:?} {shape:?} {tri:?}"
        );
        assert!(contact.depth >= 0.0);
        let sum: f64 = contact.barycentric.iter().sum();
        assert!((sum - 1.0).abs() <= 16.0 * U, "{contact:?}");
        assert!(
            contact.barycentric.iter().all(|w| (0.0..=1.0).contains(w)),
            "{contact:?}"
        );
        let same = closest_point(contact.point, &tri).distance;
        assert!(same <= world_room, "{same} {contact:?} {tri:?}");
        // Into the box, across the nearest face.
        let inwards = shape
            .axes()
            .map(|axis| (0..3).map(|k| axis[k] * contact.normal[k]).sum());
        let k = (0..3)
            .find(|&k| f64::abs(inwards[k]) > 0.5)
            .expect("an axis");
        assert!(inwards[k] * y[k] <= world_room, "{contact:?}");
        assert!(
            (half[k] - y[k].abs() - contact.depth).abs() <= world_room,
            "{contact:?}"
        );
    }
    println!(
        "box-triangle: {touching} touching, {apart} apart, depth off by {worst} u times the coordinates"
    );
    assert!(touching > 300 && apart > 300, "{touching} {apart}");
}

/// Planes around a point: of any length, some through it.
fn nasty_planes(r: &mut impl Rng, at: [f64; 3]) -> Vec<[f64; 4]> {
    let count = r.random_range(1..9);
    (0..count)
        .map(|_| {
            let n = match r.random_range(0..3) {
                0 => grid_point(r, 3).map(|x| x - 1.0),
                _ => random_point(r),
            };
            let n = if n == [0.0; 3] { [0.0, 0.0, 1.0] } else { n };
            let size = 2.0_f64.powi(r.random_range(-40..40));
            let off = [0.0, 1e-16, -1e-16, -0.1, 0.2, 0.5][r.random_range(0..6)];
            let d = off - (n[0] * at[0] + n[1] * at[1] + n[2] * at[2]);
            [n[0] * size, n[1] * size, n[2] * size, d * size]
        })
        .collect()
}

/// Heights of the corners above a plane, plus `room` times the magnitudes that enter.
fn heights(tri: &Triangle, [nx, ny, nz, d]: [f64; 4], room: f64) -> [BigRational; 3] {
    let n = exact_point([nx, ny, nz]);
    let at = |x: &[f64; 3]| product(&n, &exact_point(*x)) + exact(d);
    let size = |x: &[f64; 3]| (nx * x[0]).abs() + (ny * x[1]).abs() + (nz * x[2]).abs() + d.abs();
    let room = exact(room * tri.iter().map(size).fold(0.0, f64::max));
    tri.each_ref().map(|x| at(x) + &room)
}

#[test]
fn frustum_states_are_exact_inside_and_certain_outside() {
    let mut r = rng(33);
    let mut seen = [0; 3];
    let mut cut = 0;
    for _ in 0..2_000 {
        let place = placement(&mut r);
        let tri = nasty_triangle(&mut r);
        let at = mix(mix(tri[0], tri[1], 0.5), tri[2], r.random_range(0.0..1.5));
        let (tri, at) = (tri.map(&place), place(at));
        let planes = nasty_planes(&mut r, at);
        let Some(frustum) = Frustum::new(&planes) else {
            let far = |p: &[f64; 4]| p[3].abs() > 2.0_f64.powi(99) * p[0].abs().max(p[1].abs());
            assert!(planes.iter().any(far), "{planes:?}");
            continue;
        };
        let state = frustum.triangle(&tri);
        seen[state as usize] += 1;
        let exactly: Vec<_> = planes.iter().map(|p| heights(&tri, *p, 0.0)).collect();
        let inside = exactly.iter().flatten().all(|h| !h.is_negative());
        assert_eq!(state == FrustumState::Inside, inside, "{planes:?} {tri:?}");
        if state == FrustumState::Outside {
            assert!(!feasible(&exactly), "{planes:?} {tri:?}");
            let whole = exactly.iter().any(|p| p.iter().all(Signed::is_negative));
            cut += i32::from(!whole);
            continue;
        }
        // Twice the room that the test itself takes.
        let near: Vec<_> = planes
            .iter()
            .map(|p| heights(&tri, *p, 2.0_f64.powi(-39)))
            .collect();
        assert!(feasible(&near), "{planes:?} {tri:?}");
    }
    println!("frustum: {seen:?}, {cut} outside behind no single plane");
    assert!(seen.iter().all(|n| *n > 100) && cut > 10, "{seen:?} {cut}");
}

#[test]
fn frustums_that_are_none() {
    let up = [0.0, 0.0, 1.0, 0.0];
    assert!(Frustum::new(&[]).is_none());
    assert!(Frustum::new(&[up; 64]).is_some());
    assert!(Frustum::new(&[up; 65]).is_none());
    for bad in [f64::NAN, f64::INFINITY, 1e40] {
        assert!(Frustum::new(&[up, [0.0, 0.0, 1.0, bad]]).is_none());
    }
    assert!(Frustum::new(&[[f64::NAN, 0.0, 1.0, 0.0]]).is_none());
    assert!(Frustum::new(&[[0.0, 0.0, 0.0, 1.0]]).is_none());
    // The same plane, however long its normal.
    let tri = [[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 1.0, 2.5]];
    for size in [1e-300, 1e-200, 1.0, 1e200, 1e300] {
        let above = |d: f64| Frustum::new(&[[0.0, 0.0, size, d * size]]).expect("planes");
        assert_eq!(above(-2.0).triangle(&tri), FrustumState::Inside);
        assert_eq!(above(-2.25).triangle(&tri), FrustumState::Intersects);
        assert_eq!(above(-2.75).triangle(&tri), FrustumState::Outside);
    }
}

/// Normals of every size are planes: none loses its normal or leaves the range of exact products.
#[test]
fn planes_of_any_size_are_the_same_plane() {
    let corner = |x: f64| [x, 0.25, -0.5];
    let inside = [corner(2.0), corner(1.0), corner(3.0)];
    let outside = [corner(0.5), corner(0.75), corner(-8.0)];
    for exponent in -1074..1024 {
        // Exact, subnormal numbers included.
        let size = match exponent {
            -1074..-1022 => f64::from_bits(1 << (exponent + 1074)),
            _ => f64::from_bits(((exponent + 1023) as u64) << 52),
        };
        let plane = [size, 0.0, 0.0, -size];
        let shape = Frustum::new(&[plane]).expect("a plane");
        let [[nx, _, _, d]] = *shape.planes() else {
            panic!("one plane")
        };
        assert!(
            (1e-91..1e91).contains(&nx) && d == -nx,
            "2^{exponent}: {nx:e} {d:e}"
        );
        assert_eq!(
            shape.triangle(&inside),
            FrustumState::Inside,
            "2^{exponent}"
        );
        assert_eq!(
            shape.triangle(&outside),
            FrustumState::Outside,
            "2^{exponent}"
        );
    }
    assert!(Frustum::new(&[[f64::INFINITY, 0.0, 0.0, 1.0]]).is_none());
}
