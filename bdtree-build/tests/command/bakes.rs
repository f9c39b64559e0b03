//! What is baked from which input.

use std::path::PathBuf;

use serde_json::Value;

use super::{baked, fixture, refused, run, text};

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
    // A folder that is odd, so that warnings name it.
    let frames = folder.path().join("odd");
    std::fs::create_dir(&frames).expect("a folder");
    for name in ["w_9.obj", "w_10.obj", "notes.txt"] {
        std::fs::copy(fixture("wave/wave_00.obj"), frames.join(name)).expect("a copy");
    }
    let bytes = |input: &str, from: &std::path::Path| {
        let output = folder.path().join("out.bdt").display().to_string();
        let warnings = baked(&[input, "--modes", "1", "-o", &output], from);
        assert!(
            warnings["warnings"]
                .as_array()
                .is_some_and(|all| all.len() > 1)
        );
        std::fs::read(output).expect("file")
    };
    let plain = bytes("odd", folder.path());
    for (input, from) in [
        ("odd/", folder.path()),
        ("./odd/.", folder.path()),
        (".", &frames),
        ("../odd", &frames),
    ] {
        assert!(bytes(input, from) == plain, "{input}");
    }
    // Beside the folder, so that the next bake does not find it among the frames.
    let beside = folder.path().join("odd.bdt");
    std::fs::remove_file(&beside).ok();
    baked(&[".", "--modes", "2"], &frames);
    assert!(beside.is_file());
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
