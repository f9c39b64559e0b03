//! Normals of every answer: unit, on the stated side, of the stated thing; and the short questions beside the
//! long ones.

use bdtree_fixtures::{bake, poses};
use bdtree_runtime::narrow::Triangle;
use bdtree_runtime::{
    Ball, Capsule, Contact, Cuboid, HalfSpace, Model, PairContact, PairFront, Pose, Ray,
    RayIntersection, Shape, Transform, Workspace,
};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

fn model() -> Model {
    let mesh = bake::bumpy_sphere(12, 1);
    bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 5))
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

#[track_caller]
fn is_unit(normal: [f64; 3]) {
    assert!((length(normal) - 1.0).abs() < 1e-12, "{normal:?}");
}

/// Whether a vector stands on a triangle.
fn stands_on(normal: [f64; 3], [a, b, c]: &Triangle) -> bool {
    let edges = [sub(*b, *a), sub(*c, *b), sub(*a, *c)];
    let longest = edges.iter().fold(0.0, |m: f64, edge| m.max(length(*edge)));
    edges
        .iter()
        .all(|edge| dot(normal, *edge).abs() <= 1e-9 * longest)
}

/// Whether a unit vector points along another vector.
fn points_along(normal: [f64; 3], along: [f64; 3]) -> bool {
    dot(normal, along) >= (1.0 - 1e-9) * length(along)
}

fn somewhere(rng: &mut Pcg64Mcg, far: f64) -> [f64; 3] {
    [0; 3].map(|_| rng.random_range(-far..far))
}

