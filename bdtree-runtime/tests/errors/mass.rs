//! What is wrong with a mass or with momenta of modes.

use std::mem::{offset_of, size_of};
use std::ops::ControlFlow;

use bdtree_fixtures::mutate::{put, record, repair, section};
use bdtree_fixtures::rules::changes_of_masses;
use bdtree_format::{MassRecord, ModeMomentum, SectionKind, SectionRecord};
use bdtree_runtime::{FormatError, Model};

use crate::seen::FILE;

/// The errors that a changed file leads to.
fn errors(change: &dyn Fn(&mut Vec<u8>)) -> Result<Vec<FormatError>, FormatError> {
    let mut bytes = FILE.asset().bytes().to_vec();
    change(&mut bytes);
    repair(&mut bytes);
    let model = Model::from_bytes(&bytes)?;
    let mut errors = Vec::new();
    model.asset().verify(&mut |error| {
        errors.push(error);
        ControlFlow::Continue(())
    });
    Ok(errors)
}

#[test]
fn every_broken_number_is_told_with_its_place() {
    let asset = FILE.asset();
    let momenta = asset.mode_momenta().expect("momenta of all modes");
    assert_eq!(momenta.len(), asset.mode_count());
    for ((kind, byte, rule), change) in changes_of_masses() {
        let errors = errors(&change).expect("the file opens");
        let start = section(asset.bytes(), kind).start;
        let [error] = errors.as_slice() else {
            panic!("{rule}: {errors:?}");
        };
        let place = (error.section, error.byte, error.rule);
        assert_eq!(place, (kind, (start + byte) as u64, rule), "{error}");
    }
}

/// What opening refuses: lengths, and momenta without a mass.
#[test]
fn lengths_and_presence_are_checked_when_a_file_is_opened() {
    let shorter = |kind: SectionKind, length: usize| {
        move |b: &mut Vec<u8>| {
            let at = record(b, kind) + offset_of!(SectionRecord, length);
            put(b, at, &(length as u64).to_le_bytes());
        }
    };
    for (kind, own) in [
        (SectionKind::MASS_PROPERTIES, size_of::<MassRecord>()),
        (SectionKind::MODE_MOMENTA, 6 * size_of::<ModeMomentum>()),
    ] {
        for wrong in [own - 8, 0] {
            // The next section still begins at the next multiple of 64, or the offset is what is told.
            let error = errors(&shorter(kind, wrong)).expect_err("a wrong length");
            let rules = ["SPEC 4.3", "SPEC 3.3"];
            assert!(
                rules.iter().any(|rule| error.rule.starts_with(rule)),
                "{error}"
            );
        }
        let wrong = errors(&shorter(kind, own - 8)).expect_err("a wrong length");
        assert!(wrong.rule.starts_with("SPEC 4.3"), "{wrong}");
    }
    let without = |b: &mut Vec<u8>| {
        let at = record(b, SectionKind::MASS_PROPERTIES);
        put(b, at, b"MASX");
    };
    let error = errors(&without).expect_err("momenta of nothing");
    assert_eq!(error.rule, "SPEC 4.2: momenta of modes are those of a mass");
}
