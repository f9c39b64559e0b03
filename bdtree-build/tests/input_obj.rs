//! The OBJ reader, statement by statement.

use std::io::Write;
use std::path::Path;

use bdtree_build::error::{Part, Place};
use bdtree_build::input::{BadFaces, GroupKind, RawMesh, obj, read_mesh};
use flate2::{Compression, write::GzEncoder};
use sha2::{Digest, Sha256};

fn parse(text: &str) -> Result<RawMesh, String> {
    obj::parse(text.as_bytes(), "m.obj", BadFaces::Refuse).map_err(|e| e.to_string())
}

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";

#[test]
fn ids_count_fan_triangles_in_file_order() {
    let mesh = parse(&format!(
        "{CORNERS}v 2 2 0\nf 1 2 4 3\nf -1/7 -3//2 -5/1/1\n"
    ))
    .unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 3], [0, 3, 2], [4, 2, 0]]);
    assert_eq!(mesh.positions.len(), 5);
    assert!(mesh.warnings.is_empty());
}

#[test]
fn positive_indices_may_refer_ahead() {
    let mesh = parse(&format!("f 1 2 3\nf 2 2 3\n{CORNERS}f 1 2 3\n")).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [1, 1, 2], [0, 1, 2]]);
    assert_eq!(
        mesh.warnings,
        ["m.obj:2: triangle 1 repeats a corner (kept)"]
    );
    let error = parse(&format!("f 1 2 5\n{CORNERS}f 1 0 2")).unwrap_err();
    let lines = "m.obj:1: corner 3 `5` is out of range: the file has 4 vertices\n\
                 m.obj:6: corner 2 `0`: index 0; the first vertex is 1";
    assert_eq!(error, lines);
}

#[test]
fn coordinates_are_the_nearest_f64() {
    let text = "v 0.1 +1e3 -.5E-2 nan nan nan\nv 9007199254740993 1. 1e-400 # w\nv 0 0 1\nf 1 2 3";
    let mesh = parse(text).unwrap();
    assert_eq!(mesh.positions[0], [0.1, 1000.0, -0.005]);
    assert_eq!(mesh.positions[1], [9_007_199_254_740_992.0, 1.0, 0.0]);
}

#[test]
fn groups_are_ranges_per_kind() {
    let text = format!(
        "{CORNERS}o a b\ng left  arm\nf 1 2 3 4\nusemtl m#1\nf 1 2 3\ng\nf 1 2 4\no last\n"
    );
    let mesh = parse(&text).unwrap();
    let groups: Vec<(GroupKind, &str, u32, u32)> = mesh
        .groups
        .iter()
        .map(|g| (g.kind, g.name.as_str(), g.first_triangle, g.triangle_count))
        .collect();
    let expected = [
        (GroupKind::Object, "a b", 0, 4),
        (GroupKind::Group, "left  arm", 0, 3),
        (GroupKind::Material, "m#1", 2, 2),
        (GroupKind::Group, "", 3, 1),
        (GroupKind::Object, "last", 4, 0),
    ];
    assert_eq!(groups, expected);
}

#[test]
fn oddities_are_listed_then_counted() {
    let line = "f 1 1 2\nf 1 2 2 3\n";
    let mesh = parse(&format!(
        "{CORNERS}{}f 1 2 3 1\nl 1 2\np 1\nsurf 1\nfoo\nfoo\n",
        line.repeat(4)
    ));
    let warnings = mesh.unwrap().warnings;
    assert_eq!(warnings[0], "m.obj:5: triangle 0 repeats a corner (kept)");
    assert_eq!(
        warnings[5],
        "m.obj: 4 more triangles that repeat a corner (kept)"
    );
    let skipped = "m.obj: ignored 1 point, 1 line, 1 curve or surface statements";
    assert_eq!(warnings[6], skipped);
    assert_eq!(warnings[7], "m.obj: ignored unknown statements: 2 × `foo`");
    assert_eq!(warnings.len(), 8);
    let mesh =
        parse("v 0 0 0\nv .1 .2 .3\nv .2 .4 .6\nv 1e-200 0 0\nv 0 1e-200 0\nf 1 2 3\nf 1 4 5");
    assert_eq!(
        mesh.unwrap().warnings,
        ["m.obj:6: triangle 0 has zero area (kept)"]
    );
}

