//! Golden files: the builder writes their bytes again, queries give their answers again, and
//! readers take what the encoder never writes.

use std::fs;
use std::mem::offset_of;
use std::ops::ControlFlow;

use bdtree_format::{Header, Metadata, SectionKind, SectionRecord};
use bdtree_runtime::{AlignedBytes, Asset, Datum};
use bdtree_tests::{golden, mutate};

fn read(name: &str) -> AlignedBytes {
    AlignedBytes::read(golden::folder().join(name)).expect("a golden file")
}

fn assert_sound(asset: &Asset<'_>, name: &str) {
    asset.verify(&mut |error| -> ControlFlow<()> { panic!("{name}: {error}") });
}

#[test]
fn golden_files_are_made_again_byte_for_byte() {
    let made = golden::files();
    let mut names: Vec<String> = made.iter().map(|f| f.0.clone()).collect();
    for (name, content) in made {
        let found = fs::read(golden::folder().join(&name)).expect("a golden file");
        assert!(
            found == content,
            "{name} differs from what is made now: see `make-golden --help`, and SPEC 9.2"
        );
        assert!(found.len() < 100_000, "{name} is large");
    }
    names.sort();
    let mut found: Vec<String> = fs::read_dir(golden::folder())
        .expect("the folder")
        .map(|e| {
            e.expect("an entry")
                .file_name()
                .into_string()
                .expect("UTF-8")
        })
        .collect();
    found.sort();
    assert_eq!(found, names);
}

#[test]
fn golden_files_are_sound() {
    for name in [
        "tetrahedron.bdt",
        "sphere.bdt",
        "sparse.bdt",
        "foreign.bdt",
        "animated.bdt",
    ] {
        let bytes = read(name);
        let asset = Asset::open(&bytes).expect("open");
        assert_sound(&asset, name);
        asset.verify_checksums().expect("checksums");
    }
    let bytes = read("sparse.bdt");
    let asset = Asset::open(&bytes).expect("open");
    let mut starts: Vec<u32> = asset.nodes().iter().map(|n| n.mode_list_start).collect();
    starts.sort_unstable();
    starts.dedup();
    assert!(starts.len() > 3, "the sparse fields give several lists");
    assert!(!asset.vertex_modes().is_empty(), "vertices have lists too");
}

#[test]
fn a_golden_animation_has_its_frames() {
    let bytes = read("animated.bdt");
    let asset = Asset::open(&bytes).expect("open");
    let times: Vec<Option<f64>> = (0..asset.frame_count())
        .map(|k| asset.frame(k).expect("a frame").time_s())
        .collect();
    assert_eq!(times, [Some(0.0), Some(0.25), Some(0.5), Some(2.0)]);
    let last = asset.frame(3).expect("a frame");
    assert_eq!(last.q(), [300.0, 0.5]);
    assert_eq!(last.transform().translation, [1e3, 0.0, -0.1]);
    assert_eq!(asset.modes()[0].q_limit.get(), 512.0);
    let metadata = Metadata::from_bytes(asset.metadata()).expect("metadata");
    let error = metadata.basis_error_rel.expect("an error");
    assert_eq!(
        (error.max, error.frame, error.vertex),
        (0.0625, Some(2), Some(5))
    );
    assert_eq!(metadata.modes[0].default_q, Some(0.125));
}

/// The asset of `sphere.bdt` in other, legal bytes gives the same answers.
#[test]
fn what_the_encoder_never_writes_is_read() {
    let answers = |name: &str| fs::read_to_string(golden::folder().join(name)).expect("answers");
    assert!(answers("sphere.jsonl") == answers("foreign.jsonl"));
    let bytes = read("foreign.bdt");
    let asset = Asset::open(&bytes).expect("open");
    assert_eq!(asset.sections()[0].kind, SectionKind(*b"XTRA"));
    assert!(asset.metadata().is_empty());
    let names: Vec<(u32, &str)> = asset.groups().map(|g| (g.kind, g.name)).collect();
    assert_eq!(
        names,
        [(0, "sphere"), (1, ""), (2, "metal")],
        "unknown kinds are left out"
    );
}

/// A later minor version is read; its groups and metadata too.
#[test]
fn a_later_minor_version_is_read() {
    let mut bytes = read("sphere.bdt").to_vec();
    mutate::put(
        &mut bytes,
        offset_of!(Header, version_minor),
        &99_u16.to_le_bytes(),
    );
    mutate::repair(&mut bytes);
    let bytes = AlignedBytes::copy_of(&bytes);
    let asset = Asset::open(&bytes).expect("open");
    assert_sound(&asset, "minor version 99");
    assert_eq!(asset.groups().nth(1).expect("a group").name, "Glas ü");
    let metadata = Metadata::from_bytes(asset.metadata()).expect("metadata");
    assert_eq!(metadata.modes[2].name.as_deref(), Some("field 2"));
}

/// What 0.1, 0.2 and early 0.3 wrote otherwise was never released.
#[test]
fn earlier_layouts_are_refused_by_name() {
    for (kind, known, earlier) in [
        (SectionKind::NODES, 2, 1_u32),
        (SectionKind::ROWS, 3, 1),
        (SectionKind::ROWS, 3, 2),
        (SectionKind::METADATA, 2, 1),
    ] {
        let mut bytes = read("sphere.bdt").to_vec();
        let at = mutate::record(&bytes, kind) + offset_of!(SectionRecord, layout);
        mutate::put(&mut bytes, at, &earlier.to_le_bytes());
        mutate::repair(&mut bytes);
        let error = Asset::open(&AlignedBytes::copy_of(&bytes)).expect_err("earlier layout");
        assert_eq!((error.section, error.byte), (kind, at as u64), "{error}");
        assert_eq!(
            (error.expected, error.found),
            (Datum::Integer(known), Datum::Integer(earlier.into()))
        );
        assert!(
            error.rule.starts_with("SPEC 4.4: unknown layouts"),
            "{error}"
        );
    }
}

/// SPEC 8, for numbers that the builder would not write.
#[test]
fn errors_that_are_none_are_found() {
    let sound = read("animated.bdt").to_vec();
    let place = mutate::section(&sound, SectionKind::METADATA);
    type Change = fn(&mut Metadata);
    let changes: [Change; 5] = [
        |m| m.basis_error_rel.as_mut().expect("an error").vertex = Some(26),
        |m| m.basis_error_rel.as_mut().expect("an error").max = f64::NAN,
        |m| m.basis_error_rel.as_mut().expect("an error").rms = -1.0,
        |m| m.modes[0].default_q = Some(f64::INFINITY),
        |m| m.modes[1].default_q = Some(0.0),
    ];
    for (i, change) in changes.into_iter().enumerate() {
        let mut metadata = Metadata::from_bytes(&sound[place.clone()]).expect("metadata");
        change(&mut metadata);
        let mut section = metadata.to_bytes().expect("bytes");
        section.truncate(place.len()); // the last change makes it longer
        let mut bytes = sound.clone();
        mutate::put(&mut bytes, place.start, &section);
        mutate::repair(&mut bytes);
        let copy = AlignedBytes::copy_of(&bytes);
        let mut found = Vec::new();
        Asset::open(&copy).expect("open").verify(&mut |error| {
            found.push(error);
            ControlFlow::Continue(())
        });
        assert_eq!(found.len(), 1, "change {i}: {found:?}");
        assert_eq!(found[0].section, SectionKind::METADATA);
        assert!(found[0].rule.starts_with("SPEC 8"), "{}", found[0]);
    }
}
