//! How the viewer ends: errors are one line and exit code 1, usage is 2.

use std::process::{Command, Output};

use crate::display::{Display, Running};
use crate::hands::Hands;
use crate::{PICTURE, file};

/// The last line of standard error; graphics libraries may have written others before it.
pub(crate) fn failed(output: &Output, code: i32) -> String {
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{text}");
    assert!(!text.contains("panicked"), "{text}");
    text.lines().last().expect("a reason").to_string()
}

pub(crate) fn run(command: &mut Command) -> Output {
    command.output().expect("the viewer starts")
}

#[test]
fn bad_files_and_options_are_named() {
    let display = Display::start();
    let line = failed(&run(display.viewer().arg("no such.bdt")), 1);
    assert!(line.starts_with("no such.bdt: cannot be read: "), "{line}");
    let line = failed(
        &run(display
            .viewer()
            .arg(file("sphere.bdt"))
            .args(["--spheres", "2"])),
        1,
    );
    assert!(line.starts_with("--spheres: 2 is out of range"), "{line}");
    let line = failed(
        &run(display
            .viewer()
            .arg(file("sphere.bdt"))
            .args(["--frame", "0"])),
        1,
    );
    assert!(
        line.starts_with("--frame: ") && line.ends_with("has no animation"),
        "{line}"
    );
    let line = failed(
        &run(display.viewer().arg(file("sphere.bdt")).arg("--play")),
        1,
    );
    assert!(
        line.starts_with("--play: ") && line.ends_with("has no animation"),
        "{line}"
    );
    let line = failed(
        &run(display.viewer().arg(file("skinned.bdt")).arg("--play")),
        1,
    );
    assert!(
        line.starts_with("--play: ")
            && line.ends_with("has no animation; choose a clip with --clip"),
        "{line}"
    );
    let line = failed(
        &run(display
            .viewer()
            .arg(file("skinned.bdt"))
            .args(["--clip", "run", "--play"])),
        1,
    );
    assert!(
        line.starts_with("--clip: ") && line.contains("has no clip \"run\"; its clips are"),
        "{line}"
    );
    let line = failed(
        &run(display.viewer().arg(file("sphere.bdt")).args(["--q", "1"])),
        1,
    );
    assert!(line.starts_with("--q: q has 1 number"), "{line}");
    let usage = run(display
        .viewer()
        .arg(file("sphere.bdt"))
        .args(["--size", "0x9"]));
    assert_eq!(usage.status.code(), Some(2));
    let mut usage = display.viewer();
    let usage = run(usage.arg(file("sphere.bdt")).args(["--spheres", "x"]));
    let text = String::from_utf8_lossy(&usage.stderr);
    assert_eq!(usage.status.code(), Some(2));
    assert!(text.contains("not a whole number, 0 or more"), "{text}");

    let usage = run(display
        .viewer()
        .arg(file("sphere.bdt"))
        .args(["--screenshot", "x.jpg"]));
    let line = failed(&usage, 2);
    assert!(line.contains("unknown extension"), "{line}");

    let folder = tempfile::tempdir().expect("a folder");
    let damaged = folder.path().join("damaged.bdt");
    let mut bytes = std::fs::read(file("sphere.bdt")).expect("a golden file");
    bytes[6000] ^= 0x40;
    std::fs::write(&damaged, bytes).expect("written");
    let line = failed(&run(display.viewer().arg(&damaged)), 1);
    assert!(
        line.contains("damaged.bdt: damaged .bdt file: section TRIS"),
        "{line}"
    );
}

#[test]
fn without_a_display_or_an_adapter_there_is_one_line() {
    let display = Display::start();
    for wayland in [None, Some("wayland-0")] {
        let mut viewer = display.viewer();
        viewer.arg(file("sphere.bdt")).env_remove("DISPLAY");
        viewer.env_remove("WAYLAND_DISPLAY");
        viewer.envs(wayland.map(|name| ("WAYLAND_DISPLAY", name)));
        assert_eq!(
            failed(&run(&mut viewer), 1),
            "no window: an X11 display (or XWayland) is needed: set DISPLAY, or use `bdtree render`"
        );
    }
    let line = failed(
        &run(display
            .viewer()
            .arg(file("sphere.bdt"))
            .env("DISPLAY", ":64999")),
        1,
    );
    assert!(
        line.starts_with("no window: ") && !line.contains(".rs"),
        "{line}"
    );
    let mut viewer = display.viewer();
    viewer
        .arg(file("sphere.bdt"))
        .env("VK_DRIVER_FILES", "/nonexistent");
    viewer.env("VK_ICD_FILENAMES", "/nonexistent");
    let line = failed(&run(&mut viewer), 1);
    assert!(
        line.contains("sphere.bdt: no graphics adapter for Vulkan"),
        "{line}"
    );
}

#[test]
fn a_window_beyond_the_devices_limit_is_refused() {
    let display = Display::start();
    let line = failed(
        &run(display
            .viewer()
            .arg(file("sphere.bdt"))
            .args(["--size", "30000x200"])),
        1,
    );
    assert!(
        line.contains("the window: 30000 pixels, the graphics device takes at most"),
        "{line}"
    );
}

/// A viewer that shows something, and hands that may end it.
fn shown(display: &Display) -> (Running, Hands) {
    let mut viewer = display.viewer();
    viewer.arg(file("sphere.bdt")).args(["--size", "1000x700"]);
    let mut viewer = Running(viewer.spawn().expect("the viewer starts"));
    display.wait_for(&mut viewer, |screen| {
        screen.share(PICTURE, |c| c[0] > 0 && c[0] < 250) > 0.05
    });
    (viewer, Hands::on(display))
}

#[test]
fn closing_the_window_ends_it() {
    let display = Display::start();
    let (viewer, hands) = shown(&display);
    hands.close();
    let output = viewer.output();
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{text}");
}

#[test]
fn a_window_that_is_taken_away_is_an_error() {
    let display = Display::start();
    let (viewer, hands) = shown(&display);
    viewer.wait_for_rest();
    hands.destroy();
    let line = failed(&viewer.output(), 1);
    assert!(line.contains("the window was destroyed"), "{line}");
}

#[test]
fn a_screenshot_that_cannot_be_written_is_named() {
    let display = Display::start();
    let mut viewer = display.viewer();
    viewer
        .arg(file("sphere.bdt"))
        .args(["--screenshot", "/no/such/folder/x.png"]);
    let line = failed(&run(&mut viewer), 1);
    assert_eq!(
        line,
        "/no/such/folder/x.png: folder /no/such/folder does not exist"
    );
}
