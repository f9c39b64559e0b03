//! Frame sequences: every format reads the same numbers, and says what is wrong where.

use std::fs;
use std::path::{Path, PathBuf};

use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_build::progress::Silent;
use bdtree_tests::corpus;
use bdtree_tests::fixtures::{self, fields::npy_with};

const FRAMES: usize = 6;
const VERTICES: usize = 54;

fn fixture_folder(name: &str) -> PathBuf {
    let first = fixtures::path(&format!("{name}/wave_00.obj"));
    first.parent().expect("a folder").to_path_buf()
}

fn wave_mesh() -> RawMesh {
    read_mesh(&fixtures::path("wave/wave_00.obj")).expect("a valid fixture")
}

fn open(path: &Path, input: Option<&RawMesh>) -> FrameSequence {
    FrameSequence::open(path, input, None, &Silent).expect("a valid sequence")
}

/// What opening says, without the folder.
fn refusal(path: &Path, input: Option<&RawMesh>) -> String {
    let error = FrameSequence::open(path, input, None, &Silent).expect_err("should be refused");
    let folder = path.parent().expect("a folder").display().to_string();
    error.to_string().replace(&format!("{folder}/"), "")
}

/// All numbers, read `step` vertices at a time, frame after frame.
fn all(sequence: &FrameSequence, step: usize) -> Vec<[f64; 3]> {
    let (n, frames) = (sequence.vertex_count(), sequence.frame_count());
    let mut result = vec![[f64::NAN; 3]; n * frames];
    for first in (0..n).step_by(step) {
        let count = step.min(n - first);
        let mut values = vec![f64::NAN; 3 * count * frames];
        sequence
            .read(first..first + count, &mut values)
            .expect("readable");
        for t in 0..frames {
            for i in 0..count {
                let at = 3 * (t * count + i);
                result[t * n + first + i] = [values[at], values[at + 1], values[at + 2]];
            }
        }
    }
    result
}

fn as_single(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let single = |x: &f64| f64::from(*x as f32);
    points
        .iter()
        .map(|p| [0, 1, 2].map(|k| single(&p[k])))
        .collect()
}

/// The wave from its OBJ texts.
fn expected() -> Vec<[f64; 3]> {
    let frame = |t| read_mesh(&fixtures::path(&format!("wave/wave_0{t}.obj"))).expect("valid");
    (0..FRAMES).flat_map(|t| frame(t).positions).collect()
}

#[test]
fn every_format_has_the_same_frames() {
    let mesh = wave_mesh();
    let expected = expected();
    let single = as_single(&expected);
    assert_ne!(
        expected, single,
        "the fixture should tell the precisions apart"
    );
    let folder = open(&fixture_folder("wave"), None);
    let first = folder.first_mesh().expect("frames are meshes");
    assert_eq!(
        (&first.positions, &first.triangles),
        (&mesh.positions, &mesh.triangles)
    );
    assert_eq!((first.name.as_str(), first.hash), ("wave", folder.hash()));
    let sequences = [
        (folder, &expected),
        (open(&fixtures::path("wave.npy"), Some(&mesh)), &expected),
        (open(&fixtures::path("wave.pc2"), Some(&mesh)), &single),
        (open(&fixtures::path("wave.mdd"), Some(&mesh)), &single),
    ];
    for (sequence, expected) in &sequences {
        assert_eq!(sequence.frame_count(), FRAMES);
        assert_eq!(sequence.vertex_count(), VERTICES);
        assert!(sequence.warnings().is_empty(), "{:?}", sequence.warnings());
        for step in [1, 7, VERTICES, 1000] {
            assert_eq!(
                &&all(sequence, step),
                expected,
                "{} {step}",
                sequence.name()
            );
        }
        assert!(sequence.read(50..55, &mut [0.0; 90]).is_err());
        assert!(sequence.read(50..54, &mut [0.0; 71]).is_err());
    }
    let place = sequences[0].0.place(3);
    assert!(place.ends_with("wave/wave_03.obj"), "{place}");
    let place = sequences[2].0.place(3);
    assert!(place.ends_with("wave.pc2: frame 3"), "{place}");
}

