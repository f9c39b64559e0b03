//! A world through the interface does what one of the library does.

use std::ptr::null_mut;

use bdtree_capi::body::*;
use bdtree_capi::model::*;
use bdtree_capi::status::BdtStatus;
use bdtree_capi::types::*;
use bdtree_capi::world::*;
use bdtree_capi::world_types::*;
use bdtree_dynamics::{BodyOptions, ContactLaw, Frame, MassProperties, Plane, World, WorldOptions};
use bdtree_runtime::{Model, Transform};

use crate::shared::*;

fn mass() -> BdtMass {
    BdtMass {
        mass_kg: 2.0,
        center: vec3(0.25, 0.25, 0.25),
        inertia: [0.2, 0.2, 0.2, 0.0, 0.0, 0.0],
    }
}

/// A falling tetrahedron of the library.
fn of_the_library() -> World {
    let model = Model::read(golden("tetrahedron.bdt")).expect("a model");
    let mut world = World::new(WorldOptions::default()).expect("usual options");
    let options = BodyOptions {
        mass: Some(mass().into()),
        ..BodyOptions::default()
    };
    let _: (MassProperties, ContactLaw) = (mass().into(), ContactLaw::default());
    let id = world.add_model(&model, &options).expect("a model");
    let plane = Plane {
        normal: [0.0, 1.0, 0.0],
        offset: -0.5,
    };
    world.add_plane(plane).expect("a plane");
    let at = Transform::from_translation([0.0, 1.0, 0.0]);
    world.add_body(id, Frame::Free, at).expect("a body");
    world
}

#[test]
fn a_world_falls_as_in_rust() {
    let model = load("tetrahedron.bdt");
    let mut world = null_mut();
    assert_eq!(bdt_world_new(null_in(), one(&mut world)), BdtStatus::Ok);
    let mut options = [zeroed::<BdtBodyOptions>()];
    assert_eq!(bdt_body_defaults(write(&mut options)), BdtStatus::Ok);
    options[0].has_mass = 1;
    options[0].mass = mass();
    let (mut id, mut body) = (9, 9);
    let status = bdt_world_add_model(handle(world), handle(model), read(&options), one(&mut id));
    assert_eq!(status, BdtStatus::Ok, "{}", last_error());
    assert_eq!(bdt_model_free(handle(model)), BdtStatus::Ok);
    let ground = BdtPlane {
        normal: vec3(0.0, 1.0, 0.0),
        d: 0.5,
    };
    assert_eq!(
        bdt_world_add_plane(handle(world), read(&[ground])),
        BdtStatus::Ok
    );
    let at = BdtTransform {
        translation: vec3(0.0, 1.0, 0.0),
        ..IDENTITY
    };
    let status = bdt_world_add_body(handle(world), id, BDT_FREE, read(&[at]), one(&mut body));
    assert_eq!(
        (status, id, body),
        (BdtStatus::Ok, 0, 0),
        "{}",
        last_error()
    );

    let mut other = of_the_library();
    let mut events = Vec::new();
    for _ in 0..150 {
        let mut report: BdtStepReport = zeroed();
        assert_eq!(
            bdt_world_step(handle(world), one(&mut report)),
            BdtStatus::Ok
        );
        let own = other.step().expect("a step");
        assert_eq!(report.contacts, own.events);
        let (mut slots, mut count) = ([zeroed::<BdtEvent>(); 4], 0);
        let status = bdt_world_events(handle(world), write(&mut slots), 4, one(&mut count));
        assert_eq!(status, BdtStatus::Ok);
        events.extend_from_slice(&slots[..count]);
    }
    assert!(
        events
            .iter()
            .any(|event| event.phase == BDT_BEGAN && event.body2 == BDT_NONE)
    );
    let (mut saved, mut bytes) = (Vec::new(), vec![0; 100_000]);
    other.save(&mut saved);
    let mut length = 0;
    let status = bdt_world_save(
        handle(world),
        write(&mut bytes),
        bytes.len(),
        one(&mut length),
    );
    assert_eq!(status, BdtStatus::Ok);
    assert!(bytes[..length] == saved, "the same to the bit");

    let before = state(world);
    assert_eq!(bdt_world_step(handle(world), null_out()), BdtStatus::Ok);
    assert_ne!(state(world), before);
    assert_eq!(
        bdt_world_restore(handle(world), read(&bytes), length),
        BdtStatus::Ok
    );
    assert_eq!(state(world), before);
    let up = BdtRay {
        origin: vec3(before.position.x, -5.0, before.position.z),
        direction: vec3(0.0, 1.0, 0.0),
        max_distance: f64::INFINITY,
    };
    let mut hit = zeroed();
    assert_eq!(
        bdt_world_cast_ray(handle(world), read(&[up]), one(&mut hit)),
        BdtStatus::Ok
    );
    assert_eq!((hit.index, hit.triangle == BDT_NONE), (0, false));
    assert_eq!(bdt_world_free(handle(world)), BdtStatus::Ok);
}

fn state(world: *mut BdtWorld) -> BdtBodyState {
    let mut state = zeroed();
    assert_eq!(
        bdt_body_state(handle(world), 0, one(&mut state)),
        BdtStatus::Ok
    );
    state
}
