//! Triangles that touch the contact spheres of other bodies.

use bdtree_build::input::RawMesh;
use bdtree_dynamics::{
    BodyId, BodyOptions, ContactLaw, ContactShape, Frame, MassProperties, ModelId, World,
};
use bdtree_fixtures::bake;

use crate::support::{RADIUS, at, ball, beam, weightless};

/// Side of the plate.
const SIDE: f64 = 4.0;

/// A square of 8 × 8 × 2 triangles in the plane y = 0, without thickness.
fn plate(world: &mut World, mass_kg: f64) -> ModelId {
    plates(world, mass_kg, &[[0.0; 2]])
}

/// One such square at each x and y.
fn plates(world: &mut World, mass_kg: f64, at: &[[f64; 2]]) -> ModelId {
    const CELLS: u32 = 8;
    let mut mesh = RawMesh {
        name: "plate".to_string(),
        ..RawMesh::default()
    };
    for [shift, height] in at {
        let first = mesh.positions.len() as u32;
        for z in 0..=CELLS {
            for x in 0..=CELLS {
                let place = |k: u32| (f64::from(k) / f64::from(CELLS) - 0.5) * SIDE;
                (mesh.positions).push([place(x) + shift, *height, place(z)]);
            }
        }
        for z in 0..CELLS {
            for x in 0..CELLS {
                let a = first + z * (CELLS + 1) + x;
                let (b, c, d) = (a + 1, a + CELLS + 1, a + CELLS + 2);
                mesh.triangles.extend([[a, c, b], [b, c, d]]);
            }
        }
    }
    let model = bake::baked(&mesh, &bake::rigid(&mesh));
    let options = BodyOptions {
        contact: ContactShape::Triangles,
        mass: Some(MassProperties::cuboid(
            mass_kg,
            [SIDE, 0.01, SIDE],
            [0.0; 3],
        )),
        ..BodyOptions::default()
    };
    world.add_model(&model, &options).expect("a plate")
}

fn height(world: &World, body: BodyId) -> f64 {
    world.state(body).expect("a state").position[1]
}

/// However fast it is, and from whichever side, it comes back: over the inside of triangles, edges and corners.
#[test]
fn fast_balls_do_not_pass_through_a_plate_without_thickness() {
    for speed in [1.0, 10.0, 40.0] {
        for [x, z] in [[0.1, 0.15], [0.0, 0.0], [0.25, 0.25], [-0.7, 0.5]] {
            for side in [1.0, -1.0] {
                let mut world = weightless(1e-2, ContactLaw::default());
                // Added first or second, which turns the contact.
                let of_plate = plate(&mut world, 1.0);
                let of_ball = ball(&mut world, 1.0);
                let place = at([x, side * (RADIUS + 0.3), z]);
                let body = if speed > 5.0 {
                    let body = world.add_body(of_ball, Frame::Free, place);
                    (world.add_body(of_plate, Frame::Held, at([0.0; 3]))).expect("a plate");
                    body
                } else {
                    (world.add_body(of_plate, Frame::Held, at([0.0; 3]))).expect("a plate");
                    world.add_body(of_ball, Frame::Free, place)
                }
                .expect("a ball");
                let velocity = [0.0, -side * speed, 0.0];
                (world.set_velocity(body, velocity, [0.0; 3])).expect("a velocity");
                for _ in 0..60 {
                    match world.step() {
                        Ok(_) => {}
                        Err(error) => panic!("{speed} {x} {z}: {error}"),
                    }
                    assert!(side * height(&world, body) > 0.0, "{speed} {x} {z}");
                }
                assert!(side * height(&world, body) > RADIUS, "{speed} {x} {z}");
            }
        }
    }
}

