//! Parts of steps, which thin walls and bodies that are driven need.

use bdtree_dynamics::{BodyId, ContactLaw, DynamicsError, Frame, World, WorldOptions};
use bdtree_runtime::Transform;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::regions::{place, solid};
use crate::support::{GROUND, at, box_mesh, weightless};

/// A thin plate at rest stops one that flies at it, however it is turned; steps have as many parts as its speed needs.
#[test]
fn fast_thin_bodies_do_not_pass_through_each_other() {
    const WALL: f64 = 0.02;
    let h = 1.0 / 150.0;
    let law = ContactLaw {
        friction: 0.0,
        ..ContactLaw::default()
    };
    for speed in [3.0, 30.0] {
        for turn in [[0.0; 3], [0.4, 0.1, 0.0], [0.0, 0.3, 1.5], [0.9, 0.5, 0.6]] {
            let mut world = weightless(h, law);
            let table = solid(&mut world, 1.0, [2.0, WALL, 2.0]);
            let plate = solid(&mut world, 1.0, [0.5, WALL, 0.4]);
            (world.add_body(table, Frame::Held, at([0.0; 3]))).expect("a table");
            let turned = UnitQuaternion::from_scaled_axis(Vector3::from(turn));
            let start = Transform {
                rotation: turned.coords.into(),
                ..at([0.03, 0.5, -0.02])
            };
            let body = world.add_body(plate, Frame::Free, start).expect("a plate");
            (world.set_velocity(body, [0.0, -speed, 0.0], [0.0; 3])).expect("a velocity");
            let mut parts = 0;
            for step in 0..90 {
                let report = world
                    .step()
                    .unwrap_or_else(|error| panic!("{speed} {turn:?}: {error}"));
                if step == 0 {
                    parts = report.parts;
                }
                // Nothing of it is below: its lowest corner is not below the middle of the table.
                let at = world.placement(body).expect("a placement");
                let [x, y, z, w] = at.rotation;
                let now = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
                let lowest = (box_mesh([0.5, WALL, 0.4]).positions.iter())
                    .map(|corner| (now * Vector3::from(*corner)).y + at.translation[1])
                    .fold(f64::INFINITY, f64::min);
                let [x, _, z] = at.translation;
                let is_above = x.abs().max(z.abs()) < 0.6;
                assert!(
                    lowest > 0.0 || !is_above,
                    "{speed} {turn:?} {step}: {lowest}"
                );
            }
            assert!(parts as f64 * 0.5 * WALL >= speed * h, "{parts}");
            assert!(world.state(body).expect("a state").velocity[1] > 0.0);
        }
    }
    // Where it would need too many, the error says so.
    let mut world = weightless(h, law);
    let plate = solid(&mut world, 1.0, [0.5, WALL, 0.4]);
    let body = (world.add_body(plate, Frame::Free, at([0.0; 3]))).expect("a plate");
    (world.set_velocity(body, [1e5, 0.0, 0.0], [0.0; 3])).expect("a velocity");
    let error = world.step().expect_err("too fast");
    assert!(matches!(error, DynamicsError::Parts { .. }), "{error}");
    assert!(error.to_string().contains("steps of about"), "{error}");
}

/// A driven box is at the end of a step where it is told to be, goes there in parts, and pushes another one before it.
#[test]
fn a_driven_box_pushes_a_free_one() {
    const WALL: f64 = 0.05;
    let mut world = weightless(1e-2, ContactLaw::default());
    let pusher = solid(&mut world, 1.0, [WALL, 0.5, 0.5]);
    let pushed = solid(&mut world, 1.0, [0.1, 0.2, 0.2]);
    let pusher = (world.add_body(pusher, Frame::Driven, at([0.0; 3]))).expect("a pusher");
    let pushed = (world.add_body(pushed, Frame::Free, at([0.3, 0.02, 0.01]))).expect("a box");
    for step in 1..=40 {
        let x = 0.09 * f64::from(step);
        world.drive(pusher, &[], at([x, 0.0, 0.0])).expect("driven");
        let report = world.step().expect("a step");
        assert!(report.parts >= 4, "{}", report.parts);
        assert_eq!(place(&world, pusher).x, x);
        let gap = place(&world, pushed).x - x;
        assert!(gap > 0.5 * (WALL + 0.1) - WALL, "{step}: {gap}");
    }
    assert!(world.state(pushed).expect("a state").velocity[0] >= 9.0);
}

/// A driven body wakes what sleeps in its way, though it only moves along, and nothing goes through.
#[test]
fn a_driven_box_wakes_a_sleeping_one() {
    let mut world = World::new(WorldOptions::default()).expect("a world");
    let pusher = solid(&mut world, 1.0, [0.1, 0.3, 0.3]);
    let model = solid(&mut world, 1.0, [0.2, 0.2, 0.2]);
    world.add_plane(GROUND).expect("a plane");
    let pusher = (world.add_body(pusher, Frame::Driven, at([-1.0, 0.2, 0.0]))).expect("a pusher");
    let body = (world.add_body(model, Frame::Free, at([0.0, 0.1, 0.0]))).expect("a box");
    for _ in 0..300 {
        world.step().expect("a step");
    }
    assert_eq!(world.asleep(), 1);
    for step in 1..=150 {
        let x = -1.0 + 0.01 * f64::from(step);
        world.drive(pusher, &[], at([x, 0.2, 0.0])).expect("driven");
        world.step().expect("a step");
        assert!(place(&world, body).x - x > 0.14, "{step}");
    }
    assert!(place(&world, body).x > 0.6);
}

/// Thin plates that fly, and one that is driven: steps of many parts are the same for any number of threads and after a break.
#[test]
fn divided_steps_are_the_same_to_the_bit() {
    let bytes = |world: &World| {
        let mut out = Vec::new();
        world.save(&mut out);
        out
    };
    let made = |threads| {
        let mut world = World::new(WorldOptions {
            threads,
            ..WorldOptions::default()
        })
        .expect("a world");
        let plate = solid(&mut world, 1.0, [0.5, 0.03, 0.4]);
        world.add_plane(GROUND).expect("a plane");
        (world.add_body(plate, Frame::Driven, at([-1.0, 0.4, 0.0]))).expect("a plate");
        for k in 0..5 {
            let y = 0.3 + 0.25 * f64::from(k);
            let body = world.add_body(plate, Frame::Free, at([0.1 * y, y, 0.0]));
            let velocity = [0.0, if k < 3 { 2.0 } else { -6.0 }, 0.3];
            (world.set_velocity(body.expect("a plate"), velocity, [1.0, 0.2, 3.0]))
                .expect("a velocity");
        }
        world
    };
    let step = |world: &mut World| {
        let x = -1.0 + 0.02 * world.steps() as f64;
        world
            .drive(BodyId(0), &[], at([x, 0.4, 0.0]))
            .expect("driven");
        world.step().expect("a step")
    };
    let [mut alone, mut together, mut again] = [made(1), made(2), made(1)];
    let (mut saved, mut most, mut events) = (Vec::new(), 0, 0);
    for k in 0..60 {
        if k == 25 {
            saved = bytes(&alone);
        }
        let report = step(&mut alone);
        step(&mut together);
        most = most.max(report.parts);
        events += report.events;
    }
    assert!(most > 5 && events > 20, "{most} {events}");
    assert!(bytes(&alone) == bytes(&together));
    again.restore(&saved).expect("restored");
    for _ in 25..60 {
        step(&mut again);
    }
    assert!(bytes(&alone) == bytes(&again));
}
