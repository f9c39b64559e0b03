//! PLY and STL: the same mesh in every encoding, and what damaged files are told.

use std::fmt::Write;
use std::path::Path;

use bdtree_build::input::{BadFaces, RawMesh, obj, ply, read_mesh, stl};

/// A square of two triangles with a quad beside it.
const POSITIONS: [[f32; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.25],
    [0.0, 1.0, 0.0],
    [2.0, 0.0, -1.5],
    [2.0, 1.0, 0.0],
];
const FACES: [&[u32]; 3] = [&[0, 1, 2], &[0, 2, 3], &[1, 4, 5, 2]];
const TRIANGLES: [[u32; 3]; 4] = [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]];

fn header(encoding: &str, faces: usize) -> String {
    format!(
        "ply\nformat {encoding} 1.0\ncomment made by a test\nelement vertex 6\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nelement face {faces}\nproperty list uchar int vertex_indices\n\
         element edge 1\nproperty int vertex1\nend_header\n"
    )
}

fn ply_text(faces: &[&[u32]]) -> Vec<u8> {
    let mut text = header("ascii", faces.len());
    for [x, y, z] in POSITIONS {
        writeln!(text, "{x} {y} {z} 255").unwrap();
    }
    for face in faces {
        let corners: Vec<String> = face.iter().map(u32::to_string).collect();
        writeln!(text, "{} {}", corners.len(), corners.join(" ")).unwrap();
    }
    text += "3\n";
    text.into_bytes()
}

fn ply_binary(little: bool) -> Vec<u8> {
    let name = if little {
        "binary_little_endian"
    } else {
        "binary_big_endian"
    };
    let mut bytes = header(name, FACES.len()).into_bytes();
    let word = |x: u32| {
        if little {
            x.to_le_bytes()
        } else {
            x.to_be_bytes()
        }
    };
    for position in POSITIONS {
        bytes.extend(position.into_iter().flat_map(|x| word(x.to_bits())));
        bytes.push(255);
    }
    for face in FACES {
        bytes.push(face.len() as u8);
        bytes.extend(face.iter().flat_map(|&corner| word(corner)));
    }
    bytes.extend(word(3));
    bytes
}

fn ply(bytes: &[u8]) -> Result<RawMesh, String> {
    ply::parse(bytes, "m.ply", BadFaces::Refuse).map_err(|e| e.to_string())
}

fn stl_of(bytes: &[u8]) -> Result<RawMesh, String> {
    stl::parse(bytes, "m.stl").map_err(|e| e.to_string())
}

