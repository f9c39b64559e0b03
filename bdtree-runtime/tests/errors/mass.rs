//! What is wrong with a mass or with momenta of modes.

use std::mem::{offset_of, size_of};
use std::ops::ControlFlow;

use bdtree_fixtures::mutate::{put, record, repair, section};
use bdtree_format::{Header, MassRecord, ModeMomentum, ModeRecord, SectionKind, SectionRecord};
use bdtree_runtime::{FormatError, Model};

use crate::edits::{Change, body, field};
use crate::seen::FILE;

/// Writes a number of MASS.
fn number(offset: usize, value: f64) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        let at = section(b, SectionKind::MASS_PROPERTIES).start + offset;
        put(b, at, &value.to_le_bytes());
    }
}

/// A field of MASS as it is.
fn read(b: &[u8], offset: usize) -> f64 {
    let at = section(b, SectionKind::MASS_PROPERTIES).start + offset;
    f64::from_le_bytes(b[at..at + 8].try_into().expect("eight bytes"))
}

/// Changes of a sound file, checksums repaired afterwards.
pub(crate) fn changes() -> Vec<Change> {
    changes_of_rules()
        .into_iter()
        .map(|(_, change)| change)
        .collect()
}

/// The changes with the section, the byte in it (in the table for what opening refuses) and the rule that each breaks.
fn changes_of_rules() -> Vec<((SectionKind, usize, &'static str), Change)> {
    let mass = SectionKind::MASS_PROPERTIES;
    let momenta = SectionKind::MODE_MOMENTA;
    let kg = offset_of!(MassRecord, mass_kg);
    let inertia = offset_of!(MassRecord, inertia);
    let source = offset_of!(MassRecord, source);
    let reserved = offset_of!(MassRecord, reserved);
    let finite = "SPEC 7.10: numbers of MASS and MMOM are finite";
    let positive = "SPEC 7.10: mass, density, scale and volume are positive";
    let of_volume = "SPEC 7.10: mass is density x volume x scale^3 within 1e-9";
    let inertial = "SPEC 7.10: the inertia is that of a body: positive, no principal moment above the sum of the others";
    let known = "SPEC 7.10: a mass is that of a surface (1), a lattice (2) or elements (3)";
    let mut all: Vec<((SectionKind, usize, &'static str), Change)> = Vec::new();
    for offset in (0..offset_of!(MassRecord, source)).step_by(8) {
        all.push(((mass, offset, finite), Box::new(number(offset, f64::NAN))));
        all.push((
            (mass, offset, finite),
            Box::new(number(offset, -f64::INFINITY)),
        ));
    }
    for offset in [
        kg,
        offset_of!(MassRecord, density_kg_m3),
        offset_of!(MassRecord, scale_m),
        offset_of!(MassRecord, volume),
    ] {
        all.push(((mass, offset, positive), Box::new(number(offset, 0.0))));
        all.push(((mass, offset, positive), Box::new(number(offset, -1.0))));
        all.push((
            (mass, kg, of_volume),
            Box::new(move |b| {
                let value = read(b, offset) * (1.0 + 3e-9);
                number(offset, value)(b);
            }),
        ));
    }
    for value in [0, 4, u32::MAX] {
        all.push(((mass, source, known), Box::new(body(mass, source, value))));
    }
    for k in [0, 19] {
        let rule = "SPEC 7.10: reserved bytes of MASS are zero";
        all.push((
            (mass, reserved + k, rule),
            Box::new(move |b| {
                let at = section(b, SectionKind::MASS_PROPERTIES).start + reserved + k;
                b[at] = 1;
            }),
        ));
    }
    for (entry, of_trace) in [(0, 0.0), (1, -0.1), (2, 0.71), (3, 0.4), (5, -0.4)] {
        all.push((
            (mass, inertia, inertial),
            Box::new(move |b| {
                let trace: f64 = (0..3).map(|k| read(b, inertia + 8 * k)).sum();
                number(inertia + 8 * entry, of_trace * trace)(b);
            }),
        ));
    }
    for offset in (0..size_of::<ModeMomentum>()).step_by(8) {
        let offset = 2 * size_of::<ModeMomentum>() + offset;
        all.push((
            (momenta, offset, finite),
            Box::new(move |b| {
                let at = section(b, SectionKind::MODE_MOMENTA).start + offset;
                put(b, at, &f64::INFINITY.to_le_bytes());
            }),
        ));
    }
    all.push((
        (
            momenta,
            size_of::<ModeMomentum>(),
            "SPEC 7.10: modes with momenta have modal masses",
        ),
        Box::new(|b| {
            let at = size_of::<Header>() + size_of::<ModeRecord>();
            let mass = at + offset_of!(ModeRecord, modal_mass_kg);
            put(b, mass, &(-1.0_f64).to_le_bytes());
        }),
    ));
    all
}

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
    for ((kind, byte, rule), change) in changes_of_rules() {
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
    let length = offset_of!(SectionRecord, length);
    for (kind, own) in [
        (SectionKind::MASS_PROPERTIES, size_of::<MassRecord>()),
        (SectionKind::MODE_MOMENTA, 6 * size_of::<ModeMomentum>()),
    ] {
        for wrong in [own - 8, 0] {
            // The next section still begins at the next multiple of 64, or the offset is what is told.
            let error = errors(&field(kind, length, wrong as u32)).expect_err("a wrong length");
            let rules = ["SPEC 4.3", "SPEC 3.3"];
            assert!(
                rules.iter().any(|rule| error.rule.starts_with(rule)),
                "{error}"
            );
        }
        let wrong = errors(&field(kind, length, (own - 8) as u32)).expect_err("a wrong length");
        assert!(wrong.rule.starts_with("SPEC 4.3"), "{wrong}");
    }
    let without: Change = Box::new(|b| {
        let at = record(b, SectionKind::MASS_PROPERTIES);
        put(b, at, b"MASX");
    });
    let error = errors(&without).expect_err("momenta of nothing");
    assert_eq!(error.rule, "SPEC 4.2: momenta of modes are those of a mass");
}
