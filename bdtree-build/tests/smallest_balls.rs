//! Smallest enclosing balls of hard sets beside the smallest ball in rational arithmetic: the least
//! circumsphere of at most four points that holds all, exactly.
//!
//! `cargo test -p bdtree-build --test all -- --nocapture smallest_balls::` prints the errors of
//! docs/design/hard-cases.md.

use bdtree_build::wrap::ball::smallest_ball;
use bdtree_fixtures::oracle::exact::root;
use bdtree_fixtures::poses;
use num_rational::BigRational;
use num_traits::{Signed, Zero};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

type Point = [f64; 3];
type Exact = [BigRational; 3];

fn number(x: f64) -> BigRational {
    BigRational::from_float(x).expect("finite")
}

fn minus(a: &Exact, b: &Exact) -> Exact {
    [0, 1, 2].map(|k| &a[k] - &b[k])
}

fn dot(a: &Exact, b: &Exact) -> BigRational {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// Where 2 G λ = diag(G) for the arms' Gram matrix G: the circumcenter, relative to the point that the
/// arms start from, in their span. `None` when they are dependent: a smaller set does as well.
fn circumcenter(arms: &[Exact]) -> Option<Exact> {
    let n = arms.len();
    let two = number(2.0);
    let mut rows: Vec<Vec<BigRational>> = (0..n)
        .map(|i| {
            let mut row: Vec<_> = (0..n).map(|j| &two * dot(&arms[i], &arms[j])).collect();
            row.push(dot(&arms[i], &arms[i]));
            row
        })
        .collect();
    for c in 0..n {
        let pivot = (c..n).find(|r| !rows[*r][c].is_zero())?;
        rows.swap(c, pivot);
        let pivot = rows[c].clone();
        for (r, row) in rows.iter_mut().enumerate() {
            if r != c && !row[c].is_zero() {
                let factor = &row[c] / &pivot[c];
                for (x, p) in row.iter_mut().zip(&pivot) {
                    *x -= &factor * p;
                }
            }
        }
    }
    let mut center = [(); 3].map(|()| BigRational::zero());
    for (i, arm) in arms.iter().enumerate() {
        let share = &rows[i][n] / &rows[i][i];
        for k in 0..3 {
            center[k] += &share * &arm[k];
        }
    }
    Some(center)
}

/// The squared radius of the smallest ball.
fn smallest(points: &[Exact]) -> BigRational {
    let n = points.len();
    let mut best: Option<BigRational> = None;
    for set in 1_u32..1 << n {
        if set.count_ones() > 4 {
            continue;
        }
        let members: Vec<&Exact> = (0..n)
            .filter(|i| set >> i & 1 == 1)
            .map(|i| &points[i])
            .collect();
        let arms: Vec<Exact> = members[1..].iter().map(|p| minus(p, members[0])).collect();
        let Some(center) = circumcenter(&arms) else {
            continue;
        };
        let square = dot(&center, &center);
        if best.as_ref().is_some_and(|best| *best <= square) {
            continue;
        }
        let holds = |p: &Exact| {
            let arm = minus(&minus(p, members[0]), &center);
            dot(&arm, &arm) <= square
        };
        if points.iter().all(holds) {
            best = Some(square);
        }
    }
    best.expect("some ball holds all")
}

/// Relative error of the radius, and how far the farthest point is outside of the ball as rounded, in
/// units of 2⁻⁵³ of the largest coordinate.
fn errors(points: &[Point]) -> [f64; 2] {
    let ball = smallest_ball(points);
    let exact: Vec<Exact> = points.iter().map(|p| p.map(number)).collect();
    let least = root(&smallest(&exact));
    let center = ball.center.map(number);
    let farthest = exact
        .iter()
        .map(|p| minus(p, &center))
        .map(|arm| dot(&arm, &arm))
        .max()
        .expect("a point");
    let radius = number(ball.radius);
    let outside = if farthest > &radius * &radius {
        // √a − r = (a − r²)/(√a + r), the difference in rational numbers.
        let gap = &farthest - &radius * &radius;
        let sum = root(&farthest) + ball.radius;
        root(&(&gap * &gap)) / sum
    } else {
        0.0
    };
    let largest = points
        .iter()
        .flatten()
        .fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
    let off = if least == 0.0 {
        ball.radius
    } else {
        (ball.radius / least - 1.0).abs()
    };
    assert!(!radius.is_negative());
    [off, outside / largest * 2_f64.powi(53)]
}

fn check(name: &str, sets: impl IntoIterator<Item = Vec<Point>>) {
    let (mut worst, mut count) = ([0.0_f64; 2], 0);
    for points in sets {
        let found = errors(&points);

        assert!(
            found[0] <= 1e-15,
            "{name}: radius off by {:e}: {points:?}",
            found[0]
        );
        assert!(found[1] <= 8.0, "{name}: {} outside: {points:?}", found[1]);
        worst = [worst[0].max(found[0]), worst[1].max(found[1])];
        count += 1;
    }
    println!("| {name} | {count} | {:.1e} | {:.1} |", worst[0], worst[1]);
    assert!(count > 0);
}

fn cloud(n: usize, rng: &mut Pcg64Mcg) -> Vec<Point> {
    (0..n)
        .map(|_| [0; 3].map(|_| rng.random_range(-1.0..1.0)))
        .collect()
}

/// Points with whole coordinates on the sphere of radius 3 or 9: exactly cospherical.
fn cospherical(n: usize, rng: &mut Pcg64Mcg) -> Vec<Point> {
    let radius: i32 = [3, 9][rng.random_range(0..2)];
    let mut all: Vec<Point> = Vec::new();
    for x in -radius..=radius {
        for y in -radius..=radius {
            for z in -radius..=radius {
                if x * x + y * y + z * z == radius * radius {
                    all.push([x, y, z].map(f64::from));
                }
            }
        }
    }
    (0..n)
        .map(|_| all[rng.random_range(0..all.len())])
        .collect()
}

fn sets(mut make: impl FnMut(usize, &mut Pcg64Mcg) -> Vec<Point>, seed: u64) -> Vec<Vec<Point>> {
    let mut rng = poses::rng(seed);
    (0..30).map(|i| make(2 + i % 5, &mut rng)).collect()
}

#[test]
fn hard_sets_have_their_smallest_balls() {
    println!("| points | sets | radius, relative | outside, 2⁻⁵³ of the largest coordinate |");
    let moved = |points: Vec<Point>, by: f64| -> Vec<Point> {
        points
            .into_iter()
            .map(|p| [p[0] + by, p[1] - 2.0 * by, p[2] + 3.0 * by])
            .collect()
    };
    check("cloud", sets(cloud, 1));
    check(
        "all in one place",
        sets(|n, rng| vec![cloud(1, rng)[0]; n], 2),
    );
    check(
        "duplicates",
        sets(
            |n, rng| [cloud(n / 2 + 1, rng), cloud(1, rng).repeat(3)].concat(),
            3,
        ),
    );
    let line = |n: usize, rng: &mut Pcg64Mcg| -> Vec<Point> {
        let d = cloud(1, rng)[0];
        (0..n)
            .map(|_| rng.random_range(-8..9))
            .map(|t: i32| d.map(|x| x * f64::from(t)))
            .collect()
    };
    check("collinear to the last bit", sets(line, 4));
    check(
        "collinear by whole numbers",
        sets(
            |n, rng| {
                (0..n)
                    .map(|_| rng.random_range(-9..10))
                    .map(|t: i32| [t, 2 * t, -3 * t].map(f64::from))
                    .collect()
            },
            5,
        ),
    );
    check(
        "coplanar",
        sets(
            |n, rng| {
                cloud(n, rng)
                    .into_iter()
                    .map(|p| [p[0], p[1], 0.25])
                    .collect()
            },
            6,
        ),
    );
    check("cospherical", sets(cospherical, 7));
    for bits in [20, 25, 30, 35, 40, 52] {
        let nearly = |n: usize, rng: &mut Pcg64Mcg| -> Vec<Point> {
            let grow =
                |rng: &mut Pcg64Mcg| 1.0 + f64::from(rng.random_range(-1..2)) * 2_f64.powi(-bits);
            cospherical(n, rng)
                .into_iter()
                .map(|p| p.map(|x| x * grow(rng)))
                .collect()
        };
        check(&format!("cospherical but for 2^-{bits}"), sets(nearly, 8));
    }
    for height in [1e-3, 1e-9, 1e-15] {
        let flat = |n: usize, rng: &mut Pcg64Mcg| -> Vec<Point> {
            cloud(n, rng)
                .into_iter()
                .map(|p| [p[0], p[1], height * p[2]])
                .collect()
        };
        check(&format!("flat by {height:e}"), sets(flat, 9));
        let thin = |n: usize, rng: &mut Pcg64Mcg| -> Vec<Point> {
            cloud(n, rng)
                .into_iter()
                .map(|p| [p[0], height * p[1], height * p[2]])
                .collect()
        };
        check(&format!("thin by {height:e}"), sets(thin, 10));
        let pair = |n: usize, rng: &mut Pcg64Mcg| -> Vec<Point> {
            let cluster = cloud(n, rng).into_iter().enumerate();
            cluster
                .map(|(i, p)| [f64::from(i as u32 % 2) + height * p[0], height * p[1], 0.0])
                .collect()
        };
        check(&format!("two clusters of {height:e}"), sets(pair, 11));
    }
    for far in [1e6, 1e8, 1e15] {
        check(
            &format!("{far:e} away"),
            sets(|n, rng| moved(cloud(n, rng), far), 12),
        );
        check(
            &format!("cospherical, {far:e} away"),
            sets(|n, rng| moved(cospherical(n, rng), far), 13),
        );
    }
    let sizes = |n: usize, rng: &mut Pcg64Mcg| -> Vec<Point> {
        cloud(n, rng)
            .into_iter()
            .enumerate()
            .map(|(i, p)| p.map(|x| x * 10_f64.powi(4 * i as i32 - 8)))
            .collect()
    };
    check("sizes from 1e-8 to 1e16", sets(sizes, 14));
    for scale in [1e-40, 1e-6, 1e40] {
        check(
            &format!("{scale:e} large"),
            sets(
                |n, rng| {
                    cloud(n, rng)
                        .into_iter()
                        .map(|p| p.map(|x| x * scale))
                        .collect()
                },
                15,
            ),
        );
    }
    let neighbours = |n: usize, rng: &mut Pcg64Mcg| -> Vec<Point> {
        let p = cloud(1, rng)[0];
        (0..n)
            .map(|i| {
                let mut p = p;
                p[i % 3] = p[i % 3].next_up();
                p
            })
            .collect()
    };
    check("neighbouring numbers", sets(neighbours, 16));
}
