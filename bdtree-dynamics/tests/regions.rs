//! Closed surfaces that touch each other exactly.

use bdtree_dynamics::{
    BodyId, BodyOptions, ContactLaw, ContactShape, DynamicsError, Frame, MassProperties, ModelId,
    World, WorldOptions,
};
use bdtree_fixtures::bake;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::support::{GROUND, at, beam, box_mesh, falling, same_momenta, weightless};

const G: f64 = 9.81;

fn regions() -> BodyOptions {
    BodyOptions {
        contact: ContactShape::Regions,
        ..BodyOptions::default()
    }
}

/// A homogeneous box.
pub(crate) fn solid(world: &mut World, mass_kg: f64, sides: [f64; 3]) -> ModelId {
    let mesh = box_mesh(sides);
    let model = bake::baked(&mesh, &bake::rigid(&mesh));
    let options = BodyOptions {
        mass: Some(MassProperties::cuboid(mass_kg, sides, [0.0; 3])),
        ..regions()
    };
    world.add_model(&model, &options).expect("a box")
}

pub(crate) fn place(world: &World, body: BodyId) -> Vector3<f64> {
    world.state(body).expect("a state").position.into()
}

fn heavy(step_s: f64, law: ContactLaw) -> World {
    World::new(WorldOptions {
        step_s,
        law,
        sleep_speed: 0.0,
        accuracy: 1e-6,
        ..WorldOptions::default()
    })
    .expect("a world")
}

#[test]
fn walls_are_measured() {
    let mut world = weightless(1e-2, ContactLaw::default());
    let sides = [1.0, 0.02, 0.6];
    let model = solid(&mut world, 1.0, sides);
    let wall = |world: &World, model| world.model(model).expect("a model").thinnest_wall();
    assert!((wall(&world, model).expect("a wall") - 0.02).abs() < 1e-8);
    // In world units.
    let mesh = box_mesh(sides);
    let model = bake::baked(&mesh, &bake::rigid(&mesh));
    let scaled = BodyOptions {
        scale: 3.0,
        ..regions()
    };
    let scaled = world.add_model(&model, &scaled).expect("a box");
    assert!((wall(&world, scaled).expect("a wall") - 0.06).abs() < 1e-7);
    let given = BodyOptions {
        thinnest_wall: Some(0.25),
        ..regions()
    };
    let given = world.add_model(&model, &given).expect("a box");
    assert_eq!(wall(&world, given), Some(0.25));
    let of_spheres = (world.add_model(&model, &BodyOptions::default())).expect("a box");
    assert_eq!(wall(&world, of_spheres), None);
    for thinnest_wall in [0.0, f64::NAN, f64::INFINITY] {
        let options = BodyOptions {
            thinnest_wall: Some(thinnest_wall),
            ..regions()
        };
        let error = world.add_model(&model, &options).expect_err("no wall");
        assert!(error.to_string().contains("thinnest_wall"), "{error}");
    }
    // Without its last face it has no inside, nor has it inside out.
    let mut open = box_mesh(sides);
    open.triangles.truncate(10);
    let mut turned = box_mesh(sides);
    for triangle in &mut turned.triangles {
        triangle.swap(0, 1);
    }
    for mesh in [open, turned] {
        let model = bake::baked(&mesh, &bake::rigid(&mesh));
        let error = world.add_model(&model, &regions()).expect_err("no inside");
        assert!(matches!(error, DynamicsError::NoInside { .. }), "{error}");
        assert!(error.to_string().contains("closed surface"), "{error}");
    }
}

/// A box at rest sinks by its weight over the stiffness of its four corners on a plane, and of the four points of its
/// region on another box.
#[test]
fn resting_boxes_sink_by_their_weight() {
    let law = ContactLaw {
        stiffness: 0.5,
        damping_ratio: 0.5,
        friction: 0.4,
    };
    let h = 1.0 / 150.0;
    // Of four springs κ m / h².
    let sunk = G * h * h / (4.0 * law.stiffness);
    for is_on_box in [false, true] {
        let mut world = heavy(h, law);
        let model = solid(&mut world, 2.0, [0.5, 0.3, 0.4]);
        if is_on_box {
            let table = solid(&mut world, 1.0, [2.0, 0.4, 2.0]);
            (world.add_body(table, Frame::Held, at([0.1, -0.2, 0.05]))).expect("a table");
        } else {
            world.add_plane(GROUND).expect("a plane");
        }
        let body = (world.add_body(model, Frame::Free, at([0.0, 0.16, 0.0]))).expect("a box");
        let mut parts = 0;
        for _ in 0..600 {
            parts += world.step().expect("a step").parts;
        }
        // Slow for its walls.
        assert!(parts < 700, "{parts}");
        let contacts: Vec<_> = world.contacts().filter(|of| of.depth > 0.0).collect();
        assert_eq!(contacts.len(), 4);
        let lift: f64 = contacts.iter().map(|of| of.force[1]).sum();
        assert!((lift.abs() / (2.0 * G) - 1.0).abs() < 1e-4, "{lift}");
        for contact in contacts {
            assert!((contact.depth / sunk - 1.0).abs() < 1e-3, "{contact:?}");
        }
        assert!((place(&world, body).y - (0.15 - sunk)).abs() < 1e-3 * sunk);
        assert!(world.energy().kinetic < 1e-12);
    }
}

