//! Bodies with modes: what holds them, what bends them.

use bdtree_build::basis::elastic::{Fix, FixRegion};
use bdtree_dynamics::{
    BodyOptions, ContactLaw, Damping, DynamicsError, Frame, Oscillator, World, WorldOptions,
};
use bdtree_fixtures::bake;
use bdtree_runtime::{Transform, VertexId};

use crate::support::{at, beam, restless_beams, weightless};

/// A beam that is held at one end bends under its weight by ρ A g L⁴ / (8 E I), within 2 %.
#[test]
fn a_held_beam_bends_under_its_weight() {
    // Half a cell of the end is held.
    let end = Fix {
        axes: [true; 3],
        region: FixRegion::Box {
            min: [-1e3; 3],
            max: [1e-6, 1e3, 1e3],
        },
    };
    let held = bake::elastic("beam", 8, 80, &[end]);
    let mut world = World::new(WorldOptions::default()).expect("a world");
    let options = BodyOptions {
        damping: Damping::Ratio(0.9),
        ..BodyOptions::default()
    };
    let model = world.add_model(&held, &options).expect("a beam");
    let body = world
        .add_body(model, Frame::Held, Transform::IDENTITY)
        .expect("a body");
    for _ in 0..600 {
        world.step().expect("a step");
    }
    world.pose_instances().expect("poses");
    let pose = world.instances()[body.0].pose();
    let asset = held.asset();
    let tip = (0..asset.vertex_count() as u32)
        .map(VertexId)
        .filter(|v| asset.positions()[v.0 as usize][0] + asset.origin()[0] as f32 > 0.999_f32)
        .map(|v| {
            let rest =
                f64::from(asset.positions()[v.0 as usize][1]) * asset.unit() + asset.origin()[1];
            pose.deformed(v).expect("a vertex")[1] - rest
        });
    let (sum, count) = tip.fold((0.0, 0), |(sum, count), y| (sum + y, count + 1));
    let (young, density, side) = (2e9, 1000.0, 0.05_f64);
    let inertia = side.powi(4) / 12.0;
    let expected = -density * side * side * 9.81 / (8.0 * young * inertia);
    let found = sum / f64::from(count);
    assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");

    // Not as a free body: its modes move the center of mass.
    let error = world
        .add_body(model, Frame::Free, Transform::IDENTITY)
        .expect_err("refused");
    assert_eq!(error, DynamicsError::HeldMode { mode: 0 });
    assert!(error.to_string().contains("Frame::Held"), "{error}");
}

/// A constant force on a mode holds it, in the end, where its stiffness does.
#[test]
fn a_constant_modal_force_deflects() {
    let mut world = weightless(1.0 / 150.0, ContactLaw::default());
    let options = BodyOptions {
        damping: Damping::Rayleigh {
            mass_per_s: 40.0,
            stiffness_s: 1e-3,
        },
        strain_limit: f64::INFINITY,
        ..BodyOptions::default()
    };
    let model = world.add_model(beam(), &options).expect("a beam");
    let modes = world.model(model).expect("a model").mode_count();
    let body = world
        .add_body(model, Frame::Free, Transform::IDENTITY)
        .expect("a body");
    for _ in 0..1500 {
        (world.add_modal_force(body, &vec![2.0; modes])).expect("a force");
        world.step().expect("a step");
    }
    let mut q = vec![0.0; modes];
    world.q(body, &mut q).expect("q");
    for (q, record) in q.iter().zip(beam().asset().modes()) {
        let expected = 2.0 / (record.modal_mass_kg.get() * record.omega_rad_s.get().powi(2));
        assert!((q / expected - 1.0).abs() < 1e-9, "{q} {expected}");
    }
}

/// Modes of a free body ring after an impulse as each alone would, and its frame does not notice.
#[test]
fn a_free_beam_rings() {
    let h = 1.0 / 500.0;
    let mut world = weightless(h, ContactLaw::default());
    let options = BodyOptions {
        strain_limit: f64::INFINITY,
        ..BodyOptions::default()
    };
    let model = world.add_model(beam(), &options).expect("a beam");
    let modes = world.model(model).expect("a model").mode_count();
    let body = world
        .add_body(model, Frame::Free, at([0.0, 5.0, 0.0]))
        .expect("a body");
    let start = world.state(body).expect("a state");
    let impulse: Vec<f64> = (0..modes).map(|j| 0.01 * (j + 1) as f64).collect();
    world.add_modal_impulse(body, &impulse).expect("an impulse");
    let mut q = vec![0.0; modes];
    for n in 1..=500 {
        world.step().expect("a step");
        world.q(body, &mut q).expect("q");
        for (j, record) in beam().asset().modes().iter().enumerate() {
            let (omega, mass) = (record.omega_rad_s.get(), record.modal_mass_kg.get());
            let of = Oscillator {
                omega_rad_s: omega,
                decay_per_s: 0.05 * omega,
            };
            let whole = of.transition(f64::from(n) * h).expect("a step");
            let [expected, _] = whole.apply([0.0, impulse[j] / mass], 0.0);
            let scale = impulse[j] / mass / omega;
            // The limit is far away: (q / L)⁴ / 4.
            assert!(
                (q[j] - expected).abs() < 1e-11 * scale,
                "{n} {j}: {} {expected}",
                q[j]
            );
        }
    }
    assert_eq!(world.state(body).expect("a state"), start);
}

