//! One contact sphere: the contact law against closed forms, momentum and energy.

use bdtree_dynamics::{
    BodyId, BodyOptions, ContactLaw, DynamicsError, Frame, MassProperties, Plane, World,
    WorldOptions,
};

use crate::support::{
    GROUND, RADIUS, at, ball, ball_model, same_momenta, sliding_ball, weightless,
};

const SMOOTH: ContactLaw = ContactLaw {
    stiffness: 1e-4,
    damping_ratio: 0.0,
    friction: 0.0,
};

/// A ball on the Kelvin–Voigt law, without weight: overlap `v/ω_d e^(−γt) sin ω_d t` until it would be pulled.
#[test]
fn a_ball_bounces_as_the_closed_form_says() {
    for damping_ratio in [0.0, 0.1, 0.3] {
        let h = 1e-3;
        let law = ContactLaw {
            damping_ratio,
            ..SMOOTH
        };
        let mut world = weightless(h, law);
        let model = ball(&mut world, 2.0);
        world.add_plane(GROUND).expect("a plane");
        let body = world
            .add_body(model, Frame::Free, at([0.0, RADIUS, 0.0]))
            .expect("a body");
        world
            .set_velocity(body, [0.0, -1.0, 0.0], [0.0; 3])
            .expect("a velocity");
        // κ = k h²/m, so ω = √κ / h.
        let omega = SMOOTH.stiffness.sqrt() / h;
        let gamma = damping_ratio * omega;
        let root = (omega * omega - gamma * gamma).sqrt();
        // It is let go where k δ + d δ̇ = 0: tan ω_d t = −2ζ√(1 − ζ²) / (1 − 2ζ²), in the second quadrant.
        let ratio = damping_ratio;
        let sine = 2.0 * ratio * (1.0 - ratio * ratio).sqrt();
        let angle = std::f64::consts::PI - sine.atan2(1.0 - 2.0 * ratio * ratio);
        let end = angle / root;
        let mut steps = 0;
        while f64::from(steps) * h < 1.2 * end {
            world.step().expect("a step");
            steps += 1;
            let t = f64::from(steps) * h;
            let depth = RADIUS - world.state(body).expect("a state").position[1];
            let expected = (-gamma * t).exp() * (root * t).sin() / root;
            if t < end {
                // Second order in ω h = 0.01.
                assert!(
                    (depth - expected).abs() < 2e-4 / omega,
                    "{t}: {depth} {expected}"
                );
            }
        }
        let speed = world.state(body).expect("a state").velocity[1];
        let restitution =
            (-gamma * end).exp() * ((gamma / root) * (root * end).sin() - (root * end).cos());
        assert!(
            (speed - restitution).abs() < 1e-3,
            "{damping_ratio}: {speed} {restitution}"
        );
    }
}

/// Whatever the stiffness, a frictionless collision of two balls, off center, keeps momentum and energy.
#[test]
fn a_frictionless_collision_keeps_energy() {
    for stiffness in [1e-4, 1e-2] {
        let h = 1e-3;
        let mut world = weightless(
            h,
            ContactLaw {
                stiffness,
                ..SMOOTH
            },
        );
        let model = ball(&mut world, 2.0);
        let heavy = ball(&mut world, 5.0);
        let a = world
            .add_body(model, Frame::Free, at([-0.505, 0.1, 0.0]))
            .expect("a body");
        let b = world
            .add_body(heavy, Frame::Free, at([0.505, -0.1, 0.05]))
            .expect("a body");
        world
            .set_velocity(a, [1.0, 0.0, 0.2], [0.0, 3.0, 1.0])
            .expect("a velocity");
        world
            .set_velocity(b, [-0.4, 0.0, 0.0], [1.0, 0.0, 0.0])
            .expect("a velocity");
        let (energy, momenta) = (world.energy().mechanical(), world.momenta());
        let mut touched = 0;
        for _ in 0..2000 {
            let now = world.energy().mechanical();
            let report = world.step().expect("a step");
            touched += report.events;
            let off = (now + report.contact_energy) / energy - 1.0;
            assert!(off.abs() < 1e-3, "{off}");
        }
        assert!(touched > 10);
        let off = world.energy().mechanical() / energy - 1.0;
        assert!(off.abs() < 1e-6, "{stiffness}: {off}");
        same_momenta(momenta, world.momenta());
    }
}

