//! `verify`: sound files, broken files, the same JSON for both.

use serde_json::{Value, json};

use crate::support::Folder;

#[test]
fn sound_files_are_ok() {
    let folder = Folder::new();
    for file in ["a.bdt", "rigid.bdt"] {
        assert_eq!(
            folder.json(&["verify", file, "--json"]),
            json!({"ok": true, "errors": []})
        );
        let ran = folder.run(&["verify", file]);
        assert_eq!((ran.code, ran.out), (0, format!("{file}: ok\n")));
    }
}

#[test]
fn a_flipped_bit_is_found_and_placed() {
    let folder = Folder::new();
    let info = folder.json(&["info", "a.bdt", "--json"]);
    let sound = folder.read("a.bdt");
    for section in info["sections"].as_array().unwrap() {
        let mut bytes = sound.clone();
        let at = section["offset"].as_u64().unwrap() as usize;
        bytes[at] ^= 1;
        folder.write("bad.bdt", &bytes);
        let ran = folder.run(&["verify", "bad.bdt", "--json"]);
        assert_eq!(ran.code, 1);
        let report: Value = serde_json::from_str(&ran.out).unwrap();
        assert_eq!(report["ok"], false);
        let error = &report["errors"][0];
        assert_eq!(error["section"], section["kind"]);
        assert_eq!(error["byte"], at);
        assert!(error["rule"].as_str().unwrap().starts_with("SPEC 4.1"));
        assert!(error["expected"].is_number() && error["found"].is_number());
        let place = format!(
            "bad.bdt: section {} at byte {at}: checksum mismatch: the section table says {:08x}, the bytes give {:08x} \
             (SPEC 4.1",
            section["kind"].as_str().unwrap(),
            error["expected"].as_u64().unwrap(),
            error["found"].as_u64().unwrap()
        );
        assert!(ran.err.starts_with(&place), "{}", ran.err);
        // Every error is one line on the error stream.
        let errors = report["errors"].as_array().unwrap().len();
        assert_eq!(ran.err.lines().count(), errors);
    }
}

#[test]
fn an_error_of_opening_has_the_same_form() {
    let folder = Folder::new();
    folder.write("text.bdt", "not a tree");
    let ran = folder.run(&["verify", "text.bdt", "--json"]);
    assert_eq!(ran.code, 1);
    let report: Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(report["ok"], false);
    assert_eq!(report["errors"].as_array().map(Vec::len), Some(1));
    let error = report["errors"][0].as_object().unwrap();
    let fields: Vec<&str> = error.keys().map(String::as_str).collect();
    assert_eq!(fields, ["byte", "expected", "found", "rule", "section"]);
    assert_eq!(error["section"], "HEAD");
    let ran = folder.run(&["verify", "text.bdt"]);
    assert_eq!((ran.code, ran.out.as_str()), (1, ""));
    assert!(ran.err.starts_with("text.bdt: not a .bdt file (SPEC 9.1"));
}

/// JSON says how a number is limited, as the text does.
#[test]
fn what_is_expected_of_an_index_has_its_relation() {
    let folder = Folder::new();
    let info = folder.json(&["info", "a.bdt", "--json"]);
    let mut bytes = folder.read("a.bdt");
    let sections = info["sections"].as_array().unwrap();
    let triangles = sections.iter().find(|s| s["kind"] == "TRIS").unwrap();
    let at = triangles["offset"].as_u64().unwrap() as usize;
    bytes[at..at + 4].copy_from_slice(&65_355_u32.to_le_bytes());
    folder.write("bad.bdt", bytes);
    let ran = folder.run(&["verify", "bad.bdt", "--json"]);
    let report: Value = serde_json::from_str(&ran.out).unwrap();
    let errors = report["errors"].as_array().unwrap();
    let expected = format!("less than {}", info["vertices"]);
    let of_corner = |e: &&Value| e["found"] == 65_355 && e["expected"] == expected.as_str();
    assert_eq!(errors.iter().filter(of_corner).count(), 1, "{errors:#?}");
    let text = format!("found 65355, expected {expected}");
    assert!(ran.err.contains(&text), "{}", ran.err);
}

/// A sphere that is too small for all of its vertices is one broken rule.
#[test]
fn a_bound_that_is_too_small_is_told_once() {
    let folder = Folder::new();
    let info = folder.json(&["info", "a.bdt", "--json"]);
    let mut bytes = folder.read("a.bdt");
    let sections = info["sections"].as_array().unwrap();
    let rows = sections.iter().find(|s| s["kind"] == "ROWS").unwrap();
    // The radii of the root's lanes: the fourth row.
    let radii = rows["offset"].as_u64().unwrap() as usize + 3 * 32;
    let radius = f32::from_le_bytes(bytes[radii..radii + 4].try_into().unwrap());
    bytes[radii..radii + 4].copy_from_slice(&(radius / 8.0).to_le_bytes());
    folder.write("bad.bdt", bytes);
    let ran = folder.run(&["verify", "bad.bdt", "--json"]);
    assert_eq!(ran.code, 1);
    let report: Value = serde_json::from_str(&ran.out).unwrap();
    let errors = report["errors"].as_array().unwrap();
    let of_radius: Vec<&Value> = errors
        .iter()
        .filter(|e| e["byte"] == radii && e["rule"].as_str().unwrap().starts_with("SPEC 6.6: R "))
        .collect();
    assert_eq!(of_radius.len(), 1, "{errors:#?}");
    // The smallest ball reaches its farthest vertex.
    let expected = of_radius[0]["expected"].as_str().unwrap();
    let needed: f64 = expected.strip_prefix("at least ").unwrap().parse().unwrap();
    assert!(
        (needed / f64::from(radius) - 1.0).abs() < 1e-6,
        "{needed} {radius}"
    );
    let line = format!(
        "found {}, expected at least {needed} (SPEC 6.6",
        f64::from(radius / 8.0)
    );
    assert!(ran.err.contains(&line), "{}", ran.err);
    let mut places: Vec<String> = errors
        .iter()
        .map(|e| format!("{} {} {}", e["section"], e["byte"], e["rule"]))
        .collect();
    let told = places.len();
    places.sort();
    places.dedup();
    assert_eq!(places.len(), told);
}

