//! The legacy VTK reader: its versions, what it skips, what it refuses.

use super::shapes::parse;
use bdtree_build::input::volume::{RawVolume, parse_volume};
use bdtree_fixtures::models::volume::{Format, beam, block};

const HEAD: &str = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\n";
const POINTS: &str = "POINTS 5 float\n0 0 0 1 0 0 0 1 0\n0 0 1\n1 1 1\n";
const CELLS: &str = "CELLS 2 10\n4 0 1 2 3\n4 1 4 2 3\nCELL_TYPES 2\n10\n10\n";

fn vtk(text: &str) -> Result<RawVolume, String> {
    parse("m.vtk", text)
}

fn error(text: &str) -> String {
    vtk(text).expect_err("an error")
}

#[test]
fn words_may_be_laid_out_as_they_like() {
    let plain = vtk(&format!("{HEAD}{POINTS}{CELLS}")).unwrap();
    assert_eq!(plain.tetrahedra, [[0, 1, 2, 3], [1, 4, 2, 3]]);
    let free = "# vtk DataFile Version 4.2\r\n\r\nascii\r\n\r\ndataset unstructured_grid\r\n\
                points 5 FLOAT 0 0 0 1\r\n0 0 0 1 0 0 0 1 1 1\t1\r\ncells 2\r\n10 4 0 1 2 3 4 1 4 2 3\r\n\
                cell_types 2 10 10";
    assert_eq!(vtk(free).unwrap(), plain);
    let types_first = format!("{HEAD}CELL_TYPES 2\n10 10\n{CELLS}").replace(
        "4 1 4 2 3\nCELL_TYPES 2\n10\n10\n",
        &format!("4 1 4 2 3\n{POINTS}"),
    );
    assert_eq!(vtk(&types_first).unwrap(), plain);
}

#[test]
fn fields_and_metadata_are_skipped() {
    let field = "FIELD FieldData 3\nNULL_ARRAY\nTIME 1 1 double\n0.5\nnotes%20here 1 3 string\nCELLS 9\n\n\
                 POINTS\nMETADATA\nINFORMATION 0\n\n";
    // The metadata belongs to the array before; a further field follows.
    let text = format!(
        "{HEAD}{field}FIELD f 1\nbits 1 4 bit\n1 0 1 1\n{POINTS}METADATA\nCOMPONENT_NAMES\nx\n\n{CELLS}\
         CELL_DATA 2\nSCALARS broken\n"
    );
    let volume = vtk(&text).unwrap();
    assert_eq!(volume.tetrahedra.len(), 2);
    let short = format!("{HEAD}FIELD FieldData 1\nTIME 3 5 double\n0.5\n");
    assert_eq!(
        error(&short),
        "m.vtk:6: FIELD array `TIME`: the file ends within its 15 values"
    );
    let odd = format!("{HEAD}FIELD FieldData 1\nTIME 1 1 quaternion\n0.5\n");
    assert_eq!(
        error(&odd),
        "m.vtk:6: FIELD array `TIME`: values of type `quaternion`"
    );
}

/// Lengths of strings take one, two, four or eight bytes in binary files.
#[test]
fn binary_fields_are_skipped() {
    let bytes = beam().to_file(Format::Vtk2Binary);
    let before = b"FIELD FieldData 1\nTIME 1 1 double\n";
    let at = bytes
        .windows(before.len())
        .position(|w| w == before)
        .unwrap();
    let mut strings = b"FIELD FieldData 3\nnames 2 2 string\n".to_vec();
    strings.extend_from_slice(&[0b1100_0010, b'\n', b'P']);
    strings.extend_from_slice(&[0b1000_0000, 1, b'x']);
    strings.extend_from_slice(&[0b0100_0000, 0, 0, 3, 1, 2, 3]);
    strings.extend_from_slice(&[0, 0, 0, 0, 0, 0, 0, 1, b' ']);
    strings.extend_from_slice(b"\nbits 1 11 bit\n\xff\x01\nTIME 1 1 double\n");
    let mut with = bytes[..at].to_vec();
    with.extend_from_slice(&strings);
    with.extend_from_slice(&bytes[at + before.len()..]);
    let plain = parse_volume(&bytes, "m.vtk").unwrap();
    assert_eq!(parse_volume(&with, "m.vtk").unwrap(), plain);
}

