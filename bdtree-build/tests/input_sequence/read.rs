//! What is read: the same numbers from every format, frames in order.

use std::fs;

use bdtree_build::error::Part;
use bdtree_fixtures::models::{self, fields::npy_with};

use crate::support::{FRAMES, VERTICES, all, as_single, expected, fixture_folder, open, wave_mesh};

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
    let first = folder.first_mesh.as_ref().expect("frames are meshes");
    assert_eq!(
        (&first.positions, &first.triangles),
        (&mesh.positions, &mesh.triangles)
    );
    assert_eq!((first.name.as_str(), first.hash), ("wave", folder.hash));
    let sequences = [
        (folder, &expected),
        (open(&models::path("wave.npy"), Some(&mesh)), &expected),
        (open(&models::path("wave.pc2"), Some(&mesh)), &single),
        (open(&models::path("wave.mdd"), Some(&mesh)), &single),
    ];
    for (sequence, expected) in &sequences {
        assert_eq!(sequence.frame_count(), FRAMES);
        assert_eq!(sequence.vertex_count(), VERTICES);
        assert!(sequence.warnings.is_empty(), "{:?}", sequence.warnings);
        for step in [1, 7, VERTICES, 1000] {
            assert_eq!(&&all(sequence, step), expected, "{} {step}", sequence.name);
        }
        assert!(sequence.read(50..55, &mut [0.0; 90]).is_err());
        assert!(sequence.read(50..54, &mut [0.0; 71]).is_err());
    }
    let place = sequences[0].0.place(3).to_string();
    assert!(place.ends_with("wave/wave_03.obj"), "{place}");
    let place = sequences[2].0.place(3);
    assert_eq!(place.parts, [Part::Frame(3)]);
    assert!(place.to_string().ends_with("wave.pc2: frame 3"), "{place}");
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
fn the_hash_is_of_the_bytes() {
    use sha2::{Digest, Sha256};
    let mesh = wave_mesh();
    for name in ["wave.pc2", "wave.mdd", "wave.npy"] {
        let path = models::path(name);
        let bytes = fs::read(&path).expect("readable");
        let expected: [u8; 32] = Sha256::digest(bytes).into();
        assert_eq!(open(&path, Some(&mesh)).hash, expected, "{name}");
    }
    let mut hash = Sha256::new();
    for t in 0..FRAMES {
        let name = format!("wave_0{t}.obj");
        let bytes = fs::read(models::path(&format!("wave/{name}"))).expect("readable");
        hash.update(name);
        hash.update([0]);
        hash.update(Sha256::digest(bytes));
    }
    let expected: [u8; 32] = hash.finalize().into();
    assert_eq!(open(&fixture_folder("wave"), None).hash, expected);
}

#[test]
fn folders_are_taken_in_byte_order() {
    let folder = tempfile::tempdir().expect("a folder");
    let put =
        |name: &str, content: &[u8]| fs::write(folder.path().join(name), content).expect("ok");
    let frame = |t| fs::read(models::path(&format!("wave/wave_0{t}.obj"))).expect("readable");
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
                .to_string()
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
    let warnings = sequence.warnings.join("\n");
    for text in [
        "left out, since they are no OBJ frames, 3 entries: .hidden, f.mtl, sub.obj",
        "f_10.OBJ before f_2.obj: name them with leading zeros (f_02 before f_10) if they should be counted",
        "f_3.obj and f_3.obj.gz are two frames",
    ] {
        assert!(warnings.contains(text), "{warnings}");
    }
}