/// With friction and damping too, forces are opposite and act at one point.
#[test]
fn collisions_keep_momentum() {
    let h = 1.0 / 150.0;
    let law = ContactLaw {
        stiffness: 2.0,
        damping_ratio: 0.3,
        friction: 0.8,
    };
    let mut world = weightless(h, law);
    let model = ball(&mut world, 2.0);
    for k in 0..6 {
        let x = f64::from(k);
        let body = world
            .add_body(model, Frame::Free, at([1.1 * x, 0.1 * x, 0.0]))
            .expect("a body");
        let v = [if k < 3 { 2.0 } else { -2.5 }, 0.3, 0.1 * x];
        world
            .set_velocity(body, v, [x, 2.0, -1.0])
            .expect("a velocity");
    }
    let momenta = world.momenta();
    let energy = world.energy().mechanical();
    let mut touched = 0;
    for _ in 0..300 {
        touched += world.step().expect("a step").events;
    }
    assert!(touched > 10);
    same_momenta(momenta, world.momenta());
    assert!(world.energy().mechanical() < energy);
}

/// A ball at rest sinks by its weight over its stiffness.
#[test]
fn a_resting_ball_sinks_by_its_weight() {
    let h = 1.0 / 150.0;
    let mut world = World::new(WorldOptions::default()).expect("a world");
    let model = ball(&mut world, 2.0);
    world.add_plane(GROUND).expect("a plane");
    let body = world
        .add_body(model, Frame::Free, at([0.0, 0.6, 0.0]))
        .expect("a body");
    for _ in 0..1500 {
        world.step().expect("a step");
    }
    let stiffness = world.options().law.stiffness * 2.0 / (h * h);
    let depth = RADIUS - world.state(body).expect("a state").position[1];
    let expected = 2.0 * 9.81 / stiffness;
    assert!((depth / expected - 1.0).abs() < 1e-6, "{depth} {expected}");
}

/// A ball that cannot turn, on a slope: held just inside the friction cone, and sliding just outside as Coulomb says.
#[test]
fn a_slope_at_the_edge_of_the_friction_cone() {
    let friction = 0.4_f64;
    for (share, slides) in [(0.99, false), (1.01, true)] {
        let angle = (friction * share).atan();
        let mut options = WorldOptions::default();
        options.law.friction = friction;
        let mut world = World::new(options).expect("a world");
        // So large an inertia that it does not roll.
        let mass = bdtree_dynamics::MassProperties {
            mass_kg: 2.0,
            center: [0.0; 3],
            inertia: [1e12, 1e12, 1e12, 0.0, 0.0, 0.0],
        };
        let of = bdtree_dynamics::BodyOptions {
            mass: Some(mass),
            ..Default::default()
        };
        let model = world.add_model(&ball_model(), &of).expect("a body");
        let normal = [angle.sin(), angle.cos(), 0.0];
        world
            .add_plane(Plane {
                normal,
                offset: 0.0,
            })
            .expect("a plane");
        let body = world
            .add_body(model, Frame::Free, at(normal.map(|n| (RADIUS - 4e-4) * n)))
            .expect("a body");
        // Down the slope.
        let along = |body: BodyId, world: &World| {
            let x = world.state(body).expect("a state").position;
            x[0] * angle.cos() - x[1] * angle.sin()
        };
        for _ in 0..300 {
            world.step().expect("a step");
        }
        let start = along(body, &world);
        let speed = {
            let v = world.state(body).expect("a state").velocity;
            v[0] * angle.cos() - v[1] * angle.sin()
        };
        for _ in 0..300 {
            world.step().expect("a step");
        }
        let way = along(body, &world) - start;
        if slides {
            let acceleration = 9.81 * (angle.sin() - friction * angle.cos());
            let expected = 2.0 * speed + 0.5 * acceleration * 4.0;
            assert!((way / expected - 1.0).abs() < 1e-3, "{way} {expected}");
        } else {
            assert!(way.abs() < 1e-9, "{way}");
        }
    }
}

