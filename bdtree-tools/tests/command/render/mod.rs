//! `render`: pictures by their content, sequences, what queries visit, and what is refused.

mod characters;
mod pictures;
mod queries;

use std::fs;
use std::process::Command;

use serde_json::{Value, json};

use crate::support::{Folder, animated, baked, ball_mesh};

#[test]
fn frames_are_drawn_one_by_one_by_the_same_camera() {
    let folder = Folder::new();
    let mesh = ball_mesh();
    folder.write("moves.bdt", baked(&mesh, &animated(&mesh)));
    let out = folder.render(&[
        "moves.bdt",
        "--frames",
        "0..2",
        "-o",
        "f_%03d.png",
        "--json",
    ]);
    let reports: Vec<Value> = out
        .lines()
        .map(|l| serde_json::from_str(l).expect("JSON"))
        .collect();
    let pictures: Vec<_> = (0..3)
        .map(|i| {
            assert_eq!(reports[i]["frame"], i);
            assert_eq!(reports[i]["output"], format!("f_00{i}.png"));
            folder.read(&format!("f_00{i}.png"))
        })
        .collect();
    assert_ne!(pictures[0], pictures[1]);
    assert_ne!(pictures[1], pictures[2]);
    assert_eq!(
        fs::read_dir(folder.root()).expect("a folder").count(),
        3 + 3
    );
    // Frame 1 is turned about x, which the same q alone is not.
    let turned = folder.plain(&["moves.bdt", "--frame", "1"]);
    assert!(turned != folder.plain(&["moves.bdt", "--q", "0.5,-0.25,1"]));
    // Frame 0 is at rest.
    let first = folder.plain(&["moves.bdt", "--frame", "0"]);
    assert!(first == folder.plain(&["moves.bdt"]));
}

#[test]
fn a_line_says_what_was_written() {
    let folder = Folder::new();
    let mesh = ball_mesh();
    folder.write("moves.bdt", baked(&mesh, &animated(&mesh)));
    let scene = json!({
        "instances": [{"name": "a", "asset": "a.bdt"}],
        "queries": [{"closest": {"instance": "a", "point": [10, -1, 2]}}],
    });
    let (_, report) = folder.asked("a.bdt", &scene, &[]);
    let visited = &report["nodes_visited"];
    let ends = report["spheres"].as_array().expect("a list").len();
    let (_, level) = folder.reported(&["a.bdt", "--spheres", "1"]);
    let of_level = level["spheres"].as_array().expect("a list").len();
    for (arguments, expected) in [
        (
            &["a.bdt", "-o", "out.png"][..],
            "wrote out.png: 320 x 240 pixels\n".to_string(),
        ),
        (
            &["a.bdt", "-o", "out.png", "--spheres", "1"],
            format!("wrote out.png: 320 x 240 pixels, level 1, {of_level} spheres\n"),
        ),
        (
            &["a.bdt", "-o", "out.png", "--query", "scene.json"],
            format!("wrote out.png: 320 x 240 pixels, {visited} nodes visited, {ends} spheres\n"),
        ),
        (
            &["moves.bdt", "-o", "%d.png", "--frames", "0..1"],
            "wrote 0.png: 320 x 240 pixels, frame 0\nwrote 1.png: 320 x 240 pixels, frame 1\n"
                .to_string(),
        ),
    ] {
        assert_eq!(folder.render(arguments), expected, "{arguments:?}");
    }
}

#[test]
fn what_does_not_fit_is_told() {
    let folder = Folder::new();
    let scene = json!({"instances": [{"name": "r", "asset": "rigid.bdt"}], "queries": []});
    folder.write("other.json", scene.to_string());
    let mut broken = folder.read("a.bdt");
    *broken.last_mut().expect("bytes") ^= 1;
    folder.write("broken.bdt", broken);
    for (arguments, expected) in [
        (
            &["none.bdt", "-o", "out.png"][..],
            "none.bdt: cannot be read: No such file or directory (os error 2)",
        ),
        (
            &["a.bdt", "-o", "none/out.png"],
            "none/out.png: folder none does not exist",
        ),
        (
            &["a.bdt", "-o", "out.png", "--q", "1"],
            "--q: q has 1 number, asset a.bdt has 3 modes",
        ),
        (
            &["a.bdt", "-o", "out.png", "--frame", "0"],
            "--frame: asset a.bdt has no animation",
        ),
        (
            &["a.bdt", "-o", "%d.png", "--frames", "0..1"],
            "--frames: asset a.bdt has no animation",
        ),
        (
            &["a.bdt", "-o", "%d.png", "--frames", "0..99999999999"],
            "--frames: asset a.bdt has no animation",
        ),
        (
            &["a.bdt", "-o", "out.png", "--spheres", "9"],
            "--spheres: 9 is out of range: asset a.bdt has 3 levels, numbered from 0",
        ),
        (
            &["a.bdt", "-o", "out.png", "--query", "other.json"],
            "other.json: no instance of a.bdt",
        ),
        (
            &["a.bdt", "-o", "out.png", "--query", "none.json"],
            "none.json: cannot be read: No such file or directory (os error 2)",
        ),
        (
            &["a.bdt", "-o", "out.png", "--size", "100000x2"],
            "width of the picture: 100000 pixels, the graphics device takes at most ",
        ),
    ] {
        let said = folder.refusal(arguments);
        let is_said = if expected.ends_with(' ') {
            said.starts_with(expected)
        } else {
            said == expected
        };
        assert!(is_said, "{arguments:?}: {said}");
        assert!(!folder.path("out.png").exists());
    }
    let bare = ["render", "a.bdt", "-o", "out.png", "--against", "deformed"];
    let ran = folder.run(&bare);
    assert_eq!((ran.code, ran.out.as_str()), (2, ""), "nothing to color");
    assert!(ran.err.contains("--spheres"), "{}", ran.err);
    let ran = folder.run(&["render", "a.bdt", "-o", "out.jpg"]);
    let text = "out.jpg: unknown extension: .png can be written\n";
    assert_eq!((ran.code, ran.err.as_str()), (2, text));
    let ran = folder.run(&["render", "no.bdt", "-o", "a.png", "--frames", "0..1"]);
    let text = "a.png: has no place for the frame's number: write it as %d or %04d\n";
    assert_eq!((ran.code, ran.err.as_str()), (2, text));
    let said = folder.refusal(&["broken.bdt", "-o", "out.png"]);
    assert!(
        said.starts_with("broken.bdt: damaged .bdt file: section "),
        "{said}"
    );
    folder.write("a.png", folder.read("a.bdt"));
    assert_eq!(
        folder.refusal(&["a.png", "-o", "a.png"]),
        "a.png: is the input: it would be overwritten"
    );
    assert_eq!(folder.read("a.png"), folder.read("a.bdt"));
}

#[test]
fn without_an_adapter_there_is_one_clear_line() {
    let folder = Folder::new();
    let output = Command::new(env!("CARGO_BIN_EXE_bdtree"))
        .args(["render", "a.bdt", "-o", "out.png"])
        .current_dir(folder.root())
        // The Vulkan loader finds no driver there, by either of its names for the list.
        .env("VK_DRIVER_FILES", "none.json")
        .env("VK_ICD_FILENAMES", "none.json")
        .output()
        .expect("bdtree starts");
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1), "{said}");
    let mut lines = said
        .lines()
        .filter(|line| line.starts_with("no graphics adapter for Vulkan"));
    assert!(
        lines
            .next()
            .is_some_and(|line| line.contains("mesa-vulkan-drivers")),
        "{said}"
    );
    assert!(!said.contains("panicked"), "{said}");
}