#[test]
fn arrays_come_in_every_precision_and_order() {
    let mesh = wave_mesh();
    let expected = expected();
    let folder = tempfile::tempdir().expect("a folder");
    let shape = format!("{FRAMES}, {VERTICES}, 3");
    for dtype in ["<f4", ">f4", "<f8", ">f8"] {
        for fortran in [false, true] {
            let mut order: Vec<(usize, usize, usize)> = Vec::new();
            if fortran {
                for k in 0..3 {
                    for i in 0..VERTICES {
                        order.extend((0..FRAMES).map(|t| (t, i, k)));
                    }
                }
            } else {
                for t in 0..FRAMES {
                    for i in 0..VERTICES {
                        order.extend((0..3).map(|k| (t, i, k)));
                    }
                }
            }
            let mut bytes = Vec::new();
            for (t, i, k) in order {
                let x = expected[t * VERTICES + i][k];
                match dtype {
                    "<f4" => bytes.extend((x as f32).to_le_bytes()),
                    ">f4" => bytes.extend((x as f32).to_be_bytes()),
                    "<f8" => bytes.extend(x.to_le_bytes()),
                    _ => bytes.extend(x.to_be_bytes()),
                }
            }
            let path = folder.path().join("a.npy");
            fs::write(&path, npy_with(dtype, fortran, &shape, bytes)).expect("writable");
            let found = open(&path, Some(&mesh));
            let wanted = match dtype {
                "<f4" | ">f4" => as_single(&expected),
                _ => expected.clone(),
            };
            for step in [1, 10, 100] {
                assert_eq!(all(&found, step), wanted, "{dtype} {fortran} {step}");
            }
        }
    }
}

#[test]
fn times_come_from_the_file_or_the_rate() {
    let mesh = wave_mesh();
    let with = |path: &Path, fps| {
        let sequence = FrameSequence::open(path, Some(&mesh), fps, &Silent).expect("valid");
        (
            sequence.times_s().map(<[f64]>::to_vec),
            sequence.warnings().join("\n"),
        )
    };
    let at = |fps: f64| Some((0..FRAMES).map(|t| t as f64 / fps).collect::<Vec<_>>());
    for name in ["wave.pc2", "wave.npy"] {
        let path = fixtures::path(name);
        assert_eq!(with(&path, None).0, None, "{name}");
        assert_eq!(with(&path, Some(30.0)).0, at(30.0), "{name}");
    }
    let folder = fixture_folder("wave");
    assert_eq!(with(&folder, None).0, None);
    assert_eq!(with(&folder, Some(24.0)).0, at(24.0));
    let mdd = fixtures::path("wave.mdd");
    let own: Vec<f64> = (0..FRAMES).map(|t| f64::from(t as f32 / 25.0)).collect();
    assert_eq!(with(&mdd, None).0, Some(own));
    assert_eq!(with(&mdd, Some(50.0)).0, at(50.0));

    // Start and step of PC2, in frames.
    let temporary = tempfile::tempdir().expect("a folder");
    let changed = |name: &str, at: usize, value: [u8; 4]| {
        let mut bytes = fs::read(fixtures::path(name)).expect("readable");
        bytes[at..at + 4].copy_from_slice(&value);
        let path = temporary.path().join(name);
        fs::write(&path, bytes).expect("writable");
        path
    };
    let path = changed("wave.pc2", 20, 100.0_f32.to_le_bytes());
    assert_eq!(with(&path, Some(10.0)).0.expect("times")[..2], [10.0, 10.1]);
    let path = changed("wave.pc2", 24, 0.0_f32.to_le_bytes());
    let (times, warning) = with(&path, Some(10.0));
    assert_eq!(times, None);
    assert!(
        warning.ends_with("with 0 frames per sample: the times are not known"),
        "{warning}"
    );
    let path = changed("wave.mdd", 8 + 4 * 3, 0.01_f32.to_be_bytes());
    let (times, warning) = with(&path, None);
    assert_eq!(times, None);
    assert!(warning.contains("frame 3 is at 0.0099"), "{warning}");
    assert!(warning.contains("before frame 2 at 0.0799"), "{warning}");
    let path = changed("wave.mdd", 8, f32::NAN.to_be_bytes());
    assert!(with(&path, None).1.contains("frame 0 is at NaN s"));

    for fps in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = FrameSequence::open(&mdd, Some(&mesh), Some(fps), &Silent).expect_err("fps");
        assert!(error.to_string().starts_with("--fps: "), "{error}");
    }
}

