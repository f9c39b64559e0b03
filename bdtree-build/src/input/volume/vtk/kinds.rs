//! The names and numbers of VTK's types.

use super::super::draft::Shape;
use super::super::number::Kind;

/// The type of numbers called `word`; `None` for bits, strings and names unknown.
pub(super) fn number(word: &[u8]) -> Option<Kind> {
    Some(match word.to_ascii_lowercase().as_slice() {
        b"char" | b"signed_char" => Kind::I8,
        b"unsigned_char" => Kind::U8,
        b"short" => Kind::I16,
        b"unsigned_short" => Kind::U16,
        // VTK writes its ids as `int`.
        b"int" | b"vtkidtype" | b"vtktypeint32" => Kind::I32,
        b"unsigned_int" | b"vtktypeuint32" => Kind::U32,
        // As on 64-bit Unix.
        b"long" | b"long_long" | b"vtktypeint64" => Kind::I64,
        b"unsigned_long" | b"unsigned_long_long" | b"vtktypeuint64" => Kind::U64,
        b"float" => Kind::F32,
        b"double" => Kind::F64,
        _ => return None,
    })
}

/// What cells of type `kind` are (vtkCellType.h).
pub(super) fn cell(kind: i64) -> Shape {
    match kind {
        0 => Shape::Lower("empty cells"),
        1 | 2 => Shape::Lower("points"),
        3 | 4 | 21 | 35 | 51 | 60 | 68 | 75 => Shape::Lower("lines"),
        5 | 6 | 22 | 34 | 61 | 69 | 76 => Shape::Lower("triangles"),
        7 | 36 | 63 => Shape::Lower("polygons"),
        8 | 9 | 23 | 28 | 30 | 62 | 70 | 77 => Shape::Lower("quadrilaterals"),
        52..=54 => Shape::Lower("parametric surfaces"),
        10 => Shape::Tetrahedron,
        11 => Shape::Voxel,
        12 => Shape::Hexahedron,
        13 => Shape::Solid("wedges"),
        14 => Shape::Solid("pyramids"),
        15 => Shape::Solid("pentagonal prisms"),
        16 => Shape::Solid("hexagonal prisms"),
        24 => Shape::Solid("quadratic tetrahedra"),
        25 | 29 | 33 => Shape::Solid("quadratic hexahedra"),
        26 | 31 | 32 => Shape::Solid("quadratic wedges"),
        27 | 37 => Shape::Solid("quadratic pyramids"),
        41 => Shape::Solid("convex point sets"),
        42 => Shape::Solid("polyhedra"),
        64 | 71 | 78 => Shape::Solid("higher-order tetrahedra"),
        65 | 73 | 80 => Shape::Solid("higher-order wedges"),
        67 | 72 | 79 => Shape::Solid("higher-order hexahedra"),
        66 | 74 | 81 => Shape::Solid("higher-order pyramids"),
        _ => Shape::Solid("cells of unknown kind"),
    }
}
