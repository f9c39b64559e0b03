//! The rules: all are triggered, and all stand in the specification.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use bdtree_fixtures::rules::{self, By, told};
use bdtree_fixtures::skin::skinned_bar;
use bdtree_runtime::{
    Asset, Datum, Model, QueryError, SkeletonError, Transform, TriangleId, VertexId,
};
use serde_json::Value;

use crate::seen::{FILE, Seen};

/// Rules that no input reaches: they guard what earlier rules already ensure.
const UNREACHABLE: [&str; 4] = [
    "SPEC 2.2: the mode table lies inside the header block",
    "SPEC 2.3: the section table lies inside the header block",
    "SPEC 4.3: a section holds whole, aligned elements",
    "SPEC 7.3: a displacement is one of a vertex and a mode of the file",
];

/// Rules of what a caller gives, which no file breaks.
const OF_CALLERS: [&str; 3] = [
    "SPEC 3.2: the first byte lies at an address that is a multiple of 4",
    "SPEC 7.1: a vertex id is below N",
    "SPEC 7.2: a triangle id is below F",
];

/// All rules that the sources cite.
fn cited() -> BTreeSet<String> {
    let mut folders = vec![PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/src"))];
    let mut rules = BTreeSet::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("the sources") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
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
    let file = FILE.asset().bytes();
    for (name, bytes) in rules::sound() {
        assert!(told(&bytes).is_empty(), "{name}");
    }
    for damaged in rules::all() {
        for (by, error) in told(&damaged.bytes) {
            seen.note(&error);
            let text = error.to_string();
            match by {
                By::Open | By::Verify => {}
                By::Query => {
                    let of_query = QueryError::from(error).to_string();
                    assert!(of_query.ends_with(&text), "{of_query}");
                    assert_eq!(SkeletonError::from(error).to_string(), text);
                }
            }
        }
    }
    let skinned = Model::from_bytes(&skinned_bar()).expect("a sound file");
    let unknown = skinned.asset().influences(VertexId(u32::MAX));
    seen.note(&unknown.expect_err("no such vertex"));
    // A misaligned base.
    let mut shifted = vec![0; file.len() + 16];
    let start = shifted.as_ptr().align_offset(8);
    for odd in 1..=4 {
        let place = start + odd..start + odd + file.len();
        shifted[place.clone()].copy_from_slice(file);
        let opened = Asset::open(&shifted[place]);
        if odd == 4 {
            assert!(opened.is_ok(), "an alignment of 4 is enough");
            continue;
        }
        let error = opened.expect_err("misaligned");
        assert!(error.rule.starts_with("SPEC 3.2"), "{error}");
        seen.note(&error);
    }
    // Accessors.
    let asset = FILE.asset();
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset.pose(&[0.0; 6], Transform::IDENTITY, &mut memory);
    let pose = pose.expect("pose");
    let unknown = asset.triangle(TriangleId(u32::MAX));
    seen.note(&unknown.expect_err("no such triangle"));
    let unknown = pose.deformed(VertexId(u32::MAX));
    let unknown = unknown.expect_err("no such vertex");
    let range = (
        Datum::Below(asset.vertex_count() as u64),
        Datum::from(u32::MAX),
    );
    assert_eq!((unknown.expected, unknown.found), range, "{unknown}");
    // What a caller gave is no place in the file.
    let told = format!(
        "there is no vertex 4294967295: the asset has {}",
        asset.vertex_count()
    );
    assert_eq!(unknown.to_string(), told);
    seen.note(&unknown);
    let unknown = pose.deformed_triangle(TriangleId(u32::MAX));
    seen.note(&unknown.expect_err("no such triangle"));
    let weights = [1.0, 0.0, 0.0];
    let short = pose.add_generalized_force(TriangleId(0), weights, [1.0; 3], &mut [0.0; 5]);
    let short = short.expect_err("too short");
    let lengths = (Datum::AtLeast(6.0), Datum::from(5_usize));
    assert_eq!((short.expected, short.found), lengths, "{short}");
    let told = "argument `out` holds 5 numbers, the asset has 6 modes";
    assert_eq!(short.to_string(), told);
    let short = asset.rest_vertex(VertexId(0), &mut [[0.0; 3]; 5]);
    assert_eq!(short.expect_err("too short").to_string(), told);
    let unknown = asset.rest_vertex(VertexId(u32::MAX), &mut [[0.0; 3]; 6]);
    assert_eq!(unknown.expect_err("no such vertex").expected, range.0);

    let all = cited();
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

/// Each file of `fixtures/rules` is refused as its index says, and every rule that a file can break has one.
#[test]
fn every_rule_of_files_has_a_file() {
    let text = fs::read_to_string(rules::folder().join("index.json")).expect("the index");
    let index: Vec<Value> = serde_json::from_str(&text).expect("JSON");
    let mut found = BTreeSet::new();
    for entry in &index {
        let field = |name: &str| entry[name].as_str().expect("text");
        let bytes = fs::read(rules::folder().join(field("file"))).expect("a file");
        let told = told(&bytes);
        let own = told.iter().find(|(_, error)| error.rule == field("rule"));
        let (by, error) = own.unwrap_or_else(|| panic!("{entry}: {told:?}"));
        assert_eq!(
            (by.name(), error.to_string().as_str()),
            (field("refused_by"), field("error"))
        );
        assert_eq!(entry["structural"] == true, entry["why_not"].is_null());
        found.insert(error.rule.to_string());
    }
    let mut of_files = cited();
    of_files.retain(|rule| {
        !UNREACHABLE.contains(&rule.as_str()) && !OF_CALLERS.contains(&rule.as_str())
    });
    assert_eq!(found, of_files);
}

/// Cited numbers exist, and speak of the part that they are cited for.
#[test]
fn cited_rules_stand_in_the_specification() {
    let spec = include_str!("../../../format-spec/SPEC.md");
    for rule in cited() {
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