/// Below the friction angle a box stays, above it it slides as Coulomb says.
#[test]
fn boxes_on_slopes_stay_or_slide() {
    let law = ContactLaw {
        stiffness: 0.5,
        damping_ratio: 0.5,
        friction: 0.5,
    };
    for (share, is_on_box) in [(0.9, false), (0.9, true), (1.3, false), (1.3, true)] {
        let slope = share * law.friction;
        let angle = f64::atan(slope);
        let h = 1.0 / 300.0;
        let mut world = World::new(WorldOptions {
            step_s: h,
            gravity: [G * angle.sin(), -G * angle.cos(), 0.0],
            law,
            sleep_speed: 0.0,
            accuracy: 1e-6,
            ..WorldOptions::default()
        })
        .expect("a world");
        let model = solid(&mut world, 2.0, [0.5, 0.1, 0.5]);
        if is_on_box {
            let table = solid(&mut world, 1.0, [9.0, 1.0, 9.0]);
            (world.add_body(table, Frame::Held, at([0.0, -0.5, 0.0]))).expect("a table");
        } else {
            world.add_plane(GROUND).expect("a plane");
        }
        let body = (world.add_body(model, Frame::Free, at([0.0, 0.05, 0.0]))).expect("a box");
        let speed = |world: &World| world.state(body).expect("a state").velocity[0];
        for _ in 0..150 {
            world.step().expect("a step");
        }
        let before = speed(&world);
        for _ in 0..150 {
            world.step().expect("a step");
        }
        let rate = (speed(&world) - before) / 0.5;
        if share < 1.0 {
            assert!(speed(&world).abs() < 1e-6, "{} {is_on_box}", speed(&world));
        } else {
            let expected = G * (angle.sin() - law.friction * angle.cos());
            assert!((rate / expected - 1.0).abs() < 0.01, "{rate} {expected}");
        }
    }
}

/// Forces are opposite and act at one point: boxes that collide keep momentum and angular momentum, and gain no energy.
#[test]
fn boxes_that_collide_keep_momentum() {
    let law = ContactLaw {
        stiffness: 1.0,
        damping_ratio: 0.2,
        friction: 0.5,
    };
    let mut world = weightless(1.0 / 150.0, law);
    let models = [
        solid(&mut world, 2.0, [0.5, 0.3, 0.4]),
        solid(&mut world, 0.7, [0.2, 0.3, 0.6]),
    ];
    for k in 0..6 {
        let x = f64::from(k);
        let body = (world.add_body(
            models[k as usize % 2],
            Frame::Free,
            at([0.7 * x, 0.05 * x, 0.0]),
        ))
        .expect("a body");
        let v = [if k < 3 { 2.0 } else { -2.5 }, 0.1, 0.1 * x];
        (world.set_velocity(body, v, [x, 1.0, -1.0])).expect("a velocity");
    }
    let momenta = world.momenta();
    let energy = world.energy().mechanical();
    let mut touched = 0;
    for _ in 0..300 {
        touched += world.step().expect("a step").events;
        assert!(world.energy().mechanical() < energy * 1.001);
    }
    assert!(touched > 10);
    same_momenta(momenta, world.momenta());
    assert!(world.energy().mechanical() < 0.9 * energy);
}

/// Elastic bodies at rest: vertices carry the weight, and bend modes as `Uᵀ f` says.
#[test]
fn a_beam_at_rest_is_in_equilibrium() {
    // It lies flat, bent by less than a micrometer: forces have to be better than usual.
    let options = WorldOptions {
        sleep_speed: 0.0,
        accuracy: 1e-6,
        ..WorldOptions::default()
    };
    let mut world = falling(1, options, &regions());
    let body = BodyId(0);
    for _ in 0..2000 {
        world.step().expect("a step");
    }
    assert!(world.energy().kinetic < 1e-6, "{:?}", world.energy());
    let model = world.model_of(body).expect("a model");
    let mass = model.mass_kg().expect("a mass");
    let asset = beam().asset();
    let at = world.placement(body).expect("a placement");
    let [x, y, z, w] = at.rotation;
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    let mut fields = vec![[0.0; 3]; asset.mode_count()];
    let (mut lift, mut loads) = (0.0, vec![0.0; model.mode_count()]);
    for contact in world.contacts().filter(|contact| contact.force[1] > 0.0) {
        lift += contact.force[1];
        let own = turn.inverse() * Vector3::from(contact.force);
        let vertex = bdtree_runtime::VertexId(contact.spheres[0] as u32);
        asset.rest_vertex(vertex, &mut fields).expect("a vertex");
        for (load, field) in loads.iter_mut().zip(&fields) {
            *load += own.dot(&Vector3::from(*field));
        }
    }
    assert!((lift / (mass * G) - 1.0).abs() < 0.01, "{lift}");
    let mut q = vec![0.0; model.mode_count()];
    world.q(body, &mut q).expect("q");
    let largest = q.iter().fold(0.0_f64, |most, q| most.max(q.abs()));
    assert!(largest > 0.0);
    for (j, record) in asset.modes().iter().enumerate() {
        let stiffness = record.modal_mass_kg.get() * record.omega_rad_s.get().powi(2);
        let expected = loads[j] / stiffness;
        assert!(
            (q[j] - expected).abs() < 0.01 * largest,
            "{j}: {} {expected}",
            q[j]
        );
    }
}

