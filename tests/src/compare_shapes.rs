//! Capsules, oriented boxes and frustums beside brute force.

use bdtree_runtime::narrow::{Frustum, FrustumState, OrientedBox};
use bdtree_runtime::{Contact, StackEntry, query};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::body::Body;
use crate::compare::Posed;
use crate::{oracle, poses};

/// Asks one capsule, one box and one frustum about `point`, of the size of `radius`, and compares
/// each with brute force over `triangles`. Fifteen rounds go through all kinds.
///
/// # Panics
/// When an answer differs.
pub(crate) fn check_shapes(
    posed: &[Posed<'_>],
    triangles: &Body,
    (point, radius): ([f64; 3], f64),
    round: usize,
    stack: &mut [StackEntry],
    rng: &mut Pcg64Mcg,
) {
    let mut step = |size: f64| [0; 3].map(|_| size * rng.random_range(-1.0..1.0));
    // No length, short, across the body, endless on one side or both.
    let ends = match round % 5 {
        0 => [point, point],
        1 => [point, plus(point, step(radius))],
        2 => [minus(point, step(100.0 * radius)), point],
        3 => [point, plus(point, step(1e9 * radius))],
        _ => {
            // No coordinate may be beyond 2^100.
            let d = step((1e20 * radius).min(1e29));
            [minus(point, d), plus(point, d)]
        }
    };
    let thickness = radius * [1.0, 0.0, 0.01][round / 5 % 3];
    check_capsule(posed, triangles, ends, thickness, stack);

    let rotation = poses::random_transform(0.0, rng).rotation;
    let mut half = [0; 3].map(|_| radius * 10_f64.powf(rng.random_range(-2.0..0.5)));
    let mut center = point;
    match round % 5 {
        0 => half[rng.random_range(0..3)] = 0.0,
        1 => half = [0.0; 3],
        2 => half[rng.random_range(0..3)] *= 1e9,
        // Far and large: a corner or a face is near.
        3 => {
            half = half.map(|h| 1e6 * h);
            let shape = OrientedBox::new(center, rotation, half);
            for k in 0..3 {
                let h = half[k] * [-1.0, 0.5, 1.0][rng.random_range(0..3)];
                center = plus(center, shape.axes()[k].map(|a| h * a));
            }
        }
        _ => {}
    }
    check_box(posed, triangles, (center, rotation, half), stack);
    check_frustum(posed, triangles, (point, radius), stack, rng);
}

fn check_capsule(
    posed: &[Posed<'_>],
    triangles: &Body,
    [point1, point2]: [[f64; 3]; 2],
    radius: f64,
    stack: &mut [StackEntry],
) {
    let expected: Vec<(u32, f64)> = oracle::capsule(triangles, [point1, point2], radius)
        .into_iter()
        .map(|(id, distance)| (id, distance - radius))
        .collect();
    for (asset, pose) in posed {
        let mut found: Vec<Contact> = Vec::new();
        let outcome = query::capsule(asset, pose, point1, point2, radius, stack, &mut found);
        assert!(!outcome.expect("capsule").truncated);
        found.sort_by_key(|c| c.triangle);
        let found: Vec<(u32, f64)> = found.iter().map(|c| (c.triangle.0, c.dist)).collect();
        assert_eq!(
            found, expected,
            "capsule {point1:?} {point2:?} of radius {radius}"
        );
    }
}

fn check_box(
    posed: &[Posed<'_>],
    triangles: &Body,
    (center, rotation, half): ([f64; 3], [f64; 4], [f64; 3]),
    stack: &mut [StackEntry],
) {
    let shape = OrientedBox::new(center, rotation, half);
    let expected = oracle::cuboid(triangles, &shape);
    for (asset, pose) in posed {
        let mut found: Vec<Contact> = Vec::new();
        let outcome = query::cuboid(asset, pose, center, rotation, half, stack, &mut found);
        assert!(!outcome.expect("box").truncated);
        found.sort_by_key(|c| c.triangle);
        let found: Vec<(u32, f64)> = found.iter().map(|c| (c.triangle.0, -c.dist)).collect();
        assert_eq!(found, expected, "{shape:?}");
    }
}

/// Planes that cut the body, hold it or miss it: some about the point, some that just hold all
/// corners, some that all but do.
fn check_frustum(
    posed: &[Posed<'_>],
    triangles: &Body,
    (point, radius): ([f64; 3], f64),
    stack: &mut [StackEntry],
    rng: &mut Pcg64Mcg,
) {
    let planes: Vec<[f64; 4]> = (0..rng.random_range(1..8))
        .map(|_| {
            let n = match rng.random_range(0..2) {
                0 => [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]][rng.random_range(0..3)],
                _ => [0; 3].map(|_| rng.random_range(-1.0..1.0)),
            };
            let height = |x: &[f64; 3]| n[0] * x[0] + n[1] * x[1] + n[2] * x[2];
            let lowest = triangles.iter().flatten().map(height);
            let lowest = lowest.fold(f64::INFINITY, f64::min);
            let d = match rng.random_range(0..6) {
                0 => radius * rng.random_range(-1.0..1.0) - height(&point),
                1 => 1e-15 * radius - lowest,
                2 => -1e-15 * radius - lowest,
                3 => 1e6 * radius - lowest,
                _ => -lowest,
            };
            let size = 10_f64.powi(rng.random_range(-9..9));
            [n[0] * size, n[1] * size, n[2] * size, d * size]
        })
        .collect();
    // As they are, and the body's other side of all of them.
    for sign in [1.0, -1.0] {
        let planes: Vec<_> = planes.iter().map(|p| p.map(|x| sign * x)).collect();
        let shape = Frustum::new(&planes).expect("planes");
        let expected = oracle::frustum(triangles, &shape);
        for (asset, pose) in posed {
            let found = query::frustum(asset, pose, &shape, stack).expect("frustum");
            assert_eq!(found.state, expected, "{planes:?}");
            // The root's sphere alone may only know less.
            let sphere = query::root_sphere(asset, pose).expect("sphere");
            let coarse = sphere.state(&shape);
            assert!(coarse == FrustumState::Intersects || coarse == expected);
        }
    }
}

fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
