//! Any bytes, as they are and with checksums that fit: opened, verified, asked everything.
#![no_main]

use bdtree_fixtures::ask::{ask_everything, kernels, located, refused};
use bdtree_fixtures::{mutate, poses};
use bdtree_runtime::{Asset, Model, include_bdt};
use libfuzzer_sys::fuzz_target;

fn examine(bytes: &[u8]) {
    let model = match Model::from_bytes(bytes) {
        Ok(model) => model,
        Err(error) => return located(&error),
    };
    let asset = model.asset();
    let _ = refused(asset);
    let partner = include_bdt!("../../fixtures/golden/tetrahedron.bdt");
    let partner = Asset::open(partner).expect("the partner opens");
    // The file says what it is asked, so that a finding can be repeated.
    let seed = u64::from(asset.header().header_crc.get());
    let kernels = kernels();
    let kernel = kernels[seed as usize % kernels.len()];
    let asset = asset.with_kernel(kernel).expect("an available kernel");
    let answers = ask_everything(&asset, &partner, &mut poses::rng(seed));
    assert!(
        refused(&asset) || answers.corrupt == 0,
        "verify passed this file"
    );
}

fuzz_target!(|bytes: &[u8]| {
    examine(bytes);
    let mut repaired = bytes.to_vec();
    mutate::repair(&mut repaired);
    examine(&repaired);
});
