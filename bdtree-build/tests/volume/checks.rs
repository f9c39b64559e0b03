//! What is checked of every volume, whatever its format: order of corners, volume, doubles.

use super::shapes::{parse, volumes};
use bdtree_build::input::volume::{RawVolume, parse_volume};
use bdtree_fixtures::models::volume::{Format, Volume, block, hex_block, tet_block};

fn read(volume: &Volume, format: Format) -> Result<RawVolume, String> {
    let name = format!("m{}", format.extension());
    parse_volume(&volume.to_file(format), &name).map_err(|e| e.to_string())
}

#[test]
fn mirrored_elements_are_turned_and_counted() {
    let mut tetrahedra = Volume::of_tetrahedra(tet_block(2, 1, 1, [2.0, 1.0, 1.0]));
    let wanted = read(&tetrahedra, Format::Veg).unwrap();
    for corners in &mut tetrahedra.tetrahedra[3..] {
        corners.swap(0, 1);
    }
    let turned = read(&tetrahedra, Format::Veg).unwrap();
    let warning = "m.veg:25: 9 tetrahedra were mirrored; their corners were reordered";
    assert_eq!(turned.warnings, [warning]);
    assert_eq!(volumes(&turned), volumes(&wanted));
    assert_eq!(turned.material_of, wanted.material_of);

    let mut hexahedra = block();
    for [a, b, c, d, e, f, g, h] in &mut hexahedra.hexahedra {
        (*a, *b, *c, *d, *e, *f, *g, *h) = (*e, *f, *g, *h, *a, *b, *c, *d);
    }
    let turned = read(&hexahedra, Format::Msh2).unwrap();
    assert_eq!(turned.hexahedra, block().hexahedra);
    assert!(
        turned.warnings[1].ends_with("24 hexahedra were mirrored; their corners were reordered")
    );
}

#[test]
fn size_and_place_do_not_change_what_is_flat() {
    // Powers of two, so that the shape stays the same to the last bit.
    for (factor, offset) in [
        (0.5_f64.powi(300), 0.0),
        (2.0_f64.powi(300), 0.0),
        (1.0, 2.0_f64.powi(20)),
    ] {
        let text = |flat: bool| {
            let height = if flat { 0.0 } else { 0.0625 };
            let points = [
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.25, 0.25, height],
            ];
            let lines: String = points
                .iter()
                .map(|p| p.map(|x| format!("{:e} ", x * factor + offset)).concat() + "\n")
                .collect();
            format!(
                "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n\
                 {lines}CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n"
            )
        };
        assert!(parse("m.vtk", &text(false)).is_ok(), "{factor:e} {offset}");
        let error = parse("m.vtk", &text(true)).unwrap_err();
        assert_eq!(
            error, "m.vtk:11: element 0 has no volume",
            "{factor:e} {offset}"
        );
    }
}

#[test]
fn doubles_are_left_out_and_unused_nodes_kept() {
    let mut volume = Volume::of_tetrahedra(tet_block(1, 1, 1, [1.0; 3]));
    let [a, b, c, d] = volume.tetrahedra[1];
    volume.tetrahedra.push([b, c, a, d]);
    volume.tetrahedra.push([a, b, c, d]);
    volume.positions.extend([[2.0; 3], [3.0; 3]]);
    let read = read(&volume, Format::Veg).unwrap();
    assert_eq!(read.tetrahedra.len(), 6);
    assert_eq!(read.nodes.len(), 10);
    // Of eight elements the first four are of the first material.
    assert_eq!(read.material_of, [0, 0, 0, 0, 1, 1]);
    let expected = [
        "m.veg:26: 2 tetrahedra have the corners of an earlier one and are left out",
        "m.veg: 2 of 10 nodes belong to no element; they are kept",
    ];
    assert_eq!(read.warnings, expected);
}

#[test]
fn hexahedra_may_be_skewed_but_not_folded() {
    let skewed = |top: [f64; 3]| {
        let (mut positions, cells) = hex_block(1, 1, 1, [1.0; 3]);
        positions[7] = top;
        let error = read(&Volume::of_hexahedra((positions, cells)), Format::Vtk2);
        error.map(|volume| volumes(&volume)[0])
    };
    assert!(skewed([1.5, 1.25, 2.0]).is_ok());
    assert!(skewed([0.75; 3]).is_ok());
    // Beyond the plane through its neighbours.
    let error = skewed([0.5; 3]).unwrap_err();
    assert!(
        error.starts_with("m.vtk:23: element 1 is folded"),
        "{error}"
    );
}

#[test]
fn other_solids_are_refused_by_name() {
    let text = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 6 float\n\
                0 0 0 1 0 0 0 1 0 0 0 1 1 0 1 0 1 1\nCELLS 5 27\n6 0 1 2 3 4 5\n4 0 1 2 3\n\
                6 0 1 2 3 4 5\n5 0 1 2 3 4\n1 0\nCELL_TYPES 5\n13 10 13 14 1\n";
    let expected = "m.vtk:8: 2 wedges (type 13); only tetrahedra of 4 nodes and hexahedra of 8 are read\n\
                    m.vtk:11: 1 pyramids (type 14); only tetrahedra of 4 nodes and hexahedra of 8 are read";
    assert_eq!(parse("m.vtk", text).unwrap_err(), expected);
    let lower = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 float\n\
                 0 0 0\nCELLS 1 2\n1 0\nCELL_TYPES 1\n1\n";
    assert_eq!(
        parse("m.vtk", lower).unwrap_err(),
        "m.vtk: no tetrahedra or hexahedra"
    );
}
