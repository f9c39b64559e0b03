//! The file of a case: a seed file, changed as its format says.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::Value;

use super::binary::{self, Endian};
use super::{Case, Format, Seeds, container, json, text};

/// Statements of OBJ.
const OBJ: [&str; 20] = [
    "v 0 0 0",
    "v 1e300 -1e300 1e300",
    "v 1 2",
    "v 1e-310 0 1",
    "f 1 2 3",
    "f 1 1 1",
    "f -1 -2 -3",
    "f 1/1 2/2 3/3 4/4",
    "f 1 2",
    "f 0 1 2",
    "f 9223372036854775807 1 2",
    "f 4294967297 1 2",
    "g",
    "o a \u{1b}[31m",
    "usemtl x",
    "p 1",
    "l 1 2",
    "end",
    "mtllib \\",
    "call a.obj",
];

/// Lines of VegaFEM files.
const VEG: [&str; 18] = [
    "*VERTICES",
    "*ELEMENTS",
    "TET",
    "CUBIC",
    "TETS",
    "*MATERIAL A",
    "ENU, 1000, 1e7, 0.45",
    "ENU, 0, 0, 0.5",
    "ENU, 1e39, 1e308, -1",
    "*SET s",
    "1, 2, 3,",
    "*REGION",
    "allElements, A",
    "s, A",
    "*INCLUDE /etc/passwd",
    "2147483647 3 0 0",
    "4 3 0 0",
    "1 4 0",
];

/// Lines of VTK files.
const VTK: [&str; 22] = [
    "ASCII",
    "BINARY",
    "DATASET UNSTRUCTURED_GRID",
    "DATASET POLYDATA",
    "POINTS 4 float",
    "POINTS 4294967296 double",
    "POINTS 18446744073709551615 double",
    "CELLS 1 5",
    "CELLS 4611686018427387904 9223372036854775807",
    "CELLS 3 9223372036854775807",
    "OFFSETS vtktypeint64",
    "CONNECTIVITY vtktypeint32",
    "CELL_TYPES 1",
    "CELL_DATA 1",
    "POINT_DATA 4294967295",
    "SCALARS x double 4",
    "LOOKUP_TABLE default",
    "FIELD FieldData 9999999999",
    "x 1000000000 1000000000000 double",
    "METADATA",
    "INFORMATION 1",
    "4 0 1 2 3",
];

/// Lines of MSH files.
const MSH: [&str; 22] = [
    "$MeshFormat",
    "2.2 0 8",
    "4.1 0 8",
    "4.1 1 8",
    "$EndMeshFormat",
    "$PhysicalNames",
    "$EndPhysicalNames",
    "$Entities",
    "$EndEntities",
    "$Nodes",
    "$EndNodes",
    "$Elements",
    "$EndElements",
    "$PartitionedEntities",
    "$Comments",
    "1 4294967296 1 4294967296",
    "3 1 0 18446744073709551615",
    "3 1 4 9223372036854775807",
    "1 4 2 1 1 1 2 3 4",
    "1 4 2147483647 1 1",
    "0 1 2147483647",
    "9223372036854775807",
];

/// Words of PLY headers and lines.
const PLY: [&str; 12] = [
    "element vertex 18446744073709551615",
    "element face 4294967296",
    "element nothing 9999999999",
    "property list uint int vertex_indices",
    "property list double float vertex_index",
    "property double x",
    "property uchar z",
    "format binary_big_endian 1.0",
    "format ascii 1.0",
    "end_header",
    "4294967295 0 1 2",
    "3 0 -1 2",
];

/// Words of STL text.
const STL: [&str; 7] = [
    "solid",
    "solid a\nendsolid",
    "facet normal 0 0 0",
    "outer loop",
    "vertex 1e39 nan -0",
    "endfacet",
    "endsolid",
];

/// The generator of a case: the same numbers on every machine.
pub(super) fn rng(case: Case) -> Pcg64Mcg {
    let seed = case.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    Pcg64Mcg::seed_from_u64(seed ^ (case.format as u64) << 48 ^ case.number)
}

