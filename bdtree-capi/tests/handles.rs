//! Handles that were freed, are of another kind, are used twice, or never were any.

use std::ffi::c_void;
use std::ptr::null_mut;

use bdtree_capi::answers::{BdtContact, BdtHit};
use bdtree_capi::instance::*;
use bdtree_capi::model::*;
use bdtree_capi::query::*;
use bdtree_capi::status::BdtStatus;
use bdtree_capi::types::*;
use bdtree_capi::workspace::*;

use crate::shared::*;

#[test]
fn handles_are_freed_once_and_in_any_order() {
    let model = load("sphere.bdt");
    let (body, desk) = (instance(model), workspace());
    assert_eq!(bdt_model_free(handle(model)), BdtStatus::Ok);
    assert_eq!(bdt_model_free(handle(model)), BdtStatus::ErrorHandle);
    let mut info: BdtModelInfo = zeroed();
    assert_eq!(
        bdt_model_info(handle(model), one(&mut info)),
        BdtStatus::ErrorHandle
    );
    let mut hit: BdtHit = zeroed();
    let mut ask = || bdt_cast_ray(handle(desk), handle(body), read(&[RAY]), one(&mut hit));
    assert_eq!(ask(), BdtStatus::Ok, "the instance keeps the model");
    assert_eq!(bdt_workspace_free(handle(desk)), BdtStatus::Ok);
    assert_eq!(ask(), BdtStatus::ErrorHandle);
    assert_eq!(bdt_workspace_free(handle(desk)), BdtStatus::ErrorHandle);
    assert_eq!(bdt_instance_free(handle(body)), BdtStatus::Ok);
    assert_eq!(bdt_instance_free(handle(body)), BdtStatus::ErrorHandle);
    assert_eq!(bdt_instance_free(handle(null_mut())), BdtStatus::Ok);
}

#[test]
fn a_handle_of_another_kind_is_refused() {
    let model = load("sphere.bdt");
    let body = instance(model);
    let mut info: BdtModelInfo = zeroed();
    let status = bdt_model_info(handle(body.cast()), one(&mut info));
    assert_eq!(status, BdtStatus::ErrorHandle);
    assert_eq!(bdt_model_free(handle(body.cast())), BdtStatus::ErrorHandle);
    for address in [1, 8, 0x1000, usize::MAX] {
        let nowhere = std::ptr::without_provenance_mut(address);
        assert_eq!(bdt_instance_free(handle(nowhere)), BdtStatus::ErrorHandle);
    }
    assert_eq!(bdt_instance_free(handle(body)), BdtStatus::Ok);
    assert_eq!(bdt_model_free(handle(model)), BdtStatus::Ok);
}

/// What a callback tries with the handles of its own call.
struct Tries {
    desk: *mut BdtWorkspace,
    body: *mut BdtInstance,
    calls: usize,
    statuses: Vec<BdtStatus>,
}

extern "C" fn try_them(contact: *const BdtContact, context: *mut c_void) -> i32 {
    assert!(!contact.is_null());
    TRIES.with_borrow_mut(|tries| {
        assert!(context.is_null());
        tries.calls += 1;
        let mut hit: BdtHit = zeroed();
        let mut at: BdtTransform = zeroed();
        tries.statuses = vec![
            bdt_cast_ray(
                handle(tries.desk),
                handle(tries.body),
                read(&[RAY]),
                one(&mut hit),
            ),
            bdt_instance_set_placement(handle(tries.body), read(&[IDENTITY])),
            bdt_instance_free(handle(tries.body)),
            bdt_workspace_free(handle(tries.desk)),
            bdt_instance_placement(handle(tries.body), one(&mut at)),
        ];
    });
    0
}

thread_local! {
    static TRIES: std::cell::RefCell<Tries> = const {
        std::cell::RefCell::new(Tries { desk: null_mut(), body: null_mut(), calls: 0, statuses: Vec::new() })
    };
}

#[test]
fn callbacks_cannot_touch_what_their_call_uses() {
    use BdtStatus::{ErrorBusy, Ok};
    let model = load("sphere.bdt");
    let (body, desk) = (instance(model), workspace());
    TRIES.with_borrow_mut(|tries| (tries.desk, tries.body) = (desk, body));
    let ball = bdt_ball(vec3(0.0, 0.0, 1.0), 0.2);
    // A query that only reads lets others read.
    for (is_shared, reading) in [(0, ErrorBusy), (1, Ok)] {
        assert_eq!(bdt_workspace_set_shared(handle(desk), is_shared), Ok);
        let status = bdt_contacts_each(
            handle(desk),
            handle(body),
            read(&[ball]),
            Some(try_them),
            null_mut(),
        );
        assert_eq!(status, Ok);
        TRIES.with_borrow(|tries| {
            assert!(tries.calls > 1);
            let expected = [ErrorBusy, ErrorBusy, ErrorBusy, ErrorBusy, reading];
            assert_eq!(tries.statuses, expected);
        });
    }
    assert_eq!(
        bdt_instance_set_placement(handle(body), read(&[IDENTITY])),
        Ok
    );
    let status = bdt_contacts_each(handle(desk), handle(body), read(&[ball]), None, null_mut());
    assert_eq!(status, BdtStatus::ErrorNull);
    for status in [
        bdt_instance_free(handle(body)),
        bdt_workspace_free(handle(desk)),
        bdt_model_free(handle(model)),
    ] {
        assert_eq!(status, Ok);
    }
}

/// One instance, asked by several threads that only read it.
#[test]
fn shared_instances_answer_several_threads() {
    let model = load("sphere.bdt");
    let body = instance(model).expose_provenance();
    let threads: Vec<_> = (0..4)
        .map(|_| {
            std::thread::spawn(move || {
                let body = std::ptr::with_exposed_provenance_mut(body);
                let desk = workspace();
                assert_eq!(bdt_workspace_set_shared(handle(desk), 1), BdtStatus::Ok);
                let mut hit: BdtHit = zeroed();
                for _ in 0..if cfg!(miri) { 2 } else { 100 } {
                    let status =
                        bdt_cast_ray(handle(desk), handle(body), read(&[RAY]), one(&mut hit));
                    assert_eq!(status, BdtStatus::Ok);
                }
                assert_eq!(bdt_workspace_free(handle(desk)), BdtStatus::Ok);
                hit.distance
            })
        })
        .collect();
    let distances: Vec<f64> = threads
        .into_iter()
        .map(|t| t.join().expect("no panic"))
        .collect();
    assert!(distances.iter().all(|d| *d == distances[0] && *d > 1.9));
}

/// Unaligned and absurd arguments.
#[test]
fn what_memory_cannot_hold_is_refused() {
    let model = load("sphere.bdt");
    let (body, desk) = (instance(model), workspace());
    let mut hits: [BdtHit; 2] = zeroed();
    let status = bdtree_capi::batch::bdt_cast_rays(
        handle(desk),
        handle(body),
        read(&[RAY]),
        usize::MAX / 2,
        write(&mut hits),
    );
    assert_eq!(status, BdtStatus::ErrorArgument, "{}", last_error());
    let mut bytes = [0_u64; 30];
    let odd = odd(&mut bytes);
    let status = bdt_cast_ray(handle(desk), handle(body), read(&[RAY]), odd);
    assert_eq!(status, BdtStatus::ErrorArgument);
    assert!(last_error().contains("not aligned"), "{}", last_error());
}
