//! The `bdtree-build` command from outside: exit codes, messages with their place, whole files or
//! none.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../fixtures")
        .join(name)
}

fn run(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bdtree-build"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the command starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs, expects exit code `code` and every one of `parts` on stderr, and no file left behind.
fn refused(arguments: &[&str], code: i32, parts: &[&str]) {
    let folder = tempfile::tempdir().expect("a folder");
    let output = run(arguments, folder.path());
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {stderr}");
    for part in parts {
        assert!(
            stderr.contains(part),
            "{arguments:?}: no `{part}` in: {stderr}"
        );
    }
    assert!(!stderr.contains("panicked"), "{stderr}");
    let left: Vec<_> = std::fs::read_dir(folder.path()).expect("folder").collect();
    assert!(left.is_empty(), "{arguments:?} left {left:?}");
}

#[test]
fn bakes_beside_the_input_and_reports() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::copy(fixture("torus.obj"), folder.path().join("ring.obj")).expect("copy");
    let output = run(
        &["ring.obj", "--modes", "4", "--resolution", "12", "--json"],
        folder.path(),
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    for field in [
        "vertices",
        "triangles",
        "modes",
        "nodes",
        "depth",
        "bytes",
        "warnings",
        "stages",
        "frequencies_hz",
        "basis_error_rel",
        "tightness",
    ] {
        assert!(json.get(field).is_some(), "no field {field}");
    }
    assert_eq!(json["modes"], 4);
    assert_eq!(json["triangles"], 2304);
    assert_eq!(json["frequencies_hz"].as_array().map(Vec::len), Some(4));
    assert!(json["basis_error_rel"].is_null());
    let bytes = std::fs::metadata(folder.path().join("ring.bdt")).expect("ring.bdt");
    assert_eq!(json["bytes"].as_u64(), Some(bytes.len()));
}

#[test]
fn the_same_bytes_for_any_thread_count_and_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = fixture("icosphere.obj").display().to_string();
    let mut files = Vec::new();
    for (name, threads) in [("a.bdt", "1"), ("b.bdt", "2"), ("c.bdt", "2")] {
        let arguments = [
            &input,
            "--modes",
            "7",
            "--resolution",
            "10",
            "-o",
            name,
            "--threads",
            threads,
            "--quiet",
        ];
        let output = run(&arguments, folder.path());
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(output.stdout.is_empty() && output.stderr.is_empty());
        files.push(std::fs::read(folder.path().join(name)).expect(name));
    }
    assert!(files[0] == files[1] && files[1] == files[2]);
}

#[test]
fn rigid_and_gzipped() {
    let folder = tempfile::tempdir().expect("a folder");
    let packed = folder.path().join("ball.obj.gz");
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    let plain = std::fs::read(fixture("icosphere.obj")).expect("fixture");
    std::io::Write::write_all(&mut encoder, &plain).expect("gzip");
    std::fs::write(&packed, encoder.finish().expect("gzip")).expect("file");
    let output = run(&["ball.obj.gz", "--modes", "0", "--json"], folder.path());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(json["modes"], 0);
    assert!(json["frequencies_hz"].is_null());
    assert!(folder.path().join("ball.bdt").is_file());
}

