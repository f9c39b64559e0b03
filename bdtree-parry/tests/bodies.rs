//! Bodies of rapier that deform, in either precision.

use bdtree_fixtures::bake;
use bdtree_parry::{DeformingModel, ShapeError};

use super::ours::{FlexibleBodies, FlexibleOptions, MeshDispatcher};
use super::parry::math::Real;
use super::parry::query::{QueryDispatcher, Ray, RayCast};
use super::parry::shape::Cuboid;
use super::rapier::prelude::*;
use crate::flexible::chair;

fn ground() -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    world.narrow_phase = NarrowPhase::with_query_dispatcher(MeshDispatcher::new());
    let floor = ColliderBuilder::cuboid(5.0, 0.5, 5.0).translation(Vector::new(0.0, -0.5, 0.0));
    world.insert_collider(floor, None);
    world
}

/// A chair on the ground, or above it.
fn standing(
    world: &mut PhysicsWorld,
    flexible: &mut FlexibleBodies,
    height: Real,
) -> (RigidBodyHandle, ColliderHandle) {
    let model = DeformingModel::new(chair(), 1.0).expect("a model");
    let frame = RigidBodyBuilder::dynamic().translation(Vector::new(0.0, height, 0.0));
    let (frames, colliders) = (&mut world.bodies, &mut world.colliders);
    flexible
        .insert(
            &model,
            &FlexibleOptions::default(),
            frame,
            frames,
            colliders,
        )
        .expect("a body")
}

/// What parry does with a shape that it does not know: nothing.
#[test]
fn without_the_dispatcher_a_chair_falls_through() {
    let mut world = ground();
    world.narrow_phase = NarrowPhase::new();
    let mut flexible = FlexibleBodies::new();
    let (frame, _) = standing(&mut world, &mut flexible, 0.1);
    for _ in 0..120 {
        flexible.step(&mut world).expect("a step");
    }
    assert!(world.bodies[frame].translation().y < -3.0);
}

/// Height of the surface under a point of the chair's own frame.
fn seat(flexible: &FlexibleBodies, collider: ColliderHandle) -> Real {
    let mesh = flexible.mesh(collider).expect("a mesh");
    let ray = Ray::new(Vector::new(0.0, 0.6, 0.0), Vector::new(0.0, -1.0, 0.0));
    0.6 - mesh.cast_local_ray(&ray, 1.0, false).expect("the seat")
}

/// A load presses the seat down, and modes get as much energy as that takes.
#[test]
fn a_load_bends_a_chair() {
    let mut heights = Vec::new();
    for load in [0.0, 30.0] {
        let mut world = ground();
        let mut flexible = FlexibleBodies::new();
        let (_, collider) = standing(&mut world, &mut flexible, 0.0);
        if load > 0.0 {
            let frame = RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.52, 0.0));
            world.insert(frame, ColliderBuilder::cuboid(0.1, 0.08, 0.1).mass(load));
        }
        for _ in 0..240 {
            flexible.step(&mut world).expect("a step");
        }
        heights.push(seat(&flexible, collider));
        assert!(flexible.modal_energy(collider).expect("modes") > 0.0);
    }
    assert!(heights[1] < heights[0] - 1e-5, "{heights:?}");
}

/// A box that fell on a chair lies on its surface, even in steps in which both move by more than the seat is thick.
#[test]
fn a_box_does_not_sink_into_a_chair() {
    let mut world = ground();
    world.integration_parameters.dt = 1.0 / 64.0;
    let mut flexible = FlexibleBodies::new();
    let (frame, collider) = standing(&mut world, &mut flexible, 0.01);
    let half = Vector::splat(0.08);
    let (cube, _) = world.insert(
        RigidBodyBuilder::dynamic().translation(Vector::new(0.02, 0.9, 0.0)),
        ColliderBuilder::cuboid(half.x, half.y, half.z).mass(4.0),
    );
    let mut deepest: Real = 0.0;
    for step in 0..128 {
        flexible.step(&mut world).expect("a step");
        let [chair, cube] = [frame, cube].map(|body| *world.bodies[body].position());
        let mesh = flexible.mesh(collider).expect("a mesh");
        let found = MeshDispatcher::new()
            .contact(&(chair.inverse() * cube), mesh, &Cuboid::new(half), 0.1)
            .expect("an answer");
        // After it came to lie.
        if step > 64 {
            deepest = deepest.min(found.expect("it lies there").dist);
        }
    }
    assert!(deepest > -0.003, "{deepest}");
}

#[test]
fn a_fall_gains_no_energy() {
    let mut world = ground();
    let mut flexible = FlexibleBodies::new();
    let (frame, collider) = standing(&mut world, &mut flexible, 0.3);
    let mass = f64::from(world.bodies[frame].mass());
    let energy = |world: &PhysicsWorld, flexible: &FlexibleBodies| {
        let body = &world.bodies[frame];
        let height = f64::from(body.center_of_mass().y);
        let modes = flexible.modal_energy(collider).expect("modes");
        f64::from(body.kinetic_energy()) + 9.81 * mass * height + modes
    };
    world.step();
    let first = energy(&world, &flexible);
    let rest = 9.81 * mass * (f64::from(world.bodies[frame].center_of_mass().y) - 0.3);
    for step in 0..600 {
        flexible.step(&mut world).expect("a step");
        let now = energy(&world, &flexible);
        // rapier's own free fall gains 2.5 % of what it falls by.
        assert!(
            now < first + 0.04 * (first - rest),
            "step {step}: {now} of {first}"
        );
    }
    let moving = f64::from(world.bodies[frame].kinetic_energy());
    assert!(moving < 1e-6 * (first - rest), "{moving}");
}