#[test]
fn the_hash_is_of_the_bytes() {
    use sha2::{Digest, Sha256};
    let mesh = wave_mesh();
    for name in ["wave.pc2", "wave.mdd", "wave.npy"] {
        let path = fixtures::path(name);
        let bytes = fs::read(&path).expect("readable");
        let expected: [u8; 32] = Sha256::digest(bytes).into();
        assert_eq!(open(&path, Some(&mesh)).hash(), expected, "{name}");
    }
    let mut hash = Sha256::new();
    for t in 0..FRAMES {
        let name = format!("wave_0{t}.obj");
        let bytes = fs::read(fixtures::path(&format!("wave/{name}"))).expect("readable");
        hash.update(name);
        hash.update([0]);
        hash.update(Sha256::digest(bytes));
    }
    let expected: [u8; 32] = hash.finalize().into();
    assert_eq!(open(&fixture_folder("wave"), None).hash(), expected);
}

#[test]
fn folders_are_taken_in_byte_order() {
    let folder = tempfile::tempdir().expect("a folder");
    let put =
        |name: &str, content: &[u8]| fs::write(folder.path().join(name), content).expect("ok");
    let frame = |t| fs::read(fixtures::path(&format!("wave/wave_0{t}.obj"))).expect("readable");
    put("f_10.OBJ", &frame(0));
    put("f_2.obj", &frame(1));
    let gz = {
        use std::io::Write;
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(&frame(2)).expect("memory");
        encoder.finish().expect("memory")
    };
    put("f_3.obj.gz", &gz);
    put("f_3.obj", &frame(3));
    put("f.mtl", b"");
    put(".hidden", b"");
    fs::create_dir(folder.path().join("sub.obj")).expect("ok");
    let sequence = open(folder.path(), None);
    let order: Vec<String> = (0..4)
        .map(|t| {
            sequence
                .place(t)
                .rsplit('/')
                .next()
                .unwrap_or_default()
                .to_string()
        })
        .collect();
    assert_eq!(order, ["f_10.OBJ", "f_2.obj", "f_3.obj", "f_3.obj.gz"]);
    let expected = expected();
    let wanted = [0, 1, 3, 2]
        .map(|t| expected[t * VERTICES..][..VERTICES].to_vec())
        .concat();
    assert_eq!(all(&sequence, 5), wanted);
    let warnings = sequence.warnings().join("\n");
    for text in [
        "3 entries that are no OBJ frames are left out: .hidden, f.mtl, sub.obj",
        "f_10.OBJ before f_2.obj; numbers with leading zeros keep the order of counting",
        "f_3.obj and f_3.obj.gz are two frames",
    ] {
        assert!(warnings.contains(text), "{warnings}");
    }
}

#[test]
fn frames_with_other_vertices_or_faces_are_named() {
    let found = refusal(&fixture_folder("bad_wave_count"), None);
    assert_eq!(
        found.replace(&format!("{}/", fixtures::folder().display()), ""),
        "bad_wave_count/wave_02.obj: 55 vertices, but 54 in bad_wave_count/wave_00.obj"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let text = |t| fs::read_to_string(fixtures::path(&format!("wave/wave_0{t}.obj"))).expect("ok");
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
        "b.obj: triangle 0 has the corners 2 11 1, but 1 2 11 (vertices from 1) in a.obj"
    );
    assert_eq!(lines[1], "c.obj: 81 triangles, but 80 in a.obj");
    assert!(
        lines[2].starts_with("d.obj:56: vertex 99 is out of range"),
        "{found}"
    );
}

