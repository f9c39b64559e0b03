//! What `bdtree deform -o` leaves behind where writing goes wrong: the old file or none, one clear
//! error, no half file.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::Instant;

use bdtree_fixtures::bake;
use bdtree_fixtures::processes::{kill_while_writing, on_full_disk, set_mode, unprivileged};

use crate::support::Folder;

const PROGRAM: &str = env!("CARGO_BIN_EXE_bdtree");

/// A folder with `large.bdt`, of 13 000 vertices, open to everyone.
fn folder() -> Folder {
    let folder = Folder::new();
    set_mode(folder.root(), 0o755);
    let mesh = bake::bumpy_sphere(80, 1);
    folder.write(
        "large.bdt",
        bake::baked(&mesh, &bake::rigid(&mesh)).asset().bytes(),
    );
    folder
}

fn deform(mut command: Command, output: &str, folder: &Folder) -> Output {
    let command = command.args(["deform", "large.bdt", "-o", output]);
    command.current_dir(folder.root()).output().expect("starts")
}

/// Exit code 1 and one line.
fn refused(output: &Output, text: &str) {
    let found = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{found}");
    assert_eq!(found, text);
}

fn count(folder: &Path) -> usize {
    fs::read_dir(folder).expect("a folder").count()
}

#[test]
fn a_killed_run_leaves_the_old_file_or_none() {
    let folder = folder();
    for output in ["out.obj", "out.npy"] {
        let command = || {
            let mut command = Command::new(PROGRAM);
            let arguments = ["deform", "large.bdt", "-o", output];
            command.args(arguments).current_dir(folder.root());
            command
        };
        let begin = Instant::now();
        assert!(command().status().expect("starts").success());
        let time = begin.elapsed();
        let new = folder.read(output);
        let target = folder.path(output);
        let result = kill_while_writing(command, &target, &new, time, 40);
        println!("{output}: {result:?}, {} bytes, {time:?}", new.len());
        assert!(result.killed > 5, "{result:?}");
    }
    assert_eq!(count(folder.root()), 3);
}

#[test]
fn a_full_disk_keeps_the_old_file() {
    let folder = folder();
    for output in ["out.obj", "out.npy"] {
        folder.write(output, b"old");
        let ran = deform(on_full_disk(PROGRAM, 8), output, &folder);
        refused(
            &ran,
            &format!("{output}: cannot write: File too large (os error 27)\n"),
        );
        assert_eq!(folder.read(output), b"old");
    }
    assert_eq!(count(folder.root()), 5);
    let full = fs::File::options().write(true).open("/dev/full");
    let ran = Command::new(PROGRAM)
        .args(["deform", "large.bdt"])
        .current_dir(folder.root())
        .stdout(full.expect("/dev/full"))
        .output()
        .expect("starts");
    refused(
        &ran,
        "standard output: No space left on device (os error 28)\n",
    );
}

#[test]
fn a_read_only_folder_is_told() {
    let Some(command) = unprivileged("a_read_only_folder_is_told", PROGRAM) else {
        return;
    };
    let folder = folder();
    let locked = folder.path("locked");
    fs::create_dir(&locked).expect("a folder");
    folder.write("locked/out.npy", b"old");
    set_mode(&locked, 0o555);
    let ran = deform(command, "locked/new.npy", &folder);
    refused(
        &ran,
        "locked/new.npy: folder locked does not allow new files\n",
    );
    assert_eq!(folder.read("locked/out.npy"), b"old");
    assert_eq!(count(&locked), 1);
    set_mode(&locked, 0o755);
}

#[test]
fn impossible_outputs_are_refused() {
    let folder = folder();
    fs::create_dir(folder.path("taken.obj")).expect("a folder");
    folder.write("asset.npy", folder.read("large.bdt"));
    let run = |output| deform(Command::new(PROGRAM), output, &folder);
    refused(&run("taken.obj"), "taken.obj: is a folder: name a file\n");
    refused(&run("no/out.obj"), "no/out.obj: folder no does not exist\n");
    refused(
        &run("asset.npy/out.obj"),
        "asset.npy/out.obj: asset.npy is not a folder\n",
    );
    let ran = folder.run(&["deform", "asset.npy", "-o", "asset.npy"]);
    assert_eq!(ran.code, 1);
    assert_eq!(
        ran.err,
        "asset.npy: is the input: it would be overwritten\n"
    );
    assert_eq!(folder.read("asset.npy"), folder.read("large.bdt"));
    assert_eq!(count(folder.root()), 5);
}