/// Faster than a radius per step: the ball is stopped at its first touch, or the step says that it is too long.
#[test]
fn fast_balls_do_not_pass_through_each_other() {
    let h = 1.0 / 150.0;
    for speed in [10.0, 100.0, 1000.0] {
        let mut world = weightless(h, ContactLaw::default());
        let model = ball(&mut world, 2.0);
        let a = world
            .add_body(model, Frame::Free, at([-3.0, 0.0, 0.0]))
            .expect("a body");
        let b = world
            .add_body(model, Frame::Free, at([3.0, 0.0, 0.0]))
            .expect("a body");
        world
            .set_velocity(a, [speed, 0.0, 0.0], [0.0; 3])
            .expect("a velocity");
        world
            .set_velocity(b, [-speed, 0.0, 0.0], [0.0; 3])
            .expect("a velocity");
        for _ in 0..200 {
            match world.step() {
                Ok(_) => {}
                Err(DynamicsError::Penetration { bodies, .. }) => {
                    assert_eq!(bodies, [Some(0), Some(1)]);
                    break;
                }
                Err(error) => panic!("{error}"),
            }
            let [x, y] = [a, b].map(|body| world.state(body).expect("a state").position[0]);
            assert!(x < y, "{speed}: {x} {y}");
        }
    }
}

/// A ball whose q is driven pushes a free one before it, at its own speed and never through it: modes of an animation need
/// no frequency for that.
#[test]
fn a_driven_q_pushes_a_free_ball() {
    let h = 1.0 / 150.0;
    let law = ContactLaw {
        damping_ratio: 1.0,
        ..ContactLaw::default()
    };
    let mut world = weightless(h, law);
    let options = BodyOptions {
        strain_limit: f64::INFINITY,
        mass: Some(MassProperties::ball(2.0, RADIUS, [0.0; 3])),
        ..BodyOptions::default()
    };
    let sliding = world.add_model(&sliding_ball(), &options).expect("a ball");
    let driven = world
        .add_body(sliding, Frame::Driven, at([0.0; 3]))
        .expect("a body");
    let model = ball(&mut world, 2.0);
    let free = world
        .add_body(model, Frame::Free, at([1.2, 0.0, 0.0]))
        .expect("a body");
    world
        .set_modes(driven, &[0.1], &[0.0])
        .expect("a beginning");
    for n in 1..=300 {
        let x = 0.1 + f64::from(n) * h;
        (world.drive(driven, &[x], at([0.0; 3]))).expect("driven");
        world.step().expect("a step");
        let mut now = [0.0];
        world.q(driven, &mut now).expect("its q");
        assert!((now[0] - x).abs() < 1e-12);
        let other = world.state(free).expect("a state").position[0];
        assert!(other - x > 2.0 * RADIUS - 0.02, "{n}: {x} {other}");
    }
    let speed = world.state(free).expect("a state").velocity[0];
    assert!((1.0..1.2).contains(&speed), "{speed}");
}

/// A ball that is driven pushes a free one before it, at its own speed and never through it.
#[test]
fn a_driven_ball_pushes_a_free_one() {
    let h = 1.0 / 150.0;
    let law = ContactLaw {
        damping_ratio: 1.0,
        ..ContactLaw::default()
    };
    let mut world = weightless(h, law);
    let model = ball(&mut world, 2.0);
    let driven = world
        .add_body(model, Frame::Driven, at([0.0; 3]))
        .expect("a body");
    let free = world
        .add_body(model, Frame::Free, at([1.2, 0.0, 0.0]))
        .expect("a body");
    for n in 1..=300 {
        let x = f64::from(n) * h;
        (world.drive(driven, &[], at([x, 0.0, 0.0]))).expect("driven");
        world.step().expect("a step");
        let now = world.state(driven).expect("a state").position[0];
        assert!((now - x).abs() < 1e-12);
        let other = world.state(free).expect("a state").position[0];
        assert!(other - now > 2.0 * RADIUS - 0.02, "{n}: {now} {other}");
    }
    let speed = world.state(free).expect("a state").velocity[0];
    assert!((1.0..1.2).contains(&speed), "{speed}");
}