/// A polygon's fan covers area outside a concave one, unless it starts at the corner that turns inward.
#[test]
fn concave_polygons_are_told() {
    // An L: corner 4 turns inward.
    let corners = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n";
    let warnings = |face: &str| {
        let mesh = parse(&format!("{corners}f 1 2 3\n{face}\n"));
        mesh.expect("a mesh").warnings
    };
    let told = "m.obj:8: triangle 1 lies outside its polygon, which is concave and cut into a fan: triangulate it when \
                exporting";
    assert_eq!(
        warnings("f 5 6 1 2 3 4"),
        [told.replace("triangle 1", "triangle 4")]
    );
    assert_eq!(warnings("f 3 4 5 6 1 2"), [told]);
    for fine in ["f 4 5 6 1 2 3", "f 1 2 3 4", "f 1 3 5", "f 1 2 3 6"] {
        assert_eq!(warnings(fine), [""; 0], "{fine}");
    }
    // Vertices that come later in the file.
    let later = parse(&format!("f 3 4 5 6 1 2\n{corners}")).expect("a mesh");
    assert_eq!(
        later.warnings,
        [told.replace(":8: triangle 1", ":1: triangle 0")]
    );
}

#[test]
fn problems_beyond_a_hundred_are_counted() {
    let error = obj::parse("v 1\n".repeat(250).as_bytes(), "m.obj", BadFaces::Refuse).unwrap_err();
    // The hundred that are listed are alike: the first stands for them.
    assert_eq!(error.problems.len(), 2);
    let line = Place::file("m.obj").at(Part::Line(1));
    assert_eq!(error.problems[0].place, line);
    assert!(
        error.problems[0]
            .message
            .contains("(and 99 problems like it, at line 2; line 3; ")
    );
    assert_eq!(error.problems[1].to_string(), "m.obj: 151 more problems");
}

#[test]
fn text_cut_or_damaged_anywhere_never_panics() {
    let text =
        format!("\u{feff}{CORNERS}# c\\\no n\ng a b\nvt 0 0\nf 1/1 2//1 \\\r\n -1\nl 1 2\nf 1 2 3");
    let bytes = text.as_bytes();
    for end in 0..=bytes.len() {
        let _ = obj::parse(&bytes[..end], "m.obj", BadFaces::Refuse);
        for value in [0, b'\\', b'\n', b'-', b'/', 0xff] {
            let mut damaged = bytes.to_vec();
            if let Some(byte) = damaged.get_mut(end) {
                *byte = value;
            }
            let _ = obj::parse(&damaged, "m.obj", BadFaces::Refuse);
        }
    }
}

#[test]
fn binary_data_is_no_text() {
    let error = obj::parse(b"v\x00 \x001\x00", "m.obj", BadFaces::Refuse)
        .unwrap_err()
        .to_string();
    assert_eq!(
        error,
        "m.obj: not OBJ text: zero bytes at the start (UTF-16 or binary data)"
    );
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut gz = GzEncoder::new(Vec::new(), Compression::default());
    gz.write_all(bytes).unwrap();
    gz.finish().unwrap()
}

#[test]
fn gzip_of_several_members_is_read_and_hashed_as_on_disk() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.OBJ.GZ");
    let mut bytes = gzip(CORNERS.as_bytes());
    bytes.extend(gzip(b"f 1 2 3\n"));
    std::fs::write(&path, &bytes).unwrap();
    let mesh = read_mesh(&path).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert_eq!(mesh.name, "two.OBJ.GZ");
    assert_eq!(mesh.hash, <[u8; 32]>::from(Sha256::digest(&bytes)));

    for end in 2..bytes.len() {
        std::fs::write(&path, &bytes[..end]).unwrap();
        // A cut between the members leaves a sound file without faces.
        let error = read_mesh(&path).unwrap_err().to_string();
        let named = error.contains("damaged or truncated gzip") || error.contains("no faces");
        assert!(named, "{end}: {error}");
    }
}

#[test]
fn compression_goes_by_content() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("{CORNERS}f 1 2 3");
    let (plain, packed) = (folder.path().join("a.obj.gz"), folder.path().join("b.obj"));
    std::fs::write(&plain, &text).unwrap();
    std::fs::write(&packed, gzip(text.as_bytes())).unwrap();
    assert_eq!(read_mesh(&plain).unwrap().triangles, [[0, 1, 2]]);
    assert_eq!(read_mesh(&packed).unwrap().triangles, [[0, 1, 2]]);
}

#[test]
fn paths_that_are_no_mesh_say_why() {
    let folder = tempfile::tempdir().unwrap();
    let message = |path: &Path| read_mesh(path).unwrap_err().to_string();
    let touch = |name: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, "x").unwrap();
        path
    };
    for later in ["a.off", "a.dae.gz", "a.fbx"] {
        assert!(message(&touch(later)).contains("not supported yet: export .glb"));
    }
    assert!(message(&touch("a.veg")).contains("give it as --tets"));
    assert!(message(&touch("a.pc2")).contains("not a mesh file. Give frames with --animation"));
    assert!(message(&touch("a.glb.gz")).contains("compressed .glb files are not read"));
    assert!(message(&touch("a.txt")).contains("unknown mesh format .txt"));
    assert!(message(&touch("noextension")).contains("no file extension"));
    assert!(message(folder.path()).contains("is a folder"));
    assert!(message(&folder.path().join("missing.obj")).contains("cannot be read"));
}