#[test]
fn voxels_are_reordered() {
    let mut text = format!("{HEAD}POINTS 8 int\n");
    for i in 0..8 {
        text += &format!("{} {} {}\n", i % 2, i / 2 % 2, i / 4);
    }
    text += "CELLS 1 9\n8 0 1 2 3 4 5 6 7\nCELL_TYPES 1\n11\n";
    let volume = vtk(&text).unwrap();
    assert_eq!(volume.hexahedra, [[0, 1, 3, 2, 4, 5, 7, 6]]);
    assert!(volume.warnings.is_empty());
}

/// Every type of number, in both byte orders a writer could be thought to use: only big-endian is
/// right.
#[test]
fn numbers_of_every_type_are_big_endian() {
    let points: [i8; 12] = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1];
    let file = |name: &str, number: &dyn Fn(i8) -> Vec<u8>| {
        let mut bytes = HEAD.replace("ASCII", "BINARY").into_bytes();
        bytes.extend_from_slice(format!("POINTS 4 {name}\n").as_bytes());
        points.iter().for_each(|&x| bytes.extend(number(x)));
        bytes.extend_from_slice(b"\nCELLS 1 5\n");
        [4_i32, 0, 1, 2, 3]
            .iter()
            .for_each(|n| bytes.extend(n.to_be_bytes()));
        bytes.extend_from_slice(b"\nCELL_TYPES 1\n");
        bytes.extend(10_i32.to_be_bytes());
        parse_volume(&bytes, "m.vtk")
    };
    let wanted = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let check = |name: &str, number: &dyn Fn(i8) -> Vec<u8>| {
        let nodes = file(name, number)
            .unwrap_or_else(|e| panic!("{name}: {e}"))
            .nodes;
        assert_eq!(nodes, wanted, "{name}");
    };
    check("char", &|x| vec![x as u8]);
    check("unsigned_char", &|x| vec![x as u8]);
    check("short", &|x| i16::from(x).to_be_bytes().to_vec());
    check("unsigned_int", &|x| i32::from(x).to_be_bytes().to_vec());
    check("vtktypeint64", &|x| i64::from(x).to_be_bytes().to_vec());
    check("float", &|x| f32::from(x).to_be_bytes().to_vec());
    check("double", &|x| f64::from(x).to_be_bytes().to_vec());
    let little = file("float", &|x| f32::from(x).to_le_bytes().to_vec());
    assert_ne!(little.unwrap().nodes, wanted);
    let odd = file("bit", &|_| vec![0]).unwrap_err().to_string();
    assert!(odd.contains("numbers of type `bit`"), "{odd}");
}

#[test]
fn what_is_no_unstructured_grid_is_named() {
    let starts = |text: &str, message: &str| {
        let found = error(text);
        assert!(found.starts_with(message), "{found}");
    };
    starts("", "m.vtk:1: no legacy VTK file: it begins with ``");
    starts(
        "<?xml version=\"1.0\"?>",
        "m.vtk:1: no legacy VTK file: it begins with `<?xml version=",
    );
    starts(
        &HEAD.replace("ASCII", "HEX"),
        "m.vtk:3: expected ASCII or BINARY, found `HEX`",
    );
    let polydata = HEAD.replace("UNSTRUCTURED_GRID", "POLYDATA");
    starts(
        &polydata,
        "m.vtk:4: `DATASET POLYDATA`: only DATASET UNSTRUCTURED_GRID is read",
    );
    starts(HEAD, "m.vtk: no POINTS, no CELLS, no CELL_TYPES");
    starts(&format!("{HEAD}{POINTS}"), "m.vtk: no CELLS, no CELL_TYPES");
    starts(
        &format!("{HEAD}{POINTS}{POINTS}"),
        "m.vtk:9: a second POINTS section",
    );
    starts(
        &format!("{HEAD}{POINTS}1 2 3\n"),
        "m.vtk:9: unknown keyword `1`",
    );
}

