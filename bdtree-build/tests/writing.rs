//! What `bdtree-build` leaves behind where writing goes wrong: the old file or none, one clear
//! error, no half file.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Instant;

use bdtree_fixtures::bake::bumpy_sphere;
use bdtree_fixtures::processes::{kill_while_writing, on_full_disk, set_mode, unprivileged};

const PROGRAM: &str = env!("CARGO_BIN_EXE_bdtree-build");

/// A folder with `ball.obj` and `small.obj`, open to everyone.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    set_mode(folder.path(), 0o755);
    for (name, n) in [("ball.obj", 70), ("small.obj", 20)] {
        let mesh = bumpy_sphere(n, 1);
        let vertices = mesh.positions.iter();
        let mut text: String = vertices
            .map(|[x, y, z]| format!("v {x} {y} {z}\n"))
            .collect();
        for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|i| i + 1)) {
            text += &format!("f {a} {b} {c}\n");
        }
        fs::write(folder.path().join(name), text).expect("a mesh");
    }
    folder
}

fn rigid(input: &str, output: &str, folder: &Path) -> Command {
    let mut command = Command::new(PROGRAM);
    command
        .args([input, "--modes", "0", "--quiet", "-o", output])
        .current_dir(folder);
    command
}

/// Exit code 1, one line that names `place` and says `message`.
fn refused(output: &Output, place: &str, message: &str) {
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert_eq!(text.lines().count(), 1, "{text}");
    assert!(
        text.starts_with(&format!("bdtree-build: {place}")),
        "{text}"
    );
    assert!(text.contains(message), "no `{message}` in {text}");
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut paths: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
    paths.sort();
    paths
}

#[test]
fn a_killed_bake_leaves_the_old_file_or_none() {
    let folder = folder();
    let target = folder.path().join("out.bdt");
    let begin = Instant::now();
    let status = rigid("ball.obj", "out.bdt", folder.path()).status();
    assert!(status.expect("the command starts").success());
    let time = begin.elapsed();
    let new = fs::read(&target).expect("a file");
    let command = || rigid("ball.obj", "out.bdt", folder.path());
    let result = kill_while_writing(command, &target, &new, time, 40);
    println!("{result:?}, {} bytes, {time:?}", new.len());
    assert!(result.killed > 10, "{result:?}");
    assert_eq!(entries(folder.path()).len(), 2);
}

#[test]
fn two_bakes_to_one_file_leave_one_of_both() {
    let folder = folder();
    let target = folder.path().join("out.bdt");
    let alone = ["ball.obj", "small.obj"].map(|input| {
        let status = rigid(input, "out.bdt", folder.path()).status();
        assert!(status.expect("the command starts").success());
        fs::read(&target).expect("a file")
    });
    assert_ne!(alone[0], alone[1]);
    for _ in 0..4 {
        let inputs = ["ball.obj", "small.obj", "ball.obj", "small.obj"];
        let children = inputs.map(|input| {
            let child = rigid(input, "out.bdt", folder.path()).spawn();
            child.expect("the command starts")
        });
        for mut child in children {
            assert!(child.wait().expect("a child").success());
        }
        assert!(alone.contains(&fs::read(&target).expect("a file")));
        assert_eq!(entries(folder.path()).len(), 3, "temporary files are gone");
    }
}

#[test]
fn a_read_only_folder_is_refused() {
    let test = "a_read_only_folder_is_refused";
    let Some(mut command) = unprivileged(test, PROGRAM) else {
        return;
    };
    let folder = folder();
    let locked = folder.path().join("locked");
    fs::create_dir(&locked).expect("a folder");
    fs::write(locked.join("out.bdt"), b"old").expect("a file");
    set_mode(&locked, 0o555);
    let output = command
        .args(["ball.obj", "--modes", "0", "-o", "locked/new.bdt"])
        .current_dir(folder.path())
        .output()
        .expect("the command starts");
    refused(
        &output,
        "locked/new.bdt",
        "folder locked does not allow new files\n",
    );
    assert_eq!(fs::read(locked.join("out.bdt")).expect("old"), b"old");
    assert_eq!(entries(&locked).len(), 1);
    set_mode(&locked, 0o755);
}