fn stl_binary(title: &[u8]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes[..title.len()].copy_from_slice(title);
    bytes.extend((TRIANGLES.len() as u32).to_le_bytes());
    for triangle in TRIANGLES {
        bytes.extend([0; 12]); // a normal that nobody needs
        let corners = triangle.map(|corner| POSITIONS[corner as usize]);
        bytes.extend(corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// The triangles as positions: numbers of vertices differ between formats.
fn corners(mesh: &RawMesh) -> Vec<[[f64; 3]; 3]> {
    let positions = |t: &[u32; 3]| t.map(|corner| mesh.positions[corner as usize]);
    mesh.triangles.iter().map(positions).collect()
}

#[test]
fn ply_is_the_same_mesh_in_every_encoding() {
    for bytes in [ply_text(&FACES), ply_binary(true), ply_binary(false)] {
        let mesh = ply(&bytes).expect("a mesh");
        assert_eq!(mesh.positions, POSITIONS.map(|p| p.map(f64::from)));
        assert_eq!(mesh.triangles, TRIANGLES);
        assert_eq!(mesh.warnings, ["m.ply: ignored 1 elements `edge`"]);
    }
}

#[test]
fn stl_welds_corners_with_equal_coordinates() {
    let named =
        stl_of(&stl_binary(b"solid of a program that writes binary files")).expect("a mesh");
    assert_eq!(named, stl_of(&stl_binary(b"")).expect("a mesh"));
    assert_eq!((named.positions.len(), named.triangles.len()), (6, 4));
    let mut text = String::new();
    // Two solids, one without a name; the second repeats a corner as −0.
    for (title, triangles) in [("", &TRIANGLES[..2]), ("two", &TRIANGLES[2..])] {
        writeln!(text, "solid {title}").unwrap();
        for triangle in triangles {
            text += "  facet normal 0 0 1\n    outer loop\n";
            for corner in triangle {
                let [x, y, z] =
                    POSITIONS[*corner as usize].map(|x| if x == 0.0 { -0.0 } else { x });
                writeln!(text, "      vertex {x} {y} {z}").unwrap();
            }
            text += "    endloop\n  endfacet\n";
        }
        writeln!(text, "endsolid {title}").unwrap();
    }
    let text = text.replace("solid \n", "solid\n");
    let mesh = stl_of(text.as_bytes()).expect("a mesh");
    assert_eq!((mesh.positions.len(), corners(&mesh)), (6, corners(&named)));
    assert_eq!(
        corners(&ply(&ply_text(&FACES)).expect("a mesh")),
        corners(&mesh)
    );
}

#[test]
fn damaged_files_name_their_place() {
    let text = String::from_utf8(ply_text(&FACES)).unwrap();
    let says = |text: String, expected: &str| {
        let error = ply(text.as_bytes()).unwrap_err();
        assert!(error.starts_with(expected), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    };
    says(
        text.replace("3 0 2 3", "3 0 2 6"),
        "m.ply: face 1: corner 3 `6` is out of range: the file has 6 vertices, numbered from 0",
    );
    says(
        text.replace("3 0 2 3", "3 0 -2 3"),
        "m.ply: face 1: corner 2 `-2` is out of range",
    );
    says(
        text.replace("3 0 2 3", "2 0 2"),
        "m.ply: face 1: a face needs 3 corners or more, found 2",
    );
    says(
        text.replace("3 0 2 3", "3 0 x 3"),
        "m.ply:21: is not read as PLY",
    );
    says(
        text.replace("2 0 -1.5", "2 1e39 -1.5"),
        "m.ply: vertex 4, y: inf is not finite",
    );
    says(
        text.replace("property float z\n", ""),
        "m.ply: has vertices without x, y and z",
    );
    says(
        text.replace("vertex_indices", "corners"),
        "m.ply: has faces without vertex_indices",
    );
    says(
        text.replace("face 3", "face 99999999999"),
        "m.ply: is cut off: its header announces 99999999999 elements",
    );
    says("solid".to_string(), "m.ply:1: is not read as PLY");
    let error = stl_of(&stl_binary(b"")[..200]).unwrap_err();
    assert_eq!(
        error,
        "m.stl: is cut off: its header announces 284 bytes, found 200"
    );
    let error = stl_of(b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 zero\n").unwrap_err();
    assert!(error.starts_with("m.stl: triangle 0: "), "{error}");
    let error = stl_of(b"solid a\nendsolid a\n").unwrap_err();
    assert_eq!(error, "m.stl: no faces");
}

/// Cut or damaged anywhere, and with numbers that announce more than there is: an error or a mesh, never a panic, and
/// never memory that the file's size does not justify.
#[test]
fn files_damaged_anywhere_never_panic() {
    for bytes in [ply_text(&FACES), ply_binary(true), ply_binary(false)] {
        for at in 0..bytes.len() {
            let _ = ply(&bytes[..at]);
            for value in [0, 0xff, b'9', b'-', b'\n'] {
                let mut damaged = bytes.clone();
                damaged[at] = value;
                let _ = ply(&damaged);
            }
        }
    }
    let bytes = stl_binary(b"solid");
    for at in 0..bytes.len() {
        let _ = stl_of(&bytes[..at]);
        let mut damaged = bytes.clone();
        damaged[at] = 0xff;
        let _ = stl_of(&damaged);
    }
}

#[test]
fn bad_faces_can_be_skipped() {
    let faces: [&[u32]; 5] = [&[0, 1, 2], &[0, 9, 3], &[0, 2, 3], &[5], &[1, 4, 5, 2]];
    let bytes = ply_text(&faces);
    let mesh = ply::parse(&bytes, "m.ply", BadFaces::Skip).expect("a mesh");
    assert_eq!(mesh.triangles, TRIANGLES);
    let warnings = [
        "m.ply: face 1: skipped: corner 2 `9` is out of range: the file has 6 vertices, numbered from 0",
        "m.ply: face 3: skipped: a face needs 3 corners or more, found 1",
        "m.ply: skipped 2 bad faces: triangle ids count the others",
    ];
    assert_eq!(&mesh.warnings[..3], warnings);

    let mut text = String::from("f 1 7 2\ng first\nf 1 2 3\nf 1 0 2\n");
    for [x, y, z] in POSITIONS {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    text += "f 1 3 4\nf 1 2\ng second\nf 2 5 x\nf 2 5 6 3\n";
    let mesh = obj::parse(text.as_bytes(), "m.obj", BadFaces::Skip).expect("a mesh");
    assert_eq!(mesh.triangles, TRIANGLES);
    let groups: Vec<_> = mesh
        .groups
        .iter()
        .map(|g| (g.first_triangle, g.triangle_count))
        .collect();
    assert_eq!(groups, [(0, 2), (2, 2)]);
    assert_eq!(
        mesh.warnings[0],
        "m.obj:1: skipped: corner 2 `7` is out of range: the file has 6 vertices"
    );
    assert_eq!(
        mesh.warnings.last().map(String::as_str),
        Some("m.obj: skipped 4 bad faces: triangle ids count the others")
    );
    // What is wrong with vertices is an error all the same.
    let error = obj::parse(
        b"v 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "m.obj",
        BadFaces::Skip,
    );
    assert!(error.unwrap_err().to_string().starts_with("m.obj:1: "));
}

#[test]
fn files_are_told_by_their_extension() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str, bytes: &[u8]| -> Result<RawMesh, String> {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        read_mesh(Path::new(&path)).map_err(|e| e.to_string())
    };
    let mesh = read("a.PLY", &ply_binary(true)).expect("a mesh");
    assert_eq!((mesh.name.as_str(), mesh.triangles.len()), ("a.PLY", 4));
    assert_eq!(mesh.warnings, ["a.PLY: ignored 1 elements `edge`"]);
    assert_eq!(
        read("a.stl", &stl_binary(b""))
            .expect("a mesh")
            .triangles
            .len(),
        4
    );
    assert!(
        read("b.stl", b"x")
            .unwrap_err()
            .contains("neither STL text nor binary STL")
    );
}
