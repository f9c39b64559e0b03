//! The fixtures are what their table says, and read back as they were made.

use bdtree_build::input::{obj, read_mesh};
use bdtree_tests::fixtures;

/// Vertices and triangles, as `fixtures/README.md` lists them.
const COUNTS: [(&str, usize, usize); 30] = [
    ("chair", 9240, 17914),
    ("fish", 12390, 24776),
    ("bridge", 135926, 240316),
    ("curtain", 6184, 12020),
    ("face", 20656, 40598),
    ("triangle", 3, 1),
    ("tetrahedron", 4, 4),
    ("cube_quads", 8, 12),
    ("icosphere", 642, 1280),
    ("torus", 1152, 2304),
    ("rod", 404, 804),
    ("slivers", 184, 64),
    ("duplicates", 960, 320),
    ("non_manifold", 24, 22),
    ("pieces", 680, 1280),
    ("far", 642, 1280),
    ("far_8", 162, 320),
    ("tiny", 1152, 2304),
    ("sizes", 156, 260),
    ("components", 864, 864),
    ("touching", 210, 304),
    ("cube", 98, 192),
    ("line", 41, 60),
    ("beam", 1314, 2624),
    ("sheet", 1681, 3200),
    ("groups_unused", 2304, 2304),
    ("spellings", 8, 12),
    ("morph_nodes.glb", 52, 96),
    ("morph_nodes.gltf", 52, 96),
    ("strips_fans.glb", 24, 12),
];

#[test]
fn counts_are_as_listed() {
    for (name, vertices, triangles) in COUNTS {
        let mesh = read_mesh(&fixtures::path(name)).expect("a valid fixture");
        let found = (mesh.positions.len(), mesh.triangles.len());
        assert_eq!(found, (vertices, triangles), "{name}");
    }
    for fixture in fixtures::meshes().filter(|f| !f.is_broken) {
        let is_listed = COUNTS.iter().any(|(name, ..)| *name == fixture.name);
        assert!(is_listed, "{}", fixture.name);
    }
}

/// Table 1 of the paper: triangles exactly, vertices within 2 %.
#[test]
fn the_papers_meshes_have_the_papers_sizes() {
    let paper = [
        ("chair", 9421_usize, 17914),
        ("fish", 12531, 24776),
        ("bridge", 135304, 240316),
        ("curtain", 6184, 12020),
    ];
    for (name, vertices, triangles) in paper {
        let mesh = fixtures::mesh(name).expect("a fixture made from a mesh");
        assert_eq!(mesh.triangles.len(), triangles, "{name}");
        let off = mesh.positions.len().abs_diff(vertices);
        assert!(50 * off <= vertices, "{name}: {off} vertices off");
        assert!(mesh.is_manifold(), "{name}");
    }
}

#[test]
fn committed_files_are_what_is_made_now() {
    for fixture in fixtures::all().iter().filter(|f| !f.is_large) {
        let file = std::fs::read(fixtures::place(fixture)).expect("committed fixtures are there");
        let same = file == fixtures::content(fixture.name);
        assert!(same, "{} differs; run make-fixtures", fixture.name);
        assert!(
            file.len() < 1_000_000,
            "{} is too large to commit",
            fixture.name
        );
    }
}

#[test]
fn what_was_made_is_what_is_read() {
    for fixture in fixtures::all().iter().filter(|f| !f.is_large) {
        let Some(made) = fixtures::mesh(fixture.name) else {
            continue;
        };
        let mesh = obj::parse(&fixtures::content(fixture.name), fixture.name).expect("valid");
        assert_eq!(mesh.triangles, made.triangles, "{}", fixture.name);
        let half_digit = if fixture.name == "tiny" {
            0.51e-12
        } else {
            0.51e-6
        };
        for (p, q) in mesh.positions.iter().zip(&made.positions) {
            for k in 0..3 {
                assert!((p[k] - q[k]).abs() <= half_digit, "{}", fixture.name);
            }
        }
    }
}

#[test]
fn broken_fixtures_name_every_mistake() {
    let expected = [
        ("bad_empty", "b.obj: the file is empty"),
        (
            "bad_no_faces",
            "b.obj: no faces (`f` lines), only 1 line statements",
        ),
        (
            "bad_no_vertices",
            "b.obj: no vertices (`v` lines)\nb.obj:2: vertex 1 is out of range: the file has 0",
        ),
        (
            "bad_utf16",
            "b.obj: UTF-16 text (by its byte order mark); save the file as UTF-8 or ASCII",
        ),
        (
            "bad_truncated",
            "b.obj:15: a face needs 3 corners or more, found 2",
        ),
        (
            "bad_nan",
            "b.obj:15: y `nan` is not a finite number\nb.obj:16: x `inf` is not a finite \
             number\nb.obj:17: z `1e999` is not a finite number",
        ),
        (
            "bad_index_zero",
            "b.obj:15: corner 1 `0`: index 0; the first vertex is 1",
        ),
        (
            "bad_index_range",
            "b.obj:15: vertex 9 is out of range: the file has 8\nb.obj:16: corner 1 `-9`: relative \
             index before the first vertex; 8 vertices so far\nb.obj:17: corner 3 \
             `99999999999999999999`: index beyond the greatest number of vertices",
        ),
        (
            "bad_numbers",
            "b.obj:15: x `1.0D0` is not a number\nb.obj:16: x `1,5` is not a number\nb.obj:17: a \
             vertex needs 3 coordinates, found 2\nb.obj:18: x `0x1` is not a number\nb.obj:19: \
             corner 3 `x`: is not a vertex index\nb.obj:20: corner 3 `3/a`: has a texture or \
             normal index that is no integer\nb.obj:21: corner 1 `1/2/3/4`: has more than three \
             parts",
        ),
    ];
    for (name, text) in expected {
        let error = obj::parse(&fixtures::content(name), "b.obj").expect_err(name);
        assert_eq!(error.to_string(), text, "{name}");
    }
    let broken = fixtures::meshes().filter(|f| f.is_broken).count();
    assert_eq!(broken, expected.len());
}
