//! Pictures of characters in the poses of their clips.

use bdtree_build::recipe::Motion;
use bdtree_fixtures::models;

use crate::drawn::{Picture, WHITE, spheres_hold};
use crate::support::{Folder, baked_surface, character, positions_of_npy};

/// Share of the pixels that are drawn on in one of two pictures only.
fn drawn_in_one(a: &Picture, b: &Picture) -> f64 {
    let pairs = a.pixels.iter().zip(&b.pixels);
    let count = pairs
        .filter(|(a, b)| (**a == WHITE) != (**b == WHITE))
        .count();
    count as f64 / a.pixels.len() as f64
}

/// How `deform` and `render` are asked for a pose of bones and morph targets.
const POSED: [&str; 5] = ["tube.bdt", "--clip", "wave", "--time", "0.7"];

/// A folder with the character, and what `deform` writes for its pose.
fn with_deformed(output: &str) -> Folder {
    let folder = Folder::new();
    folder.write("tube.bdt", character("skinned_tube.glb"));
    let ran = folder.run(&[&["deform"], &POSED[..], &["-o", output]].concat());
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    folder
}

/// The pose looks like the mesh that `deform` writes for it, baked without bones.
#[test]
fn a_posed_character_looks_like_its_deformed_mesh() {
    let folder = with_deformed("posed.obj");
    folder.write(
        "posed.bdt",
        baked_surface(folder.path("posed.obj"), Motion::Rigid),
    );
    for view in ["--view=30,20", "--view=-80,5"] {
        let plain = ["--no-legend", view];
        let shown = folder.picture(&[&POSED[..], &plain].concat());
        assert!(shown.covered() > 0.05, "{}", shown.covered());
        let mesh = folder.picture(&[&["posed.bdt"], &plain[..]].concat());
        let other = drawn_in_one(&shown, &mesh);
        assert!(other < 0.002, "{view}: {other} of the pixels");
        let rest = folder.picture(&[&["tube.bdt"], &plain[..]].concat());
        let other = drawn_in_one(&shown, &rest);
        assert!(other > 0.02, "{view}: only {other} of the pixels changed");
    }
}

/// The spheres of a level hold every vertex of the pose.
#[test]
fn spheres_of_a_posed_character_hold_its_vertices() {
    let folder = with_deformed("posed.npy");
    let vertices = positions_of_npy(&folder.read("posed.npy"));
    let (_, report) = folder.reported(&[&POSED[..], &["--spheres", "0"]].concat());
    spheres_hold(report["spheres"].as_array().expect("a list"), &vertices);
}

/// Growth is over the radius with the bones at rest: bones that scale, as a rig in other units does, are no growth.
#[test]
fn growth_is_over_bones_at_rest() {
    let folder = Folder::new();
    let source = std::fs::read(models::path("skinned_tube.glb")).expect("read");
    // As long as before, so that the binary chunk's place stays.
    let (old, new) = (b"\"translation\":[0,1,0]", b"\"scale\":[8,8,8]      ");
    let at = source.windows(old.len()).position(|w| w == old);
    let mut scaled = source.clone();
    let at = at.expect("the rig's place");
    scaled[at..at + new.len()].copy_from_slice(new);
    let growth = |bytes: &[u8], posture: &[&str]| {
        std::fs::write(folder.path("tube.glb"), bytes).expect("written");
        let motion = Motion::MorphsElseSkin(Default::default(), Default::default());
        let baked = baked_surface(folder.path("tube.glb"), motion);
        folder.write("tube.bdt", baked);
        let arguments = [&["tube.bdt", "--spheres", "1"], posture].concat();
        let (_, report) = folder.reported(&arguments);
        ["mean", "max"].map(|key| report["growth"][key].as_f64().expect("a number"))
    };
    assert_eq!(growth(&source, &[]), [1.0; 2]);
    assert_eq!(growth(&scaled, &[]), [1.0; 2]);
    let posed = growth(&source, &POSED[1..]);
    assert!(posed[1] > 1.01, "{posed:?}");
    let scaled = growth(&scaled, &POSED[1..]);
    // The rig stands elsewhere, too, so that the slack of rounding is not the same.
    for k in 0..2 {
        assert!((scaled[k] - posed[k]).abs() < 1e-3, "{scaled:?} {posed:?}");
    }
}
