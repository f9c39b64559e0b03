//! A reader written from SPEC.md alone, in another language, reads every golden file.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use bdtree_build::mass::Momentum;
use bdtree_fixtures::skin::skinned_bar;
use bdtree_fixtures::{bake, mutate};
use bdtree_format::SectionKind;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(file: &Path) -> Output {
    Command::new("python3")
        .arg(root().join("tests/python/bdt_reader.py"))
        .arg(file)
        .output()
        .expect("python3 runs (README: what the tests need)")
}

/// All `.bdt` files below `folder`.
fn golden_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable entry").path();
        if path.is_dir() {
            golden_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "bdt") {
            found.push(path);
        }
    }
}

#[test]
fn golden_files_are_read() {
    let mut files = vec![root().join("format-spec/tests/example.bdt")];
    golden_files(&root().join("fixtures/golden"), &mut files);
    for file in files {
        let output = read(&file);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {errors}", file.display());
        let [major, _, minor, ..] = fs::read(&file).expect("a golden file")[8..] else {
            panic!("a version");
        };
        let version = format!("{{\"version\": \"{major}.{minor}\", \"bytes\": ");
        assert!(output.stdout.starts_with(version.as_bytes()));
    }
}

#[test]
fn skins_are_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("bar.bdt");
    let bytes = skinned_bar();
    fs::write(&file, &bytes).expect("written");
    let output = read(&file);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    for part in [
        r#""joints": [{"name": "root", "parent": null}, {"name": "elbow", "parent": 0}, {"name": "tip", "parent": 1}]"#,
        r#""clips": [{"name": "bend", "duration_s": 1.0}, {"name": "stretch", "duration_s": 2.0}]"#,
        r#""influences_max": 3"#,
    ] {
        assert!(text.contains(part), "{text}");
    }
    // One rule of each section, broken under a checksum that fits.
    for (kind, at, value, rule) in [
        (SectionKind::SKIN, 0, 2_u32, "7.7"),
        (SectionKind::INFLUENCE_STARTS, 0, 1, "7.7"),
        (SectionKind::INFLUENCES, 0, 0, "7.7"),
        (SectionKind::BONES, 0, 3, "7.8"),
        (SectionKind::BONE_FIELDS, 0, 1, "5.1"),
        (SectionKind::BONE_LIST_STARTS, 0, 1, "6.10"),
        (SectionKind::BONE_LISTS, 0, 0xffff, "6.10"),
        (SectionKind::BONE_ROWS, 0, 0x8080_0000, "6.10"),
        (SectionKind::SKELETON, 0, 0, "7.8"),
        (SectionKind::JOINTS, 0, 2, "7.8"),
        (SectionKind::CLIPS, 0, 1, "7.9"),
        (SectionKind::CHANNELS, 8, 4, "7.9"),
        (SectionKind::KEYS, 0, 0x3f80_0000, "7.9"),
    ] {
        let mut bytes = bytes.clone();
        let at = mutate::section(&bytes, kind).start + at;
        mutate::put(&mut bytes, at, &value.to_le_bytes());
        mutate::repair(&mut bytes);
        fs::write(&file, bytes).expect("written");
        let output = read(&file);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success(), "{kind}");
        assert!(
            errors.contains(&format!("(SPEC {rule})")),
            "{kind}: {errors}"
        );
    }
}

/// A sphere whose modes have momenta, and one rule of each kind broken.
#[test]
fn masses_are_read() {
    let mesh = bake::bumpy_sphere(8, 1);
    let mut basis = bake::smooth_basis(&mesh, 2, 1);
    for mode in &mut basis.modes {
        mode.modal_mass_kg = Some(2.0);
        mode.momentum = Some(Momentum {
            about: [0.0; 3],
            linear: [0.5, 0.0, -1.0],
            angular: [0.0, 0.25, 0.0],
        });
    }
    let model = bake::baked(&mesh, &basis);
    let bytes = model.asset().bytes();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("sphere.bdt");
    fs::write(&file, bytes).expect("written");
    let output = read(&file);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains(r#""mass": {"mass_kg": "#), "{text}");
    let (mass, momenta) = (SectionKind::MASS_PROPERTIES, SectionKind::MODE_MOMENTA);
    let mass_at = |b: &[u8], k: usize| {
        let at = mutate::section(b, mass).start + 8 * k;
        f64::from_le_bytes(b[at..at + 8].try_into().expect("eight bytes"))
    };
    let trace: f64 = (4..7).map(|k| mass_at(bytes, k)).sum();
    for (kind, at, value) in [
        (mass, 0, mass_at(bytes, 0) * (1.0 + 3e-9)),
        (mass, 8, f64::NAN),
        (mass, 32, -0.1 * trace),
        (mass, 48, 0.8 * trace),
        (mass, 56, 0.4 * trace),
        (mass, 80, 0.0),
        (mass, 104, 0.0),
        (mass, 120, 1.0),
        (momenta, 48, f64::INFINITY),
    ] {
        let mut bytes = bytes.to_vec();
        let at = mutate::section(&bytes, kind).start + at;
        mutate::put(&mut bytes, at, &value.to_le_bytes());
        mutate::repair(&mut bytes);
        fs::write(&file, bytes).expect("written");
        let output = read(&file);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{kind} {value}");
        assert!(errors.contains("(SPEC 7.10)"), "{kind} {value}: {errors}");
    }
    let mut without = bytes.to_vec();
    let record = mutate::record(&without, mass);
    mutate::put(&mut without, record, b"MASX");
    mutate::repair(&mut without);
    fs::write(&file, without).expect("written");
    let errors = read(&file).stderr;
    assert!(String::from_utf8_lossy(&errors).contains("momenta without a mass (SPEC 4.2)"));
}

#[test]
fn a_flipped_bit_is_refused() {
    let mut bytes = fs::read(root().join("format-spec/tests/example.bdt")).expect("the example");
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("flipped.bdt");
    fs::write(&file, bytes).expect("written");
    let output = read(&file);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("checksum of DISP (SPEC 4.1)"));
}

/// The rules of vertices' modes, under valid checksums.
#[test]
fn broken_vertex_records_are_refused() {
    let sound = fs::read(root().join("fixtures/golden/sparse.bdt")).expect("a golden file");
    let place = mutate::section(&sound, SectionKind::VERTEX_MODES);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("broken.bdt");
    for (at, value, rule) in [
        (place.start, 1_u32, "ends of VMOD (SPEC 7.6)"),
        (place.start + 8, u32::MAX, "list of vertex 0 (SPEC 6.7)"),
        (place.end - 16, 0, "(SPEC 7.6)"),
        (place.start + 4, 1 << 20, "list of vertex 0 (SPEC 6.7)"),
        (place.end - 4, 1, "ends of VMOD (SPEC 7.6)"),
    ] {
        let mut bytes = sound.clone();
        mutate::put(&mut bytes, at, &value.to_le_bytes());
        mutate::repair(&mut bytes);
        fs::write(&file, bytes).expect("written");
        let output = read(&file);
        assert_eq!(output.status.code(), Some(1));
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(text.contains(rule), "{text}");
    }
}
