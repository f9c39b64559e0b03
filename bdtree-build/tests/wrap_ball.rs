//! Smallest enclosing balls against all support sets (P07).

use crate::tree_support::*;
use bdtree_build::wrap::ball::smallest_ball;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

type Point = [f64; 3];

fn sub(a: Point, b: Point) -> Point {
    std::array::from_fn(|k| a[k] - b[k])
}

fn dot(a: Point, b: Point) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

/// Solves the symmetric system 2 G λ = diag(G) by elimination with pivoting: the circumcenter of
/// `arms` and 0 in their span. `None` when they are dependent.
fn circumcenter(arms: &[Point]) -> Option<Point> {
    let n = arms.len();
    let mut m = vec![[0.0; 4]; n];
    for i in 0..n {
        for j in 0..n {
            m[i][j] = 2.0 * dot(arms[i], arms[j]);
        }
        m[i][3] = dot(arms[i], arms[i]);
    }
    for c in 0..n {
        let pivot = (c..n).max_by(|&a, &b| m[a][c].abs().total_cmp(&m[b][c].abs()))?;
        m.swap(c, pivot);
        if m[c][c] == 0.0 {
            return None;
        }
        for r in 0..n {
            if r != c {
                let f = m[r][c] / m[c][c];
                let pivot_row = m[c];
                for (x, p) in m[r].iter_mut().zip(pivot_row) {
                    *x -= f * p;
                }
            }
        }
    }
    let mut center = [0.0; 3];
    for (i, arm) in arms.iter().enumerate() {
        for k in 0..3 {
            center[k] += m[i][3] / m[i][i] * arm[k];
        }
    }
    center.iter().all(|x| x.is_finite()).then_some(center)
}

/// The least radius over the circumspheres of all subsets of at most four points, each grown to
/// hold all points.
fn oracle(points: &[Point]) -> f64 {
    let n = points.len();
    let mut best = f64::INFINITY;
    let mut consider = |set: &[usize]| {
        let base = points[set[0]];
        let arms: Vec<Point> = set[1..].iter().map(|&i| sub(points[i], base)).collect();
        if let Some(center) = circumcenter(&arms) {
            let reach = points
                .iter()
                .map(|&p| sub(sub(p, base), center))
                .map(|d| dot(d, d).sqrt())
                .fold(0.0, f64::max);
            if reach < best {
                best = reach;
            }
        }
    };
    for a in 0..n {
        consider(&[a]);
        for b in 0..a {
            consider(&[a, b]);
            for c in 0..b {
                consider(&[a, b, c]);
                for d in 0..c {
                    consider(&[a, b, c, d]);
                }
            }
        }
    }
    best
}

fn check(name: &str, points: &[Point]) {
    let ball = smallest_ball(points);
    let best = oracle(points);
    // The oracle solves its systems through Gram matrices and is itself only as exact as this.
    assert!(
        (ball.radius - best).abs() <= 1e-12 * best,
        "{name}: radius {} instead of {best} for {points:?}",
        ball.radius
    );
    // The center is rounded to the coordinates' own precision.
    let coordinate = points
        .iter()
        .flatten()
        .fold(0.0, |m: f64, x| m.max(x.abs()));
    for &p in points {
        let d = sub(p, ball.center);
        let slack = 1e-15 * coordinate * 4.0;
        assert!(
            dot(d, d).sqrt() <= ball.radius * (1.0 + 1e-15 * 8.0) + slack,
            "{name}: {points:?}"
        );
    }
}

fn on_sphere(rng: &mut Pcg64Mcg, count: usize) -> Vec<Point> {
    (0..count).map(|_| unit_vector(rng)).collect()
}

