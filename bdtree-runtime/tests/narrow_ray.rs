//! Rays: no leaks through closed meshes, certified points, edge-on and zero-area triangles.

use crate::narrow_oracle::*;
use bdtree_runtime::narrow::{PreparedRay, RayHit, ray_hit};
use num_traits::{Signed, ToPrimitive};
use rand::RngExt;
use rand_pcg::Pcg64;

fn unit(d: [f64; 3]) -> [f64; 3] {
    let n = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
    d.map(|x| x / n)
}

fn toward(from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    unit([0, 1, 2].map(|k| to[k] - from[k]))
}

fn first_hit(ray: &PreparedRay, mesh: &[Triangle]) -> Option<(usize, RayHit)> {
    let mut best: Option<(usize, RayHit)> = None;
    for (i, tri) in mesh.iter().enumerate() {
        if let Some(h) = ray_hit(ray, tri, f64::MAX)
            && best.is_none_or(|(_, b)| h.t < b.t)
        {
            best = Some((i, h));
        }
    }
    best
}

/// |origin + t direction − Σ w corner| in exact arithmetic, in units of u L; asserts τ = 128 u L.
fn check_hit(ray: &PreparedRay, tri: &Triangle, hit: &RayHit) -> f64 {
    let w = hit.barycentric;
    assert!(w.iter().all(|&x| (0.0..=1.0).contains(&x)), "{w:?}");
    assert!((w[0] + w[1] + w[2] - 1.0).abs() <= 4.0 * U, "{w:?}");
    let l = largest_difference(&[ray.origin()], tri);
    // Weights sum to 1 to rounding only: all relative to the origin.
    let origin = exact_point(ray.origin());
    let direction = exact_point(ray.direction());
    let mut off = direction.map(|d| exact(hit.t) * d);
    for (corner, w) in tri.iter().zip(w) {
        off = plus_scaled(&off, &-exact(w), &minus(&exact_point(*corner), &origin));
    }
    let squared = product(&off, &off);
    let scaled = squared / (exact(l) * exact(l));
    let error = scaled.to_f64().expect("in range").sqrt() / U;
    assert!(error <= 128.0, "{error} uL: {ray:?} {tri:?} {hit:?}");
    error
}

/// A closed star-shaped mesh: a cube's faces cut into n × n squares, pushed out unevenly.
fn closed_mesh(r: &mut Pcg64, n: i32, rough: f64, offset: f64) -> Vec<Triangle> {
    let mut corners = std::collections::HashMap::new();
    let mut corner = |g: [i32; 3]| {
        *corners.entry(g).or_insert_with(|| {
            let d = unit(g.map(|x| f64::from(2 * x - n) / f64::from(n)));
            let radius = 1.0 + r.random_range(-rough..=rough);
            d.map(|x| x * radius + offset)
        })
    };
    let mut mesh = Vec::new();
    for axis in 0..3 {
        for side in [0, n] {
            for i in 0..n {
                for j in 0..n {
                    let mut at = |di: i32, dj: i32| {
                        let mut g = [0; 3];
                        g[axis] = side;
                        g[(axis + 1) % 3] = i + di;
                        g[(axis + 2) % 3] = j + dj;
                        corner(g)
                    };
                    let q = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
                    mesh.push([q[0], q[1], q[2]]);
                    mesh.push([q[0], q[2], q[3]]);
                }
            }
        }
    }
    mesh
}

#[test]
fn closed_meshes_never_leak() {
    let mut r = rng(21);
    let (mut rays, mut worst) = (0, 0.0_f64);
    for (rough, offset) in [(0.0, 0.0), (0.3, 0.0), (0.3, 1e6), (0.05, -3.0)] {
        let mesh = closed_mesh(&mut r, 5, rough, offset);
        for tri in &mesh {
            let inside = random_point(&mut r).map(|x| offset + 0.3 * x);
            let outside = random_point(&mut r).map(|x| offset + 30.0 * x);
            let s = r.random_range(0.0..1.0);
            for target in [
                tri[0],
                mix(tri[0], tri[1], 0.5),
                mix(tri[1], tri[2], s),
                mix(mix(tri[0], tri[1], s), tri[2], 0.3),
            ] {
                for (from, to) in [
                    (inside, target),
                    ([offset; 3], target),
                    // From outside to a point well inside, past the target's neighbourhood.
                    (target.map(|x| offset + 3.0 * (x - offset)), [offset; 3]),
                    (outside, inside),
                ] {
                    let ray = PreparedRay::new(from, toward(from, to));
                    let (i, hit) = first_hit(&ray, &mesh)
                        .unwrap_or_else(|| panic!("leak: {from:?} to {to:?} at {target:?}"));
                    if rays % 8 == 0 {
                        worst = worst.max(check_hit(&ray, &mesh[i], &hit));
                    }
                    rays += 1;
                }
            }
        }
    }
    println!("{rays} rays, none leaked; worst {worst} u L off");
}

