//! PLY, text and binary of both byte orders, by the crate `ply-rs-bw`.
//!
//! Vertices are the elements `vertex` in their order, faces the elements `face`; other elements and properties are
//! left out, with a warning for elements.

use std::io::{BufRead, Cursor};

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use super::faces::Faces;
use super::{BadFaces, RawMesh};
use crate::error::{BakeError, Part, Place, Problems};

/// The mesh in the PLY file `bytes`; `name` and `hash` are left empty, `place` is the file's name in problems.
///
/// # Errors
/// A header or data that is not PLY, with the line where it is text; vertices without x, y and z or with coordinates
/// that are not finite; faces with fewer than three corners or corners out of range, unless they are skipped;
/// triangle strips; no vertices or no faces.
pub fn parse(bytes: &[u8], place: &str, bad: BadFaces) -> Result<RawMesh, BakeError> {
    let parser = Parser::<Element>::new();
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = parser
        .read_header(&mut reader)
        .map_err(|e| error(&e, place))?;
    let (mut positions, mut others) = (Vec::new(), Vec::new());
    let mut faces = None;
    for definition in header.elements.values() {
        check_count(definition, &header, reader.get_mut(), place)?;
        check_properties(definition, place)?;
        let elements = parser.read_payload_for_element(&mut reader, definition, &header);
        let elements = elements.map_err(|e| error(&e, place))?;
        match definition.name.as_str() {
            "vertex" => positions = vertices(&elements, place)?,
            "face" => faces = Some(elements),
            name if !elements.is_empty() => others.push((name, elements.len())),
            _ => {}
        }
    }
    let Some(elements) = faces else {
        let message = "no faces: the header has no element `face`";
        return Err(BakeError::one("input", Place::file(place), message));
    };
    let mut faces = Faces::new(place, bad);
    for (face, element) in elements.iter().enumerate() {
        faces.add(face, &element.corners, &positions);
    }
    let mut mesh = faces.finish(positions)?;
    let ignored = others.iter();
    let ignored =
        ignored.map(|(name, count)| format!("{place}: ignored {count} elements `{name}`"));
    mesh.warnings.extend(ignored);
    Ok(mesh)
}

/// A vertex or a face, by the names that files use.
#[derive(Default)]
struct Element {
    position: [f64; 3],
    corners: Vec<i64>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let axis = ["x", "y", "z"].iter().position(|axis| *axis == name);
        match (axis, name) {
            (Some(axis), _) => match scalar(&property) {
                Some(x) => self.position[axis] = x,
                None => return PropertyAccessResult::UnsupportedType,
            },
            (None, "vertex_indices" | "vertex_index") => match integers(property) {
                Some(corners) => self.corners = corners,
                None => return PropertyAccessResult::UnsupportedType,
            },
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

fn scalar(property: &Property) -> Option<f64> {
    Some(match *property {
        Property::Char(x) => x.into(),
        Property::UChar(x) => x.into(),
        Property::Short(x) => x.into(),
        Property::UShort(x) => x.into(),
        Property::Int(x) => x.into(),
        Property::UInt(x) => x.into(),
        Property::Float(x) => x.into(),
        Property::Double(x) => x,
        _ => return None,
    })
}

fn integers(property: Property) -> Option<Vec<i64>> {
    fn wide<T: Into<i64>>(list: Vec<T>) -> Option<Vec<i64>> {
        Some(list.into_iter().map(Into::into).collect())
    }
    match property {
        Property::ListChar(list) => wide(list),
        Property::ListUChar(list) => wide(list),
        Property::ListShort(list) => wide(list),
        Property::ListUShort(list) => wide(list),
        Property::ListInt(list) => wide(list),
        Property::ListUInt(list) => wide(list),
        _ => None,
    }
}

/// More elements than the rest of the file has bytes for are refused before they are read: a few bytes could
/// announce any number of elements without properties.
fn check_count(
    definition: &ElementDef,
    header: &Header,
    rest: &mut impl BufRead,
    place: &str,
) -> Result<(), BakeError> {
    let bytes = |scalar: &ScalarType| match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    };
    let properties = definition.properties.values();
    let least: usize = match header.encoding {
        // A digit and a space or an end of line each.
        Encoding::Ascii => 2 * properties.count(),
        _ => properties
            .map(|property| match &property.data_type {
                PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => bytes(scalar),
            })
            .sum(),
    };
    let left = rest.fill_buf().map_or(0, <[u8]>::len);
    // The last line may lack its end.
    if definition.count <= (left + 1) / least.max(1) {
        return Ok(());
    }
    let message = format!(
        "is cut off: its header announces {} elements `{}`, more than {left} bytes can hold",
        definition.count, definition.name
    );
    Err(BakeError::one("input", Place::file(place), message))
}

/// Vertices need three coordinates, faces their corners.
fn check_properties(definition: &ElementDef, place: &str) -> Result<(), BakeError> {
    let has = |name: &str| definition.properties.contains_key(name);
    let lacks = match definition.name.as_str() {
        "vertex" if definition.count > 0 && !["x", "y", "z"].into_iter().all(has) => {
            "vertices without x, y and z"
        }
        "face" if definition.count > 0 && !(has("vertex_indices") || has("vertex_index")) => {
            "faces without vertex_indices"
        }
        "tristrips" if definition.count > 0 => {
            "triangle strips, which are not read: save it with faces"
        }
        _ => return Ok(()),
    };
    let message = format!("has {lacks}");
    Err(BakeError::one("input", Place::file(place), message))
}

fn vertices(elements: &[Element], place: &str) -> Result<Vec<[f64; 3]>, BakeError> {
    let mut problems = Problems::new("input");
    if elements.is_empty() || elements.len() > u32::MAX as usize {
        let message = format!("{} vertices; expected 1 to {}", elements.len(), u32::MAX);
        problems.add(|| (Place::file(place), message));
    }
    for (vertex, element) in elements.iter().enumerate() {
        if let Some(axis) = element.position.iter().position(|x| !x.is_finite()) {
            let at = || {
                Place::file(place)
                    .at(Part::Vertex(vertex))
                    .at(Part::Axis(axis))
            };
            problems.add(|| (at(), format!("{} is not finite", element.position[axis])));
        }
    }
    problems.into_result(Place::file(place))?;
    Ok(elements.iter().map(|element| element.position).collect())
}

/// The crate's error, at its line where it knows it, without the text of the line, which may be anything.
fn error(error: &ParseError, place: &str) -> BakeError {
    let file = Place::file(place);
    let at = match error.line() {
        Some(line) => file.at(Part::Line(line as u64)),
        None => file,
    };
    let text = error.to_string();
    let text = match text.split_once(": ") {
        Some((line, rest)) if line.starts_with("Line ") => rest,
        _ => &text,
    };
    let reason = text.lines().next().unwrap_or_default();
    BakeError::one("input", at, format!("is not read as PLY: {reason}"))
}
