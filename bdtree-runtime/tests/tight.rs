//! `verify` finds bounds that are too small, under valid checksums. What is guaranteed, per SPEC
//! 5.8: R, ΔR and δR that the vertices below a lane exceed by 2⁻⁴⁰ of them, far less than the step
//! to the next f32 or to the next unit; b± that is below its recomputed value by more than the
//! guards, of which 2⁻²¹ R ΔR is always enough. So one step less (the next f32, or a unit of 16-bit
//! rows) is found wherever the recomputed bound lies above it, which this test decides on its own,
//! lane by lane.

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use bdtree_fixtures::lanes::{Lane, Number};
use bdtree_fixtures::mutate::{get_f32, put, repair, section};
use bdtree_fixtures::{bake, golden};
use bdtree_format::SectionKind;
use bdtree_runtime::Model;

fn power(e: i32) -> f64 {
    2_f64.powi(e)
}

/// The least number of 16 bits.
const LEAST: f64 = i16::MIN as f64;

/// The places in ROWS that verify reports.
fn reported(bytes: &[u8]) -> BTreeSet<usize> {
    let model = Model::from_bytes(bytes).expect("open");
    let mut places = BTreeSet::new();
    model.asset().verify(&mut |error| {
        assert_eq!(error.section, SectionKind::ROWS, "{error}");
        places.insert(error.byte as usize);
        ControlFlow::Continue(())
    });
    places
}

/// `irregular`: no norm is itself an f32, where writers go one step further than they need.
fn check(model: &Model, irregular: bool) {
    let asset = *model.asset();
    let bytes = asset.bytes();
    assert!(reported(bytes).is_empty());
    let rows = section(bytes, SectionKind::ROWS).start;
    let mut changed = bytes.to_vec();
    // Steps found and steps tried: R, ΔR, b±, δR.
    let mut counts = [[0; 2]; 4];
    for lane in Lane::all(&asset) {
        for number in lane.numbers() {
            let at = rows + lane.place(number);
            let (units, unit) = lane.units(number);
            // Writes a number of the kind that is stored.
            let mut lower = |to: f64| {
                let stored: Vec<u8> = bytes[at..at + 4].to_vec();
                match number {
                    Number::Growth(_) | Number::Cross(..) => {
                        put(&mut changed, at, &(to as i16).to_le_bytes())
                    }
                    _ => put(&mut changed, at, &(to as f32).to_le_bytes()),
                }
                repair(&mut changed);
                let found = reported(&changed).contains(&at);
                put(&mut changed, at, &stored);
                found
            };
            let (kind, lowered) = match number {
                Number::Radius => (0, f64::from(get_f32(bytes, at).next_down())),
                Number::Step(_) => (3, f64::from(get_f32(bytes, at).next_down())),
                Number::Growth(_) => (1, units - 1.0),
                _ => (2, units - 1.0),
            };
            let storable = match kind {
                1 => lowered >= 0.0,
                2 => lowered >= LEAST,
                _ => (lowered as f32).is_normal(),
            };
            if !storable {
                continue;
            }
            let found = lower(lowered);
            let verdict = lane.verdict(number, lowered * unit);
            assert!(
                verdict.is_none_or(|expected| expected == found),
                "{lane:?}, {number:?}: {units} lowered, found: {found}"
            );
            counts[kind][0] += usize::from(found);
            counts[kind][1] += 1;
            if let Number::Cross(k, _) = number {
                let product = lane.value(Number::Radius) * lane.value(Number::Growth(k));
                let lower_still = units - 1.0 - (power(-21) * product / unit).ceil();
                assert!(
                    lower_still < LEAST || lower(lower_still),
                    "{lane:?}, {number:?}"
                );
            }
        }
    }
    println!(
        "found of tried: R {:?}, ΔR {:?}, b± {:?}, δR {:?}",
        counts[0], counts[1], counts[2], counts[3]
    );
    for kind in [0, 1, 3] {
        let [found, tried] = counts[kind];
        assert!(
            !irregular || 100 * found >= 98 * tried,
            "bounds are as small as their rows allow"
        );
    }
    assert!(counts[0][1] > 0);
}

#[test]
fn bounds_one_step_too_small_are_found() {
    let mesh = bake::bumpy_sphere(5, 1);
    check(&bake::baked(&mesh, &bake::rigid(&mesh)), true);
    check(&bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 1)), true);
    check(&bake::baked(&mesh, &bake::smooth_basis(&mesh, 10, 1)), true);
    let golden = Model::read(golden::folder().join("sphere.bdt")).expect("read");
    check(&golden, false);
}
