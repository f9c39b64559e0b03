use std::path::PathBuf;

use clap::Parser;
use serde_json::{Value, json};

use super::{Arguments, run};

/// A report of two settings of everything.
fn report() -> Value {
    let pair = |x: &str, y: &[&str]| -> Value {
        let one = |k: f64| {
            let mut all = serde_json::Map::from_iter([(x.to_string(), json!(k))]);
            all.extend(y.iter().map(|y| (y.to_string(), json!(2.0 + k))));
            Value::Object(all)
        };
        json!([one(0.0), one(1.0)])
    };
    let curve = |question: &str, standing: Value| {
        let mut curve = json!({"question": question,
            "points": [{"amount": 1.0, "ratio": 8.0}, {"amount": 64.0, "ratio": 0.5}]});
        for (name, value) in standing.as_object().expect("an object") {
            curve[name] = value.clone();
        }
        curve
    };
    let crosses =
        json!({"ahead": "crosses", "above": "refit", "from": 1.0, "to": 64.0, "break_even": 16.0});
    let ours = json!({"ahead": "bdtree", "above": "bdtree"});
    let unsure =
        json!({"ahead": "partly", "below": "bdtree", "above": null, "from": 1.0, "to": 64.0});
    json!({"asset": {"triangles": 12},
        "modes": pair("modes", &["error_max_rel", "bytes", "time_rel", "ball_visits"]),
        "depth": pair("level", &["extra_area_rel", "penetration_error_rel", "ball_micros"]),
        "refit": {"curves": [curve("ray", crosses), curve("ball", ours), curve("pair", unsure)]}})
}

fn advice() -> Value {
    json!({"leaves": [{"leaf_size": 2, "time_rel": 0.9, "bytes": 300},
        {"leaf_size": 4, "time_rel": 0.6, "bytes": 200}]})
}

fn with(report: &Value, advice: &Value) -> Result<crate::report::Report, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, value: &Value| -> PathBuf {
        let path = folder.path().join(name);
        std::fs::write(&path, value.to_string()).expect("written");
        path
    };
    let (report, advice) = (
        write("cloth.report.json", report),
        write("cloth.advice.json", advice),
    );
    let words: [&std::ffi::OsStr; 5] = [
        "guide".as_ref(),
        "--report".as_ref(),
        report.as_ref(),
        "--advice".as_ref(),
        advice.as_ref(),
    ];
    let arguments = Arguments::try_parse_from(words).expect("options");
    run(&arguments).map_err(|e| e.to_string())
}

#[test]
fn figures_are_those_of_the_files() {
    let made = with(&report(), &advice()).expect("a guide");
    assert_eq!(made.pictures.len(), 4);
    let points = |pointer: &str| made.value.pointer(pointer).cloned();
    let first = |key: &str, chart: usize| points(&format!("/times/{key}/{chart}/curves/0/points"));
    assert_eq!(first("modes", 0), Some(json!([[0.0, 200.0], [1.0, 300.0]])));
    assert_eq!(
        first("modes", 1),
        Some(json!([[0.0, 2.0 / 3.0], [1.0, 1.0]]))
    );
    assert_eq!(first("leaves", 0), Some(json!([[2.0, 1.5], [4.0, 1.0]])));
    assert_eq!(first("refit", 0), Some(json!([[1.0, 8.0], [64.0, 0.5]])));
    assert_eq!(
        points("/times/refit/0/curves/0/asset"),
        Some(json!("cloth"))
    );
    let table = made.tables[0].csv();
    assert_eq!(
        table.lines().nth(1),
        Some("cloth,12,16,not up to 64,unsure above 1")
    );
}

/// The table follows what curves say of themselves, whatever the points are.
#[test]
fn break_evens_are_those_of_the_curves() {
    for (standing, text) in [
        (
            json!({"ahead": "refit", "above": "refit"}),
            "at every number",
        ),
        (json!({"ahead": "close", "from": 1.0, "to": 64.0}), "unsure"),
        (
            json!({"ahead": "crosses", "below": "refit", "above": "bdtree", "break_even": 7.0}),
            "up to 7",
        ),
        (
            json!({"ahead": "partly", "below": "bdtree", "above": "refit", "from": 4.0, "to": 64.0}),
            "unsure from 4 to 64",
        ),
    ] {
        let mut own = report();
        let curve = &mut own["refit"]["curves"][0];
        for name in ["ahead", "below", "above", "from", "to", "break_even"] {
            curve[name] = standing[name].clone();
        }
        let made = with(&own, &advice()).expect("a guide");
        let row = format!("cloth,12,{text},not up to 64,unsure above 1");
        assert_eq!(made.tables[0].csv().lines().nth(1), Some(row.as_str()));
    }
    let mut lacks = report();
    lacks["refit"]["curves"][0]["ahead"] = Value::Null;
    let error = with(&lacks, &advice()).expect_err("nothing said");
    assert!(
        error.ends_with("the curve of ray does not say who is ahead"),
        "{error}"
    );
}

/// However few leaf sizes there are, each is marked below both plots.
#[test]
fn leaf_sizes_are_marked_and_named() {
    let tried = json!({"leaves": [{"leaf_size": 2, "time_rel": 0.9, "bytes": 330},
        {"leaf_size": 4, "time_rel": 0.6, "bytes": 300}, {"leaf_size": 8, "time_rel": 0.7, "bytes": 280}]});
    let made = with(&report(), &tried).expect("a guide");
    let leaves = made.pictures.iter().find(|(key, _)| *key == "leaves");
    let (_, svg) = leaves.expect("a picture of leaves");
    for text in ["2", "4", "8", "most triangles of a leaf"] {
        let count = svg.lines().filter(|line| *line == text).count();
        assert_eq!(count, 2, "{text} in {svg}");
    }
}

#[test]
fn what_is_missing_is_named() {
    let mut lacks = report();
    lacks["depth"] = Value::Null;
    let error = with(&lacks, &advice()).expect_err("no depth");
    assert!(
        error.ends_with("cloth.report.json: no list at /depth"),
        "{error}"
    );
    lacks["depth"] = json!([]);
    let error = with(&lacks, &advice()).expect_err("no level");
    assert!(
        error.contains("cloth.report.json: nothing at /depth has /level"),
        "{error}"
    );
    let error = with(&report(), &json!({})).expect_err("no leaves");
    assert!(
        error.ends_with("cloth.advice.json: no list at /leaves"),
        "{error}"
    );
}
