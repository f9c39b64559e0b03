//! The rules: all are triggered, and all stand in the specification.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use bdtree_fixtures::mutate::repair;
use bdtree_runtime::{
    AlignedBytes, Asset, Pose, Transform, TriangleId, VertexId, add_generalized_force,
};

use crate::deep::list_twice;
use crate::seen::{FILE, Seen};
use crate::{asked, deep, open};

/// Rules that no input reaches: they guard what earlier rules already ensure.
const UNREACHABLE: [&str; 4] = [
    "SPEC 3.1: files are read on little-endian hosts only",
    "SPEC 2.2: the mode table lies inside the header block",
    "SPEC 2.3: the section table lies inside the header block",
    "SPEC 4.3: a section holds whole, aligned elements",
];

/// All rules that the sources cite.
fn rules() -> BTreeSet<String> {
    let mut folders = vec![PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/src"))];
    let mut rules = BTreeSet::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("the sources") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            // Its one rule, of leaves that share triangles, none of the edits here breaks.
            if path.ends_with("traverse/leaves.rs") {
                continue;
            }
            let source = fs::read_to_string(path).expect("a source");
            for piece in source.split("\"SPEC ").skip(1) {
                let text = piece.split('"').next().expect("a closed string");
                let text: String = text.split("\\\n").map(|l| l.trim_start()).collect();
                rules.insert(format!("SPEC {text}"));
            }
        }
    }
    rules
}

#[test]
fn every_rule_is_triggered() {
    let mut seen = Seen::default();
    seen.everything(&FILE);
    assert!(seen.0.is_empty(), "{:?}", seen.0);
    let changes = [open::changes(), deep::changes(), asked::changes()];
    for change in changes.into_iter().flatten() {
        let mut bytes = FILE.to_vec();
        change(&mut bytes);
        repair(&mut bytes);
        seen.everything(&bytes);
    }
    seen.everything(&list_twice(true));
    seen.everything(&list_twice(false));
    // Checksums that are not repaired.
    for at in [100, FILE.len() - 1] {
        let mut bytes = FILE.to_vec();
        bytes[at] ^= 1;
        seen.everything(&bytes);
    }
    // A misaligned base.
    let copy = AlignedBytes::copy_of(&[&[0; 4][..], &FILE].concat());
    for start in 1..4 {
        let mut shifted = copy.to_vec();
        shifted.rotate_left(4 - start);
        let shifted = AlignedBytes::copy_of(&shifted);
        let error = Asset::open(&shifted[start..start + FILE.len()]).expect_err("misaligned");
        assert!(error.rule.starts_with("SPEC 3.2"), "{error}");
        seen.note(&error);
    }
    assert!(
        Asset::open(&copy[4..]).is_ok(),
        "an alignment of 4 is enough"
    );
    // Accessors.
    let asset = Asset::open(&FILE).expect("open");
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = Pose::new(&asset, &[0.0; 6], Transform::IDENTITY, &mut memory).expect("pose");
    seen.note(
        &asset
            .triangle(TriangleId(u32::MAX))
            .expect_err("no such triangle"),
    );
    seen.note(
        &asset
            .deformed(&pose, VertexId(u32::MAX))
            .expect_err("no such vertex"),
    );
    let short = add_generalized_force(
        &asset,
        &pose,
        TriangleId(0),
        [1.0, 0.0, 0.0],
        [1.0; 3],
        &mut [0.0; 5],
    );
    seen.note(&short.expect_err("too short"));

    let all = rules();
    assert!(all.len() > 60, "{}", all.len());
    let missing: Vec<_> = all
        .iter()
        .filter(|r| !seen.0.contains(*r) && !UNREACHABLE.contains(&r.as_str()))
        .collect();
    assert!(missing.is_empty(), "not triggered: {missing:#?}");
    for rule in UNREACHABLE {
        assert!(all.contains(rule) && !seen.0.contains(rule), "{rule}");
    }
    let unknown: Vec<_> = seen.0.difference(&all).collect();
    assert!(unknown.is_empty(), "not in the sources: {unknown:#?}");
}

/// Cited numbers exist, and speak of the part that they are cited for.
#[test]
fn cited_rules_stand_in_the_specification() {
    let spec = include_str!("../../../format-spec/SPEC.md");
    for rule in rules() {
        let number = rule["SPEC ".len()..]
            .split([':', ')'])
            .next()
            .expect("a number");
        let cited = spec.lines().any(|line| {
            line.trim_start_matches('#')
                .trim_start()
                .starts_with(&format!("{number} "))
                && line.starts_with("##")
        });
        assert!(cited, "{rule}");
    }
}
