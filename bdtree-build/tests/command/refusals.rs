//! What is refused, and that no file is lost or left behind by it.

use std::process::Command;

use super::{fixture, refused, run, text};

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
        &["--max-error-rel", "no frames or morph targets"],
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
    for (option, value, why) in [
        ("--max-error-rel", "1%", "not a number; write 0.01 for it"),
        ("--fps", "25,2", "not a number"),
        ("--young", "inf", "not a finite number"),
        ("--memory-limit", "2G", "not a whole number of at least 0"),
    ] {
        refused(&["a.obj", option, value], 2, &[option, why]);
    }
    // Only readers of OBJ and PLY files skip faces.
    for words in [&["a.glb"][..], &["."], &["--animation", "frames"]] {
        let why = "--skip-bad-faces is for ";
        refused(&[words, &["--skip-bad-faces"]].concat(), 2, &[why]);
    }
    refused(&["a.PLY.gz", "--skip-bad-faces"], 1, &["a.PLY.gz"]);
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
    // A baked file is not baked again.
    std::fs::write(path("a.bdt"), "baked").expect("file");
    for (arguments, why) in [
        (&["a.bdt"][..], "is a baked file already"),
        (&["a.bdt", "-o", "b.bdt"], "is a baked file already"),
    ] {
        let output = run(arguments, folder.path());
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        let message = text(&output.stderr);
        assert!(message.contains(why), "{message}");
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
