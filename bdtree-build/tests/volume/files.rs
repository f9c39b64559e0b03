//! The same volume in every format, and files that are none.

use std::io::Write as _;

use bdtree_build::input::volume::{RawVolume, parse_volume, read_volume};
use bdtree_fixtures::models;
use bdtree_fixtures::models::volume::{Format, Volume, beam, block, hex_block, tet_block};
use flate2::{Compression, write::GzEncoder};
use sha2::{Digest, Sha256};

/// All formats agree on nodes and elements to the last bit.
fn assert_same(read: &RawVolume, made: &Volume, format: Format) {
    assert_eq!(read.nodes, made.positions, "{format:?}");
    assert_eq!(read.tetrahedra, made.tetrahedra, "{format:?}");
    assert_eq!(read.hexahedra, made.hexahedra, "{format:?}");
}

#[test]
fn every_format_gives_the_same_volume() {
    for made in [beam(), block()] {
        for format in Format::ALL {
            let name = format!("v{}", format.extension());
            let read = parse_volume(&made.to_file(format), &name).expect("valid");
            assert_same(&read, &made, format);
            let skipped = match (format, made.tetrahedra.is_empty()) {
                (Format::Veg, _) => "",
                (Format::Msh2 | Format::Msh2Binary | Format::Msh4 | Format::Msh4Binary, true) => {
                    "2 points, 6 quadrilaterals"
                }
                (Format::Msh2 | Format::Msh2Binary | Format::Msh4 | Format::Msh4Binary, false) => {
                    "2 points, 8 triangles"
                }
                (_, true) => "6 quadrilaterals",
                (_, false) => "8 triangles",
            };
            let warnings: Vec<String> = (!skipped.is_empty())
                .then(|| format!("{name}: ignored what is no volume: {skipped}"))
                .into_iter()
                .collect();
            assert_eq!(read.warnings, warnings, "{format:?}");
        }
    }
}

/// Tetrahedra and hexahedra in one file: material-free, both in order.
#[test]
fn formats_may_mix_the_kinds() {
    let (positions, cells) = tet_block(1, 1, 1, [1.0; 3]);
    let (more, hexahedra) = hex_block(2, 1, 1, [2.0, 1.0, 1.0]);
    let shift = positions.len() as u32;
    let mut volume = Volume::of_tetrahedra((positions, cells));
    volume
        .positions
        .extend(more.iter().map(|p| [p[0] + 5.0, p[1], p[2]]));
    volume.hexahedra = hexahedra
        .iter()
        .map(|cell| cell.map(|c| c + shift))
        .collect();
    for format in &Format::ALL[1..] {
        let name = format!("v{}", format.extension());
        let read = parse_volume(&volume.to_file(*format), &name).expect("valid");
        assert_same(&read, &volume, *format);
    }
}

#[test]
fn fixtures_are_read_with_name_and_hash() {
    for (name, nodes, elements) in [
        ("beam_tets.veg", 81, 192),
        ("beam_tets.vtk", 81, 192),
        ("beam_tets_binary.vtk", 81, 192),
        ("beam_tets_2.msh", 81, 192),
        ("beam_tets_4.msh", 81, 192),
        ("block_hex.veg", 60, 24),
        ("block_hex.vtk", 60, 24),
        ("mirrored_tets.veg", 12, 12),
    ] {
        let path = models::path(name);
        let volume = read_volume(&path).expect(name);
        let count = volume.tetrahedra.len() + volume.hexahedra.len();
        assert_eq!((volume.nodes.len(), count), (nodes, elements), "{name}");
        assert_eq!(volume.name, name);
        let bytes = std::fs::read(path).expect("a fixture");
        assert_eq!(volume.hash, <[u8; 32]>::from(Sha256::digest(&bytes)));
    }
}

#[test]
fn broken_fixtures_name_every_mistake() {
    let folded = "is folded: its Jacobian changes sign (corners in another order than VTK's, or the \
                  element is too distorted)";
    for (name, text) in [
        (
            "bad_volume_index.veg",
            "b.veg:19: corner 3: vertex 9 is not one of the 8\nb.veg:22: corner 1: vertex 100 is not \
             one of the 8"
                .to_string(),
        ),
        (
            "bad_volume_flat.veg",
            "b.veg:21: element 4 has no volume\nb.veg:23: element 6: corners 2 and 3 are the same"
                .into(),
        ),
        ("bad_volume_folded.vtk", format!("b.vtk:85: element 7 {folded}")),
        (
            "bad_volume_truncated.veg",
            "b.veg:90: the number of elements 192 is more than the rest of the file can hold (1083 \
             bytes)"
                .into(),
        ),
        (
            "bad_volume_truncated.vtk",
            "b.vtk: byte 2102: the size of CELLS 992 is more than the rest of the file can hold (1764 \
             bytes)"
                .into(),
        ),
        (
            "bad_volume_truncated.msh",
            "b.msh:254: element 66: a node is missing\nb.msh:254: the file ends before an element"
                .into(),
        ),
    ] {
        let place = format!("b.{}", name.rsplit('.').next().unwrap_or_default());
        let error = parse_volume(&models::content(name), &place).expect_err(name);
        assert_eq!(error.to_string(), text, "{name}");
        assert!(read_volume(&models::path(name)).is_err(), "{name}");
    }
}

#[test]
fn compression_goes_by_content() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = beam().to_file(Format::Veg);
    let mut gz = GzEncoder::new(Vec::new(), Compression::default());
    gz.write_all(&bytes).unwrap();
    let packed = gz.finish().unwrap();
    for (name, content) in [
        ("a.VEG.gz", &packed),
        ("b.veg", &packed),
        ("c.veg.gz", &bytes),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        assert_eq!(read_volume(&path).expect(name).tetrahedra.len(), 192);
    }
}

#[test]
fn paths_that_are_no_volume_say_why() {
    let folder = tempfile::tempdir().unwrap();
    let message = |name: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, "x").unwrap();
        read_volume(&path).unwrap_err().to_string()
    };
    let supported = "(read as volumes: .veg, .vtk, .msh, each also .gz)";
    assert!(message("a.vtu").contains(&format!(".vtu files are not read {supported}")));
    assert!(message("a.obj").contains(".obj files are not read"));
    assert!(message("a.dat").contains("unknown volume format .dat"));
    assert!(message("noextension").contains("no file extension"));
    let error = read_volume(folder.path()).unwrap_err().to_string();
    assert!(error.contains("is a folder"));
    let error = read_volume(&folder.path().join("missing.veg")).unwrap_err();
    assert!(error.to_string().contains("cannot be read"));
}