#[test]
fn the_input_must_fit() {
    let mut mesh = wave_mesh();
    let folder = fixture_folder("wave");
    assert!(open(&folder, Some(&mesh)).first_mesh().is_none());
    mesh.triangles.swap(0, 1);
    let sequence = open(&folder, Some(&mesh));
    let warning = sequence.warnings().join("\n");
    assert!(
        warning.contains("wave_00.obj: triangle 0 has the corners 1 2 11, but 1 11 10")
            && warning.ends_with("in wave_00.obj; the faces of wave_00.obj are used"),
        "{warning}"
    );
    mesh.positions.pop();
    for name in ["wave.pc2", "wave.mdd", "wave.npy"] {
        let text = refusal(&fixtures::path(name), Some(&mesh));
        let expected = format!("{name}: 54 vertices per frame, but wave_00.obj has 53");
        assert_eq!(text, expected);
        let text = refusal(&fixtures::path(name), None);
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
    let text = refusal(&fixtures::path("bad_wave_nan.npy"), Some(&mesh));
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
    assert_eq!(lines.len(), 101);
    assert_eq!(lines[0], "a.npy: frame 0, vertex 0, x: inf is not finite");
    assert_eq!(lines[7], "a.npy: frame 1, vertex 1, x: inf is not finite");
    assert_eq!(lines[100], "a.npy: 101 more problems");
    values[..200].fill(0.0);
    let bytes = values.iter().flat_map(|x| x.to_le_bytes());
    fs::write(&path, npy_with("<f8", false, &shape, bytes)).expect("writable");
    assert_eq!(
        refusal(&path, Some(&mesh)),
        "a.npy: frame 1, vertex 12, z: -1e31 is too large: coordinates lie within 2^100"
    );

    for t in 0..2 {
        let text = fs::read_to_string(fixtures::path(&format!("wave/wave_0{t}.obj"))).expect("ok");
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
    let text = refusal(&fixtures::path("bad_wave_truncated.pc2"), Some(&mesh));
    assert_eq!(
        text,
        "bad_wave_truncated.pc2: truncated: 6 frames of 54 points need 3920 bytes, the file has \
         1960, which is 2 whole frames"
    );
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["wave.pc2", "wave.mdd", "wave.npy"] {
        let bytes = fs::read(fixtures::path(name)).expect("readable");
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
    let pc2 = fs::read(fixtures::path("wave.pc2")).expect("readable");
    let mdd = fs::read(fixtures::path("wave.mdd")).expect("readable");
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
    assert!(refusal(others.path(), None).contains("no .obj frames among the 1 entries"));
}

/// `data/animations/README.md`: the OBJ sequences take every 4th (curtain_wind) or 2nd (elephant)
/// frame of the cache.
#[test]
fn corpus_folders_agree_with_their_caches() {
    for (name, cache, step) in [
        ("curtain_wind", "curtain_wind.pc2", 4),
        ("elephant", "elephant.mdd", 2),
    ] {
        let relative = format!("animations/{name}");
        let Some(folder) = corpus::path("sequence_corpus_folders", &relative) else {
            return;
        };
        let frames = open(&folder, None);
        let cache = open(&folder.join(cache), frames.first_mesh());
        let n = frames.vertex_count();
        assert_eq!(frames.frame_count(), cache.frame_count().div_ceil(step));
        let (frames, cache) = (all(&frames, n), all(&cache, n));
        for (t, frame) in frames.chunks_exact(n).enumerate() {
            let other = &cache[t * step * n..][..n];
            for (p, q) in frame.iter().zip(other) {
                for k in 0..3 {
                    // The texts have at least six digits.
                    let off = (p[k] - q[k]).abs();
                    assert!(off <= 1e-6 * p[k].abs().max(1.0), "{name} {t}: {p:?} {q:?}");
                }
            }
        }
    }
}

#[test]
fn corpus_damaged_caches_are_named() {
    let mesh = wave_mesh();
    for (name, expected) in [
        ("curtain_truncated.pc2", "which is 3 whole frames"),
        (
            "cube_mangled.mdd",
            "has bytes after its last frame: 4 frames of 24 points",
        ),
    ] {
        let relative = format!("messy/{name}");
        let Some(path) = corpus::path("sequence_corpus_damaged", &relative) else {
            return;
        };
        let text = refusal(&path, Some(&mesh));
        assert!(text.starts_with(name) && text.contains(expected), "{text}");
    }
}