#[test]
fn axis_rays_through_a_grid_box_never_leak() {
    // Everything exact: rays run through corners, along edges and inside faces.
    let n = 4;
    let mut r = rng(22);
    let mut mesh = Vec::new();
    for tri in closed_mesh(&mut r, n, 0.0, 0.0) {
        // Back onto the box, on integers.
        mesh.push(tri.map(|p| {
            let m = p.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            p.map(|x| (x / m * 2.0).round())
        }));
    }
    for axis in 0..3 {
        for i in -2..=2 {
            for j in -2..=2 {
                for back in [1.0, -1.0] {
                    let mut o = [f64::from(i); 3];
                    o[(axis + 1) % 3] = f64::from(j);
                    o[axis] = -5.0 * back;
                    let mut d = [0.0; 3];
                    d[axis] = back;
                    let (_, hit) = first_hit(&PreparedRay::new(o, d), &mesh).expect("hit");
                    assert_eq!(hit.t, 3.0);
                    assert_eq!(hit.point[axis], -2.0 * back);
                    // From a point of the surface: at once.
                    let (_, hit) = first_hit(&PreparedRay::new(hit.point, d), &mesh).expect("hit");
                    assert_eq!(hit.t, 0.0);
                }
            }
        }
    }
}

#[test]
fn every_hit_is_certified_and_clear_hits_are_found() {
    let mut r = rng(23);
    let (mut worst, mut hits) = (0.0_f64, 0);
    for _ in 0..6_000 {
        let place = placement(&mut r);
        let tri = nasty_triangle(&mut r).map(&place);
        let target = mix(mix(tri[0], tri[1], r.random_range(0.0..1.0)), tri[2], 0.5);
        let spread = 10.0_f64.powf(r.random_range(-16.0..0.5));
        // Half of the origins nearly in the plane: grazing rays.
        let lift = random_point(&mut r);
        let from = mix(tri[1], tri[2], r.random_range(-3.0..3.0));
        let size = largest_difference(&tri, &tri);
        let from = [0, 1, 2].map(|k| from[k] + size * spread * lift[k]);
        if from == target {
            continue;
        }
        let gap = largest_difference(&[from], &[target]);
        let to = [0, 1, 2].map(|k| (target[k] - from[k]) / gap);
        let ray = PreparedRay::new(from, unit(to));
        if let Some(hit) = ray_hit(&ray, &tri, f64::MAX) {
            worst = worst.max(check_hit(&ray, &tri, &hit));
            hits += 1;
            assert_eq!(
                ray_hit(&ray, &tri, hit.t),
                Some(hit),
                "limits are inclusive"
            );
            let shorter = hit.t.next_down();
            assert!(hit.t == 0.0 || ray_hit(&ray, &tri, shorter).is_none());
        }
    }
    println!("{hits} hits, worst {worst} u L off");
    assert!(hits > 1_500);
}

#[test]
fn agrees_with_exact_hits_away_from_the_rim() {
    let mut r = rng(24);
    let mut hits = 0;
    for _ in 0..6_000 {
        let tri = [(); 3].map(|()| random_point(&mut r));
        let (from, d) = (random_point(&mut r), unit(random_point(&mut r)));
        let ray = PreparedRay::new(from, d);
        // Exact barycentric coordinates and t of the line by Cramer's rule.
        let [a, b, c] = tri.map(exact_point);
        let (o, d) = (exact_point(from), exact_point(d));
        let (e, g, w) = (minus(&b, &a), minus(&c, &a), minus(&o, &a));
        let det = product(&d, &cross(&g, &e));
        let t = product(&w, &cross(&e, &g)) / &det;
        let u = product(&w, &cross(&d, &g)) / &det;
        let v = product(&w, &cross(&e, &d)) / &det;
        let rest = exact(1.0) - &u - &v;
        let hit = ray_hit(&ray, &tri, f64::MAX);
        let rim = exact(1e-9);
        if [&u, &v, &rest, &t].iter().all(|x| **x > rim) {
            let hit = hit.expect("a clear hit");
            let t = t.to_f64().expect("in range");
            let steep = det.to_f64().expect("in range").abs();
            assert!((hit.t - t).abs() <= 64.0 * U / steep, "{} {t}", hit.t);
            hits += 1;
        } else if [&u, &v, &rest, &t].iter().any(|x| **x < -rim.abs()) {
            assert!(hit.is_none());
        }
    }
    assert!(hits > 100);
}