#[test]
fn bad_input_names_its_place_and_leaves_nothing() {
    let path = |name: &str| fixture(name).display().to_string();
    let out = ["-o", "out.bdt"];
    let bake =
        |name: &str| -> Vec<String> { [&path(name), out[0], out[1]].map(str::to_owned).to_vec() };
    for (name, parts) in [
        ("bad_empty.obj", vec!["bad_empty.obj"]),
        ("bad_no_faces.obj", vec!["bad_no_faces.obj", "face"]),
        ("bad_no_vertices.obj", vec!["bad_no_vertices.obj"]),
        ("bad_utf16.obj", vec!["bad_utf16.obj", "UTF-16"]),
        ("bad_truncated.obj", vec!["bad_truncated.obj:"]),
        ("bad_nan.obj", vec!["bad_nan.obj:"]),
        ("bad_index_zero.obj", vec!["bad_index_zero.obj:"]),
        ("bad_index_range.obj", vec!["bad_index_range.obj:"]),
        (
            "bad_numbers.obj",
            vec!["bad_numbers.obj:15", "bad_numbers.obj:21"],
        ),
        ("missing.obj", vec!["missing.obj"]),
    ] {
        let arguments = bake(name);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        refused(&arguments, 1, &parts);
    }
    let torus = path("torus.obj");
    refused(
        &[&torus, "--modes", "300", "--resolution", "2", "-o", "x.bdt"],
        1,
        &["modes"],
    );
    refused(
        &[
            &torus,
            "--resolution",
            "1024",
            "--memory-limit",
            "200",
            "-o",
            "x.bdt",
        ],
        1,
        &["resolution"],
    );
    refused(
        &[&torus, "--modes", "0", "-o", "no/such/folder/x.bdt"],
        1,
        &["no/such/folder"],
    );
    refused(
        &[&torus, "--basis", "none.npy", "-o", "x.bdt"],
        1,
        &["none.npy"],
    );
    refused(
        &[&torus, "--fix", "xyz:nogroup", "-o", "x.bdt"],
        1,
        &["nogroup"],
    );
    let folder = tempfile::tempdir().expect("a folder");
    let own = folder.path().join("mesh.obj");
    std::fs::copy(fixture("torus.obj"), &own).expect("copy");
    let output = run(
        &["mesh.obj", "--modes", "0", "-o", "mesh.obj"],
        folder.path(),
    );
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("is an input"));
    assert_eq!(
        std::fs::read(own).expect("kept"),
        std::fs::read(fixture("torus.obj")).expect("fixture")
    );
    let output = run(&["mesh.obj", "--modes", "0"], folder.path());
    assert_eq!(output.status.code(), Some(0));
    let output = run(
        &["mesh.obj", "--modes", "0", "--young", "1e6"],
        folder.path(),
    );
    assert!(text(&output.stderr).contains("--young is not used"));
    for option in ["--animation", "--tets"] {
        refused(&[option, "x.nothing"], 1, &["x.nothing"]);
    }
    // What is read, but not as the mesh.
    refused(&[&path("beam_tets.veg")], 1, &["--tets"]);
    refused(&[&path("wave.pc2")], 1, &["--animation"]);
    refused(
        &["--animation", &path("wave.pc2")],
        1,
        &["wave.pc2", "mesh"],
    );
    refused(
        &[&torus, "--animation", &path("wave.pc2")],
        1,
        &["wave.pc2", "1152"],
    );
    refused(
        &["--animation", &path("bad_wave_count")],
        1,
        &["bad_wave_count"],
    );
    refused(
        &["--tets", &path("bad_volume_flat.veg")],
        1,
        &["bad_volume_flat.veg"],
    );
    refused(
        &[&path("bad_gltf_accessor.glb")],
        1,
        &["bad_gltf_accessor.glb"],
    );
    refused(
        &[&torus, "--modes", "auto", "--max-error-rel", "0.01"],
        1,
        &["--modes auto", "no source"],
    );
}

#[test]
fn usage_errors_exit_with_2() {
    refused(&[], 2, &["INPUT"]);
    refused(&["a.obj", "--modes", "many"], 2, &["--modes"]);
    refused(&["a.obj", "--modes", "513"], 2, &["512"]);
    refused(&["a.obj", "--modes", "auto"], 2, &["--max-error-rel"]);
    refused(&["a.obj", "--max-error-rel", "0"], 2, &["--max-error-rel"]);
    refused(&["a.obj", "--range-rel", "0"], 2, &["--range-rel"]);
    refused(&["a.obj", "--young", "0"], 2, &["--young"]);
    refused(&["a.obj", "--poisson", "0.5"], 2, &["--poisson"]);
    refused(&["--animation", "a", "--fps", "0"], 2, &["--fps"]);
    refused(&["a.obj", "--align"], 2, &["--animation"]);
    refused(&["--animation", "a", "--tets", "b"], 2, &["--tets"]);
    refused(&["--tets", "a.veg", "--mass", "heavy"], 2, &["consistent"]);
    refused(
        &["a.obj", "--modes", "3", "--max-error-rel", "0.1"],
        2,
        &["--modes 3", "--max-error-rel"],
    );
    refused(&["a.obj", "--leaf-size", "0"], 2, &["--leaf-size"]);
    refused(&["a.obj", "--no-such-option"], 2, &["--no-such-option"]);
    refused(&["a.obj", "--fix", "w:0,0,0,1,1,1"], 2, &["--fix"]);
}

