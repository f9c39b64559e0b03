//! Damaged files and scenes: an answer or an error, never a panic. Runs the command in-process.

use std::ffi::OsString;

use bdtree_runtime::Model;
use serde_json::json;

use crate::support::Folder;

/// Steps of a linear congruential generator: its high bits.
struct Steps(u64);

impl Steps {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n
    }
}

/// Runs the command; exit code and error stream.
fn run(folder: &Folder, arguments: &[&str]) -> (u8, String) {
    // Names of files become paths in the folder; the process has its own current folder.
    let in_folder = |text: &&str| {
        if text.contains('.') {
            folder.path(text).into_os_string()
        } else {
            OsString::from(text)
        }
    };
    let arguments =
        std::iter::once(OsString::from("bdtree")).chain(arguments.iter().map(in_folder));
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let code = bdtree_tools::run(arguments, &mut out, &mut err);
    (code, String::from_utf8(err).expect("UTF-8"))
}

#[test]
fn damaged_files_are_refused_or_answered() {
    let folder = Folder::new();
    let sound = folder.read("a.bdt");
    let scene = json!({
        "instances": [{"name": "a", "asset": "bad.bdt", "q": [1, -1, 0.5]},
                      {"name": "b", "asset": "a.bdt", "translation": [0.5, 0, 0]}],
        "queries": [
            {"ball": {"instance": "a", "center": [10, -2.5, 0], "radius": 0.9}},
            {"closest": {"instance": "a", "point": [9, -2.5, 0]}},
            {"plane": {"instance": "a", "normal": [0, 0, 1], "offset": 0}},
            {"ray": {"instance": "a", "origin": [10, -2.5, 9], "direction": [0, 0, -1]}},
            {"pair": {"a": "a", "b": "b"}}]});
    folder.write("scene.json", scene.to_string());
    let mut steps = Steps(7);
    let mut answered = 0;
    for case in 0..300 {
        let mut bytes = sound.clone();
        for _ in 0..1 + case % 4 {
            // Mostly behind the header block, whose checksum every command checks.
            let start = if case % 10 == 0 { 0 } else { 700 };
            let at = start + steps.below(bytes.len() - start);
            bytes[at] = [0, 0x7f, 0x80, 0xff, bytes[at] ^ (1 << steps.below(8))][steps.below(5)];
        }
        if case % 25 == 0 {
            bytes.truncate(steps.below(bytes.len()));
        }
        folder.write("bad.bdt", &bytes);
        let (code, err) = run(&folder, &["verify", "bad.bdt"]);
        assert_eq!(code == 0, bytes == sound, "case {case}: {err}");
        for arguments in [
            &["info", "bad.bdt"][..],
            &["deform", "bad.bdt", "--no-verify"],
            &["query", "scene.json", "--no-verify"],
            &["diff", "a.bdt", "bad.bdt"],
        ] {
            let (code, err) = run(&folder, arguments);
            let most = if arguments[0] == "diff" { 2 } else { 1 };
            assert!(code <= most, "case {case} {arguments:?}: {err}");
            assert_eq!(
                code == most,
                !err.is_empty(),
                "case {case} {arguments:?}: {err}"
            );
            answered += u32::from(code == 0);
        }
        // Queries check sums, which do not cover the padding between sections.
        let model = Model::from_bytes(&bytes);
        let summed = model.and_then(|model| model.asset().verify_checksums());
        let code = run(&folder, &["query", "scene.json"]).0;
        assert_eq!(code, u8::from(summed.is_err()), "case {case}");
    }
    assert!(answered > 100, "the cases test little: {answered}");
}

#[test]
fn damaged_scenes_are_refused_or_answered() {
    let folder = Folder::new();
    let scene = json!({
        "instances": [{"name": "a", "asset": "a.bdt", "q": [1, -1, 0.5], "scale": 2,
                       "rotation": [0, 0, 0, 1], "translation": [0, 0, 0]}],
        "options": {"max_depth": null},
        "queries": [{"ball": {"instance": "a", "center": [20, -5, 0], "radius": 0.9}},
                    {"closest": {"instance": "a", "point": [0, 0, 0], "max_distance": 4}}]})
    .to_string();
    let mut steps = Steps(3);
    for case in 0..2000 {
        let mut text = scene.clone().into_bytes();
        for _ in 0..1 + case % 3 {
            let at = steps.below(text.len());
            let other = text[steps.below(text.len())];
            match steps.below(3) {
                0 => text[at] = other,
                1 => text.insert(at, other),
                _ => drop(text.remove(at)),
            }
        }
        folder.write("scene.json", &text);
        let (code, err) = run(&folder, &["query", "scene.json"]);
        assert!(code <= 1, "case {case}: {err}");
        assert_eq!(code == 1, !err.is_empty(), "case {case}: {err}");
    }
}
