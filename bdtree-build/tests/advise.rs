//! `bdtree-build --advise` from outside: no file, sentences, and a command line that does what they say.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

const PROGRAM: &str = env!("CARGO_BIN_EXE_bdtree-build");

fn fixture(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures");
    folder.join(name).display().to_string()
}

fn run(arguments: &[&str], folder: &Path) -> Output {
    Command::new(PROGRAM)
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the command starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

/// The JSON object of a run that succeeds and writes nothing.
fn advised(arguments: &[&str]) -> Value {
    let folder = folder();
    let arguments = [arguments, &["--advise", "--json"]].concat();
    let output = run(&arguments, folder.path());
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        text(&output.stderr)
    );
    let left: Vec<_> = std::fs::read_dir(folder.path()).expect("folder").collect();
    assert!(left.is_empty(), "{arguments:?} left {left:?}");
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

/// Sentences and last line of a run that succeeds.
fn told(arguments: &[&str], folder: &Path) -> (String, String) {
    let arguments = [arguments, &["--advise"]].concat();
    let output = run(&arguments, folder);
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        text(&output.stderr)
    );
    let all = text(&output.stdout);
    let (sentences, command) = all.trim_end().rsplit_once('\n').expect("two lines");
    (sentences.to_string(), command.to_string())
}

