//! The playground: steps and a picture without a display, and a window in which bodies are dropped.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::display::{Display, Picture, Running};
use crate::ends::{failed, run};
use crate::hands::{Hands, LEFT};
use crate::{CONTROLS, EDGE, PANEL, PICTURE, SIZE, file};

/// What standard output says of a run that ends well.
fn said(command: &mut Command) -> String {
    let output = run(command);
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{text}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Red as contacts are.
fn is_contact([r, g, b]: [u8; 3]) -> bool {
    r > 170 && g < 70 && b < 70
}

/// The lines of a table without its last columns: what depends on the threads, and the times.
fn untimed(path: &Path) -> Vec<String> {
    let text = fs::read_to_string(path).expect("a table");
    let line = |line: &str| {
        let columns: Vec<&str> = line.split(',').collect();
        columns[..columns.len() - 3].join(",")
    };
    text.lines().map(line).collect()
}

#[test]
fn steps_are_made_and_drawn_without_a_display() {
    let display = Display::start();
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name);
    let start = |threads: &str, bodies: &[&str]| {
        let mut command = display.playground();
        command.env_remove("DISPLAY").arg(file("tetrahedron.bdt"));
        command.args(bodies);
        command.args(["--seed", "7", "--threads", threads]);
        command.args(["--size", "600x400"]);
        command
    };
    for threads in ["1", "2"] {
        let mut command = start(threads, &["--bodies", "8"]);
        command.args(["--steps", "150", "--screenshot"]);
        command.arg(place(&format!("{threads}.png")));
        command.arg("--out").arg(place(threads));
        let text = said(command.arg("--checkpoint").arg(place("state")));
        let first = format!("8 bodies, 150 steps of 1/150 s, {threads} threads, ");
        assert!(text.starts_with(&first), "{text}");
        assert!(
            text.contains("simulation per frame of 5 steps: median "),
            "{text}"
        );
        assert!(text.contains(": 600 x 400 pixels\n"), "{text}");
    }
    // The same for any number of threads.
    let rows = untimed(&place("1/playground-steps.csv"));
    assert_eq!(rows, untimed(&place("2/playground-steps.csv")));
    assert_eq!(rows.len(), 151);
    assert!(rows[0].starts_with("step,bodies,events,"), "{}", rows[0]);
    assert!(rows[150].starts_with("150,8,"), "{}", rows[150]);
    let picture = Picture::load(&place("1.png"));
    let all = [0, 0, 600, 400];
    assert_eq!(
        picture.difference(&Picture::load(&place("2.png")), all),
        0.0
    );
    // Bodies of many colors on the grey ground, and red dots where they touch it.
    let colored = |[r, g, b]: [u8; 3]| r.max(g).max(b) - r.min(g).min(b) > 40;
    let share = picture.share(all, colored);
    assert!((0.05..0.6).contains(&share), "{share}");
    assert!(picture.share(all, is_contact) > 3e-5);
    let text = fs::read_to_string(place("1/playground.json")).expect("a report");
    let report: Value = serde_json::from_str(&text).expect("JSON");
    let number = |at: &str| report.pointer(at).and_then(Value::as_f64);
    assert_eq!(
        [number("/bodies"), number("/end")],
        [Some(8.0), Some(150.0)]
    );
    let [median, high, most] = ["median", "p95", "most"]
        .map(|of| number(&format!("/times/frame_ms/{of}")).expect("times"));
    assert!(
        0.0 < median && median <= high && high <= most,
        "{median} {high} {most}"
    );
    assert!(number("/times/drawing_ms").expect("a time") > 0.0);

    // From there it goes on as it would have.
    let mut command = start("1", &[]);
    command.arg("--resume").arg(place("state"));
    said(
        command
            .args(["--steps", "50"])
            .arg("--out")
            .arg(place("on")),
    );
    let mut command = start("1", &["--bodies", "8"]);
    said(
        command
            .args(["--steps", "200"])
            .arg("--out")
            .arg(place("whole")),
    );
    let on = untimed(&place("on/playground-steps.csv"));
    let whole = untimed(&place("whole/playground-steps.csv"));
    assert_eq!(on[1..], whole[151..]);
}

#[test]
fn clicks_drop_bodies_and_closing_saves_them() {
    let display = Display::start();
    let folder = tempfile::tempdir().expect("a folder");
    let state = folder.path().join("state");
    let mut command = display.playground();
    command
        .arg(file("tetrahedron.bdt"))
        .args(["--size", "1000x700"]);
    command.arg("--checkpoint").arg(&state);
    let mut window = Running(command.spawn().expect("the playground starts"));
    let is_drawn = |screen: &Picture| {
        screen.share(CONTROLS, |c| c == PANEL) > 0.5
            && screen.share(PICTURE, |c| c == [0; 3]) == 0.0
    };
    let mut last = display.wait_for(&mut window, is_drawn);
    window.wait_for_rest();
    let hands = Hands::on(&display);
    for x in [EDGE + 240, EDGE + 440] {
        hands.point([x, 420]);
        hands.press(LEFT);
        hands.release(LEFT);
        // It falls: frame follows frame.
        for _ in 0..2 {
            let moved = |screen: &Picture| screen.difference(&last, PICTURE) > 0.002;
            last = display.wait_for(&mut window, moved);
        }
    }
    hands.close();
    let output = window.output();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(
        String::from_utf8_lossy(&output.stdout),
        format!("wrote {}\n", state.display())
    );
    let mut command = display.playground();
    command
        .arg(file("tetrahedron.bdt"))
        .args(["--steps", "1", "--resume"]);
    let text = said(command.arg(&state));
    assert!(text.starts_with("2 bodies, 1 steps"), "{text}");
}

#[test]
fn what_is_wrong_is_told_in_the_window_or_in_a_line() {
    let display = Display::start();
    let start = |name: &str, options: &[&str]| {
        let mut command = display.playground();
        command.arg(file(name)).args(options);
        command
    };
    let line = failed(
        &run(&mut start("sphere.bdt", &["--bodies", "2", "--steps", "9"])),
        1,
    );
    assert!(
        line.starts_with("playground: sphere.bdt: mode 0 has no frequency"),
        "{line}"
    );
    let line = failed(&run(&mut start("no such.bdt", &[])), 1);
    assert!(line.contains("no such.bdt: cannot be read"), "{line}");
    for usage in [
        &["--out", "x"][..],
        &["--scale", "0"],
        &["--resume", "x", "--bodies", "2"],
    ] {
        assert_eq!(
            run(&mut start("sphere.bdt", usage)).status.code(),
            Some(2),
            "{usage:?}"
        );
    }
    // The window opens, and says it in red below the picture.
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("window.png");
    let mut command = start("sphere.bdt", &["--bodies", "2", "--size", "1000x700"]);
    said(command.arg("--screenshot").arg(&path));
    let wrong = |[r, g, b]: [u8; 3]| r > 150 && g < 90 && b < 100;
    let below = [EDGE, SIZE[1] - 80, SIZE[0], SIZE[1]];
    let problem = Picture::load(&path).share(below, wrong);
    assert!(problem > 0.002, "{problem}");
    // Without what is wrong, and with bodies, the copy is of the beginning and the same each time.
    let copies = [0, 1].map(|_| {
        let mut command = start("tetrahedron.bdt", &["--bodies", "5", "--size", "1000x700"]);
        said(command.arg("--screenshot").arg(&path));
        Picture::load(&path)
    });
    assert_eq!(copies[0].share(below, wrong), 0.0);
    assert_eq!(copies[0].difference(&copies[1], PICTURE), 0.0);
}
