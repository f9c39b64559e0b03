//! Every messy file of the corpus: the right mesh, or the right complaint.
//!
//! The corpus is the folder `$BDTREE_CORPUS/messy`. Without the variable the tests pass with a
//! line that says so, unless `BDTREE_CORPUS_REQUIRED=1`.

use std::path::{Path, PathBuf};

use bdtree_build::input::read_mesh;
use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::progress::Silent;

/// The corpus folder `name`, or `None` after saying that it is skipped.
fn corpus(name: &str) -> Option<PathBuf> {
    let thread = std::thread::current();
    bdtree_fixtures::corpus::path(thread.name().unwrap_or("messy"), name)
}

enum Expected {
    /// Numbers of vertices, triangles and warnings.
    Mesh(usize, usize, usize),
    /// Each problem, after the file's path.
    Error(&'static [&'static str]),
}
use Expected::{Error, Mesh};

const TABLE: &[(&str, Expected)] = &[
    (
        "box_UTF16BE.obj",
        Error(&[": UTF-16 text (by its byte order mark); save the file as UTF-8 or ASCII"]),
    ),
    ("box_longline.obj", Mesh(8, 944, 6)),
    ("box_without_lineending.obj", Mesh(8, 12, 0)),
    ("catmark_torus_creases0.obj", Mesh(32, 64, 1)),
    ("cgal_degtri_sliding.obj", Mesh(8, 8, 4)),
    ("cgal_fold.obj", Mesh(12, 12, 0)),
    ("cgal_quads_to_stitch.obj", Mesh(20, 16, 0)),
    ("cgal_tetra_intersected_by_triangle.obj", Mesh(7, 5, 0)),
    ("concave_polygon.obj", Mesh(64, 64, 1)),
    ("cornell_box.obj", Mesh(76, 36, 0)),
    ("cube-vertex-w-component.obj", Mesh(8, 12, 0)),
    ("cube_compressed.obj", Mesh(8, 12, 0)),
    ("cube_with_vertexcolors.obj", Mesh(8, 12, 0)),
    ("curtain_soup.obj", Mesh(2022, 674, 0)),
    ("curtain_t_junctions.obj", Mesh(442, 771, 0)),
    ("empty.obj", Error(&[": the file is empty"])),
    ("face_in_group_name.obj", Error(&[": no faces (`f` lines)"])),
    (
        "fish_bad_faces.obj",
        Error(&[":2842: corner 3 `99999999` is out of range: the file has 945 vertices"]),
    ),
    (
        "fish_inf.obj",
        Error(&[
            ":101: y `inf` is not a finite number",
            ":201: x `-Infinity` is not a finite number",
        ]),
    ),
    (
        "fish_truncated.obj",
        Error(&[":3386: a face needs 3 corners or more, found 2"]),
    ),
    ("groups.obj", Mesh(1156, 2308, 0)),
    (
        "invalid-face-definition.obj",
        Error(&[
            ":15: a face needs 3 corners or more, found 1",
            ":18: a face needs 3 corners or more, found 2",
        ]),
    ),
    (
        "invalid-relative-vertex-index.obj",
        Error(&[
            ": no vertices (`v` lines)",
            ":1: corner 1 `-4`: relative index before the first vertex; 0 vertices so far",
        ]),
    ),
    (
        "issue-140-zero-face-idx.obj",
        Error(&[":16: corner 1 `0/0/0`: index 0; the first vertex is 1"]),
    ),
    ("issue-295-trianguation-failure.obj", Mesh(16, 28, 0)),
    ("issue-319-003.obj", Mesh(10, 8, 0)),
    ("joined_tetrahedra.obj", Mesh(5, 8, 0)),
    ("leading-decimal-dot-issue-201.obj", Mesh(3, 1, 0)),
    (
        "line-prim.obj",
        Error(&[": no faces (`f` lines), only 2 line statements"]),
    ),
    (
        "malformed.obj",
        Error(&[
            ":23: corner 2 `12` is out of range: the file has 8 vertices",
            ":28: corner 1 `0`: index 0; the first vertex is 1",
        ]),
    ),
    ("multiple_spaces.obj", Mesh(4, 1, 0)),
    ("nancolor.obj", Mesh(8, 12, 0)),
    ("negative_indices.obj", Mesh(8, 12, 0)),
    ("not_convex.obj", Mesh(288, 96, 0)),
    (
        "notenoughindices.obj",
        Error(&[":9: a face needs 3 corners or more, found 2"]),
    ),
    (
        "number_formats.obj",
        Error(&[
            ":11: z `3.1+e2` is not a number",
            ":12: z `+3.1+e2` is not a number",
            ":13: z `-3.1+e2` is not a number",
            ":15: z `3.1-e2` is not a number",
            ":16: z `+3.1-e2` is not a number",
            ":17: z `-3.1-e2` is not a number",
        ]),
    ),
    ("obj_with_no_face_in_chunk.obj", Mesh(3, 1, 0)),
    ("only_a_part_of_vertexcolors.obj", Mesh(5, 3, 0)),
    ("polygonfaces.obj", Mesh(5, 3, 0)),
    ("quadknot.obj", Mesh(1440, 2880, 0)),
    ("regr01.obj", Mesh(2108, 2710, 4)),
    ("regr_3429812.obj", Mesh(4, 4, 0)),
    ("singlevn.obj", Mesh(4, 2, 0)),
    ("soup_env.obj", Mesh(6540, 2180, 1)),
    ("soup_rob.obj", Mesh(648, 216, 1)),
    ("spot_cr_only.obj", Mesh(188, 372, 2)),
    ("spot_offset_1e6.obj", Mesh(188, 372, 2)),
    ("spot_scale_1e-6.obj", Mesh(188, 372, 2)),
    (
        "test-nan.obj",
        Error(&[
            ":12: x `nan` is not a finite number",
            ":13: x `inf` is not a finite number",
            ":14: x `1.#IND` is not a number",
            ":15: x `1.#INF` is not a number",
        ]),
    ),
    (
        "testline.obj",
        Error(&[": no faces (`f` lines), only 6 line statements"]),
    ),
    ("testmixed.obj", Mesh(8, 12, 1)),
    (
        "testpoints.obj",
        Error(&[": no faces (`f` lines), only 6 point statements"]),
    ),
];

