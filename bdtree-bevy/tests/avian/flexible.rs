//! Bodies whose contacts move q.

use avian3d::parry::query::{Ray, RayCast};
use avian3d::prelude::*;
use bdtree_bevy::Deformation;
use bdtree_bevy::avian::{BdtCollider, Flexible, FlexibleModes};
use bdtree_fixtures::bake;
use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_transform::components::Transform;

use super::support;
use crate::chair::chair;

/// A chair above the ground.
fn standing(height: f32) -> (App, Entity) {
    let mut app = support::app();
    let asset = support::add(&mut app, chair());
    let floor = (
        RigidBody::Static,
        Collider::cuboid(10.0, 1.0, 10.0),
        Transform::from_xyz(0.0, -0.5, 0.0),
    );
    app.world_mut().spawn(floor);
    let more = (
        RigidBody::Dynamic,
        Flexible::default(),
        Friction::new(0.5),
        Transform::from_xyz(0.0, height, 0.0),
    );
    let chair = support::mesh_body(&mut app, asset, more);
    (app, chair)
}

fn get<C: Component + Clone>(app: &App, entity: Entity) -> C {
    app.world().get::<C>(entity).expect("a component").clone()
}

/// Of the rigid motion.
fn kinetic_energy(app: &App, entity: Entity) -> f64 {
    let mass = get::<ComputedMass>(app, entity).value();
    let inertia = get::<ComputedAngularInertia>(app, entity);
    let rotation = get::<Rotation>(app, entity).0;
    let linear = get::<LinearVelocity>(app, entity).0;
    let angular = rotation.inverse() * get::<AngularVelocity>(app, entity).0;
    let turning = angular.dot(inertia.tensor() * angular);
    f64::from(0.5 * (mass * linear.length_squared() + turning))
}

#[test]
fn a_chair_weighs_what_its_bake_says() {
    let (mut app, chair_entity) = standing(0.3);
    support::steps(&mut app, 2);
    let record = chair().asset().mass_properties().expect("a mass");
    let mass = get::<ComputedMass>(&app, chair_entity).value();
    assert!((f64::from(mass) / record.mass_kg.get() - 1.0).abs() < 1e-5);
    app.world_mut()
        .entity_mut(chair_entity)
        .insert(ColliderDensity(2.0));
    support::steps(&mut app, 2);
    let twice = get::<ComputedMass>(&app, chair_entity).value();
    assert!((twice / mass - 2.0).abs() < 1e-5);
}

/// A ball that falls on the seat makes the chair ring; then both lie still.
#[test]
fn a_ball_makes_a_chair_ring_and_rests() {
    let (mut app, chair) = standing(0.01);
    let ball = (
        RigidBody::Dynamic,
        Collider::sphere(0.1),
        Mass(3.0),
        Friction::new(0.8),
        AngularDamping(2.0),
        Transform::from_xyz(0.0, 1.0, 0.0),
    );
    let ball = app.world_mut().spawn(ball).id();
    let mut loudest = 0.0_f64;
    for _ in 0..64 * 6 {
        support::steps(&mut app, 1);
        if let Some(modes) = app.world().get::<FlexibleModes>(chair) {
            loudest = loudest.max(modes.kinetic_energy());
            assert_eq!(get::<Deformation>(&app, chair).q, modes.q());
        }
    }
    assert!(loudest > 3e-4, "it rang with {loudest} J");
    let left = get::<FlexibleModes>(&app, chair).kinetic_energy();
    assert!(left < 0.02 * loudest, "{left} of {loudest}");
    let height = get::<Position>(&app, ball).0.y;
    assert!((0.48..0.58).contains(&height), "{height}");
    for body in [ball, chair] {
        assert!(app.world().get::<Sleeping>(body).is_some(), "it lies still");
        assert!(kinetic_energy(&app, body) < 1e-3);
    }
    // And goes on doing so: nothing moves.
    let before = (
        get::<Position>(&app, ball),
        get::<FlexibleModes>(&app, chair).q(),
    );
    support::steps(&mut app, 64);
    let after = (
        get::<Position>(&app, ball),
        get::<FlexibleModes>(&app, chair).q(),
    );
    assert_eq!(before, after);
}

