//! Help, version, mistakes of usage, closed pipes.

use std::process::{Command, Stdio};

use crate::support::Folder;

#[test]
fn help_shows_defaults_and_units() {
    let folder = Folder::new();
    for (command, texts) in [
        ("info", &["mesh units"][..]),
        ("verify", &["1000"]),
        ("diff", &["[default: 0]", "0 or more"]),
        (
            "deform",
            &[
                "[default: zeros; with --clip",
                "mesh units",
                "counted from 0",
            ],
        ),
        ("query", &["world"]),
        #[cfg(feature = "render")]
        (
            "render",
            &[
                "[default: 1280x960]",
                "[default: 0.35]",
                "[default: 30,20,1]",
                "[default: zeros; with --clip",
                "[default: rest]",
                "counted from 0",
                "degrees",
                "world units",
            ],
        ),
    ] {
        let ran = folder.run(&[command, "--help"]);
        assert_eq!((ran.code, ran.err.as_str()), (0, ""));
        for text in texts {
            assert!(ran.out.contains(text), "{command}: {text}: {}", ran.out);
        }
    }
    let ran = folder.run(&["--version"]);
    assert_eq!(ran.code, 0);
    assert_eq!(ran.out, concat!("bdtree ", env!("CARGO_PKG_VERSION"), "\n"));
}

#[test]
fn mistakes_of_usage_are_2() {
    let folder = Folder::new();
    for arguments in [
        &[][..],
        &["inof", "a.bdt"],
        &["info"],
        &["info", "a.bdt", "b.bdt"],
        &["verify", "a.bdt", "--stress", "--cases", "0"],
        &["verify", "a.bdt", "--stress", "--cases", "-3"],
        &["verify", "a.bdt", "--cases", "3"],
        &["diff", "a.bdt"],
        &["diff", "a.bdt", "a.bdt", "--tolerance-rel", "-1"],
        &["diff", "a.bdt", "a.bdt", "--tolerance-rel", "nan"],
        &["diff", "a.bdt", "a.bdt", "--tolerance-rel", "x"],
        &["verify", "a.bdt", "--stress", "--seed", "x"],
        &["deform", "a.bdt", "--frame", "-1"],
        &["render", "a.bdt", "-o", "a.png", "--frame", "1.5"],
        &["render", "a.bdt", "-o", "a.png", "--spheres", "x"],
        &["render", "a.bdt", "-o", "a.png", "--opacity", "x"],
        &["deform", "a.bdt", "--q", "1,two"],
        &["deform", "a.bdt", "--q", "1,nan,0"],
        &["deform", "a.bdt", "--q", "0,0,0", "--frame", "1"],
        &["query"],
        &["render", "a.bdt"],
        &[
            "render", "a.bdt", "-o", "a.png", "--q", "0,0,0", "--frame", "1",
        ],
        &[
            "render", "a.bdt", "-o", "a.png", "--frame", "1", "--frames", "1..2",
        ],
        &["render", "a.bdt", "-o", "a.png", "--frames", "2..1"],
        &[
            "render", "a.bdt", "-o", "a.png", "--frames", "1..2", "--query", "s.json",
        ],
        &["render", "a.bdt", "-o", "a.png", "--size", "0x10"],
        &["render", "a.bdt", "-o", "a.png", "--opacity", "1.5"],
        &["render", "a.bdt", "-o", "a.png", "--view", "0,95"],
        &["render", "a.bdt", "-o", "a.png", "--against", "nothing"],
    ] {
        let ran = folder.run(arguments);
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{arguments:?}");
        assert!(!ran.err.is_empty(), "{arguments:?}");
        // No text of Rust's own parsers.
        for text in ["found in string", "float literal"] {
            assert!(!ran.err.contains(text), "{arguments:?}: {}", ran.err);
        }
        assert!(
            !ran.err.contains("unexpected argument '-"),
            "{arguments:?}: {}",
            ran.err
        );
    }
}

#[test]
fn a_closed_pipe_is_no_error() {
    let folder = Folder::new();
    for arguments in [&["deform", "a.bdt"][..], &["info", "a.bdt"], &["--help"]] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_bdtree"))
            .args(arguments)
            .current_dir(folder.root())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("bdtree starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("bdtree ends");
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert!(output.stderr.is_empty(), "{arguments:?}");
    }
}