/// Modes that rest go on once something hits the body.
#[test]
fn a_hit_wakes_modes() {
    let mut world = ground();
    let mut flexible = FlexibleBodies::new();
    let (frame, collider) = standing(&mut world, &mut flexible, 0.0);
    let mut run = |world: &mut PhysicsWorld, steps: usize| {
        let mut most = 0.0_f64;
        for _ in 0..steps {
            flexible.step(world).expect("a step");
            most = most.max(flexible.modal_kinetic_energy(collider).expect("modes"));
        }
        most
    };
    run(&mut world, 120);
    assert!(world.bodies[frame].is_sleeping());
    assert_eq!(run(&mut world, 60), 0.0);
    let ball = RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.7, 0.0));
    world.insert(ball, ColliderBuilder::ball(0.1).mass(1.0));
    assert!(run(&mut world, 60) > 1e-6);
}

/// Modes that rest go on once nothing touches the body any more, however slowly it moves.
#[test]
fn what_is_let_go_vibrates() {
    let mut world = ground();
    let mut flexible = FlexibleBodies::new();
    let (frame, collider) = standing(&mut world, &mut flexible, 0.0);
    // Until they rest.
    for _ in 0..120 {
        flexible.step(&mut world).expect("a step");
        let is_bent = flexible.modal_energy(collider) > Some(0.0);
        if is_bent && flexible.modal_kinetic_energy(collider) == Some(0.0) {
            break;
        }
    }
    let stored = flexible.modal_energy(collider).expect("modes");
    assert!(stored > 0.0 && !world.bodies[frame].is_sleeping());
    assert_eq!(flexible.modal_kinetic_energy(collider), Some(0.0));
    world.gravity = Vector::ZERO;
    world.bodies[frame].set_linvel(Vector::new(0.0, 0.2, 0.0), true);
    let mut most = 0.0_f64;
    for _ in 0..60 {
        flexible.step(&mut world).expect("a step");
        most = most.max(flexible.modal_kinetic_energy(collider).expect("modes"));
    }
    assert!(most > 0.0, "{most}");
    assert!(flexible.modal_energy(collider).expect("modes") < stored);
}

#[test]
fn what_cannot_vibrate_is_refused() {
    let mesh = bake::bumpy_sphere(4, 3);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 5));
    let model = DeformingModel::new(&model, 1.0).expect("a model");
    let mut world = ground();
    let mut flexible = FlexibleBodies::new();
    let mut insert = |options: &FlexibleOptions| {
        let frame = RigidBodyBuilder::dynamic();
        let (frames, colliders) = (&mut world.bodies, &mut world.colliders);
        flexible.insert(&model, options, frame, frames, colliders)
    };
    let refused = insert(&FlexibleOptions::default());
    assert!(matches!(refused, Err(ShapeError::Dynamics(text)) if text.contains("mode 0")));
    let rigid = FlexibleOptions {
        is_deformable: false,
        ..FlexibleOptions::default()
    };
    let (_, collider) = insert(&rigid).expect("a rigid body");
    let refused = |flexible: &mut FlexibleBodies| {
        let refused = flexible.set_modes(collider, &[0.0], &[0.0]);
        refused.expect_err("no modes").to_string()
    };
    assert_eq!(refused(&mut flexible), "1 amplitudes for 0 modes");
    assert!(flexible.remove(collider) && !flexible.remove(collider));
    assert!(refused(&mut flexible).starts_with("no body has the collider"));
}

/// A body that was bent and let go swings as its frequency says.
#[test]
fn modes_swing() {
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::ZERO;
    world.integration_parameters.dt = 1.0 / 480.0;
    let mut flexible = FlexibleBodies::new();
    let (_, collider) = standing(&mut world, &mut flexible, 0.0);
    let omega = chair().asset().modes()[0].omega_rad_s.get();
    let mut start = vec![0.0; 6];
    start[1] = f64::NAN;
    let refused = flexible.set_modes(collider, &start, &[0.0; 6]);
    assert!(
        refused
            .expect_err("NaN")
            .to_string()
            .starts_with("mode 1: ")
    );
    start = vec![0.0; 6];
    start[0] = 0.01;
    flexible
        .set_modes(collider, &start, &[0.0; 6])
        .expect("modes");
    // Half a swing, to the next whole step.
    let steps = (std::f64::consts::PI / omega * 480.0).round() as usize;
    for _ in 0..steps {
        flexible.step(&mut world).expect("a step");
    }
    let q = flexible.q(collider).expect("modes")[0];
    let expected = -0.01 * (-0.1 * std::f64::consts::PI).exp();
    assert!((f64::from(q) - expected).abs() < 5e-4, "{q}, {expected}");
}
