//! Every status is returned by something.

use std::collections::HashSet;
use std::ffi::c_void;
use std::ptr::null_mut;

use bdtree_capi::answers::{BdtContact, BdtHit};
use bdtree_capi::instance::*;
use bdtree_capi::model::*;
use bdtree_capi::query::*;
use bdtree_capi::skeleton::bdt_skeleton_pose_new;
use bdtree_capi::status::BdtStatus;
use bdtree_capi::types::*;
use bdtree_capi::workspace::*;
use bdtree_capi::world::*;
use bdtree_capi::world_types::BdtWorldOptions;

use crate::shared::*;

extern "C" fn stop(_: *const BdtContact, _: *mut c_void) -> i32 {
    1
}

/// What each call returned, by itself: the expected status, and a word of what `bdt_last_error` says.
#[test]
fn every_status_is_returned() {
    let (model, desk) = (load("sphere.bdt"), workspace());
    let body = instance(model);
    let mut hit: BdtHit = zeroed();
    let mut seen = HashSet::new();
    let mut expect = |status: BdtStatus, wanted: BdtStatus, word: &str| {
        assert_eq!(status, wanted, "{}", last_error());
        assert!(last_error().contains(word), "{}", last_error());
        seen.insert(status);
    };

    let ask = |ray: &[BdtRay], hit: &mut BdtHit| {
        bdt_cast_ray(handle(desk), handle(body), read(ray), one(hit))
    };
    expect(ask(&[RAY], &mut hit), BdtStatus::Ok, "");
    assert_eq!((hit.triangle == BDT_NONE, hit.index), (false, 0));

    let ball = bdt_ball(vec3(0.0, 0.0, 0.0), 2.0);
    let (mut slots, mut count) = ([zeroed::<BdtContact>(); 2], 0);
    let status = bdt_contacts(
        handle(desk),
        handle(body),
        read(&[ball]),
        write(&mut slots),
        slots.len(),
        one(&mut count),
    );
    expect(status, BdtStatus::Truncated, "");
    assert_eq!(count, 192);

    let status = bdt_contacts_each(
        handle(desk),
        handle(body),
        read(&[ball]),
        Some(stop),
        null_mut(),
    );
    expect(status, BdtStatus::Stopped, "");

    let status = bdt_cast_ray(handle(desk), handle(body), null_in(), one(&mut hit));
    expect(status, BdtStatus::ErrorNull, "ray is NULL");
    let status = bdt_cast_ray(
        handle(desk),
        handle(null_mut()),
        read(&[RAY]),
        one(&mut hit),
    );
    expect(status, BdtStatus::ErrorNull, "instance is NULL");

    let foreign = (&raw mut hit).cast::<BdtInstance>();
    let status = bdt_instance_set_placement(handle(foreign), read(&[IDENTITY]));
    expect(status, BdtStatus::ErrorHandle, "instance: not a handle");

    let mut touching = 0;
    let status = bdtree_capi::pair::bdt_pair_intersects(
        handle(desk),
        handle(body),
        handle(body),
        handle(null_mut()),
        one(&mut touching),
    );
    expect(status, BdtStatus::ErrorBusy, "the same handle twice");

    let nowhere = BdtRay {
        direction: vec3(0.0, 0.0, 0.0),
        ..RAY
    };
    expect(
        ask(&[nowhere], &mut hit),
        BdtStatus::ErrorArgument,
        "direction: zero",
    );

    let status = bdt_instance_set_q(handle(body), read(&[0.0]), 1);
    expect(status, BdtStatus::ErrorLength, "q has 1 entries");

    let mut mode: BdtMode = zeroed();
    let status = bdt_model_mode(handle(model), 3, one(&mut mode));
    expect(
        status,
        BdtStatus::ErrorIndex,
        "there is no mode 3: there are 3",
    );

    let mut other = null_mut();
    let status = bdt_model_load(text("no such file"), one(&mut other));
    expect(status, BdtStatus::ErrorIo, "no such file: cannot be read");

    let status = bdt_model_from_memory(read(b"hello"), 5, one(&mut other));
    expect(status, BdtStatus::ErrorFormat, "a whole header");

    let status = bdt_instance_set_q(handle(body), read(&[f32::NAN, 0.0, 0.0]), 3);
    expect(status, BdtStatus::ErrorPose, "q[0] is not a finite number");

    let mut skeleton = null_mut();
    let status = bdt_skeleton_pose_new(handle(model), one(&mut skeleton));
    expect(status, BdtStatus::ErrorNoSkin, "no skin");

    let (mut q, mut at) = ([0.0; 3], IDENTITY);
    let status = bdt_model_sample(handle(model), 0.5, write(&mut q), 3, one(&mut at));
    expect(status, BdtStatus::ErrorNoAnimation, "no animation");

    // A damaged file that opens.
    let mut bytes = std::fs::read(golden("sphere.bdt")).expect("it is there");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x55;
    assert_eq!(
        bdt_model_from_memory(read(&bytes), bytes.len(), one(&mut other)),
        BdtStatus::Ok
    );
    expect(
        bdt_model_verify_checksums(handle(other)),
        BdtStatus::ErrorFormat,
        "checksum mismatch",
    );
    expect(
        bdt_model_verify(handle(other)),
        BdtStatus::ErrorFormat,
        "checksum mismatch",
    );
    assert_eq!(bdt_model_free(handle(other)), BdtStatus::Ok);

    worlds(&mut expect);
    // A panic is provoked beside its code.
    seen.insert(BdtStatus::ErrorPanic);
    let missing: Vec<_> = BdtStatus::ALL
        .iter()
        .filter(|status| !seen.contains(status))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
    for status in [
        bdt_instance_free(handle(body)),
        bdt_model_free(handle(model)),
    ] {
        assert_eq!(status, BdtStatus::Ok);
    }
    assert_eq!(bdt_workspace_free(handle(desk)), BdtStatus::Ok);
}

