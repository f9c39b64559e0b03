//! Questions about the whole world equal brute force over all deformed triangles of all entities.

use bdtree_bevy::bdtree_runtime::narrow::OrientedBox;
use bdtree_bevy::bdtree_runtime::{Ball, Capsule, Cuboid, HalfSpace, Ray};
use bdtree_bevy::{DeformingQueries, WorldQueryError};
use bdtree_fixtures::oracle::{self, body::Body};
use bdtree_fixtures::poses;
use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::system::RunSystemOnce;
use bevy_transform::components::Transform;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::common::{app, ball, bar, deformation, instance, random_joints, random_place, spawn};

/// Some bodies close to each other.
fn crowd(count: usize, spread: f64, rng: &mut Pcg64Mcg) -> (App, Vec<Entity>) {
    let mut app = app();
    let models = [ball(), bar()];
    let entities: Vec<_> = (0..count)
        .map(|k| {
            let model = &models[k % 2];
            let entity = spawn(&mut app, model, random_place(spread, rng));
            let q = poses::random_q(model.asset(), 0.3, rng);
            let joints = random_joints(model, rng);
            let mut deformation = deformation(&mut app, entity);
            (deformation.q, deformation.joints) = (q, joints);
            entity
        })
        .collect();
    app.update();
    (app, entities)
}

/// All deformed triangles of each.
fn deformed(app: &App, entities: &[Entity]) -> Vec<(Entity, Body)> {
    let body = |entity: &Entity| {
        let pose = instance(app, *entity).snapshot();
        (*entity, oracle::deformed_triangles(&pose))
    };
    entities.iter().map(body).collect()
}

fn ask<T: Send + Sync + 'static>(
    app: &mut App,
    question: impl FnOnce(DeformingQueries) -> T + Send + Sync + 'static,
) -> T {
    let mut question = Some(question);
    app.world_mut()
        .run_system_once(move |queries: DeformingQueries| question.take().unwrap()(queries))
        .unwrap()
}

fn point(spread: f64, rng: &mut Pcg64Mcg) -> [f64; 3] {
    [0; 3].map(|_| rng.random_range(-spread..spread))
}

#[test]
fn rays_equal_brute_force() {
    let mut rng = poses::rng(1);
    let (mut app, entities) = crowd(60, 12.0, &mut rng);
    let bodies = deformed(&app, &entities);
    let rays: Vec<Ray> = (0..2000)
        .map(|k| {
            let limit = if k % 3 == 0 { 10.0 } else { f64::INFINITY };
            let (from, target) = (point(20.0, &mut rng), point(9.0, &mut rng));
            let direction = if k % 7 == 0 {
                // Along an axis.
                [0.0, 0.0, -from[2]]
            } else {
                [0, 1, 2].map(|k| target[k] - from[k])
            };
            Ray::new(from, direction).with_max_distance(limit)
        })
        .collect();
    let left_out = entities[3];
    let answers = ask(&mut app, {
        let rays = rays.clone();
        move |mut queries| {
            let filter = |entity| entity != left_out;
            rays.iter()
                .map(|ray| {
                    let (mut all, mut through) = (Vec::new(), Vec::new());
                    queries.cast_ray_all(ray, filter, &mut all).unwrap();
                    queries
                        .cast_ray_through(ray, filter, |e| e.index_u32() % 3 == 0, &mut through)
                        .unwrap();
                    (
                        queries.cast_ray(ray, filter).unwrap(),
                        queries.intersects_ray(ray, filter).unwrap(),
                        all,
                        through,
                    )
                })
                .collect::<Vec<_>>()
        }
    });
    let mut hit_count = 0;
    for (ray, (first, any, all, through)) in rays.iter().zip(&answers) {
        let mut expected = Vec::new();
        let mut firsts = Vec::new();
        for (entity, body) in bodies.iter().filter(|(entity, _)| *entity != left_out) {
            let direction = oracle::unit(ray.direction);
            let hits = oracle::ray_all(body, ray.origin, direction, ray.max_distance);
            expected.extend(hits.iter().map(|(id, d)| (*d, *entity, *id)));
            let first = oracle::ray(body, ray.origin, direction, ray.max_distance);
            firsts.extend(first.map(|(id, d)| (d, *entity, id)));
        }
        let by_distance = |a: &(f64, Entity, u32), b: &(f64, Entity, u32)| {
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2))
        };
        expected.sort_by(by_distance);
        firsts.sort_by(by_distance);
        let told = |hit: &bdtree_bevy::EntityHit<bdtree_bevy::bdtree_runtime::RayIntersection>| {
            (hit.distance, hit.entity, hit.triangle.0)
        };
        assert_eq!(all.iter().map(told).collect::<Vec<_>>(), expected);
        assert_eq!(first.as_ref().map(told), firsts.first().copied());
        assert_eq!(any.is_some(), !expected.is_empty());
        assert!(any.is_none_or(|any| expected.iter().any(|hit| hit.1 == any)));
        let blocking = firsts.iter().position(|hit| hit.1.index_u32() % 3 == 0);
        let seen = blocking.map_or(firsts.len(), |k| k + 1);
        // Others at the same distance as what blocks are seen too.
        assert_eq!(
            through.iter().map(told).collect::<Vec<_>>(),
            firsts[..seen].to_vec()
        );
        hit_count += usize::from(first.is_some());
    }
    assert!((300..1900).contains(&hit_count), "{hit_count}");
}

