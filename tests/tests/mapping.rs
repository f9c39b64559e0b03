//! The three doors to a file give the same asset, and a large mapped one opens at once without
//! being read.

use std::fs::OpenOptions;
use std::mem::offset_of;
use std::time::{Duration, Instant};

use bdtree_format::{Header, SectionKind, SectionRecord};
use bdtree_runtime::{AlignedBytes, Asset, MappedFile, include_bdt};
use bdtree_tests::resident::mapped_bytes;
use bdtree_tests::{golden, mutate};

#[test]
fn all_doors_lead_to_the_same_asset() {
    let embedded = include_bdt!("../../fixtures/golden/sphere.bdt");
    let path = golden::folder().join("sphere.bdt");
    let read = AlignedBytes::read(&path).expect("read");
    let mapped = MappedFile::open(&path).expect("mapped");
    for bytes in [embedded, &read, &mapped] {
        assert!((bytes.as_ptr() as usize).is_multiple_of(64));
        assert!(*bytes == *embedded);
        let asset = Asset::open(bytes).expect("open");
        assert!(asset.verify(&mut |_| std::ops::ControlFlow::Break(())));
        assert_eq!(asset.triangle_count(), 192);
    }
    assert!(MappedFile::open(golden::folder().join("missing.bdt")).is_err());
}

#[test]
fn a_large_file_opens_without_being_read() {
    // The golden tetrahedron with 10 million vertices: a hole in the file.
    const VERTICES: u64 = 10_000_000;
    let mut bytes = AlignedBytes::read(golden::folder().join("tetrahedron.bdt"))
        .expect("read")
        .to_vec();
    // VERT becomes long; DISP (empty for a rigid asset) and META stand behind it.
    let start = mutate::section(&bytes, SectionKind::POSITIONS).start;
    let mut end = start as u64 + 12 * VERTICES;
    for (kind, length) in [
        (SectionKind::POSITIONS, 12 * VERTICES),
        (SectionKind::DISPLACEMENTS, 0),
        (SectionKind::METADATA, 1000),
    ] {
        let at = mutate::record(&bytes, kind);
        let offset = if kind == SectionKind::POSITIONS {
            start as u64
        } else {
            end.next_multiple_of(64)
        };
        end = offset + length;
        mutate::put(
            &mut bytes,
            at + offset_of!(SectionRecord, offset),
            &offset.to_le_bytes(),
        );
        mutate::put(
            &mut bytes,
            at + offset_of!(SectionRecord, length),
            &length.to_le_bytes(),
        );
    }
    mutate::put(
        &mut bytes,
        offset_of!(Header, file_bytes),
        &end.to_le_bytes(),
    );
    let count = (VERTICES as u32).to_le_bytes();
    mutate::put(&mut bytes, offset_of!(Header, vertex_count), &count);
    bytes.truncate(start);
    mutate::repair(&mut bytes);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("large.bdt");
    std::fs::write(&path, &bytes).expect("written");
    let file = OpenOptions::new().write(true).open(&path).expect("open");
    file.set_len(end).expect("a sparse file");
    assert!(end > 100_000_000);

    let mut times: Vec<Duration> = (0..11)
        .map(|_| {
            let begin = Instant::now();
            let mapped = MappedFile::open(&path).expect("mapped");
            let asset = Asset::open(&mapped).expect("open");
            assert_eq!(asset.vertex_count() as u64, VERTICES);
            begin.elapsed()
        })
        .collect();
    times.sort_unstable();
    assert_eq!(mapped_bytes(&path).unwrap_or(0), 0, "nothing is mapped now");
    let mapped = MappedFile::open(&path).expect("mapped");
    let asset = Asset::open(&mapped).expect("open");
    let grown = mapped_bytes(&path);
    assert_eq!(asset.positions().len() as u64, VERTICES);
    println!("{end} bytes open in {:?} (median)", times[5]);
    // The aim is 1 ms; five leave room for a busy machine.
    assert!(times[5] < Duration::from_millis(5), "{times:?}");
    // Systems without /proc do not tell.
    if cfg!(target_os = "linux") {
        let grown = grown.expect("/proc/self/smaps");
        println!("resident memory grows by {grown} bytes");
        assert!(0 < grown && grown < 64 * 1024);
    }
}