#[test]
fn long_lists_are_cut() {
    let folder = Folder::new();
    let info = folder.json(&["info", "a.bdt", "--json"]);
    let mut bytes = folder.read("a.bdt");
    let section = |kind: &str| {
        let sections = info["sections"].as_array().unwrap();
        let section = sections.iter().find(|s| s["kind"] == kind).unwrap();
        let number = |field: &str| section[field].as_u64().unwrap() as usize;
        number("offset")..number("offset") + number("bytes")
    };
    // Every node, triangle and vertex breaks at least one rule.
    for kind in ["NODE", "TRIS", "SLOT", "VERT", "DISP"] {
        bytes[section(kind)].fill(0x7e);
    }
    folder.write("bad.bdt", bytes);
    let ran = folder.run(&["verify", "bad.bdt", "--json"]);
    assert_eq!(ran.code, 1);
    let report: Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(report["errors"].as_array().map(Vec::len), Some(1000));
    assert!(
        ran.err
            .ends_with("bad.bdt: stopped after 1000 broken rules\n")
    );
}

#[test]
fn a_missing_file_is_named() {
    let ran = Folder::new().run(&["verify", "no.bdt", "--json"]);
    assert_eq!((ran.code, ran.out.as_str()), (1, ""));
    assert!(ran.err.starts_with("no.bdt: cannot be read: "));
}

#[test]
fn a_stress_run_tells_what_it_tried() {
    let folder = Folder::new();
    for file in ["a.bdt", "rigid.bdt"] {
        let arguments = ["verify", file, "--stress", "--cases", "3000", "--json"];
        let report = folder.json(&arguments);
        assert_eq!(
            (&report["ok"], &report["errors"]),
            (&json!(true), &json!([]))
        );
        let stress = &report["stress"];
        assert_eq!(stress["cases"], 3000);
        assert_eq!(
            (&stress["violations"], &stress["unbounded"]),
            (&json!(0), &json!(0))
        );
        assert!(stress["vertices"].as_u64() > stress["cases"].as_u64());
        assert!(
            stress["kernels"]
                .as_array()
                .unwrap()
                .contains(&json!("Scalar"))
        );
        let cost = stress["rounding_slack_rel"].as_f64().unwrap();
        assert!(cost > 0.0 && cost < 1e-3, "{cost}");
        let tightest = &stress["tightest"];
        let number = |name: &str| tightest[name].as_f64().unwrap();
        let margin = (number("radius") - number("distance")) / number("slack");
        assert!(margin > 0.0 && (margin - number("margin_slacks")).abs() < 1e-6 * margin);
        // The same seed tries the same cases, another one others.
        assert_eq!(folder.json(&arguments), report);
        let other = folder.json(&[&arguments[..], &["--seed", "1"]].concat());
        assert_ne!(other["stress"], *stress);
    }
    let ran = folder.run(&["verify", "a.bdt", "--stress", "--cases", "10"]);
    let lines: Vec<&str> = ran.out.lines().collect();
    assert_eq!((ran.code, lines.len(), lines[0]), (0, 5, "a.bdt: ok"));
    for (line, (start, end)) in lines[1..].iter().zip([
        ("a.bdt: ", " vertex checks passed, none failed"),
        ("a.bdt: 10 cases: a node in one of ", " poses"),
        ("a.bdt: smallest margin: ", " code)"),
        ("a.bdt: rounding adds ", " % to the mean radius at q_range"),
    ]) {
        assert!(line.starts_with(start) && line.ends_with(end), "{line}");
    }
    assert!(lines[3].contains("(sphere ") && lines[3].contains(" of node "));
    assert!(ran.err.is_empty());
}

/// Bounds of a file that breaks a rule are not tried.
#[test]
fn a_broken_file_is_not_tried() {
    let folder = Folder::new();
    let mut bytes = folder.read("a.bdt");
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    folder.write("bad.bdt", &bytes);
    let ran = folder.run(&["verify", "bad.bdt", "--stress", "--json"]);
    assert_eq!(ran.code, 1);
    let report: Value = serde_json::from_str(&ran.out).unwrap();
    assert!(report["stress"].is_null() && report["ok"] == false);
}