/// Beams in a heap vibrate, and steps are the same for any number of threads and after a break.
#[test]
fn heaps_are_the_same_to_the_bit() {
    let bytes = |world: &World| {
        let mut out = Vec::new();
        world.save(&mut out);
        out
    };
    let made = |threads| {
        let options = WorldOptions {
            threads,
            ..WorldOptions::default()
        };
        falling(4, options, &regions())
    };
    let [mut alone, mut together, mut again] = [made(1), made(2), made(1)];
    let first = alone.energy().mechanical();
    let (mut saved, mut between, mut energy) = (Vec::new(), 0, f64::INFINITY);
    for step in 0..100 {
        if step == 40 {
            saved = bytes(&alone);
        }
        let before = alone.energy().mechanical();
        let report = alone.step().expect("a step");
        together.step().expect("a step");
        between += (alone.contacts().filter(|of| of.bodies[1].is_some())).count();
        let now = before + report.contact_energy;
        assert!(now < energy + 0.01 * first, "{step}: {now} {energy}");
        energy = energy.min(now);
    }
    assert!(between > 50, "{between}");
    assert!(alone.energy().modal > 1e-4);
    assert!(bytes(&alone) == bytes(&together));
    again.restore(&saved).expect("restored");
    for _ in 40..100 {
        again.step().expect("a step");
    }
    assert!(bytes(&alone) == bytes(&again));
}

/// Bodies of the other shapes meet the contact spheres of one whose surface is exact for its like.
#[test]
fn other_shapes_meet_contact_spheres() {
    let law = ContactLaw {
        stiffness: 0.5,
        damping_ratio: 0.5,
        friction: 0.4,
    };
    for shape in [ContactShape::Spheres, ContactShape::Triangles] {
        let mut world = heavy(1.0 / 150.0, law);
        let mesh = box_mesh([2.0, 0.4, 2.0]);
        let table = bake::baked(&mesh, &bake::rigid(&mesh));
        let of = BodyOptions {
            contact: shape,
            ..BodyOptions::default()
        };
        let table = world.add_model(&table, &of).expect("a table");
        let model = solid(&mut world, 2.0, [0.5, 0.3, 0.4]);
        let table = (world.add_body(table, Frame::Held, at([0.0, -0.2, 0.0]))).expect("a table");
        let body = (world.add_body(model, Frame::Free, at([0.0, 3.5, 0.0]))).expect("a box");
        let of = |body| {
            let model = world.model_of(body).expect("a model");
            let spheres = model.spheres();
            (0..spheres.len())
                .map(|k| spheres.radius(k))
                .fold(0.0, f64::max)
        };
        let [of_table, of_body] = [table, body].map(of);
        for _ in 0..600 {
            world.step().expect("a step");
        }
        // It lies on spheres, so it is not lower than on the table itself, nor higher than on a heap of both.
        let height = place(&world, body).y;
        assert!(
            height > 0.1 && height < of_table + 2.0 * of_body,
            "{height}"
        );
        assert!(world.energy().kinetic < 1e-6, "{shape:?}");
        assert!(world.contacts().any(|contact| contact.force[1].abs() > 1.0));
    }
}

/// A law without stiffness stops nothing, and no step runs for ever.
#[test]
fn a_law_without_stiffness_ends() {
    let law = ContactLaw {
        stiffness: 0.0,
        ..ContactLaw::default()
    };
    let mut world = heavy(1.0 / 150.0, law);
    let model = solid(&mut world, 1.0, [0.5, 0.3, 0.4]);
    world.add_plane(GROUND).expect("a plane");
    world
        .add_body(model, Frame::Free, at([0.0, 0.4, 0.0]))
        .expect("a box");
    let end = (0..200).find_map(|_| world.step().err());
    assert!(
        matches!(end, Some(DynamicsError::Penetration { .. })),
        "{end:?}"
    );
}