#[test]
fn radius_is_that_of_the_best_support_set() {
    let mut rng = rng(5);
    for round in 0..300 {
        let n = rng.random_range(1..=12);
        let mut cloud: Vec<Point> = (0..n)
            .map(|_| std::array::from_fn(|_| rng.random_range(-1.0..1.0)))
            .collect();
        check("cloud", &cloud);
        let direction = unit_vector(&mut rng);
        let line: Vec<Point> = cloud.iter().map(|p| direction.map(|d| d * p[0])).collect();
        check("collinear", &line);
        let plane: Vec<Point> = cloud.iter().map(|p| [p[0], p[1], 0.25]).collect();
        check("coplanar", &plane);
        check("cospherical", &on_sphere(&mut rng, n));
        let circle: Vec<Point> = (0..n)
            .map(|_| rng.random_range(0.0..6.2f64))
            .map(|a| [a.cos(), a.sin(), 0.0])
            .collect();
        check("cocircular", &circle);
        let grid: Vec<Point> = cloud.iter().map(|p| p.map(|x| (x * 2.0).round())).collect();
        check("grid with duplicates", &grid);
        let doubled: Vec<Point> = cloud.iter().chain(&cloud).copied().take(12).collect();
        check("duplicates", &doubled);
        let huge = 2f64.powi(rng.random_range(0..40));
        let far: Vec<Point> = cloud.iter().map(|p| p.map(|x| x + huge)).collect();
        check("offset", &far);
        let scale = 2f64.powi(rng.random_range(-120..120));
        for x in cloud.iter_mut().flatten() {
            *x *= scale;
        }
        check("scale", &cloud);
        let needle: Vec<Point> = cloud
            .iter()
            .map(|p| [p[0], p[1] * 1e-6, p[2] * 1e-9])
            .collect();
        check(&format!("needle {round}"), &needle);
    }
}

#[test]
fn symmetric_bodies_have_their_balls() {
    let corners = |i: usize| -> Point { std::array::from_fn(|k| (i >> k & 1) as f64) };
    let cube: Vec<Point> = (0..8).map(corners).collect();
    check("cube", &cube);
    let ball = smallest_ball(&cube);
    assert_eq!(ball.center, [0.5; 3]);
    assert_eq!(smallest_ball(&[]).radius, 0.0);
    let point = [0.1, -0.2, 1e30];
    assert_eq!(smallest_ball(&[point; 7]).center, point);
    assert_eq!(smallest_ball(&[point; 7]).radius, 0.0);
}

/// Large sets: inside the ball, and the points on its surface have no smaller one.
#[test]
fn large_sets_are_held_by_the_points_on_the_surface() {
    let mut rng = rng(6);
    let cloud: Vec<Point> = (0..100_000)
        .map(|_| std::array::from_fn(|_| rng.random_range(-1.0..1.0)))
        .collect();
    let lattice: Vec<Point> = (0..64_000)
        .map(|i| [i % 40, i / 40 % 40, i / 1600].map(f64::from))
        .collect();
    for (name, points) in [
        ("cloud", cloud),
        ("sphere", on_sphere(&mut rng, 100_000)),
        ("lattice", lattice),
    ] {
        let ball = smallest_ball(&points);
        let distances = points
            .iter()
            .map(|&p| sub(p, ball.center))
            .map(|d| dot(d, d).sqrt());
        let outermost = distances.clone().fold(0.0, f64::max);
        assert!(outermost <= ball.radius * (1.0 + 1e-14), "{name}");
        // The center is in the hull of the surface points: no direction leaves all behind.
        let surface: Vec<Point> = points
            .iter()
            .zip(distances)
            .filter(|(_, d)| *d >= ball.radius * (1.0 - 1e-9))
            .map(|(&p, _)| sub(p, ball.center))
            .collect();
        for _ in 0..1000 {
            let direction = unit_vector(&mut rng);
            let ahead = surface
                .iter()
                .map(|&p| dot(p, direction))
                .fold(f64::NEG_INFINITY, f64::max);
            assert!(ahead >= -1e-7 * ball.radius, "{name}");
        }
    }
}
