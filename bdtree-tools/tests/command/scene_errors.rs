//! Scenes that are refused: every problem with its place, before the first line.

use serde_json::{Value, json};

use crate::support::Folder;

fn scene(instances: Value, queries: Value) -> Value {
    json!({"instances": instances, "queries": queries})
}

/// Exit code 1, nothing on the output, and what is on the error stream.
fn refused(folder: &Folder, text: &str) -> String {
    folder.write("scene.json", text);
    let ran = folder.run(&["query", "scene.json"]);
    assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{text}");
    ran.err
}

#[test]
fn instances_fit_their_assets() {
    let folder = Folder::new();
    let ball = json!({"ball": {"instance": "a", "center": [0, 0, 0], "radius": 1}});
    for (instance, expected) in [
        (
            json!({"name": "a", "asset": "a.bdt", "q": [1]}),
            "instances[0].q: q has 1 number, asset a.bdt has 3 modes",
        ),
        (
            json!({"name": "a", "asset": "rigid.bdt", "q": [1, 2]}),
            "instances[0].q: q has 2 numbers, asset rigid.bdt has 0 modes",
        ),
        (
            json!({"name": "a", "asset": "a.bdt", "q": [0, "1", 0]}),
            "instances[0].q[1]: expected a number, found a string",
        ),
        (
            json!({"name": "a", "asset": "a.bdt", "rotation": [0, 0, 0, 1.002]}),
            "instances[0].rotation: a quaternion of length 1.002, not within 1e-3 of 1",
        ),
        (
            json!({"name": "a", "asset": "a.bdt", "rotation": [0, 0, 1]}),
            "instances[0].rotation: expected 4 numbers, found 3",
        ),
        (
            json!({"name": "a", "asset": "a.bdt", "scale": -1}),
            "instances[0].scale: not positive",
        ),
        (
            json!({"name": "a", "asset": "a.bdt", "scale": [1, 1, 1]}),
            "instances[0].scale: expected a number, found a list",
        ),
        (
            json!({"name": "a", "asset": "a.bdt", "scale": 1e-30}),
            "instances[0].scale: not within 2^-60 to 2^60",
        ),
        (
            json!({"name": "a", "asset": "a.bdt", "translation": [0, 0, -1e25]}),
            "instances[0].translation[2]: beyond 2^80",
        ),
    ] {
        let text = scene(json!([instance]), json!([ball])).to_string();
        assert_eq!(
            refused(&folder, &text),
            format!("scene.json: {expected}\n"),
            "{text}"
        );
    }
    let far = json!([{"name": "a", "asset": "a.bdt", "q": [0, 1e30, -1e300]}]);
    let lines = refused(&folder, &scene(far, json!([])).to_string());
    let lines: Vec<&str> = lines.lines().collect();
    assert_eq!(lines.len(), 2, "{lines:?}");
    assert!(lines[0].starts_with("scene.json: instances[0].q[1]: 1000000"));
    assert!(lines[1].starts_with("scene.json: instances[0].q[2]: -1000000"));
    assert!(lines[1].contains(" exceeds the limit of "));
}

#[test]
fn names_are_unique_and_known() {
    let folder = Folder::new();
    let a = json!({"name": "a", "asset": "a.bdt"});
    let queries = json!([{"pair": {"a": "a", "b": "c"}}, {"pair": {"a": "a", "b": "a"}}]);
    assert_eq!(
        refused(&folder, &scene(json!([a, a]), queries).to_string()),
        "scene.json: instances[1].name: a second instance \"a\"\n\
         scene.json: queries[0].pair.b: unknown instance \"c\"\n\
         scene.json: queries[1].pair.b: the same instance as a\n"
    );
}

#[test]
fn broken_assets_are_told_once() {
    let folder = Folder::new();
    let mut bytes = folder.read("a.bdt");
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    folder.write("bad.bdt", bytes);
    let instances = json!([{"name": "a", "asset": "no.bdt"}, {"name": "b", "asset": "no.bdt"},
        {"name": "c", "asset": "bad.bdt"}, {"name": "d", "asset": "./bad.bdt"}]);
    let queries = json!([{"ball": {"instance": "d", "center": [0, 0, 0], "radius": -1}}]);
    let err = refused(&folder, &scene(instances.clone(), queries).to_string());
    let lines: Vec<&str> = err.lines().collect();
    assert_eq!(lines.len(), 3, "{err}");
    assert!(lines[0].starts_with("scene.json: instances[0].asset: no.bdt: cannot be read: "));
    let damaged =
        "scene.json: instances[2].asset: bad.bdt: damaged .bdt file: section META at byte ";
    assert!(lines[1].starts_with(damaged), "{err}");
    assert_eq!(lines[2], "scene.json: queries[0].ball.radius: negative");
    let only_bad = json!([instances[2]]);
    folder.write("scene.json", scene(only_bad, json!([])).to_string());
    let ran = folder.run(&["query", "scene.json", "--no-verify"]);
    assert_eq!((ran.code, ran.out.as_str(), ran.err.as_str()), (0, "", ""));
}

