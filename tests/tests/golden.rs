//! Golden files: the builder writes their bytes again, queries give their answers again, and
//! readers take what the encoder never writes.

use std::fs;
use std::mem::offset_of;
use std::ops::ControlFlow;

use bdtree_format::{Header, Metadata, SectionKind};
use bdtree_runtime::{AlignedBytes, Asset};
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
    for name in ["tetrahedron.bdt", "sphere.bdt", "sparse.bdt", "foreign.bdt"] {
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