/// A ball touches the edge of a plate, is hit from below and pushed against a plate above it, faster than its own speed let
/// expect: that the lower plate touched it before does not mean that it came through the upper one.
#[test]
fn a_ball_stays_between_two_plates() {
    for (speed, gap) in [(5.0, 1e-3), (10.0, 3e-3), (30.0, 1e-2)] {
        for share in [0.2, 0.3, 0.4, 0.5] {
            let h = 1e-2;
            let mut world = weightless(h, ContactLaw::default());
            let top = 2.0 * RADIUS + gap;
            // The lower one's edge is at x = 0.
            let both = plates(&mut world, 1.0, &[[-0.5 * SIDE, 0.0], [0.0, top]]);
            let of_ball = ball(&mut world, 1.0);
            (world.add_body(both, Frame::Held, at([0.0; 3]))).expect("plates");
            let place = at([-0.05, RADIUS * (1.0 - 1e-6), 0.15]);
            let body = (world.add_body(of_ball, Frame::Free, place)).expect("a ball");
            let towards = [-0.5, f64::sqrt(0.75)];
            // They meet within the first step.
            let apart = 2.0 * RADIUS + share * speed * h;
            let place = [
                -0.05 - apart * towards[0],
                RADIUS - apart * towards[1],
                0.15,
            ];
            let other = (world.add_body(of_ball, Frame::Free, at(place))).expect("a ball");
            let velocity = towards.map(|x| speed * x);
            (world.set_velocity(other, [velocity[0], velocity[1], 0.0], [0.0; 3]))
                .expect("a velocity");
            let mut deepest = 0.0_f64;
            for step in 0..100 {
                let report = world.step().expect("a step");
                deepest = deepest.max(report.penetration);
                let above = height(&world, body);
                assert!(above < top, "{speed} {gap} {share} {step}: {above}");
            }
            // It met the upper one.
            assert!(deepest > 1e-3 * RADIUS, "{speed} {gap} {share}: {deepest}");
        }
    }
}

/// A ball that is pressed so deep that its center is on the other side comes back; one that is pressed by more than its diameter
/// is an error.
#[test]
fn what_is_pressed_through_a_plate_comes_back() {
    let law = ContactLaw {
        stiffness: 0.5,
        damping_ratio: 0.5,
        friction: 0.4,
    };
    let h = 1e-2;
    let (mut least, mut refused) = (f64::INFINITY, 0);
    for share in [1.3, 1.9, 2.1] {
        for side in [1.0, -1.0] {
            let mut world = weightless(h, law);
            let of_plate = plate(&mut world, 1.0);
            let of_ball = ball(&mut world, 1.0);
            (world.add_body(of_plate, Frame::Held, at([0.0; 3]))).expect("a plate");
            let place = at([0.1, side * RADIUS, 0.15]);
            let body = (world.add_body(of_ball, Frame::Free, place)).expect("a ball");
            // k = κ m / h².
            let force = share * RADIUS * law.stiffness / (h * h);
            let mut error = None;
            for step in 0..400 {
                let share = f64::min(f64::from(step) / 200.0, 1.0);
                let press = [0.0, -side * force * share, 0.0];
                (world.add_force(body, press, [0.0; 3])).expect("a force");
                if let Err(found) = world.step() {
                    error = Some(found.to_string());
                    break;
                }
            }
            if let Some(error) = error {
                assert!(
                    share > 2.0 && error.contains("more than the 1.000e0"),
                    "{error}"
                );
                refused += 1;
                continue;
            }
            let sunk = RADIUS - side * height(&world, body);
            assert!((sunk - share * RADIUS).abs() < 1e-3, "{sunk} {share}");
            least = least.min(side * height(&world, body));
            for _ in 0..100 {
                world.step().expect("a step");
            }
            assert!(
                side * height(&world, body) > RADIUS - 1e-3,
                "{share} {side}"
            );
        }
    }
    assert!(least < -0.8 * RADIUS && refused == 2, "{least} {refused}");
}

