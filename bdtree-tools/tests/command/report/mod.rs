//! `report`: its page and its figures, on assets of every kind.

mod animation;
mod characters;
mod figures;
mod kinds;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use crate::drawn::Picture;
use crate::support::Folder;

impl Folder {
    /// The figures and the page of an asset; of each picture its first letters only, for any word may be in it.
    fn report(&self, name: &str) -> (Value, String) {
        let ran = self.run(&["report", name, "--json", "-o", "out.html"]);
        assert_eq!(ran.code, 0, "{name}: {}", ran.err);
        assert!(tells_parts(&ran.err), "{name}: {}", ran.err);
        let figures = serde_json::from_str(&ran.out).expect("one JSON object");
        let page = String::from_utf8(self.read("out.html")).expect("UTF-8");
        let mut parts = page.split("base64,");
        let mut short = parts.next().expect("a page").to_string();
        for part in parts {
            let (picture, rest) = part.split_once('"').expect("an end");
            short += &format!("base64,{:.5}\"{rest}", picture);
        }
        (figures, without_options(&short))
    }

    /// The first picture of the page of an asset without modes.
    fn portrait(&self, options: &[&str]) -> Picture {
        let ran = self.run(&[&["report", "rigid.bdt", "-o", "out.html"], options].concat());
        assert_eq!(ran.code, 0, "{options:?}: {}", ran.err);
        let page = String::from_utf8(self.read("out.html")).expect("UTF-8");
        let picture = page
            .split("base64,")
            .nth(1)
            .and_then(|p| p.split('"').next());
        let picture = STANDARD.decode(picture.expect("a picture"));
        self.write("out.png", picture.expect("base 64"));
        Picture::read(&self.path("out.png"))
    }
}

/// A page without what keeps the names of options in one line.
fn without_options(page: &str) -> String {
    let mut parts = page.split("<span class=\"option\">");
    let first = parts.next().unwrap_or_default().to_string();
    parts.fold(first, |text, part| text + &part.replacen("</span>", "", 1))
}

/// Whether there is a line for each part that was begun, and nothing else.
fn tells_parts(err: &str) -> bool {
    let mut lines = err.lines();
    let is_part = |line: &str| line.starts_with("measuring ") || line == "baking for comparison";
    lines.next() == Some("measuring levels") && lines.all(is_part)
}

#[test]
fn what_is_wrong_is_told() {
    let folder = Folder::new();
    let mut broken = folder.read("a.bdt");
    *broken.last_mut().expect("bytes") ^= 1;
    folder.write("broken.bdt", broken);
    for (arguments, expected) in [
        (&["none.bdt"][..], "none.bdt: cannot be read: No such file"),
        (&["broken.bdt"], "broken.bdt: damaged .bdt file: section "),
        (
            &["a.bdt", "-o", "none/out.html"],
            "none/out.html: folder none does not exist\n",
        ),
    ] {
        let ran = folder.run(&[&["report"], arguments].concat());
        assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{arguments:?}");
        assert!(
            ran.err.starts_with(expected) && ran.err.lines().count() == 1,
            "{}",
            ran.err
        );
        assert!(!folder.path("out.html").exists());
    }
    let ran = folder.run(&["report", "a.bdt", "-o", "out.txt"]);
    let text = "out.txt: unknown extension: .html can be written\n";
    assert_eq!((ran.code, ran.err.as_str()), (2, text));
    folder.write("a.html", folder.read("a.bdt"));
    let ran = folder.run(&["report", "a.html"]);
    assert_eq!(ran.code, 1);
    assert!(
        ran.err.contains("is the input: it would be overwritten"),
        "{}",
        ran.err
    );
}

#[test]
fn pictures_of_the_page_stand_as_those_of_render() {
    let folder = Folder::new();
    for up in ["y", "z", "-x"] {
        let found = folder.portrait(&["--up", up]);
        let fixed = ["--no-legend", "--shadow", "-o", "out.png", "--up", up];
        folder.render_at("720x540", &[&["rigid.bdt"], &fixed[..]].concat());
        let expected = Picture::read(&folder.path("out.png"));
        assert_eq!(found.size, expected.size);
        assert!(found.pixels == expected.pixels, "{up}");
        let default = folder.portrait(&[]);
        assert_eq!(found.pixels == default.pixels, up == "y", "{up}");
    }
    let ran = folder.run(&["report", "rigid.bdt", "--up", "w"]);
    assert_eq!(ran.code, 2, "{}", ran.err);
}

#[test]
fn the_page_lies_beside_the_file() {
    let folder = Folder::new();
    let ran = folder.run(&["report", "rigid.bdt"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, "measuring levels\n"));
    assert!(ran.out.ends_with("wrote rigid.html\n"), "{}", ran.out);
    assert!(folder.path("rigid.html").exists());
    let ran = folder.run(&["report", "rigid.bdt", "--json"]);
    assert!(ran.out.starts_with('{') && ran.code == 0);
}
