//! The surface of a volume: closed, outward, around the same volume.

use super::shapes::{enclosed, is_closed, parse, volumes};
use bdtree_build::input::volume::{RawVolume, parse_volume, surface};
use bdtree_fixtures::models::volume::{Format, Volume, beam, block, hex_block, tet_block};

fn raw(volume: &Volume) -> RawVolume {
    RawVolume {
        name: "v".into(),
        hash: [7; 32],
        nodes: volume.positions.clone(),
        tetrahedra: volume.tetrahedra.clone(),
        hexahedra: volume.hexahedra.clone(),
        ..RawVolume::default()
    }
}

#[test]
fn the_surface_is_closed_and_encloses_the_elements() {
    let blocks = [
        (
            Volume::of_tetrahedra(tet_block(5, 4, 3, [1.0, 0.7, 0.3])),
            2 * 2 * (20 + 15 + 12),
        ),
        (
            Volume::of_hexahedra(hex_block(5, 4, 3, [1.0, 0.7, 0.3])),
            2 * 2 * (20 + 15 + 12),
        ),
        (beam(), 2 * 2 * (16 + 16 + 4)),
        (block(), 2 * 2 * (12 + 8 + 6)),
    ];
    for (made, triangles) in blocks {
        let volume = raw(&made);
        let mesh = surface(&volume);
        assert_eq!(mesh.triangles.len(), triangles);
        assert!(is_closed(&mesh));
        assert_eq!((&mesh.name, mesh.hash), (&volume.name, volume.hash));
        assert_eq!(mesh.positions, volume.nodes);
        // The faces of the blocks are flat, so that cutting them changes nothing.
        let sum: f64 = volumes(&volume).iter().sum();
        assert!(volumes(&volume).iter().all(|&v| v > 0.0));
        assert!((enclosed(&mesh) - sum).abs() < 1e-13 * sum, "{sum}");
    }
}

#[test]
fn the_volumes_warnings_come_along() {
    let volume = RawVolume {
        warnings: vec!["v: odd".into()],
        ..raw(&block())
    };
    let inside = "v: 6 of 60 nodes are inside: vertices without triangles";
    assert_eq!(surface(&volume).warnings, ["v: odd", inside]);
}

#[test]
fn nodes_inside_are_counted() {
    let mesh = surface(&raw(&Volume::of_hexahedra(hex_block(4, 3, 5, [1.0; 3]))));
    assert_eq!(
        mesh.warnings,
        ["v: 24 of 120 nodes are inside: vertices without triangles"]
    );
    let mesh = surface(&raw(&Volume::of_tetrahedra(tet_block(1, 1, 9, [1.0; 3]))));
    assert!(mesh.warnings.is_empty());
}

/// Element by element, then face by face; a quadrilateral is a fan around its first corner.
#[test]
fn triangles_follow_the_elements() {
    let text = "*VERTICES\n5 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n\
                *ELEMENTS\nTET\n2 4 0\n1 1 2 3 4\n2 2 5 3 4\n";
    let mesh = surface(&parse("m.veg", text).unwrap());
    let expected = [
        [0, 2, 1],
        [0, 1, 3],
        [0, 3, 2],
        [1, 2, 4],
        [1, 4, 3],
        [4, 2, 3],
    ];
    assert_eq!(mesh.triangles, expected);
    let mesh = surface(&raw(&Volume::of_hexahedra(hex_block(1, 1, 1, [1.0; 3]))));
    assert_eq!(
        mesh.triangles[..4],
        [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6]]
    );
}

/// A tetrahedron on the face of a cube: nodes are shared, faces are not.
#[test]
fn faces_that_do_not_match_stay_boundary() {
    let (mut positions, hexahedra) = hex_block(1, 1, 1, [1.0; 3]);
    positions.push([0.5, 0.5, 2.0]);
    let volume = RawVolume {
        nodes: positions,
        hexahedra,
        tetrahedra: vec![[4, 5, 7, 8], [4, 7, 6, 8]],
        ..RawVolume::default()
    };
    let mesh = surface(&volume);
    assert_eq!(mesh.triangles.len(), 12 + 6);
    assert!(is_closed(&mesh));
    let sum: f64 = volumes(&volume).iter().sum();
    assert!((enclosed(&mesh) - sum).abs() < 1e-14);
}

#[test]
fn crowded_and_overlapping_faces_are_warned_of() {
    // Two on the upper side of the face 0 1 2, one below.
    let nodes = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.3, 0.3, 2.0],
        [0.0, 0.0, -1.0],
    ];
    let volume = RawVolume {
        name: "v".into(),
        nodes,
        tetrahedra: vec![[0, 1, 2, 3], [0, 1, 2, 4], [0, 2, 1, 5]],
        ..RawVolume::default()
    };
    let mesh = surface(&volume);
    assert_eq!(
        mesh.warnings,
        [
            "v: 1 faces belong to three elements or more",
            "v: 1 faces have elements on the same side: these overlap"
        ]
    );
    assert_eq!(mesh.triangles.len(), 9);
}

/// Numbers of elements do not change the surface's shape; the order of corners does not either.
#[test]
fn the_surface_does_not_depend_on_how_corners_are_turned() {
    let made = beam();
    let mut turned = made.clone();
    for corners in &mut turned.tetrahedra {
        let [a, b, c, d] = *corners;
        *corners = [c, d, a, b];
    }
    let sorted = |volume: &Volume| {
        let name = "m.vtk";
        let volume = parse_volume(&volume.to_file(Format::Vtk2), name).unwrap();
        let mut triangles = surface(&volume).triangles;
        for triangle in &mut triangles {
            let lowest = (0..3).min_by_key(|&i| triangle[i]).unwrap();
            triangle.rotate_left(lowest);
        }
        triangles.sort_unstable();
        triangles
    };
    assert_eq!(sorted(&made), sorted(&turned));
}