#[test]
fn the_third_radius_is_negative() {
    let folder = Folder::new();
    let ball =
        |radius: f64| json!({"ball": {"instance": "a", "center": [0, 0, 0], "radius": radius}});
    let queries = json!([ball(1.0), ball(2.0), ball(-1.0)]);
    let text = scene(json!([{"name": "a", "asset": "a.bdt"}]), queries).to_string();
    assert_eq!(
        refused(&folder, &text),
        "scene.json: queries[2].ball.radius: negative\n"
    );
}

#[test]
fn syntax_errors_have_line_and_column() {
    let folder = Folder::new();
    for (text, place) in [
        (
            "",
            "scene.json: not JSON: EOF while parsing a value at line 1 column 0\n",
        ),
        ("{\n  \"a\": 1,,\n}", "line 2 column 10\n"),
        (
            "{\"queries\": [], \"queries\": []}",
            "repeated key \"queries\" at line 1",
        ),
        (
            "{\"queries\": [1e999]}",
            "scene.json: number out of range at line 1 column ",
        ),
        (
            "{\"queries\": [NaN]}",
            "scene.json: not JSON (JSON has no NaN or Infinity): expected value at line 1 column 14\n",
        ),
        (
            "\u{feff}{}",
            "scene.json: begins with a byte order mark: save it without one\n",
        ),
        (
            "{} x",
            "scene.json: not JSON: trailing characters at line 1 column 4\n",
        ),
    ] {
        let err = refused(&folder, text);
        assert!(err.starts_with("scene.json: "), "{err}");
        assert!(err.contains(place), "{text}: {err}");
    }
    let ran = folder.run_with(&["query", "-"], "[");
    assert_eq!((ran.code, ran.out.as_str()), (1, ""));
    assert!(ran.err.starts_with("stdin: "));
    let ran = folder.run(&["query", "no.json"]);
    assert_eq!((ran.code, ran.out.as_str()), (1, ""));
    assert!(ran.err.starts_with("no.json: cannot be read: "));
}

#[test]
fn corrupt_records_are_an_error_not_a_panic() {
    let folder = Folder::new();
    let info = folder.json(&["info", "a.bdt", "--json"]);
    let sound = folder.read("a.bdt");
    let queries = json!([
        {"ball": {"instance": "a", "center": [10, -2.5, 0], "radius": 9}},
        {"closest": {"instance": "a", "point": [10, -2.5, 0]}},
        {"plane": {"instance": "a", "normal": [0, 0, 1], "offset": 100}},
        {"ray": {"instance": "a", "origin": [10, -2.5, 9], "direction": [0, 0, -1]}},
        {"capsule": {"instance": "a", "point1": [10, -2.5, 0], "point2": [9, 0, 0], "radius": 9}},
        {"box": {"instance": "a", "center": [10, -2.5, 0], "half_extents": [9, 9, 9]}},
        {"frustum": {"instance": "a", "planes": [[1, 0, 0, -10]]}},
        {"pair": {"a": "a", "b": "b", "tolerance": 10}}]);
    let instances = json!([{"name": "a", "asset": "bad.bdt"}, {"name": "b", "asset": "bad.bdt"}]);
    folder.write("scene.json", scene(instances, queries).to_string());
    for section in info["sections"].as_array().unwrap() {
        let start = section["offset"].as_u64().unwrap() as usize;
        let end = start + section["bytes"].as_u64().unwrap() as usize;
        for byte in [0x00, 0x7e, 0xff] {
            let mut bytes = sound.clone();
            bytes[start..end].fill(byte);
            folder.write("bad.bdt", bytes);
            let ran = folder.run(&["query", "scene.json", "--no-verify"]);
            assert!(ran.code == 0 || ran.code == 1, "{ran:?}");
            assert!(!ran.err.contains("panicked"), "{}", ran.err);
            if ran.code == 1 {
                assert!(ran.err.starts_with("scene.json: queries["), "{}", ran.err);
                assert!(ran.err.contains("damaged .bdt file"), "{}", ran.err);
            }
            if section["kind"] == "TRIS" && byte == 0xff {
                assert_eq!((ran.code, ran.out.as_str()), (1, ""));
                let place =
                    "scene.json: queries[0]: bad.bdt: damaged .bdt file: section TRIS at byte ";
                assert!(ran.err.starts_with(place), "{}", ran.err);
            }
            for command in [
                &["info"][..],
                &["deform", "--no-verify"],
                &["diff", "a.bdt"],
            ] {
                let ran = folder.run(&[command, &["bad.bdt"]].concat());
                assert!(!ran.err.contains("panicked"), "{command:?}: {}", ran.err);
            }
        }
    }
}

/// Another kind of file, and none.
#[test]
fn what_is_no_scene_is_named() {
    let folder = Folder::new();
    for (file, text) in [
        ("a.bdt", "a.bdt: not a JSON scene\n"),
        ("no.json", "no.json: cannot be read: "),
    ] {
        let ran = folder.run(&["query", file]);
        assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{file}");
        assert!(ran.err.starts_with(text), "{}", ran.err);
        assert_eq!(ran.err.lines().count(), 1, "{}", ran.err);
    }
}
