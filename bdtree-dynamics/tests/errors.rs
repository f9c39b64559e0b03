//! Every error, and that its text says what would work.

use bdtree_build::input::RawMesh;
use bdtree_dynamics::{
    BodyId, BodyOptions, ContactLaw, DynamicsError, Frame, MassProperties, ModelId, Plane, World,
    WorldOptions,
};
use bdtree_fixtures::bake;
use bdtree_runtime::format::{NodeRecord, SectionKind};
use bdtree_runtime::{Asset, Model, Transform, include_bdt};

use crate::support::{GROUND, at, ball, ball_model, beam};

const H: f64 = 1.0 / 150.0;

fn says<T>(result: Result<T, DynamicsError>, text: &str) {
    match result {
        Ok(_) => panic!("not refused: {text}"),
        Err(error) => assert!(error.to_string().contains(text), "{error}"),
    }
}

#[test]
fn worlds_name_what_is_wrong() {
    let with = |change: fn(&mut WorldOptions)| {
        let mut options = WorldOptions::default();
        change(&mut options);
        World::new(options)
    };
    says(with(|o| o.step_s = -1.0), "1/150 s would do");
    says(with(|o| o.gravity[1] = f64::NAN), "gravity: not finite");
    says(with(|o| o.threads = 0), "threads");
    says(with(|o| o.law.stiffness = f64::NAN), "stiffness");
    says(with(|o| o.law.damping_ratio = -0.1), "damping_ratio");
    says(with(|o| o.law.friction = 11.0), "between 0 and 10");
    let stiff = ContactLaw::default().with_stiffness(1e9, 2.0, H);
    says(
        stiff,
        "are too long for contacts of 1000000000 N/m; use steps of at most",
    );
    let law = ContactLaw::default()
        .with_stiffness(4.5e4, 2.0, H)
        .expect("a law");
    assert!((law.stiffness - 1.0).abs() < 1e-12);

    let mut world = World::new(WorldOptions::default()).expect("a world");
    says(
        world.add_plane(Plane {
            normal: [0.0, 2.0, 0.0],
            offset: 0.0,
        }),
        "unit normal",
    );
    says(
        world.add_body(ModelId(0), Frame::Free, Transform::IDENTITY),
        "model 0: there is none",
    );
    says(world.state(BodyId(3)), "body 3: there is none");
    let model = ball(&mut world, 1.0);
    let scaled = Transform {
        scale: 2.0,
        ..Transform::IDENTITY
    };
    says(
        world.add_body(model, Frame::Free, scaled),
        "the body model 1",
    );
    let body = world
        .add_body(model, Frame::Free, Transform::IDENTITY)
        .expect("a body");
    says(
        world.set_velocity(body, [f64::NAN; 3], [0.0; 3]),
        "velocity: not finite",
    );
    says(
        world.add_force(body, [0.0; 3], [f64::INFINITY; 3]),
        "torque: not finite",
    );
    says(
        world.add_modal_force(body, &[1.0]),
        "1 values for the 0 modes",
    );
    says(world.drive(body, &[], Transform::IDENTITY), "driven body 0");

    let model = world
        .add_model(beam(), &BodyOptions::default())
        .expect("a beam");
    let of = world.model(model).expect("a model");
    let (modes, limit) = (
        of.mode_count(),
        f64::from(beam().asset().modes()[0].q_range.get()),
    );
    let body = world
        .add_body(model, Frame::Free, at([0.0, 9.0, 0.0]))
        .expect("a body");
    let mut q = vec![0.0; modes];
    q[0] = limit;
    says(
        world.set_modes(body, &q, &vec![0.0; modes]),
        "not below the strain limit",
    );
    says(
        world.set_modes(body, &vec![0.0; modes], &vec![f64::NAN; modes]),
        "rate of q",
    );
    says(
        world.add_modal_force(body, &vec![f64::NAN; modes]),
        "modal force: not finite",
    );
    says(
        world.add_modal_impulse(body, &vec![f64::NAN; modes]),
        "modal impulse: not finite",
    );
    // What was refused has changed nothing.
    let mut now = vec![1.0; modes];
    world.q(body, &mut now).expect("q");
    assert!(now.iter().all(|q| *q == 0.0));
}