/// What only worlds return.
fn worlds(expect: &mut impl FnMut(BdtStatus, BdtStatus, &str)) {
    let mut options = usual();
    options.step_s = -1.0;
    let mut world = null_mut();
    let status = bdt_world_new(read(&[options]), one(&mut world));
    expect(status, BdtStatus::ErrorDynamics, "a step of -1 s");

    assert_eq!(bdt_world_new(null_in(), one(&mut world)), BdtStatus::Ok);
    let status = bdt_world_restore(handle(world), read(b"nothing"), 7);
    expect(status, BdtStatus::ErrorState, "not a saved state");

    // A body deep in the ground.
    let model = load("tetrahedron.bdt");
    let mut body_options = defaults();
    body_options.has_mass = 1;
    body_options.mass.mass_kg = 1.0;
    body_options.mass.inertia = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
    let (mut id, mut body) = (0, 0);
    let status = bdt_world_add_model(
        handle(world),
        handle(model),
        read(&[body_options]),
        one(&mut id),
    );
    assert_eq!(status, BdtStatus::Ok, "{}", last_error());
    let ground = BdtPlane {
        normal: vec3(0.0, 1.0, 0.0),
        d: -50.0,
    };
    assert_eq!(
        bdt_world_add_plane(handle(world), read(&[ground])),
        BdtStatus::Ok
    );
    let status = bdt_world_add_body(
        handle(world),
        id,
        BDT_FREE,
        read(&[IDENTITY]),
        one(&mut body),
    );
    assert_eq!(status, BdtStatus::Ok, "{}", last_error());
    let status = bdt_world_step(handle(world), null_out());
    expect(status, BdtStatus::ErrorStep, "overlap");
    assert_eq!(bdt_world_free(handle(world)), BdtStatus::Ok);
    assert_eq!(bdt_model_free(handle(model)), BdtStatus::Ok);
}

fn usual() -> BdtWorldOptions {
    let mut options = [zeroed::<BdtWorldOptions>()];
    assert_eq!(bdt_world_defaults(write(&mut options)), BdtStatus::Ok);
    options[0]
}

fn defaults() -> bdtree_capi::world_types::BdtBodyOptions {
    let mut options = [zeroed()];
    assert_eq!(bdt_body_defaults(write(&mut options)), BdtStatus::Ok);
    options[0]
}

#[test]
fn every_status_has_a_text_of_its_own() {
    let mut texts = HashSet::new();
    for status in BdtStatus::ALL
        .map(|status| status as i32)
        .into_iter()
        .chain([-1000])
    {
        assert!(texts.insert(status_text(status)), "{status}");
    }
    assert_eq!(status_text(7), status_text(i32::MIN), "no status");
}
