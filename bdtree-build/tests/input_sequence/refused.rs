//! What is refused, and where.

use std::fs;

use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::progress::Silent;
use bdtree_fixtures::models::{self, fields::npy_with};

use crate::support::{FRAMES, VERTICES, fixture_folder, open, refusal, wave_mesh};

#[test]
fn frames_with_other_vertices_or_faces_are_named() {
    let found = refusal(&fixture_folder("bad_wave_count"), None);
    assert_eq!(
        found.replace(&format!("{}/", models::folder().display()), ""),
        "bad_wave_count/wave_02.obj: 55 vertices, but 54 in bad_wave_count/wave_00.obj: a folder holds the frames of one \
         animation; meshes are baked one by one"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let text = |t| fs::read_to_string(models::path(&format!("wave/wave_0{t}.obj"))).expect("ok");
    let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("ok");
    put("a.obj", &text(0));
    put("b.obj", &text(1).replace("f 1 2 11\n", "f 2 11 1\n"));
    put("c.obj", &format!("{}f 1 2 3\n", text(2)));
    put("d.obj", &text(3).replace("f 1 2 11\n", "f 1 2 99\n"));
    put("e.obj", &text(4));
    let prefix = format!("{}/", folder.path().display());
    let found = refusal(folder.path(), None).replace(&prefix, "");
    let name = folder
        .path()
        .file_name()
        .expect("a name")
        .to_string_lossy()
        .into_owned();
    let found = found.replace(&format!("{name}/"), "");
    let lines: Vec<&str> = found.lines().collect();
    assert_eq!(lines.len(), 3, "{found}");
    assert_eq!(
        lines[0],
        "b.obj: triangle 0 has the corners 2 11 1, but 1 2 11 (vertices from 1) in a.obj: a folder holds \
         the frames of one animation; meshes are baked one by one"
    );
    assert_eq!(lines[1], "c.obj: 81 triangles, but 80 in a.obj");
    assert!(
        lines[2].starts_with("d.obj:56: corner 3 `99` is out of range"),
        "{found}"
    );
}

#[test]
fn the_input_must_fit() {
    let mut mesh = wave_mesh();
    let folder = fixture_folder("wave");
    assert!(open(&folder, Some(&mesh)).first_mesh.is_none());
    mesh.triangles.swap(0, 1);
    let sequence = open(&folder, Some(&mesh));
    let warning = sequence.warnings.join("\n");
    assert!(
        warning.contains("wave_00.obj: triangle 0 has the corners 1 2 11, but 1 11 10")
            && warning.ends_with("in wave_00.obj; the faces of wave_00.obj are used"),
        "{warning}"
    );
    mesh.positions.pop();
    for name in ["wave.pc2", "wave.mdd", "wave.npy"] {
        let text = refusal(&models::path(name), Some(&mesh));
        let expected = format!("{name}: 54 vertices per frame, but wave_00.obj has 53");
        assert_eq!(text, expected);
        let text = refusal(&models::path(name), None);
        assert!(
            text.ends_with("name the mesh they belong to as INPUT"),
            "{text}"
        );
    }
    let text = refusal(&folder, Some(&mesh));
    assert_eq!(
        text,
        "wave/wave_00.obj: 54 vertices per frame, but wave_00.obj has 53"
    );
}

#[test]
fn numbers_that_are_no_coordinates_are_listed() {
    let mesh = wave_mesh();
    let text = refusal(&models::path("bad_wave_nan.npy"), Some(&mesh));
    assert_eq!(
        text,
        "bad_wave_nan.npy: frame 1, vertex 7, z: NaN is not finite"
    );

    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.npy");
    let mut values = vec![1.0_f64; FRAMES * VERTICES * 3];
    values[..200].fill(f64::INFINITY);
    values[200] = -1e31;
    let bytes = values.iter().flat_map(|x| x.to_le_bytes());
    let shape = format!("{FRAMES},{VERTICES},3");
    // In Fortran order the frame varies fastest.
    fs::write(&path, npy_with("<f8", true, &shape, bytes)).expect("writable");
    let text = refusal(&path, Some(&mesh));
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 2);
    let first = "a.npy: frame 0, vertex 0, x: inf is not finite (and 99 problems like it, at frame 1, vertex 0, x; ";
    assert!(lines[0].starts_with(first), "{}", lines[0]);
    assert!(lines[0].contains("frame 1, vertex 1, x; "), "{}", lines[0]);
    assert_eq!(lines[1], "a.npy: 101 more problems");
    values[..200].fill(0.0);
    let bytes = values.iter().flat_map(|x| x.to_le_bytes());
    fs::write(&path, npy_with("<f8", false, &shape, bytes)).expect("writable");
    assert_eq!(
        refusal(&path, Some(&mesh)),
        "a.npy: frame 1, vertex 12, z: -1e31 is too large: coordinates lie within 2^100"
    );

    for t in 0..2 {
        let text = fs::read_to_string(models::path(&format!("wave/wave_0{t}.obj"))).expect("ok");
        let text = if t == 0 {
            text
        } else {
            text.replace("v 0 ", "v 1e40 ")
        };
        fs::write(folder.path().join(format!("{t}.obj")), text).expect("ok");
    }
    let text = refusal(folder.path(), None);
    assert!(
        text.contains("1.obj, vertex 0, x: 1e40 is too large"),
        "{text}"
    );
}