/// What a shell makes of a command line, with `--json` behind it.
fn baked(command: &str, folder: &Path) -> Value {
    let programs = PathBuf::from(PROGRAM);
    let output = Command::new("/bin/sh")
        .args(["-c", &format!("{command} --json")])
        .env("PATH", programs.parent().expect("a folder"))
        .current_dir(folder)
        .output()
        .expect("a shell");
    assert!(
        output.status.success(),
        "{command}: {}",
        text(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

#[test]
fn the_advised_command_keeps_its_promise() {
    let frames = fixture("wave");
    let morphs = fixture("morph_nodes.glb");
    for (arguments, goal) in [
        (
            &[
                "--animation",
                &frames,
                "--modes",
                "8",
                "--max-error-rel",
                "0.05",
            ][..],
            0.05,
        ),
        (&["--animation", &frames], 0.01),
        (&[&morphs, "--max-error-rel", "0.2"], 0.2),
    ] {
        let json = advised(arguments);
        assert_eq!(json["is_met"], true, "{json:#}");
        let (kept, error) = (
            &json["modes"],
            json["error_rel"].as_f64().expect("an error"),
        );
        assert!(error <= goal, "{error} over {goal}");
        let folder = folder();
        let arguments = [arguments, &["-o", "a b's.bdt"]].concat();
        let (_, command) = told(&arguments, folder.path());
        let bake = baked(&command, folder.path());
        assert!(folder.path().join("a b's.bdt").is_file());
        assert_eq!(&bake["modes"], kept, "{command}");
        let stated = bake["basis_error_rel"]["max"].as_f64().expect("an error");
        // Fewer modes are made anew: that may round otherwise.
        assert!(
            stated <= error * (1.0 + 1e-6) + 1e-7,
            "{command}: {stated}, not {error}"
        );
    }
}

/// The bytes that are stated are those of the file that the advised command writes, settings, error and warnings in its
/// metadata included.
#[test]
fn the_advised_file_has_the_stated_length() {
    let [frames, morphs, chair, cube, swells, tets] = [
        "wave",
        "morph_nodes.glb",
        "chair.obj",
        "cube.obj",
        "cube_swells.npy",
        "beam_tets.veg",
    ]
    .map(fixture);
    for arguments in [
        // No more than there are: that would be a warning which the advised command does not meet.
        &["--animation", &frames, "--modes", "4"][..],
        &[&morphs, "--max-error-rel", "0.2"],
        &[&cube, "--basis", &swells, "--max-error-rel", "0.06"],
        &["--tets", &tets, "--modes", "10", "--max-error-rel", "0.1"],
        &[
            &chair,
            "--modes",
            "10",
            "--resolution",
            "8",
            "--max-error-rel",
            "0.1",
        ],
    ] {
        let folder = folder();
        let arguments = [arguments, &["-o", "x.bdt"]].concat();
        let json = advised(&arguments);
        let command = json["command"].as_str().expect("a command");
        let bake = baked(command, folder.path());
        let file = std::fs::metadata(folder.path().join("x.bdt")).expect("a file");
        let (stated, made) = (&json["chosen"]["bytes"], file.len());
        println!(
            "{command}: {} of {} modes, {stated} bytes",
            json["modes"], json["all"]["modes"]
        );
        assert_eq!(stated.as_u64(), Some(made), "{command}: {bake:#}");
    }
}

#[test]
fn fewer_modes_are_good_enough_for_a_lax_goal() {
    let frames = fixture("wave");
    let arguments = ["--animation", &frames, "--modes", "8"];
    let mut last = usize::MAX;
    for goal in ["1e-4", "0.01", "0.1", "10"] {
        let json = advised(&[&arguments[..], &["--max-error-rel", goal]].concat());
        let kept = json["chosen"]["modes"].as_array().expect("modes").len();
        assert!(kept <= last, "{kept} modes for {goal}, {last} before");
        last = kept;
    }
    assert_eq!(last, 0, "ten diagonals need no mode");
    // How many modes were tried, and how many there are.
    let arguments = [
        "--animation",
        &frames,
        "--modes",
        "2",
        "--max-error-rel",
        "10",
    ];
    let (sentences, _) = told(&arguments, folder().path());
    assert!(
        sentences.starts_with("The first 0 of 2 modes ("),
        "{sentences}"
    );
    assert!(
        sentences.contains(" available) keep every vertex within "),
        "{sentences}"
    );
}

#[test]
fn counts_and_errors_are_the_same_twice() {
    let frames = fixture("wave");
    let runs = [(); 2].map(|()| {
        let mut json = advised(&["--animation", &frames, "--modes", "6"]);
        // Times decide on the leaf size.
        let object = json.as_object_mut().expect("an object");
        for name in ["command", "arguments", "sentences", "leaf_size", "chosen"] {
            assert!(object.remove(name).is_some(), "{name}");
        }
        let refining = object.remove("refining").expect("refined poses");
        assert!(refining["bytes"].as_u64() > Some(1000), "{refining:#}");
        assert!(
            refining["prepare_seconds"].as_f64() > Some(0.0),
            "{refining:#}"
        );
        for kind in ["ball", "ray"] {
            let gain = &refining[kind];
            for name in ["seconds", "refined_seconds"] {
                assert!(gain[name].as_f64() > Some(0.0), "{refining:#}");
            }
            assert!(gain["pays_from"].is_null() || gain["pays_from"].as_f64() > Some(0.0));
        }
        // Too few triangles for parts.
        assert!(refining["nearby"].is_null(), "{refining:#}");
        forget_times(&mut json);
        json
    });
    assert_eq!(runs[0], runs[1]);
    let works = &runs[0]["all"]["works"];
    for kind in ["ball", "ray", "pair"] {
        assert!(works[kind]["found"].as_u64() > Some(0), "{works:#}");
        assert!(works[kind]["nodes_visited"].as_u64() > Some(0), "{works:#}");
    }
    let curve = runs[0]["curve"].as_array().expect("a curve");
    assert!((2..=6).contains(&curve.len()), "{curve:?}");
}

fn forget_times(value: &mut Value) {
    match value {
        Value::Object(object) => {
            object.retain(|name, _| name != "seconds" && name != "time_rel");
            object.values_mut().for_each(forget_times);
        }
        Value::Array(values) => values.iter_mut().for_each(forget_times),
        _ => {}
    }
}

#[test]
fn a_goal_that_cannot_be_met_is_said_to_be_missed() {
    let frames = fixture("wave");
    let folder = folder();
    let arguments = [
        "--animation",
        &frames,
        "--modes",
        "1",
        "--max-error-rel",
        "1e-9",
    ];
    let json = advised(&arguments);
    assert_eq!(
        (&json["is_met"], &json["modes"]),
        (&false.into(), &1.into())
    );
    assert!(json["error_rel"].as_f64() > Some(1e-9));
    let (sentences, command) = told(
        &[&arguments[..], &["-o", "wave.bdt"]].concat(),
        folder.path(),
    );
    assert!(
        sentences.starts_with("1 mode leaves an error of ")
            && sentences.contains(" (goal: 1.00e-7 %). Allow more with --modes."),
        "{sentences}"
    );
    assert_eq!(baked(&command, folder.path())["modes"], 1);
    // Without a number all that there are are taken.
    let json = advised(&["--animation", &frames, "--max-error-rel", "1e-12"]);
    assert_eq!(json["is_met"], false);
    let all = json["all"]["modes"].as_array().map(Vec::len);
    assert_eq!(json["modes"].as_u64().map(|n| n as usize), all);
}

#[test]
fn what_is_missing_is_said() {
    let folder = folder();
    let [triangle, cube, swells, beam] = [
        "triangle.obj",
        "cube.obj",
        "cube_swells.npy",
        "beam_tets.veg",
    ]
    .map(fixture);
    for (arguments, parts) in [
        (
            &[triangle.as_str(), "--modes", "0"][..],
            &["is rigid", "rest pose"][..],
        ),
        (
            &[&triangle, "--modes", "2", "--resolution", "8"],
            &[
                "--range-rel",
                "no animation",
                "leaves out the vibration modes",
            ],
        ),
        (&[&cube, "--modes", "0"], &["is rigid"]),
        (
            &[&cube, "--basis", &swells],
            &["--range-rel", "no animation"],
        ),
        (
            &["--tets", &beam, "--modes", "3"],
            &["--range-rel", "leaves out the vibration modes"],
        ),
    ] {
        let arguments = [arguments, &["-o", "x.bdt"]].concat();
        let (sentences, command) = told(&arguments, folder.path());
        for part in parts {
            assert!(
                sentences.contains(part),
                "{arguments:?}: no `{part}` in {sentences}"
            );
        }
        assert!(!folder.path().join("x.bdt").exists());
        baked(&command, folder.path());
        std::fs::remove_file(folder.path().join("x.bdt")).expect("baked");
    }
    // With a range nothing is assumed.
    let (sentences, _) = told(
        &[&cube, "--basis", &swells, "--range-rel", "0.1"],
        folder.path(),
    );
    assert!(!sentences.contains("--range-rel"), "{sentences}");
}

#[test]
fn bad_input_is_refused_as_without_advice() {
    let folder = folder();
    for (name, part) in [
        ("bad_empty.obj", "bad_empty.obj"),
        ("bad_nan.obj", "bad_nan.obj:"),
        ("missing.obj", "missing.obj"),
    ] {
        let output = run(&[&fixture(name), "--advise"], folder.path());
        assert_eq!(output.status.code(), Some(1), "{name}");
        let stderr = text(&output.stderr);
        assert!(
            stderr.contains(part) && !stderr.contains("panicked"),
            "{stderr}"
        );
        assert!(output.stdout.is_empty());
    }
    for arguments in [
        &["a.obj", "--advise", "--quiet"][..],
        &["--advise"],
        &["a.obj", "--advise", "--max-error-rel", "0"],
        &["a.obj", "--advise", "--modes", "few"],
    ] {
        let output = run(arguments, folder.path());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn a_leaf_size_that_is_given_stays() {
    let torus = fixture("torus.obj");
    let arguments = [torus.as_str(), "--modes", "0", "--leaf-size", "3"];
    let json = advised(&arguments);
    assert_eq!(json["leaf_size"], 3);
    assert_eq!(json["leaves"].as_array().map(Vec::len), Some(1));
    let command = json["command"].as_str().expect("a command");
    assert!(command.ends_with("--leaf-size 3 --modes 0"), "{command}");
}