/// A ball on a plate sinks as on a plane, wherever it lies, and slides over edges as over a plane.
#[test]
fn a_plate_of_triangles_is_flat() {
    let law = ContactLaw {
        stiffness: 0.5,
        damping_ratio: 0.5,
        friction: 0.0,
    };
    let (h, mass, g) = (1e-2, 2.0, 9.81);
    let mut world = World::new(bdtree_dynamics::WorldOptions {
        step_s: h,
        law,
        sleep_speed: 0.0,
        ..bdtree_dynamics::WorldOptions::default()
    })
    .expect("a world");
    let of_ball = ball(&mut world, mass);
    let of_plate = plate(&mut world, 1.0);
    (world.add_body(of_plate, Frame::Held, at([0.0; 3]))).expect("a plate");
    // k = κ m / h²: it sinks by m g / k.
    let depth = g * h * h / law.stiffness;
    let start = [-1.5, RADIUS - depth, -1.3];
    let body = (world.add_body(of_ball, Frame::Free, at(start))).expect("a ball");
    (world.set_velocity(body, [1.0, 0.0, 0.83], [0.0; 3])).expect("a velocity");
    for step in 0..280 {
        let report = world.step().expect("a step");
        assert_eq!(report.events, 1, "{step}");
        // One that is found while it overlaps begins with its overlap: only the first one may.
        assert!(report.late == 0 || step == 0 || height(&world, body) > 0.0);
        let state = world.state(body).expect("a state");
        let sunk = RADIUS - state.position[1];
        assert!(
            (sunk - depth).abs() < 1e-2 * RADIUS,
            "{step}: {sunk} {depth}"
        );
        assert!(
            (state.velocity[0] - 1.0).abs() < 1e-6,
            "{step}: {:?}",
            state.velocity
        );
    }
}

/// A ball that hits a free plate, without friction: momentum, angular momentum and energy stay.
#[test]
fn a_free_plate_keeps_momentum_and_energy() {
    let law = ContactLaw {
        stiffness: 1e-2,
        damping_ratio: 0.0,
        friction: 0.0,
    };
    let mut world = weightless(1e-3, law);
    let (of_ball, of_plate) = (ball(&mut world, 0.7), plate(&mut world, 1.0));
    (world.add_body(of_plate, Frame::Free, at([0.0; 3]))).expect("a plate");
    let place = at([0.1, RADIUS + 0.02, 0.08]);
    let body = (world.add_body(of_ball, Frame::Free, place)).expect("a ball");
    (world.set_velocity(body, [0.0, -1.0, 0.0], [0.0; 3])).expect("a velocity");
    let ([p, l], energy) = (world.momenta(), world.energy().mechanical());
    let mut events = 0;
    for _ in 0..200 {
        events += world.step().expect("a step").events;
    }
    assert!(events > 10, "{events}");
    let [p1, l1] = world.momenta();
    for k in 0..3 {
        assert!((p[k] - p1[k]).abs() < 1e-9, "{p:?} {p1:?}");
        assert!((l[k] - l1[k]).abs() < 1e-9, "{l:?} {l1:?}");
    }
    let now = world.energy().mechanical();
    assert!((now - energy).abs() < 1e-3 * energy, "{now} {energy}");
    assert!(world.state(body).expect("a state").velocity[1] > -0.9);
}

/// A ball falls on the triangles of a beam that vibrates: it rings, and energy never grows.
#[test]
fn triangles_of_a_beam_vibrate() {
    let law = ContactLaw::default();
    let mut world = weightless(1.0 / 300.0, law);
    let of_ball = ball(&mut world, 0.5);
    let options = BodyOptions {
        contact: ContactShape::Triangles,
        ..BodyOptions::default()
    };
    let of_beam = world.add_model(beam(), &options).expect("a beam");
    let hit = world
        .add_body(of_beam, Frame::Free, at([0.0; 3]))
        .expect("a beam");
    let center = world.state(hit).expect("a state").position;
    let place = at([center[0], center[1] + RADIUS + 0.1, center[2]]);
    let body = world.add_body(of_ball, Frame::Free, place).expect("a ball");
    (world.set_velocity(body, [0.0, -2.0, 0.0], [0.0; 3])).expect("a velocity");
    let (first, [p, _]) = (world.energy().mechanical(), world.momenta());
    let (mut least, mut modal) = (first, 0.0_f64);
    for step in 0..300 {
        let mechanical = world.energy().mechanical();
        let report = world.step().expect("a step");
        let energy = mechanical + report.contact_energy;
        assert!(energy < least + 0.01 * first, "{step}: {energy} {least}");
        least = least.min(energy);
        modal = modal.max(world.energy().modal);
    }
    assert!(modal > 1e-3 * first, "{modal}");
    let [p1, _] = world.momenta();
    for k in 0..3 {
        assert!((p[k] - p1[k]).abs() < 1e-9, "{p:?} {p1:?}");
    }
    assert!(world.state(body).expect("a state").velocity[1] > -1.9);
}
