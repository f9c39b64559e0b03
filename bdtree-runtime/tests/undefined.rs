//! Small files opened, verified and asked everything, few enough for an interpreter that finds
//! undefined behaviour (ci/miri.sh). There `fuzz-files` would take days.

use bdtree_fixtures::ask::{ask_everything, kernels, refused};
use bdtree_fixtures::mutate::Damage;
use bdtree_fixtures::poses;
use bdtree_runtime::{Asset, Model, include_bdt};

/// A triangle with one mode (SPEC 10), and a rigid tetrahedron.
fn files() -> [&'static [u8]; 2] {
    [
        include_bdt!("../../format-spec/tests/example.bdt"),
        include_bdt!("../../fixtures/golden/tetrahedron.bdt"),
    ]
}

/// Repetitions, each with other questions.
fn rounds() -> u64 {
    if cfg!(miri) { 1 } else { 40 }
}

#[test]
fn sound_files_are_asked_everything() {
    let [one, two] = files();
    for bytes in files() {
        let asset = Asset::open(bytes).expect("open");
        assert!(!refused(&asset));
        let copy = Model::from_bytes(bytes).expect("open");
        assert!(copy.asset().bytes() == bytes);
        let partner = Asset::open(if bytes == one { two } else { one }).expect("open");
        for (k, kernel) in kernels().into_iter().enumerate() {
            println!("{kernel:?}");
            let asset = asset.with_kernel(kernel).expect("an available kernel");
            for round in 0..rounds() {
                let answers = ask_everything(&asset, &partner, &mut poses::rng(round + k as u64));
                assert!(answers.given > 40 && answers.corrupt == 0, "{answers:?}");
            }
        }
    }
}

#[test]
fn damaged_files_are_asked_everything() {
    let mut opened = 0;
    // The larger one takes an interpreter minutes.
    let some = if cfg!(miri) { 1 } else { 2 };
    for (k, bytes) in files().into_iter().take(some).enumerate() {
        let partner = Asset::open(bytes).expect("open");
        for (d, damage) in Damage::ALL.into_iter().enumerate() {
            for round in 0..rounds() {
                let mut rng = poses::rng(round + 100 * d as u64 + 1000 * k as u64);
                let Ok(model) = Model::from_bytes(&damage.done_to(&partner, &mut rng)) else {
                    continue;
                };
                opened += 1;
                let _ = refused(model.asset());
                ask_everything(model.asset(), &partner, &mut rng);
            }
        }
    }
    assert!(opened > 0);
}