#[test]
fn body_models_say_what_is_missing() {
    let mut world = World::new(WorldOptions::default()).expect("a world");
    let mut model = |options: &BodyOptions| world.add_model(beam(), options);
    says(
        model(&BodyOptions {
            scale: 0.0,
            ..BodyOptions::default()
        }),
        "scale",
    );
    says(
        model(&BodyOptions {
            level: Some(9),
            ..BodyOptions::default()
        }),
        "the tree has levels 0 to",
    );
    says(
        model(&BodyOptions {
            strain_limit: f64::NAN,
            ..BodyOptions::default()
        }),
        "strain_limit",
    );
    let mass = MassProperties {
        mass_kg: -1.0,
        center: [0.0; 3],
        inertia: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
    };
    says(
        model(&BodyOptions {
            mass: Some(mass),
            ..BodyOptions::default()
        }),
        "mass properties",
    );

    // Fields without frequencies.
    let mesh: RawMesh = bake::bumpy_sphere(8, 1);
    let given = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 3));
    let options = BodyOptions {
        mass: Some(MassProperties::ball(1.0, 1.0, [0.0; 3])),
        ..BodyOptions::default()
    };
    let silent = world.add_model(&given, &options).expect("a model");
    for frame in [Frame::Free, Frame::Held] {
        says(
            world.add_body(silent, frame, Transform::IDENTITY),
            "mode 0 has no frequency and modal mass",
        );
    }
    // They may be driven, or rigid.
    (world.add_body(silent, Frame::Driven, Transform::IDENTITY)).expect("a driven body");
    let rigid = BodyOptions {
        is_deformable: false,
        ..options
    };
    assert!(world.add_model(&given, &rigid).is_ok());

    let skinned = include_bdt!("../../fixtures/golden/skinned.bdt");
    let skinned = Model::from_static(skinned).expect("an asset");
    says(
        world.add_model(&skinned, &BodyOptions::default()),
        "has a skin",
    );

    // An open triangle weighs nothing that anybody knows.
    let open = world
        .add_model(&ball_model(), &BodyOptions::default())
        .expect("a model");
    says(
        world.add_body(open, Frame::Free, Transform::IDENTITY),
        "has no mass properties; bake it from a closed mesh",
    );
    assert!(
        world
            .add_body(open, Frame::Held, Transform::IDENTITY)
            .is_ok()
    );
}

/// Nodes that are their own children, in a file that nobody has verified: no way up ends, and none is followed for ever.
#[test]
fn circular_trees_are_no_endless_loop() {
    let sound = include_bdt!("../../fixtures/golden/sphere.bdt");
    let asset = Asset::open(sound).expect("an asset");
    let nodes = (asset.sections().iter())
        .find(|section| section.kind == SectionKind::NODES)
        .expect("nodes");
    let (start, count) = (nodes.offset.get() as usize, asset.node_count());
    assert!(count > 2 && asset.depth() > 1);
    for index in 0..count {
        let mut bytes = sound.to_vec();
        let at = start + index * size_of::<NodeRecord>();
        bytes[at..at + 4].copy_from_slice(&(index as u32).to_le_bytes());
        let model = Model::from_bytes(&bytes).expect("it opens");
        let mut world = World::new(WorldOptions::default()).expect("a world");
        let options = BodyOptions {
            is_deformable: false,
            level: Some(asset.depth() - 1),
            ..BodyOptions::default()
        };
        world.add_model(&model, &options).expect("a model");
    }
}

#[test]
fn too_deep_overlaps_are_an_error() {
    let mut world = World::new(WorldOptions::default()).expect("a world");
    let model = ball(&mut world, 1.0);
    world.add_plane(GROUND).expect("a plane");
    world
        .add_body(model, Frame::Free, at([0.0, -0.2, 0.0]))
        .expect("a body");
    says(world.step(), "body 0 and a plane overlap by 7.00");
}