#[test]
fn edge_on_triangles_are_closed_sets() {
    let tri = [[1.0, -1.0, 0.0], [3.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
    let x = [1.0, 0.0, 0.0];
    let at = |o: [f64; 3]| ray_hit(&PreparedRay::new(o, x), &tri, f64::MAX);
    // Enters at the side x = 1.
    let hit = at([0.0, 0.25, 0.0]).expect("hit");
    assert_eq!((hit.t, hit.point), (1.0, [1.0, 0.25, 0.0]));
    // Starts inside.
    let hit = at([2.0, 0.25, 0.0]).expect("hit");
    assert_eq!((hit.t, hit.point), (0.0, [2.0, 0.25, 0.0]));
    // Touches a corner, starts at the last corner, has passed, passes above, beside.
    assert_eq!(at([0.0, 1.0, 0.0]).expect("hit").point, [1.0, 1.0, 0.0]);
    assert_eq!(at([3.0, 0.0, 0.0]).expect("hit").t, 0.0);
    assert!(at([3.5, 0.0, 0.0]).is_none());
    assert!(at([0.0, 0.0, 1e-300]).is_some(), "below the range: 0");
    assert!(at([0.0, 0.0, 1e-60]).is_none());
    assert!(at([0.0, 1.0 + 1e-15, 0.0]).is_none());
}

#[test]
fn a_ray_that_starts_on_a_triangle_hits_at_once() {
    let mut r = rng(26);
    for _ in 0..3_000 {
        let tri = [(); 3].map(|()| grid_point(&mut r, 1000).map(|x| x + 1e6));
        // Exactly in the plane and well inside.
        let from = mix(mix(tri[0], tri[1], 0.5), tri[2], 0.25);
        let ray = PreparedRay::new(from, unit(random_point(&mut r)));
        let hit = ray_hit(&ray, &tri, 0.0).unwrap_or_else(|| panic!("{tri:?} {ray:?}"));
        assert_eq!(hit.t, 0.0);
    }
}

#[test]
fn zero_area_is_missed() {
    let mut r = rng(25);
    for case in 0..3_000 {
        let [p, q] = [(); 2].map(|()| grid_point(&mut r, 9));
        let tri = match case % 3 {
            0 => [p, q, mix(p, q, 0.25)],
            1 => [p, p, q],
            _ => [p, p, p],
        };
        let from = grid_point(&mut r, 7);
        let target = mix(tri[0], tri[2], r.random_range(0.0..1.0));
        if from != target {
            let ray = PreparedRay::new(from, toward(from, target));
            assert_eq!(ray_hit(&ray, &tri, f64::MAX), None);
        }
    }
}

#[test]
fn zero_area_is_missed_from_anywhere() {
    let mut r = rng(26);
    for case in 0..100_000 {
        // Exactly collinear; seen from points with all digits, the sheared corners are so only up to rounding.
        let size = 2_f64.powi(r.random_range(-30..30));
        let [p, d] = [(); 2].map(|()| grid_point(&mut r, 9));
        let at = |k: f64| [0, 1, 2].map(|i| size * (p[i] + k * d[i]));
        let tri = [at(0.0), at(f64::from(case % 7) - 3.0), at(1.0)];
        let far = size * 10_f64.powi(r.random_range(-1..4));
        let from = [(); 3].map(|()| far * r.random_range(-1.0..1.0));
        let ray = PreparedRay::new(from, toward(from, at(r.random_range(0.0..1.0))));
        assert_eq!(ray_hit(&ray, &tri, f64::MAX), None, "{tri:?} from {from:?}");
    }
}
