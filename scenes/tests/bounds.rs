//! Every bound of the study holds every vertex, and all of them find what brute force finds.

use bdtree_build::tree::{LaneKind, Split};
use bdtree_fixtures::poses::rng;
use bdtree_runtime::narrow::triangles_intersect;
use bdtree_scenes::bounds::body::Body;
use bdtree_scenes::bounds::bound::Wrapped;
use bdtree_scenes::bounds::contenders::contenders;
use bdtree_scenes::bounds::overlap::{BoxTest, Relation};
use bdtree_scenes::bounds::pair::pair;
use bdtree_scenes::bounds::posed::Posed;
use bdtree_scenes::bounds::scene::{self, Mesh};
use bdtree_scenes::bounds::shape::Ball;
use bdtree_scenes::bounds::single::{ball, ray};
use nalgebra::Isometry3;
use rand::RngExt;

const MODES: usize = 5;

fn body(mesh: &Mesh, seed: u64) -> Body {
    let fields = scene::smooth_fields(mesh, MODES, 2.5, &mut rng(seed));
    mesh.body(&fields, Split::Cost, 4)
}

/// One mode, all modes, small and large: up to four diagonals.
fn poses(seed: u64) -> Vec<Vec<f64>> {
    let mut rng = rng(seed);
    let mut all = vec![vec![0.0; MODES]];
    for size in [0.1, 1.0, 20.0] {
        for _ in 0..4 {
            all.push(
                (0..MODES)
                    .map(|_| size * rng.random_range(-1.0..1.0))
                    .collect(),
            );
        }
        for sign in [-size, size] {
            let mut q = vec![0.0; MODES];
            q[rng.random_range(0..MODES)] = sign;
            all.push(q);
        }
    }
    all
}

#[test]
fn every_lane_holds_its_vertices() {
    for (mesh, seed) in [(scene::bumpy_sphere(9), 1), (scene::curtain(14), 2)] {
        let body = body(&mesh, seed);
        for contender in contenders() {
            let wrapped = Wrapped::new(&body, contender.bound);
            for q in poses(seed + 10) {
                let vertices = body.deformed(&q);
                for lane in 0..body.lane_count() {
                    if body.kind(lane) == LaneKind::Empty {
                        continue;
                    }
                    let shape = wrapped.at(&body, lane, &q, &vertices);
                    for v in body.vertices_below(lane) {
                        let excess = shape.excess(&vertices[*v as usize], &wrapped.directions);
                        // f64 sums of a dozen terms of the size of the body; sizes of lanes
                        // are above a hundredth of that.
                        assert!(
                            excess < 1e-10,
                            "{}: lane {lane}, vertex {v} is {excess} outside at {q:?}",
                            contender.name
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn a_smaller_bound_would_not_hold_them() {
    let mesh = scene::bumpy_sphere(6);
    let body = body(&mesh, 3);
    let q = &poses(4)[6];
    let vertices = body.deformed(q);
    for contender in contenders() {
        let wrapped = Wrapped::new(&body, contender.bound);
        let escapes = (0..body.lane_count())
            .filter(|lane| body.kind(*lane) != LaneKind::Empty)
            .any(|lane| {
                let mut shape = wrapped.at(&body, lane, &[0.0; MODES], &body.positions);
                if let Some(ball) = &mut shape.ball {
                    ball.radius *= 0.999;
                }
                let below = body.vertices_below(lane).iter();
                let mut excess =
                    below.map(|v| shape.excess(&vertices[*v as usize], &wrapped.directions));
                excess.any(|excess| excess > 1e-6)
            });
        assert!(escapes, "{}: the rest bound holds a pose", contender.name);
    }
}

#[test]
fn every_bound_finds_the_same_contacts() {
    let mesh = scene::bumpy_sphere(8);
    let body = body(&mesh, 5);
    let mut rng = rng(6);
    for displacement in [0.0, 0.1, 0.2] {
        let qa = scene::pose(&body, mesh.diagonal(), Some(displacement), &mut rng);
        let qb = scene::pose(&body, mesh.diagonal(), Some(displacement), &mut rng);
        let (turn, along) = (scene::rotation(&mut rng), scene::direction(&mut rng));
        let place = scene::placed(turn, along, 1.0);
        let mut expected = 0;
        for contender in contenders() {
            let wrapped = Wrapped::new(&body, contender.bound);
            let hulls = contender.boxes == BoxTest::Hull;
            let relation = Relation::new(contender.boxes, &wrapped.directions, &place);
            let mut a = Posed::new(&body, &wrapped, &qa, Isometry3::identity(), hulls);
            let mut b = Posed::new(&body, &wrapped, &qb, place, hulls);
            if expected == 0 {
                expected = brute_force(&a, &b);
                assert!(expected > 0);
            }
            let counts = pair(&mut a, &mut b, &relation, contender.filter);
            assert_eq!(counts.contacts, expected, "{}", contender.name);
        }
    }
}

fn brute_force(a: &Posed<'_>, b: &Posed<'_>) -> u64 {
    let all = |posed: &Posed<'_>| -> Vec<_> {
        let count = posed.body.corners.len() as u32;
        (0..count).map(|t| posed.triangle(t)).collect()
    };
    let (all_a, all_b) = (all(a), all(b));
    let touching = all_a
        .iter()
        .flat_map(|ta| all_b.iter().filter(move |tb| triangles_intersect(ta, tb)));
    touching.count() as u64
}

#[test]
fn every_bound_finds_the_same_in_balls_and_on_rays() {
    let mesh = scene::curtain(20);
    let body = body(&mesh, 7);
    let mut rng = rng(8);
    let q = scene::pose(&body, mesh.diagonal(), Some(0.1), &mut rng);
    for _ in 0..20 {
        let at = body.positions[rng.random_range(0..body.positions.len())];
        let near = Ball {
            centre: at + scene::direction(&mut rng) * 0.1,
            radius: 0.15,
        };
        let origin = scene::direction(&mut rng) * 3.0;
        let line = (origin, (at - origin).normalize());
        let mut expected = None;
        for contender in contenders() {
            let wrapped = Wrapped::new(&body, contender.bound);
            let mut posed = Posed::new(&body, &wrapped, &q, Isometry3::identity(), false);
            let found = (ball(&mut posed, &near).found, ray(&mut posed, &line).1);
            assert_eq!(*expected.get_or_insert(found), found, "{}", contender.name);
        }
    }
}