#[test]
fn files_are_as_long_as_they_say() {
    let mesh = wave_mesh();
    let text = refusal(&models::path("bad_wave_truncated.pc2"), Some(&mesh));
    assert_eq!(
        text,
        "bad_wave_truncated.pc2: truncated: 6 frames of 54 points need 3920 bytes, the file has \
         1960, which is 2 whole frames"
    );
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["wave.pc2", "wave.mdd", "wave.npy"] {
        let bytes = fs::read(models::path(name)).expect("readable");
        let path = folder.path().join(name);
        for end in (0..150)
            .step_by(3)
            .chain([bytes.len() - 13, bytes.len() - 1])
        {
            fs::write(&path, &bytes[..end]).expect("writable");
            let text = refusal(&path, Some(&mesh));
            assert!(text.starts_with(name), "{end}: {text}");
        }
        fs::write(&path, [&bytes[..], &[0]].concat()).expect("writable");
        let text = refusal(&path, Some(&mesh));
        assert!(text.contains("has bytes after its"), "{text}");
        // Every byte of the header, some values: no panic, no absurd allocation.
        for at in 0..bytes.len().min(140) {
            for value in [0, 0x7f, 0xff] {
                let mut damaged = bytes.clone();
                damaged[at] = value;
                fs::write(&path, damaged).expect("writable");
                let _ = FrameSequence::open(&path, Some(&mesh), Some(24.0), &Silent);
            }
        }
    }
}

#[test]
fn nothing_is_refused_by_name() {
    let mesh = wave_mesh();
    let folder = tempfile::tempdir().expect("a folder");
    let put = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("writable");
        path
    };
    let pc2 = fs::read(models::path("wave.pc2")).expect("readable");
    let mdd = fs::read(models::path("wave.mdd")).expect("readable");
    let with = |bytes: &[u8], at: usize, value: i32, big: bool, keep: usize| {
        let mut bytes = bytes[..keep].to_vec();
        let value = if big {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        };
        bytes[at..at + 4].copy_from_slice(&value);
        bytes
    };
    let cases = [
        (
            "no_frames.pc2",
            with(&pc2, 28, 0, false, 32),
            "holds 0 frames of 54 points",
        ),
        (
            "no_points.pc2",
            with(&pc2, 16, 0, false, 32),
            "holds 6 frames of 0 points",
        ),
        (
            "minus.pc2",
            with(&pc2, 28, -3, false, 32),
            "the header says -3 frames",
        ),
        (
            "version.pc2",
            with(&pc2, 12, 2, false, 32),
            "PC2 version 2; version 1 is read",
        ),
        (
            "huge.pc2",
            with(&pc2, 28, i32::MAX, false, 32),
            "which is 0 whole frames",
        ),
        (
            "magic.pc2",
            mdd.clone(),
            "it does not begin with POINTCACHE2",
        ),
        (
            "no_frames.mdd",
            with(&mdd, 0, 0, true, 8),
            "holds 0 frames of 54 points",
        ),
        (
            "minus.mdd",
            with(&mdd, 4, -1, true, 8),
            "the header says -1 points",
        ),
        (
            "huge.mdd",
            with(&mdd, 0, i32::MAX, true, 8),
            "which is 0 whole frames",
        ),
        (
            "flat.npy",
            npy_with("<f8", false, "4,3", [0; 96]),
            "shape [4, 3] is not (T, N, 3)",
        ),
        (
            "none.npy",
            npy_with("<f8", false, "0,54,3", []),
            "holds 0 frames of 54 points",
        ),
        (
            "none.abc",
            Vec::new(),
            ".abc is no animation: an animation is a folder",
        ),
        (
            "none",
            Vec::new(),
            "no file extension: an animation is a folder",
        ),
    ];
    for (name, bytes, expected) in cases {
        let text = refusal(&put(name, &bytes), Some(&mesh));
        assert!(
            text.starts_with(name) && text.contains(expected),
            "{name}: {text}"
        );
    }
    assert!(refusal(&folder.path().join("missing.pc2"), None).contains("cannot be read"));
    let others = tempfile::tempdir().expect("a folder");
    assert!(refusal(others.path(), None).contains("an empty folder: no .obj frames"));
    fs::write(others.path().join("a.txt"), "").expect("writable");
    assert!(refusal(others.path(), None).contains("its one entry is no .obj frame"));
}