/// Calls `check` with poses of several sizes.
fn for_poses(seed: u64, mut check: impl FnMut(&Pose<'_>, f64, &mut Pcg64Mcg)) {
    let model = model();
    let asset = model.asset();
    let mut rng = poses::rng(seed);
    for _ in 0..30 {
        let q = poses::random_q(asset, 0.2, &mut rng);
        let place = Transform {
            translation: [0.0; 3],
            ..poses::random_transform(1.0, &mut rng)
        };
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = asset.pose(&q, place, &mut memory).expect("a pose");
        check(&pose, place.scale, &mut rng);
    }
}

#[test]
fn rays_meet_normals_that_face_them() {
    let mut hits = 0;
    for_poses(1, |pose, size, rng| {
        let mut workspace = Workspace::new();
        let mut query = pose.query(&mut workspace);
        let rays: Vec<Ray> = (0..20)
            .map(|_| Ray::new(somewhere(rng, 2.0 * size), somewhere(rng, 1.0)))
            .collect();
        let mut many = vec![None; rays.len()];
        query.cast_rays(&rays, &mut many).expect("rays");
        let mut any = vec![false; rays.len()];
        query.intersects_rays(&rays, &mut any).expect("rays");
        for ((ray, first), any) in rays.iter().zip(many).zip(any) {
            assert_eq!(query.cast_ray(ray), Ok(first));
            assert_eq!(query.intersects_ray(ray), Ok(first.is_some()));
            assert_eq!(any, first.is_some());
            let mut all: Vec<RayIntersection> = Vec::new();
            query.cast_ray_all(ray, &mut all).expect("a ray");
            let nearest = all.iter().map(|hit| (hit.distance, hit.triangle));
            let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            assert_eq!(first.map(|hit| (hit.distance, hit.triangle)), nearest);
            for hit in &all {
                is_unit(hit.normal);
                assert!(dot(hit.normal, ray.direction) < 0.0, "it faces the ray");
                let triangle = pose.deformed_triangle(hit.triangle).expect("a triangle");
                assert!(stands_on(hit.normal, &triangle), "{hit:?}");
                hits += 1;
            }
            // Up to just before the first hit there is none, up to just behind it there is.
            if let Some(hit) = first {
                let before = ray.with_max_distance(hit.distance * (1.0 - 1e-9));
                let behind = ray.with_max_distance(hit.distance * (1.0 + 1e-9));
                assert_eq!(query.intersects_ray(&before), Ok(false));
                assert_eq!(query.cast_ray(&behind), Ok(first));
            }
        }
    });
    assert!(hits > 100, "{hits}");
}

#[test]
fn projections_have_normals_towards_the_point() {
    let mut on_it = 0;
    for_poses(2, |pose, size, rng| {
        let mut workspace = Workspace::new();
        let mut query = pose.query(&mut workspace);
        for round in 0..20 {
            let corners = pose.deformed_triangle(bdtree_runtime::TriangleId(round * 3));
            let corners = corners.expect("a triangle");
            let point = match round % 4 {
                0 => corners[0], // on it
                _ => somewhere(rng, 2.0 * size),
            };
            let near = query
                .project_point(point, f64::INFINITY)
                .expect("an answer");
            let near = near.expect("a point");
            is_unit(near.normal);
            let towards = sub(point, near.point);
            assert!((length(towards) - near.distance).abs() <= 1e-12 * size);
            if near.distance == 0.0 {
                let triangle = pose.deformed_triangle(near.triangle).expect("a triangle");
                assert!(stands_on(near.normal, &triangle), "{near:?}");
                on_it += 1;
            } else if near.distance > 1e-6 * size {
                assert!(points_along(near.normal, towards), "{near:?}");
            }
        }
    });
    assert!(on_it > 100, "{on_it}");
}

#[test]
fn contacts_have_normals_of_their_shapes() {
    let mut found = [0; 4];
    for_poses(3, |pose, size, rng| {
        let mut workspace = Workspace::new();
        let mut query = pose.query(&mut workspace);
        for round in 0..12 {
            let point = somewhere(rng, 1.1 * size);
            let other = somewhere(rng, 1.1 * size);
            let radius = size * rng.random_range(0.05..0.4);
            let shapes: [Shape; 4] = [
                Ball::new(point, radius).into(),
                Capsule::new(point, other, 0.3 * radius).into(),
                Cuboid::new(point, [radius; 3]).into(),
                HalfSpace::new(point, length(point) - size).into(),
            ];
            let shape = shapes[round % 4];
            let mut contacts: Vec<Contact> = Vec::new();
            query.contacts(shape, &mut contacts).expect("contacts");
            assert_eq!(query.intersects(shape), Ok(!contacts.is_empty()));
            for contact in &contacts {
                is_unit(contact.normal);
                let clear = 1e-6 * size;
                match shape {
                    Shape::Ball(ball) => {
                        let towards = sub(ball.center, contact.point);
                        let is_clear = length(towards) > clear;
                        assert!(!is_clear || points_along(contact.normal, towards));
                        assert!(contact.distance <= 0.0);
                    }
                    Shape::Capsule(_) if contact.distance > clear - 0.3 * radius => {
                        // From the point along the normal, as far as the segment is.
                        let away = contact.distance + 0.3 * radius;
                        let along = [0, 1, 2].map(|k| contact.point[k] + away * contact.normal[k]);
                        let t = dot(sub(along, point), sub(other, point))
                            / dot(sub(other, point), sub(other, point));
                        let t = t.clamp(0.0, 1.0);
                        let on = [0, 1, 2].map(|k| point[k] + t * (other[k] - point[k]));
                        assert!(length(sub(along, on)) < clear, "{contact:?}");
                    }
                    Shape::Cuboid(_) => {
                        // Into the box, from the face that the point is nearest to the outside of.
                        let axes = contact.normal.iter().filter(|c| c.abs() > 1e-9).count();
                        assert_eq!(axes, 1, "{contact:?}");
                    }
                    Shape::HalfSpace(half_space) => {
                        let into = half_space.normal.map(|n| -n);
                        assert!(points_along(contact.normal, into));
                    }
                    _ => {}
                }
                found[round % 4] += 1;
            }
        }
    });
    assert!(found.iter().all(|count| *count > 100), "{found:?}");
}

#[test]
fn pairs_have_a_normal_on_each_side() {
    let model = model();
    let asset = model.asset();
    let mut rng = poses::rng(4);
    let mut workspace = Workspace::new();
    let (mut touching, mut near, mut apart) = (0, 0, 0);
    for round in 0..40 {
        let qs = [0, 1].map(|_| poses::random_q(asset, 0.1, &mut rng));
        let away = 1.0 + 0.04 * f64::from(round);
        let place = Transform {
            translation: [away, 0.2, 0.1],
            scale: 1.0,
            ..poses::random_transform(1.0, &mut rng)
        };
        let mut memory = [0, 1].map(|_| vec![0.0; asset.pose_len()]);
        let [memory0, memory1] = &mut memory;
        let a = asset.pose(&qs[0], Transform::IDENTITY, memory0).expect("a");
        let b = asset.pose(&qs[1], place, memory1).expect("b");
        let motions = [&a, &b].map(bdtree_runtime::Motion::new);
        let (a, b) = (
            a.moving(&motions[0]).expect("a"),
            b.moving(&motions[1]).expect("b"),
        );
        let mut front = PairFront::new();
        let mut query = a.against(&b, &mut workspace);
        let mut pairs: Vec<PairContact> = Vec::new();
        query.contacts(0.05, &mut pairs).expect("pair");
        let closest = query.closest_points(f64::INFINITY).expect("a distance");
        let closest = closest.expect("two triangles");
        assert_eq!(query.distance(f64::INFINITY), Ok(Some(closest.distance)));
        assert_eq!(
            query.distance(0.999 * closest.distance),
            Ok((closest.distance == 0.0).then_some(0.0))
        );
        let meets = pairs.iter().any(|pair| pair.distance == 0.0);
        assert_eq!(query.intersects(), Ok(meets));
        assert_eq!(meets, closest.distance == 0.0);
        let mut query = a.against(&b, &mut workspace).front(&mut front);
        for _ in 0..3 {
            assert_eq!(query.intersects(), Ok(meets));
        }
        for pair in pairs.iter().chain([&closest]) {
            is_unit(pair.normal1);
            is_unit(pair.normal2);
            if pair.distance == 0.0 {
                assert_eq!(pair.point1, pair.point2);
                for (pose, triangle, normal) in [
                    (&a, pair.triangle1, pair.normal1),
                    (&b, pair.triangle2, pair.normal2),
                ] {
                    let triangle = pose.deformed_triangle(triangle).expect("a triangle");
                    assert!(stands_on(normal, &triangle), "{pair:?}");
                }
                touching += 1;
            } else if pair.distance > 1e-6 {
                assert!(points_along(pair.normal1, sub(pair.point2, pair.point1)));
                assert!(points_along(pair.normal2, sub(pair.point1, pair.point2)));
                near += 1;
            }
        }
        apart += usize::from(!meets);
    }
    assert!(
        touching > 50 && near > 50 && apart > 5,
        "{touching}, {near}, {apart}"
    );
}
