//! Arguments as C gives them.
#![allow(unsafe_code)] // what C promises: docs/design/unsafe.md

use std::ffi::{CStr, CString, c_char};
use std::path::PathBuf;

use bdtree_capi::border::{Handle, In, Kind, Out};
use bdtree_capi::instance::{BdtInstance, bdt_instance_new};
use bdtree_capi::model::{BdtModel, bdt_model_load, bdt_model_read};
use bdtree_capi::status::{BdtStatus, bdt_last_error, bdt_status_text};
use bdtree_capi::types::{BdtRay, BdtTransform, BdtVec3};
use bdtree_capi::workspace::{BdtWorkspace, bdt_workspace_new};

/// A handle, which may be anything: tests run with debug assertions.
pub(crate) fn handle<K: Kind>(address: *mut K) -> Handle<K> {
    const { assert!(cfg!(debug_assertions)) };
    // SAFETY: with debug assertions any address will do.
    unsafe { Handle::new(address) }
}

pub(crate) fn read<T>(values: &[T]) -> In<T> {
    // SAFETY: the tests pass no larger count than there are values, and no test changes them meanwhile.
    unsafe { In::new(values.as_ptr()) }
}

pub(crate) fn write<T>(values: &mut [T]) -> Out<T> {
    // SAFETY: the tests pass no larger count than there are values, and use them for one argument alone.
    unsafe { Out::new(values.as_mut_ptr()) }
}

pub(crate) fn one<T>(value: &mut T) -> Out<T> {
    write(std::slice::from_mut(value))
}

/// A text, which lives as long as the test.
pub(crate) fn text(text: &str) -> In<c_char> {
    let text = CString::new(text).expect("no 0 in it");
    // SAFETY: it is closed by 0 and never freed.
    unsafe { In::new(text.into_raw()) }
}

pub(crate) fn null_in<T>() -> In<T> {
    // SAFETY: NULL is allowed.
    unsafe { In::new(std::ptr::null()) }
}

pub(crate) fn null_out<T>() -> Out<T> {
    // SAFETY: NULL is allowed.
    unsafe { Out::new(std::ptr::null_mut()) }
}

pub(crate) fn golden(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fixtures/golden");
    path.join(name).to_str().expect("UTF-8").to_string()
}

pub(crate) fn load(name: &str) -> *mut BdtModel {
    let mut model = std::ptr::null_mut();
    // Miri maps no files.
    let open = if cfg!(miri) {
        bdt_model_read
    } else {
        bdt_model_load
    };
    let status = open(text(&golden(name)), one(&mut model));
    assert_eq!(status, BdtStatus::Ok, "{}", last_error());
    model
}

pub(crate) fn instance(model: *mut BdtModel) -> *mut BdtInstance {
    let mut instance = std::ptr::null_mut();
    let status = bdt_instance_new(handle(model), one(&mut instance));
    assert_eq!(status, BdtStatus::Ok, "{}", last_error());
    instance
}

pub(crate) fn workspace() -> *mut BdtWorkspace {
    let mut workspace = std::ptr::null_mut();
    assert_eq!(bdt_workspace_new(one(&mut workspace)), BdtStatus::Ok);
    workspace
}

/// A value to be written over.
pub(crate) fn zeroed<T: zerocopy::FromZeros>() -> T {
    T::new_zeroed()
}

/// What a status says.
pub(crate) fn status_text(status: i32) -> &'static str {
    let text = bdt_status_text(status);
    // SAFETY: the function returns static texts closed by 0.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().expect("UTF-8")
}

pub(crate) fn last_error() -> String {
    let mut bytes = [0 as c_char; 300];
    let mut length = 0;
    bdt_last_error(write(&mut bytes), bytes.len(), one(&mut length));
    let bytes = bytes.iter().take(length).map(|c| c.cast_unsigned());
    String::from_utf8(bytes.collect()).expect("UTF-8")
}

pub(crate) const fn vec3(x: f64, y: f64, z: f64) -> BdtVec3 {
    BdtVec3 { x, y, z }
}

pub(crate) const IDENTITY: BdtTransform = BdtTransform {
    rotation: bdtree_capi::types::BdtQuat {
        x: 0.0,
        y: 0.0,
        z: 0.0,
        w: 1.0,
    },
    translation: vec3(0.0, 0.0, 0.0),
    scale: 1.0,
};

/// Down through the unit sphere.
pub(crate) const RAY: BdtRay = BdtRay {
    origin: vec3(0.1, 3.0, 0.2),
    direction: vec3(0.0, -1.0, 0.0),
    max_distance: f64::INFINITY,
};

/// Room for a value at an address that is not aligned.
pub(crate) fn odd<T>(words: &mut [u64]) -> Out<T> {
    assert!(size_of_val(words) > size_of::<T>());
    // SAFETY: there is room for it.
    unsafe { Out::new(words.as_mut_ptr().cast::<u8>().wrapping_add(1).cast()) }
}