#[test]
fn counts_and_indices_must_fit() {
    let with = |from: &str, to: &str| {
        let text = format!("{HEAD}{POINTS}{CELLS}");
        assert!(text.contains(from));
        error(&text.replacen(from, to, 1))
    };
    assert_eq!(
        with("POINTS 5", "POINTS 6"),
        "m.vtk:5: 6 points declared, 5 found"
    );
    assert_eq!(
        with("0 0 1\n1 1 1", "0 0 nan\n1 x 1"),
        "m.vtk:7: point 3: z `nan` is not a finite number\nm.vtk:8: point 4: y `x` is not a number"
    );
    assert_eq!(
        with("4 1 4 2 3", "4 1 5 2 3"),
        "m.vtk:11: element 1: point 5 is not one of the 5 (from 0)"
    );
    assert_eq!(
        with("4 1 4 2 3", "4 1 4 2 -3"),
        "m.vtk:11: element 1: point -3 is not one of the 5 (from 0)"
    );
    assert_eq!(
        with("CELLS 2 10", "CELLS 2 11"),
        "m.vtk:9: CELLS has 11 numbers, its 2 cells use 10"
    );
    assert_eq!(
        with("CELLS 2", "CELLS 3"),
        "m.vtk:9: 3 cells declared, 2 found"
    );
    assert_eq!(
        with("4 1 4 2 3", "7 1 4 2 3"),
        "m.vtk:11: element 1: 7 points, where CELLS has 5 numbers left"
    );
    assert_eq!(
        with("4 1 4 2 3", "4 1 4 2 3.5"),
        "m.vtk:11: element 1: a point `3.5` is not an integer"
    );
    assert_eq!(
        with("CELLS 2 10\n4 0 1 2 3\n4", "CELLS 2 9\n3 0 1 2\n4"),
        "m.vtk:10: element 0: a tetrahedron of 3 points"
    );
    assert_eq!(
        with("CELL_TYPES 2\n10\n", "CELL_TYPES 1\n"),
        "m.vtk: 2 cells, but 1 cell types"
    );
    assert_eq!(
        with("CELL_TYPES 2\n10\n10", "CELL_TYPES 2\n10"),
        "m.vtk:14: element 1: the file ends before the type"
    );
    assert!(
        with("POINTS 5", "POINTS 9999999999999999999").contains("more than the rest of the file")
    );
}

#[test]
fn offsets_must_ascend_to_the_end() {
    let text = String::from_utf8(block().to_file(Format::Vtk5)).unwrap();
    assert!(text.contains("\n0 4 8 12 16 20 24 32 "));
    let with = |to: &str| error(&text.replace("\n0 4 8 12 16 20 24 32 ", to));
    assert!(
        with("\n0 4 8 12 16 20 24 22 ")
            .contains("offset 22 after 24: offsets ascend from 0 to 216")
    );
    assert!(with("\n1 4 8 12 16 20 24 32 ").contains("offsets do not run from 0 to 216"));
    assert!(with("\n0 4 8 12 16 20 24 999 ").contains("offset 999 after 24"));
    assert!(with("\n0 4 8 12 16 20 25 32 ").contains("element 6: a hexahedron of 7 points"));
    let swapped = text
        .replace("OFFSETS", "OFFSETS ")
        .replace("CONNECTIVITY", "CONNECT");
    assert!(error(&swapped).contains("expected CONNECTIVITY, found `CONNECT`"));
}