/// A mutated file, and the size of the text in it where it is compressed.
pub(super) fn file(case: Case, seeds: &Seeds, rng: &mut Pcg64Mcg) -> (Vec<u8>, usize) {
    let all = seeds.of(case.format);
    let mut bytes = all[rng.random_range(0..all.len())].clone();
    let other = &all[rng.random_range(0..all.len())];
    // One in 32 stays sound.
    let changes = [0, 1, 2, 3, 5][match rng.random_range(0..32) {
        0 => 0,
        1..14 => 1,
        14..22 => 2,
        22..28 => 3,
        _ => 4,
    }];
    let text = |bytes: &mut Vec<u8>, words: &[&str], rng: &mut Pcg64Mcg| {
        (0..changes).for_each(|_| text::change(bytes, words, other, rng));
    };
    let half_binary = |bytes: &mut Vec<u8>, words: &[&str], rng: &mut Pcg64Mcg| {
        for _ in 0..changes {
            match rng.random_range(0..3) {
                0 => binary::change(bytes, &[], Endian::Little, other, rng),
                _ => text::change(bytes, words, other, rng),
            }
        }
    };
    let fields = |bytes: &mut Vec<u8>, fields: &[usize], endian, rng: &mut Pcg64Mcg| {
        (0..changes).for_each(|_| binary::change(bytes, fields, endian, other, rng));
    };
    match case.format {
        Format::Obj | Format::Frames => text(&mut bytes, &OBJ, rng),
        Format::ObjGz => {
            text(&mut bytes, &OBJ, rng);
            return compressed(bytes, rng);
        }
        Format::Veg => text(&mut bytes, &VEG, rng),
        Format::Frequencies | Format::List => text(&mut bytes, &["1", "0", "4 5"], rng),
        Format::Vtk => half_binary(&mut bytes, &VTK, rng),
        Format::Msh => half_binary(&mut bytes, &MSH, rng),
        Format::Ply => half_binary(&mut bytes, &PLY, rng),
        Format::Stl => half_binary(&mut bytes, &STL, rng),
        Format::Pc2 => fields(
            &mut bytes,
            &[12, 16, 16, 20, 24, 28, 28],
            Endian::Little,
            rng,
        ),
        Format::Mdd => fields(&mut bytes, &[0, 0, 4, 4, 8, 12], Endian::Big, rng),
        Format::Npy | Format::Basis => bytes = container::npy(&bytes, other, changes, rng),
        Format::Glb => bytes = container::glb(&bytes, other, changes, rng),
        Format::Gltf | Format::Scene => bytes = document(&bytes, other, changes, rng),
    }
    let size = bytes.len();
    (bytes, size)
}

/// JSON text, changed as a tree, seldom as text.
fn document(bytes: &[u8], other: &[u8], changes: usize, rng: &mut Pcg64Mcg) -> Vec<u8> {
    let read = |bytes: &[u8]| serde_json::from_slice(bytes).unwrap_or(Value::Null);
    let (mut value, spare) = (read(bytes), read(other));
    let mut as_text = 0;
    for _ in 0..changes {
        match rng.random_range(0..5) {
            0 => as_text += 1,
            _ => json::change(&mut value, &spare, rng),
        }
    }
    let mut text = container::json_text(&value, rng);
    for _ in 0..as_text {
        text::change(
            &mut text,
            &["\"a\": [[[[[", "NaN,", "\"nodes\":"],
            other,
            rng,
        );
    }
    text
}

/// Compressed text, seldom damaged, seldom in two members.
fn compressed(text: Vec<u8>, rng: &mut Pcg64Mcg) -> (Vec<u8>, usize) {
    let member = |text: &[u8]| {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        let written = encoder.write_all(text);
        written.and_then(|()| encoder.finish()).unwrap_or_default()
    };
    let mut bytes = match rng.random_range(0..8) {
        0 => {
            let (a, b) = text.split_at(text.len() / 2);
            [member(a), member(b)].concat()
        }
        _ => member(&text),
    };
    if rng.random_range(0..4) == 0 {
        let copy = bytes.clone();
        binary::change(&mut bytes, &[0, 2, 4], Endian::Little, &copy, rng);
    }
    let size = text.len().max(bytes.len());
    (bytes, size)
}