#[test]
fn every_messy_obj_gives_its_mesh_or_its_complaint() {
    let Some(folder) = corpus("messy") else {
        return;
    };
    for (name, expected) in TABLE {
        let path = folder.join(name);
        let place = path.display().to_string();
        match (read_mesh(&path), expected) {
            (Ok(mesh), Mesh(vertices, triangles, warnings)) => {
                let found = (
                    mesh.positions.len(),
                    mesh.triangles.len(),
                    mesh.warnings.len(),
                );
                assert_eq!(found, (*vertices, *triangles, *warnings), "{name}");
                assert_eq!(&mesh.name, name);
            }
            (Err(error), Error(problems)) => {
                let wanted: Vec<String> = problems.iter().map(|p| format!("{place}{p}")).collect();
                assert_eq!(error.to_string(), wanted.join("\n"), "{name}");
            }
            (Ok(_), Error(_)) => panic!("{name} should not be readable"),
            (Err(error), Mesh(..)) => panic!("{name}: {error}"),
        }
    }
}

#[test]
fn no_messy_obj_is_missing_from_the_table() {
    let Some(folder) = corpus("messy") else {
        return;
    };
    for path in files(&folder) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_obj = path.extension().is_some_and(|e| e == "obj");
        assert!(
            !is_obj || TABLE.iter().any(|(known, _)| *known == name),
            "{name}"
        );
    }
}

#[test]
fn other_messy_formats_are_refused_with_what_is_read() {
    let Some(folder) = corpus("messy") else {
        return;
    };
    let formats = ["pc2", "mdd"];
    let others = files(&folder).into_iter();
    let mut count = 0;
    for path in others.filter(|p| {
        p.extension()
            .is_some_and(|e| formats.iter().any(|f| e == *f))
    }) {
        let error = read_mesh(&path).unwrap_err().to_string();
        assert!(error.contains("Give frames with --animation"), "{error}");
        let mesh = read_mesh(&bdtree_fixtures::models::path("cube_quads")).expect("a mesh");
        let error = FrameSequence::open(&path, Some(&mesh), None, &Silent).unwrap_err();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        assert!(error.to_string().contains(&*name), "{error}");
        count += 1;
    }
    assert!(count > 0);
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a corpus folder can be listed");
    entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .collect()
}
