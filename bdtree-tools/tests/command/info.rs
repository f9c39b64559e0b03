//! `info`: fields, values, errors.

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use bdtree_build::basis::BasisError;
use bdtree_runtime::{Model, Transform};

use crate::support::{Folder, animated, baked_with_error, ball_mesh, bounds, character};

#[test]
fn json_has_every_field() {
    let folder = Folder::new();
    let info = folder.json(&["info", "a.bdt", "--json"]);
    let bytes = folder.read("a.bdt");
    let mesh = ball_mesh();
    assert_eq!(info["version"], "0.5");
    assert_eq!(info["bytes"], bytes.len());
    assert_eq!(info["vertices"], mesh.positions.len());
    assert_eq!(info["triangles"], mesh.triangles.len());
    assert_eq!(info["modes"], 3);
    assert!(info["nodes"].as_u64() > Some(1));
    assert!(info["depth"].as_u64() > Some(1));
    assert_eq!(info["origin"].as_array().map(Vec::len), Some(3));
    assert_eq!(info["q_limit"].as_array().map(Vec::len), Some(3));
    assert_eq!(info["q_range"], json!([2.0, 2.0, 2.0]));
    assert_eq!(
        info["source"],
        json!({"name": "ball.obj", "hash": "ab".repeat(32)})
    );
    let modes = info["mode_info"].as_array().unwrap();
    assert_eq!(
        modes[0],
        json!({"name": "stretch", "frequency_hz": 12.5 / std::f64::consts::TAU, "modal_mass_kg": 3.25,
               "default_q": null})
    );
    assert_eq!(
        modes[1],
        json!({"name": null, "frequency_hz": null, "modal_mass_kg": null, "default_q": null})
    );
    assert_eq!(modes.len(), 3);
    assert_eq!(info.get("frames"), Some(&Value::Null));
    let sections = info["sections"].as_array().unwrap();
    assert_eq!(sections[0]["kind"], "NODE");
    let last = sections.last().unwrap();
    assert_eq!(last["kind"], "META");
    let end = last["offset"].as_u64().unwrap() + last["bytes"].as_u64().unwrap();
    assert_eq!(end, bytes.len() as u64);
    let [low, high] = bounds(&mesh);
    for (name, corner) in [("min", low), ("max", high)] {
        for (k, expected) in corner.into_iter().enumerate() {
            let found = info["bounds"][name][k].as_f64().expect("a number");
            assert!((found - expected).abs() < 1e-6, "{name} {k}: {found}");
        }
    }
    assert_eq!(info.get("scale_m"), Some(&Value::Null));
    assert_eq!(info["warnings"], json!(["odd"]));
    assert_eq!(info["settings"], json!({"modes": "3"}));
    assert_eq!(
        info["groups"][3],
        json!({"kind": "group", "name": "bottom half", "first_triangle": 126, "triangles": 126})
    );
}

#[test]
fn levels_shrink_and_cover_the_mesh() {
    let folder = Folder::new();
    let info = folder.json(&["info", "a.bdt", "--json"]);
    let levels = info["levels"].as_array().unwrap();
    assert_eq!(Some(levels.len() as u64), info["depth"].as_u64());
    for (l, level) in levels.iter().enumerate() {
        assert_eq!(level["level"], l);
        assert!(level["spheres"].as_u64() > Some(0));
        assert!(level["radius_mean"].as_f64() <= level["radius_max"].as_f64());
    }
    // In mesh units: the spheres of the root are smaller than the ball, those below smaller yet.
    // Growth is that of the runtime's own spheres.
    let model = Model::read(folder.path("a.bdt")).expect("an asset");
    let asset = model.asset();
    let q: Vec<f32> = asset.modes().iter().map(|m| m.q_range.get()).collect();
    let [mut at_rest, mut moved] = [(); 2].map(|()| vec![0.0; asset.pose_len()]);
    let at_rest = asset
        .pose(&[0.0; 3], Transform::IDENTITY, &mut at_rest)
        .expect("a pose");
    let moved = asset
        .pose(&q, Transform::IDENTITY, &mut moved)
        .expect("a pose");
    for (l, found) in info["growth_mean"].as_array().unwrap().iter().enumerate() {
        let mut growths = Vec::new();
        for (i, node) in (0..).zip(asset.nodes()) {
            if usize::from(node.level) == l {
                let [a, b] =
                    [&moved, &at_rest].map(|pose| pose.node_spheres(i).expect("a node").radius);
                growths.extend(
                    node.lanes()
                        .map(|lane| f64::from(a[lane]) / f64::from(b[lane])),
                );
            }
        }
        let mean = growths.iter().sum::<f64>() / growths.len() as f64;
        // The pose at rest adds its rounding to the stored radii.
        let found = found.as_f64().expect("a number");
        assert!(
            (found / mean - 1.0).abs() < 1e-4 && found > 1.0,
            "{found} {mean}"
        );
    }
    let text = folder.run(&["info", "a.bdt"]).out;
    assert!(
        text.contains("growth       spheres at q_range are on average "),
        "{text}"
    );
    // The verdict is the bake's, which knows the smallest possible spheres.
    assert!(text.contains(" times as large as at rest\n"), "{text}");
    let text = folder.run(&["info", "rigid.bdt"]).out;
    let still = "growth       rigid: spheres do not grow\n";
    assert!(text.contains(still), "{text}");
    folder.write("bent.bdt", character("skinned_12.glb"));
    let text = folder.run(&["info", "bent.bdt"]).out;
    let still = "growth       spheres grow with the bones only: there are no modes\n";
    assert!(text.contains(still), "{text}");
    let largest = |l: usize| levels[l]["radius_max"].as_f64().unwrap();
    assert!((0.2..1.3).contains(&largest(0)), "{levels:?}");
    assert!(largest(levels.len() - 1) < largest(0));
}