/// Height of the seat's middle in the chair's frame.
fn seat(app: &App, chair: Entity) -> f32 {
    let collider = get::<BdtCollider>(app, chair);
    let ray = Ray::new(Vec3::new(0.0, 0.6, 0.0), Vec3::NEG_Y);
    let hit = collider
        .mesh()
        .expect("a mesh")
        .cast_local_ray(&ray, 1.0, false);
    0.6 - hit.expect("the seat")
}

#[test]
fn a_load_bends_a_chair() {
    let mut heights = Vec::new();
    for load in [0.0, 30.0] {
        let (mut app, chair) = standing(0.0);
        if load > 0.0 {
            let load = (
                RigidBody::Dynamic,
                Collider::cuboid(0.2, 0.16, 0.2),
                Mass(load),
                Transform::from_xyz(0.0, 0.52, 0.0),
            );
            app.world_mut().spawn(load);
        }
        support::steps(&mut app, 64 * 4);
        heights.push(seat(&app, chair));
    }
    assert!(heights[1] < heights[0] - 1e-5, "{heights:?}");
}

#[test]
fn a_fall_gains_no_energy() {
    let (mut app, chair) = standing(0.3);
    support::steps(&mut app, 2);
    let mass = f64::from(get::<ComputedMass>(&app, chair).value());
    let height = |app: &App| {
        let center = get::<Rotation>(app, chair).0 * get::<ComputedCenterOfMass>(app, chair).0;
        f64::from(get::<Position>(app, chair).0.y + center.y)
    };
    let energy = |app: &App| {
        let modes = get::<FlexibleModes>(app, chair).energy();
        kinetic_energy(app, chair) + 9.81 * mass * height(app) + modes
    };
    let first = energy(&app);
    let fall = 9.81 * mass * 0.3;
    for step in 0..640 {
        support::steps(&mut app, 1);
        let now = energy(&app);
        assert!(now < first + 0.04 * fall, "step {step}: {now} of {first}");
    }
    let moving = kinetic_energy(&app, chair);
    assert!(moving < 1e-6 * fall, "{moving}");
}

/// A body that was bent and let go swings as its frequency says; a program may write q.
#[test]
fn modes_swing() {
    let (mut app, chair_entity) = standing(1.0);
    app.world_mut().resource_mut::<Gravity>().0 = Vec3::ZERO;
    support::steps(&mut app, 2);
    let mode = chair().asset().modes()[0];
    let mut q = vec![0.0; 6];
    q[0] = 0.3 * mode.q_range.get();
    app.world_mut()
        .get_mut::<Deformation>(chair_entity)
        .expect("a mesh")
        .q = q.clone();
    support::steps(&mut app, 1);
    let start = get::<FlexibleModes>(&app, chair_entity).energy();
    assert!(start > 0.0);
    // Damped at a ratio of 0.1.
    let seconds = 16.0 * f64::from(support::STEP_S);
    support::steps(&mut app, 16);
    let left = get::<FlexibleModes>(&app, chair_entity).energy() / start;
    let expected = (-0.2 * mode.omega_rad_s.get() * seconds).exp();
    assert!((left / expected).ln().abs() < 0.3, "{left}, {expected}");
}

#[test]
fn what_cannot_vibrate_stays_rigid() {
    let (mut app, _) = standing(0.0);
    let mesh = bake::bumpy_sphere(4, 3);
    let asset = support::add(
        &mut app,
        &bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 5)),
    );
    let at = Transform::from_xyz(5.0, 5.0, 0.0);
    let body = support::mesh_body(
        &mut app,
        asset,
        (RigidBody::Static, Flexible::default(), at),
    );
    support::steps(&mut app, 3);
    assert!(app.world().get::<FlexibleModes>(body).is_none());
    assert!(app.world().get::<BdtCollider>(body).is_some());
}