/// Negative numbers are numbers: what refuses them is the option, which names its range.
#[test]
fn negative_values_are_refused_by_their_option() {
    for (option, value, why) in [
        ("--modes", "-1", "0 to 512"),
        ("--young", "-5", "positive number"),
        ("--density", "-1e3", "positive number"),
        ("--scale", "-0.5", "positive number"),
        ("--thickness", "-1", "positive number"),
        ("--range-rel", "-1", "positive number"),
        ("--resolution", "-4", "1..=1024"),
        ("--leaf-size", "-1", "1..=255"),
        ("--memory-limit", "-1", "--memory-limit"),
        ("--threads", "-2", "--threads"),
    ] {
        for words in [
            vec!["a.obj", option, value],
            vec!["a.obj", &format!("{option}={value}")],
        ] {
            let output = run(&words, std::path::Path::new("."));
            let message = text(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{words:?}: {message}");
            assert!(
                message.contains(why) && message.contains(option),
                "{words:?}: {message}"
            );
            assert!(!message.contains("unexpected"), "{words:?}: {message}");
        }
    }
}

/// Nothing that the bake reads, and nothing that is no `.bdt` file, is overwritten.
#[test]
fn inputs_and_other_files_are_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    for name in ["torus.obj", "wave.npy", "beam_tets.veg"] {
        std::fs::copy(fixture(name), path(name)).expect("copy");
    }
    std::fs::copy(fixture("wave/wave_00.obj"), path("wave.obj")).expect("copy");
    std::fs::create_dir(path("frames")).expect("folder");
    std::fs::copy(fixture("wave/wave_00.obj"), path("frames/0.obj")).expect("copy");
    std::fs::write(path("notes.txt"), "mine").expect("notes");
    for arguments in [
        &["torus.obj", "--modes", "0", "-o", "torus.obj"][..],
        &["wave.obj", "--animation", "wave.npy", "-o", "wave.npy"],
        &["--tets", "beam_tets.veg", "-o", "beam_tets.veg"],
        &["torus.obj", "--modes", "0", "-o", "notes.txt"],
        &["--animation", "frames", "-o", "frames/1.obj"],
    ] {
        let before = arguments.last().map(|name| std::fs::read(path(name)).ok());
        let output = run(arguments, folder.path());
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        let after = arguments.last().map(|name| std::fs::read(path(name)).ok());
        assert!(before == after, "{arguments:?}");
    }
    // What is a .bdt file may be replaced, whatever its name.
    for _ in 0..2 {
        let output = run(
            &["torus.obj", "--modes", "0", "-o", "asset.bin"],
            folder.path(),
        );
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
}

/// Files hold no folders: an absolute and a relative path give the same bytes.
#[test]
fn bytes_do_not_depend_on_how_a_path_is_typed() {
    let folder = tempfile::tempdir().expect("a folder");
    std::os::unix::fs::symlink(fixture(""), folder.path().join("data")).expect("link");
    let absolute = fixture("").display().to_string();
    for arguments in [
        &["D/slivers.obj", "--modes", "0"][..],
        &["D/strips_fans.glb", "--modes", "0"],
        &["D/wave/wave_00.obj", "--animation", "D/wave.npy"],
        &["--animation", "D/wave/"],
        &["--tets", "D/mirrored_tets.veg", "--modes", "2"],
        &["--tets", "D/block_hex.veg", "--modes", "2"],
    ] {
        let bytes = |place: &str, name: &str| {
            let own = arguments
                .iter()
                .map(|a| a.replace("D/", place))
                .chain(["-o".into(), name.into()]);
            let own: Vec<String> = own.collect();
            let own: Vec<&str> = own.iter().map(String::as_str).collect();
            baked(&own, folder.path());
            std::fs::read(folder.path().join(name)).expect("file")
        };
        let (a, b) = (
            bytes("data/", "a.bdt"),
            bytes(&format!("{absolute}/"), "b.bdt"),
        );
        assert!(a == b, "{arguments:?}");
        let has = |text: &[u8]| a.windows(text.len()).any(|w| w == text);
        assert!(!has(absolute.as_bytes()) && !has(b"data/"), "{arguments:?}");
    }
}

/// Runs with `--json`, expects success, and gives the object.
fn baked(arguments: &[&str], folder: &Path) -> Value {
    let output = run(&[arguments, &["--json"]].concat(), folder);
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

#[test]
fn frames_become_modes_and_play() {
    let folder = tempfile::tempdir().expect("a folder");
    std::os::unix::fs::symlink(fixture("wave"), folder.path().join("my.frames")).expect("link");
    let json = baked(&["--animation", "my.frames/", "--fps", "30"], folder.path());
    assert!(folder.path().join("my.frames.bdt").is_file());
    assert_eq!(json["frames"], 6);
    assert!(json["basis_error_rel"]["max"].as_f64() < Some(1e-6));
    assert!(json["frequencies_hz"].is_null());
    let duration = json["duration_s"].as_f64().expect("times");
    assert!((duration - 5.0 / 30.0).abs() < 1e-9);
    let bounds = &json["bounds"];
    assert!(bounds["min"][0].as_f64() < bounds["max"][0].as_f64());
    let bytes = std::fs::read(folder.path().join("my.frames.bdt")).expect("a file");
    let model = bdtree_runtime::Model::from_bytes(&bytes).expect("a file");
    let metadata = bdtree_format::Metadata::from_bytes(model.asset().metadata()).expect("metadata");
    assert_eq!(metadata.settings["modes"], "10");
    let modes = json["modes"].as_u64();

    let wave = fixture("wave.pc2").display().to_string();
    let mesh = fixture("wave/wave_00.obj").display().to_string();
    let limit = ["--modes", "auto", "--max-error-rel", "0.05", "--align"];
    let arguments = [
        &[mesh.as_str(), "--animation", &wave, "-o", "few.bdt"],
        &limit[..],
    ]
    .concat();
    let json = baked(&arguments, folder.path());
    assert!(json["modes"].as_u64() < modes);
    let error = &json["basis_error_rel"];
    let (max, rms) = (error["max"].as_f64(), error["rms"].as_f64());
    assert!(max <= Some(0.05) && rms < max && rms > Some(0.0));
    assert!(error["frame"].is_u64() && error["vertex"].is_u64());
}

#[test]
fn morph_targets_are_modes() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = fixture("morph_nodes.glb").display().to_string();
    let all = baked(&[&input, "-o", "all.bdt"], folder.path());
    let warnings = |more: &[&str]| {
        let arguments = [&[input.as_str(), "-o", "all.bdt"], more].concat();
        text(&run(&arguments, folder.path()).stderr)
    };
    // Warnings name the file as it was given.
    let told = warnings(&[]);
    let start =
        format!("bdtree-build: warning: {input}: 2 animations move weights; \"talk\", the first");
    assert!(told.contains(&start), "{told}");
    let told = warnings(&["--clip", "talk"]);
    assert!(!told.contains("animations move weights"), "{told}");
    let count = all["modes"].as_u64().expect("modes");
    assert!(count >= 2 && all["frames"].is_u64());
    let one = baked(&[&input, "-o", "one.bdt", "--modes", "1"], folder.path());
    assert_eq!(one["modes"], 1);
    let error = |json: &Value| json["basis_error_rel"]["max"].as_f64().expect("error");
    assert!(error(&one) > 0.01 && error(&all) < 1e-6);
    let limit = error(&one).to_string();
    let arguments = [&input, "-o", "auto.bdt", "--max-error-rel", &limit];
    let auto = baked(&arguments, folder.path());
    assert!(auto["modes"].as_u64() < Some(count) && error(&auto) <= error(&one));
    let none = baked(&[&input, "-o", "none.bdt", "--modes", "0"], folder.path());
    assert!(none["modes"] == 0 && error(&none) >= error(&one));
}

#[test]
fn volumes_give_modes_to_their_surface_or_to_a_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    let tets = fixture("beam_tets.veg").display().to_string();
    let bake = |more: &[&str]| {
        let arguments = [
            &["--tets", tets.as_str(), "-o", "beam.bdt", "--modes", "6"],
            more,
        ]
        .concat();
        baked(&arguments, folder.path())
    };
    let own = bake(&[]);
    assert_eq!(own["frequencies_hz"].as_array().map(Vec::len), Some(6));
    assert!(own["volume"]["elements"].as_u64() > Some(10));
    let lumped = bake(&["--mass", "lumped"]);
    let first = |json: &Value| json["frequencies_hz"][0].as_f64().expect("frequency");
    assert!(first(&lumped) < first(&own));
    // Any mesh near it can be carried along.
    let mesh = folder.path().join("skin.obj");
    std::fs::write(
        &mesh,
        "v 0.1 0.1 0.1\nv 0.4 0.1 0.1\nv 0.1 0.2 0.1\nf 1 2 3\n",
    )
    .expect("mesh");
    let skin = bake(&["skin.obj"]);
    assert_eq!(skin["vertices"], 3);
    assert_eq!(skin["frequencies_hz"], own["frequencies_hz"]);
}

