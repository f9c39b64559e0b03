//! `bdtree view` starts the program that lies beside it, else one of PATH, else says how to get it.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};

/// A copy of the command, alone in a folder.
fn alone(folder: &Path) -> Command {
    let bdtree = folder.join("bdtree");
    fs::copy(env!("CARGO_BIN_EXE_bdtree"), &bdtree).expect("copied");
    let mut command = Command::new(bdtree);
    command.env("PATH", folder.join("programs"));
    command
}

/// A program that says what it was given.
fn program(path: &Path, name: &str) {
    fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    let text = format!("#!/bin/sh\necho {name} \"$@\"\nexit 7\n");
    fs::write(path, text).expect("written");
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).expect("executable");
}

/// Runs it; again where a file that was just written is still open in a child of another test's.
fn output(command: &mut Command) -> Output {
    loop {
        match command.output() {
            Err(error) if error.kind() == std::io::ErrorKind::ExecutableFileBusy => {}
            other => return other.expect("it starts"),
        }
    }
}

#[test]
fn it_is_found_beside_the_command_then_on_the_path() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["view", "a.bdt", "--q", "-1,2", "--help"];
    program(&folder.path().join("programs/bdtree-view"), "on-path");
    let found = output(alone(folder.path()).args(arguments));
    assert_eq!(
        String::from_utf8_lossy(&found.stdout),
        "on-path a.bdt --q -1,2 --help\n"
    );
    assert_eq!(found.status.code(), Some(7), "its exit code");
    program(&folder.path().join("bdtree-view"), "beside");
    let found = output(alone(folder.path()).args(arguments));
    assert_eq!(
        String::from_utf8_lossy(&found.stdout),
        "beside a.bdt --q -1,2 --help\n"
    );
}

#[test]
fn without_it_one_line_says_how_to_get_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let missing = output(alone(folder.path()).args(["view", "a.bdt"]));
    assert_eq!(missing.status.code(), Some(2));
    let text = String::from_utf8_lossy(&missing.stderr);
    assert!(text.starts_with("bdtree-view: not installed"), "{text}");
    assert!(
        text.contains("cargo install --locked --path bdtree-view") && text.lines().count() == 1,
        "{text}"
    );
    let usage = output(alone(folder.path()).arg("view"));
    assert_eq!(usage.status.code(), Some(2), "no file");
}