#[test]
fn shapes_and_points_equal_brute_force() {
    let mut rng = poses::rng(2);
    let (mut app, entities) = crowd(60, 8.0, &mut rng);
    let bodies = deformed(&app, &entities);
    let mut touched = [0; 5];
    for _ in 0..200 {
        let place = poses::random_transform(8.0, &mut rng);
        let radius = rng.random_range(0.1..2.0);
        let ball = Ball::new(place.translation, radius);
        let capsule = Capsule::new(place.translation, point(8.0, &mut rng), 0.5 * radius);
        let half = point(1.5, &mut rng).map(f64::abs);
        let cuboid = Cuboid::new(place.translation, half).rotated(place.rotation);
        let half_space = HalfSpace::new(point(1.0, &mut rng), rng.random_range(-9.0..0.0));
        let reach = rng.random_range(0.0..3.0);
        let (answers, entities, nearest) = ask(&mut app, move |mut queries| {
            let mut answers: [Vec<_>; 4] = Default::default();
            let mut entities: [Vec<Entity>; 4] = Default::default();
            macro_rules! shape {
                ($k:literal, $shape:ident) => {
                    queries
                        .contacts($shape, |_| true, &mut answers[$k])
                        .unwrap();
                    queries
                        .intersections($shape, |_| true, &mut entities[$k])
                        .unwrap();
                };
            }
            shape!(0, ball);
            shape!(1, capsule);
            shape!(2, cuboid);
            shape!(3, half_space);
            let nearest = queries.project_point(place.translation, reach, |_| true);
            (answers, entities, nearest.unwrap())
        });
        let oriented = OrientedBox::new(cuboid.center, cuboid.rotation, cuboid.half_extents);
        let mut expected: [Vec<(Entity, u32)>; 4] = Default::default();
        let mut closest: Option<(f64, Entity, u32)> = None;
        for (entity, body) in &bodies {
            let mut add = |k: usize, ids: Vec<u32>| {
                expected[k].extend(ids.into_iter().map(|id| (*entity, id)));
            };
            let ids = |found: Vec<(u32, f64)>| found.into_iter().map(|f| f.0).collect();
            add(0, ids(oracle::ball(body, ball.center, ball.radius)));
            let ends = [capsule.a, capsule.b];
            add(1, ids(oracle::capsule(body, ends, capsule.radius)));
            add(2, ids(oracle::cuboid(body, &oriented)));
            let normal = oracle::unit(half_space.normal);
            add(3, oracle::plane(body, normal, half_space.offset));
            if let Some((id, d)) = oracle::closest(body, place.translation, reach)
                && closest.is_none_or(|best| (d, *entity) < (best.0, best.1))
            {
                closest = Some((d, *entity, id));
            }
        }
        for k in 0..4 {
            let mut found: Vec<_> = answers[k]
                .iter()
                .map(|c| (c.entity, c.triangle.0))
                .collect();
            found.sort();
            expected[k].sort();
            assert_eq!(found, expected[k]);
            let mut own: Vec<_> = expected[k].iter().map(|c| c.0).collect();
            own.dedup();
            assert_eq!(entities[k], own);
            touched[k] += usize::from(!found.is_empty());
        }
        let nearest = nearest.map(|hit| (hit.distance, hit.entity, hit.triangle.0));
        assert_eq!(nearest, closest);
        touched[4] += usize::from(nearest.is_some());
    }
    assert!(touched.iter().all(|count| *count > 40), "{touched:?}");
}