#[test]
fn ranges_are_a_share_of_the_diagonal() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = fixture("beam.obj").display().to_string();
    let mean = |share: &str| {
        let arguments = [
            &input,
            "--modes",
            "3",
            "--resolution",
            "20",
            "-o",
            "x.bdt",
            "--range-rel",
            share,
        ];
        let json = baked(&arguments.map(AsRef::as_ref), folder.path());
        json["tightness"][0]["mean"].as_f64().expect("tightness")
    };
    // Farther out spheres grow more.
    assert!(mean("0.2") > mean("0.02"));
}

/// What the summary says of animations and rigid meshes, and of faces that are bad.
#[test]
fn summaries_and_refusals_say_what_to_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let wave = fixture("wave").display().to_string();
    let said = |arguments: &[&str]| {
        let ran = run(arguments, folder.path());
        assert!(ran.status.success(), "{}", text(&ran.stderr));
        (text(&ran.stdout), text(&ran.stderr))
    };
    let (summary, _) = said(&["--animation", &wave, "-o", "w.bdt", "--modes", "2"]);
    for part in [
        "animation: 6 frames, times unknown (give --fps)\n",
        "error of the basis: at most ",
        " % of the diagonal (vertex ",
        "sphere radius over the smallest possible, per level: ",
    ] {
        assert!(summary.contains(part), "no `{part}` in {summary}");
    }
    let (summary, _) = said(&["--animation", &wave, "-o", "w.bdt", "--fps", "10"]);
    assert!(
        summary.contains("animation: 6 frames, 0.5 s\n"),
        "{summary}"
    );
    let cube = fixture("cube.obj").display().to_string();
    let (summary, _) = said(&[&cube, "-o", "c.bdt", "--modes", "0"]);
    assert!(
        summary.contains("spheres do not grow: no mode moves anything\n"),
        "{summary}"
    );
    assert!(!summary.contains("smallest possible"), "{summary}");

    let mut mesh = std::fs::read_to_string(fixture("cube.obj")).expect("a fixture");
    let line = mesh.lines().count() + 1;
    let vertices = mesh.lines().filter(|line| line.starts_with("v ")).count();
    mesh += "f 1 2 99999999\nf 1 1 2\nf 1 2 x\n";
    std::fs::create_dir(folder.path().join("in")).expect("a folder");
    std::fs::write(folder.path().join("in/bad.obj"), mesh).expect("written");
    let wrong = format!("corner 3 `99999999` is out of range: the file has {vertices} vertices");
    let arguments = ["in/bad.obj", "-o", "b.bdt", "--modes", "0"];
    let told = text(&run(&arguments, folder.path()).stderr);
    let all = format!(
        "bdtree-build: in/bad.obj:{line}: {wrong} (--skip-bad-faces leaves such faces out)\n"
    );
    assert!(told.contains(&all), "{told}");
    assert_eq!(told.matches("--skip-bad-faces").count(), 1, "{told}");
    let (_, told) = said(&[&arguments[..], &["--skip-bad-faces"]].concat());
    let told: Vec<&str> = told.lines().collect();
    let warning = "bdtree-build: warning: in/bad.obj";
    assert_eq!(told[0], format!("{warning}:{line}: skipped: {wrong}"));
    assert!(
        told[1].starts_with(&format!("{warning}:{}: triangle ", line + 1)),
        "{told:?}"
    );
    assert!(
        told[2].starts_with(&format!("{warning}:{}: skipped: corner 3", line + 2)),
        "{told:?}"
    );
    refused(&["."], 1, &["bdtree-build: "]);
    refused(
        &[&cube, "--modes", "0", "-o", "."],
        1,
        &["bdtree-build: . is a folder: name a file\n"],
    );
}