#[test]
fn impossible_outputs_are_refused() {
    let folder = folder();
    fs::create_dir(folder.path().join("taken.bdt")).expect("a folder");
    std::os::unix::fs::symlink("loop.bdt", folder.path().join("loop.bdt")).expect("a link");
    let before = entries(folder.path());
    let long = format!("{}.bdt", "x".repeat(300));
    for (output, message) in [
        (
            "taken.bdt",
            "bdtree-build: taken.bdt is a folder: name a file\n",
        ),
        ("no/such/out.bdt", "folder no/such does not exist\n"),
        ("ball.obj/out.bdt", "ball.obj is not a folder\n"),
        ("ball.obj", "is an input: it would be overwritten"),
        ("small.obj", "is there already and no .bdt file"),
        ("new.obj", "would look like a mesh: name the output .bdt"),
        ("-", "standard output is no place for a bake: name a file"),
    ] {
        let ran = Command::new(PROGRAM)
            .args(["ball.obj", "--modes", "0", "-o", output])
            .current_dir(folder.path())
            .output()
            .expect("the command starts");
        refused(&ran, output, message);
    }
    // These are only met when the finished file takes its name.
    for (output, message) in [
        ("loop.bdt", "cannot"),
        (
            &*long,
            "cannot put the finished file in place: File name too long",
        ),
    ] {
        let ran = rigid("small.obj", output, folder.path()).output();
        let ran = ran.expect("the command starts");
        if output == long {
            refused(&ran, output, message);
        } else {
            // A link to itself is replaced like any name, or refused: never followed for ever.
            assert!(ran.status.code().is_some());
            fs::remove_file(folder.path().join(output)).expect("one name");
        }
    }
    let after: Vec<PathBuf> = before
        .iter()
        .filter(|path| !path.ends_with("loop.bdt"))
        .cloned()
        .collect();
    assert_eq!(entries(folder.path()), after, "nothing came, nothing went");
}

/// A second name of the input is another file to write to: the input keeps its bytes.
#[test]
fn a_hard_link_to_the_input_does_not_harm_it() {
    let folder = folder();
    let (input, link) = (
        folder.path().join("small.obj"),
        folder.path().join("link.bdt"),
    );
    let text = fs::read(&input).expect("a mesh");
    fs::hard_link(&input, &link).expect("a link");
    let status = rigid("small.obj", "link.bdt", folder.path()).status();
    assert!(status.expect("the command starts").success());
    assert_eq!(fs::read(&input).expect("a mesh"), text);
    assert!(
        fs::read(&link)
            .expect("a file")
            .starts_with(&bdtree_format::MAGIC)
    );
}

/// Frames that are set aside, and the report, meet a full disk too.
#[test]
fn a_full_disk_elsewhere_is_told() {
    let folder = folder();
    let frames = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/wave");
    let output = on_full_disk(PROGRAM, 1)
        .arg("--animation")
        .arg(frames)
        .args(["--modes", "2", "-o", "wave.bdt"])
        .current_dir(folder.path())
        .env("TMPDIR", folder.path())
        .output()
        .expect("bash");
    let place = folder.path().display().to_string();
    refused(
        &output,
        &place,
        "cannot hold the frames in a temporary file",
    );
    assert_eq!(entries(folder.path()).len(), 2);

    for option in ["--json", "--threads=1"] {
        let full = fs::File::options().write(true).open("/dev/full");
        let output = Command::new(PROGRAM)
            .args(["small.obj", "--modes", "0", "-o", "out.bdt", option])
            .current_dir(folder.path())
            .stdout(full.expect("/dev/full"))
            .output()
            .expect("the command starts");
        refused(&output, "standard output", "No space left on device");
        assert!(folder.path().join("out.bdt").exists(), "the file is made");
    }
}
