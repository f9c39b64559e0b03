//! Gmsh's element types.

use super::super::draft::Shape;

/// The nodes of the largest type, 93.
pub(super) const MOST_NODES: usize = 125;

/// What elements of type `kind` are, their dimension and their number of nodes (Gmsh reference
/// manual, "MSH file format"); `None` for a type unknown.
pub(super) fn element(kind: i64) -> Option<(Shape, i64, usize)> {
    let lower = |name, dimension, nodes| Some((Shape::Lower(name), dimension, nodes));
    let solid = |name, nodes| Some((Shape::Solid(name), 3, nodes));
    match kind {
        15 => lower("points", 0, 1),
        1 => lower("lines", 1, 2),
        8 => lower("lines", 1, 3),
        26 => lower("lines", 1, 4),
        27 => lower("lines", 1, 5),
        28 => lower("lines", 1, 6),
        2 => lower("triangles", 2, 3),
        9 => lower("triangles", 2, 6),
        20 => lower("triangles", 2, 9),
        21 => lower("triangles", 2, 10),
        22 => lower("triangles", 2, 12),
        23 | 24 => lower("triangles", 2, 15),
        25 => lower("triangles", 2, 21),
        3 => lower("quadrilaterals", 2, 4),
        10 => lower("quadrilaterals", 2, 9),
        16 => lower("quadrilaterals", 2, 8),
        4 => Some((Shape::Tetrahedron, 3, 4)),
        5 => Some((Shape::Hexahedron, 3, 8)),
        6 => solid("prisms", 6),
        7 => solid("pyramids", 5),
        11 => solid("second-order tetrahedra", 10),
        12 => solid("second-order hexahedra", 27),
        13 => solid("second-order prisms", 18),
        14 => solid("second-order pyramids", 14),
        17 => solid("second-order hexahedra", 20),
        18 => solid("second-order prisms", 15),
        19 => solid("second-order pyramids", 13),
        29 => solid("third-order tetrahedra", 20),
        30 => solid("fourth-order tetrahedra", 35),
        31 => solid("fifth-order tetrahedra", 56),
        92 => solid("third-order hexahedra", 64),
        93 => solid("fourth-order hexahedra", 125),
        _ => None,
    }
}