/// Rates are those of q, not of the variable that the strain limit bends: near the limit they differ by a factor.
#[test]
fn rates_are_those_of_q() {
    let h = 1e-7;
    let mut world = weightless(h, ContactLaw::default());
    let model = (world.add_model(beam(), &BodyOptions::default())).expect("a beam");
    let body = (world.add_body(model, Frame::Free, Transform::IDENTITY)).expect("a body");
    let ranges = beam().asset().modes().iter();
    let q: Vec<f64> = ranges
        .map(|mode| 0.9 * f64::from(mode.q_range.get()))
        .collect();
    let rate = vec![2.0; q.len()];
    world.set_modes(body, &q, &rate).expect("below the limit");
    let mut told = vec![0.0; q.len()];
    world.q_rate(body, &mut told).expect("rates");
    assert!(told.iter().all(|told| (told - 2.0).abs() < 1e-12));
    world.step().expect("a step");
    world.q(body, &mut told).expect("q");
    for (before, now) in q.iter().zip(&told) {
        let moved = (now - before) / h;
        assert!((moved - 2.0).abs() < 0.02, "{moved}");
    }
    assert!(world.q_rate(body, &mut [0.0]).is_err());
}

/// A hard kick: q stays below the limit, and no step has more energy than the one before.
#[test]
fn the_strain_limit_holds_and_adds_no_energy() {
    let h = 1.0 / 150.0;
    let mut world = weightless(h, ContactLaw::default());
    let options = BodyOptions {
        damping: Damping::Ratio(0.0),
        ..BodyOptions::default()
    };
    let model = world.add_model(beam(), &options).expect("a beam");
    let modes = world.model(model).expect("a model").mode_count();
    let body = world
        .add_body(model, Frame::Free, Transform::IDENTITY)
        .expect("a body");
    world
        .add_modal_impulse(body, &vec![1e4; modes])
        .expect("an impulse");
    let energy = world.energy().modal;
    let mut q = vec![0.0; modes];
    for _ in 0..2000 {
        world.step().expect("a step");
        world.q(body, &mut q).expect("q");
        for (q, record) in q.iter().zip(beam().asset().modes()) {
            assert!(q.abs() <= f64::from(record.q_range.get()), "{q}");
        }
    }
    let off = world.energy().modal / energy - 1.0;
    assert!(off.abs() < 1e-10, "{off}");
}

/// At rest on the ground: contacts carry the weight, each mode is bent by what contacts do to it, and every contact is as
/// deep as its force over its stiffness.
#[test]
fn a_resting_body_is_in_equilibrium() {
    let mut world = restless_beams(1);
    let body = bdtree_dynamics::BodyId(0);
    for _ in 0..3000 {
        world.step().expect("a step");
    }
    assert!(world.energy().kinetic < 1e-6, "{:?}", world.energy());
    let model = world.model_of(body).expect("a model");
    let spheres = model.spheres();
    let (modes, stride) = (model.mode_count(), spheres.stride());
    let mass = model.mass_kg().expect("a mass");
    let mut lift = 0.0;
    let mut loads = vec![0.0; stride];
    let turn = world.state(body).expect("a state").orientation;
    let turn = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(
        turn[3], turn[0], turn[1], turn[2],
    ));
    let mut count = 0;
    for contact in world.contacts().filter(|contact| contact.force[1] > 0.0) {
        lift += contact.force[1];
        count += 1;
        let own = turn.inverse() * nalgebra::Vector3::from(contact.force);
        let field = spheres.field(contact.spheres[0]);
        field.pull(own, &vec![1.0; stride], &mut loads);
        assert!(contact.depth > 0.0);
    }
    assert!(count >= 2);
    assert!((lift / (mass * 9.81) - 1.0).abs() < 0.01, "{lift}");
    let mut q = vec![0.0; modes];
    world.q(body, &mut q).expect("q");
    let largest = q.iter().fold(0.0_f64, |m, q| m.max(q.abs()));
    for (j, record) in beam().asset().modes().iter().enumerate() {
        let stiffness = record.modal_mass_kg.get() * record.omega_rad_s.get().powi(2);
        let expected = loads[j] / stiffness;
        assert!(
            (q[j] - expected).abs() < 0.01 * largest,
            "{j}: {} {expected}",
            q[j]
        );
    }
}