#[test]
fn a_rigid_file_has_empty_lists() {
    let folder = Folder::new();
    let info = folder.json(&["info", "rigid.bdt", "--json"]);
    assert_eq!(info["modes"], 0);
    for field in ["q_limit", "q_range", "mode_info"] {
        assert_eq!(info[field], json!([]), "{field}");
    }
}

#[test]
fn text_names_the_facts() {
    let folder = Folder::new();
    let ran = folder.run(&["info", "a.bdt"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    for text in [
        "ball.obj",
        "given, 3 modes",
        "4 (1 object, 2 groups, 1 material)",
        "stretch",
        "setting      modes = 3",
        "warning      odd",
        "mesh units, diagonal ",
        &"ab".repeat(32),
    ] {
        assert!(ran.out.contains(text), "{text}: {}", ran.out);
    }
    // Sections are for those who ask; what no mode has is no column.
    assert!(!ran.out.contains("NODE"), "{}", ran.out);
    assert!(!ran.out.contains("default q"), "{}", ran.out);
    assert!(ran.out.contains("frequency [Hz]"), "{}", ran.out);
    let with_sections = folder.run(&["info", "a.bdt", "--sections"]).out;
    assert!(with_sections.contains("NODE"), "{with_sections}");
    let long = ran
        .out
        .split_whitespace()
        .filter(|word| word.parse::<f64>().is_ok());
    for word in long {
        let digits = word.split('e').next().unwrap_or_default();
        let digits = digits.trim_start_matches(['-', '0', '.']);
        assert!(!digits.contains('.') || digits.len() <= 8, "{word}");
    }
}

#[test]
fn bad_files_are_named() {
    let folder = Folder::new();
    folder.write("empty.bdt", "");
    folder.write("text.bdt", "x".repeat(200));
    folder.write("text.glb", "x".repeat(200));
    let mut short = folder.read("a.bdt");
    short.pop();
    folder.write("short.bdt", short);
    for (file, text) in [
        ("no.bdt", "no.bdt: cannot be read: "),
        (".", ".: cannot be read: "),
        (
            "empty.bdt",
            "empty.bdt: not a .bdt file: section HEAD at byte 0: the file has 0 bytes, its header needs 128 (SPEC 2.1",
        ),
        ("text.bdt", "text.bdt: not a .bdt file (SPEC 9.1"),
        (
            "text.glb",
            "text.glb: not a .bdt file: bake it first with `bdtree-build text.glb`",
        ),
        (
            "short.bdt",
            "short.bdt: damaged .bdt file: section HEAD at byte 16: the file has ",
        ),
    ] {
        let ran = folder.run(&["info", file, "--json"]);
        assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{file}");
        assert!(ran.err.starts_with(text), "{}", ran.err);
        assert_eq!(ran.err.lines().count(), 1);
    }
}

/// In the words of the bake.
#[test]
fn a_skin_is_described() {
    let folder = Folder::new();
    folder.write("tube.bdt", character("skinned_tube.glb"));
    let ran = folder.run(&["info", "tube.bdt"]);
    let line = "skin         4 joints, 4 bones, at most 4 influences of a vertex\n";
    assert!(ran.out.contains(line), "{}", ran.out);
}

/// The reader of `tests/python`, written from SPEC.md alone, prints the same values.
#[test]
fn another_reader_agrees() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folder = Folder::new();
    let example = root.join("format-spec/tests/example.bdt");
    let (mesh, basis) = (ball_mesh(), animated(&ball_mesh()));
    let error = BasisError {
        max_rel: 0.0125,
        rms_rel: 0.002,
        frame: Some(2),
        vertex: 17,
    };
    folder.write("moving.bdt", baked_with_error(&mesh, &basis, Some(error)));
    let files = ["a.bdt", "rigid.bdt", "moving.bdt"].map(|name| folder.path(name));
    let files = files.into_iter().chain([example]);
    for file in files {
        let file = file.to_str().expect("UTF-8");
        let ours = folder.json(&["info", file, "--json"]);
        let output = Command::new("python3")
            .arg(root.join("tests/python/bdt_reader.py"))
            .arg(file)
            .output()
            .expect("python3 runs (README: what the tests need)");
        let theirs: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        for (field, value) in theirs.as_object().expect("an object") {
            assert_eq!(&ours[field], value, "{file}: {field}");
        }
    }
    let mut reader = Command::new("python3");
    let output = reader.arg(root.join("tests/python/bdt_reader.py")).output();
    let output = output.expect("python3 runs");
    assert_eq!(output.status.code(), Some(2), "no file");
    assert!(output.stderr.starts_with(b"usage: "));
}