/// A full disk: the old file stays, nothing else is left.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_keeps_the_old_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let target = folder.path().join("ball.bdt");
    std::fs::write(&target, b"old").expect("old file");
    // A limit on the size of files stands in for a full disk: writes fail the same way.
    let output = Command::new("bash")
        .args([
            "-c",
            "trap '' XFSZ; ulimit -f 8; exec \"$0\" \"$1\" --modes 0 -o ball.bdt",
        ])
        .arg(env!("CARGO_BIN_EXE_bdtree-build"))
        .arg(fixture("torus.obj"))
        .current_dir(folder.path())
        .output()
        .expect("bash");
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("ball.bdt"));
    assert_eq!(std::fs::read(&target).expect("old file"), b"old");
    assert_eq!(std::fs::read_dir(folder.path()).expect("folder").count(), 1);
}

/// A folder can hold nothing but frames.
#[test]
fn a_folder_as_input_holds_frames() {
    let folder = tempfile::tempdir().expect("a folder");
    std::os::unix::fs::symlink(fixture("wave"), folder.path().join("wave")).expect("link");
    let json = baked(&["wave", "--fps", "30"], folder.path());
    assert_eq!(json["frames"], 6);
    let given = folder.path().join("given.bdt");
    let option = baked(
        &["--animation", "wave", "--fps", "30", "-o", "given.bdt"],
        folder.path(),
    );
    assert_eq!(option["frames"], 6);
    let bytes = |path: PathBuf| std::fs::read(path).expect("a file");
    assert_eq!(bytes(folder.path().join("wave.bdt")), bytes(given));
    let cube = fixture("cube.obj").display().to_string();
    for option in [&["--align"][..], &["--fps", "30"], &["--about", "input"]] {
        let arguments = [&[cube.as_str()], option].concat();
        refused(
            &arguments,
            2,
            &[option[0], "needs frames: give --animation"],
        );
    }
}