#[test]
fn pairs_equal_brute_force() {
    let mut rng = poses::rng(3);
    let (mut app, entities) = crowd(16, 3.0, &mut rng);
    let bodies = deformed(&app, &entities);
    let mut touching = 0;
    for i in 0..bodies.len() {
        for j in 0..i {
            let pair = [bodies[i].0, bodies[j].0];
            let (contacts, touch, closest) = ask(&mut app, move |mut queries| {
                let mut contacts = Vec::new();
                queries.pair_contacts(pair, 0.0, &mut contacts).unwrap();
                let closest = queries.closest_points(pair, f64::INFINITY).unwrap();
                assert_eq!(
                    queries.distance(pair, f64::INFINITY).unwrap(),
                    closest.map(|c| c.distance)
                );
                (contacts, queries.are_touching(pair).unwrap(), closest)
            });
            let expected = oracle::pair(&bodies[i].1, &bodies[j].1, 0.0);
            let mut found: Vec<_> = contacts
                .iter()
                .map(|c| (c.triangle1.0, c.triangle2.0))
                .collect();
            found.sort();
            assert_eq!(found, expected);
            assert_eq!(touch, !expected.is_empty());
            assert_eq!(closest.unwrap().distance == 0.0, touch);
            touching += usize::from(touch);
        }
    }
    assert!((10..110).contains(&touching), "{touching}");
}

#[test]
fn what_cannot_be_asked_is_told() {
    let mut app = app();
    let entity = spawn(&mut app, &ball(), Transform::default());
    let none = app.world_mut().spawn_empty().id();
    app.update();
    ask(&mut app, move |mut queries| {
        let nan = Ray::new([0.0; 3], [f64::NAN, 0.0, 0.0]);
        let still = Ray::new([0.0; 3], [0.0; 3]);
        for ray in [nan, still] {
            let refused = queries.cast_ray(&ray, |_| true);
            assert_eq!(refused, Err(WorldQueryError::Ray));
        }
        let ray = Ray::new([0.0; 3], [0.0, 0.0, 1.0]);
        assert_eq!(
            queries.cast_ray_at(none, &ray),
            Err(WorldQueryError::NoInstance(none))
        );
        assert_eq!(
            queries.are_touching([entity, none]),
            Err(WorldQueryError::NoInstance(none))
        );
        assert_eq!(
            queries.are_touching([entity, entity]),
            Err(WorldQueryError::Same(entity))
        );
        let bad = Ball::new([0.0, 0.0, 1.0], f64::NAN);
        let refused = queries.contacts(bad, |_| true, &mut Vec::new());
        let why = refused.unwrap_err().to_string();
        assert!(why.contains("radius"), "{why}");
    });
}