#[test]
fn bad_faces_are_grouped_or_skipped() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut mesh =
        String::from_utf8(std::fs::read(fixture("cube.obj")).expect("a fixture")).expect("a text");
    for _ in 0..201 {
        mesh += "\nf 1 2";
    }
    std::fs::write(folder.path().join("many.obj"), mesh).expect("written");
    let ran = run(&["many.obj", "--modes", "0"], folder.path());
    let told = text(&ran.stderr);
    assert_eq!(
        (ran.status.code(), told.lines().count()),
        (Some(1), 2),
        "{told}"
    );
    assert!(
        told.contains("found 2 (and 99 problems like it, at line "),
        "{told}"
    );
    assert!(told.contains("101 more problems"), "{told}");
    let json = baked(
        &["many.obj", "--modes", "0", "--skip-bad-faces"],
        folder.path(),
    );
    let warnings = json["warnings"].as_array().expect("a list");
    assert_eq!(warnings.len(), 6);
    assert_eq!(
        warnings[5],
        "many.obj: skipped 201 bad faces: triangle ids count the others"
    );
}

#[test]
fn unknown_groups_are_told_which_there_are() {
    let refuse = |name: &str, parts: &[&str]| {
        let mesh = fixture(name).display().to_string();
        let fix = ["--fix", "xyz:sofa", "--resolution", "4", "-o", "out.bdt"];
        refused(&[&[mesh.as_str()], &fix[..]].concat(), 1, parts);
    };
    refuse("cube.obj", &["--fix sofa: ", "the mesh has no groups"]);
    refuse("groups_unused.obj", &["--fix sofa: ", "its groups are \""]);
}

/// The summary says how large the mesh is, and warns where its unit is probably not the meter.
#[test]
fn sizes_are_told_and_doubted() {
    let folder = tempfile::tempdir().expect("a folder");
    let cube = std::fs::read_to_string(fixture("cube.obj")).expect("a fixture");
    let large: String = cube
        .lines()
        .map(|line| match line.strip_prefix("v ") {
            Some(position) => {
                let grown = position.split_whitespace().map(|x| format!("{x}e3"));
                format!("v {}\n", grown.collect::<Vec<_>>().join(" "))
            }
            None => format!("{line}\n"),
        })
        .collect();
    std::fs::write(folder.path().join("large.obj"), large).expect("written");
    let bake = |options: &[&str]| {
        let arguments = [&["large.obj", "--modes", "2", "--resolution", "4"], options].concat();
        let ran = run(&arguments, folder.path());
        assert!(ran.status.success(), "{}", text(&ran.stderr));
        (text(&ran.stdout), text(&ran.stderr))
    };
    let (summary, warnings) = bake(&[]);
    assert!(summary.contains("1 mesh unit = 1 m (--scale)"), "{summary}");
    assert!(
        summary.contains("size: ") && summary.contains("bounds: spheres are "),
        "{summary}"
    );
    assert!(
        warnings.contains("give --scale (meters per mesh unit) if that is wrong"),
        "{warnings}"
    );
    let (summary, warnings) = bake(&["--scale", "0.001"]);
    assert!(
        summary.contains("1 mesh unit = 0.001 m (--scale)"),
        "{summary}"
    );
    assert_eq!(warnings, "");
}
