//! STL, binary and text, by the crate `stl_io`.
//!
//! The format repeats positions in every triangle: corners with the same three numbers become one vertex, numbered in
//! the order in which they are first met. Normals are not read.

use std::collections::HashMap;
use std::io::Cursor;

use stl_io::{Vector, Vertex};

use super::faces::Faces;
use super::{BadFaces, RawMesh};
use crate::error::{BakeError, Part, Place};

/// Bytes before the triangles of a binary file, and of each of them.
const HEADER_BYTES: usize = 84;
const TRIANGLE_BYTES: usize = 50;

/// The mesh in the STL file `bytes`; `name` and `hash` are left empty, `place` is the file's name in problems.
///
/// # Errors
/// A file that ends early, text that is not STL, coordinates that are not finite, no triangles.
pub fn parse(bytes: &[u8], place: &str) -> Result<RawMesh, BakeError> {
    let mut welded = Welded::default();
    if is_binary(bytes) {
        check_length(bytes, place)?;
        // `stl_io` takes what begins with "solid " for text, as the header of a binary file may as well.
        let mut copy = bytes.to_vec();
        copy[0] = 0;
        welded.read(copy, place)?;
    } else {
        // `stl_io` stops at the first "endsolid"; a file may hold several.
        for solid in solids(bytes) {
            welded.read(solid, place)?;
        }
    }
    let mut faces = Faces::new(place, BadFaces::Refuse);
    for (face, corners) in welded.triangles.iter().enumerate() {
        faces.add(face, corners, &welded.positions);
    }
    faces.finish(welded.positions)
}

/// Text begins with "solid" and holds "facet" or "endsolid"; a binary file may begin so too, but its length tells.
fn is_binary(bytes: &[u8]) -> bool {
    let has = |word: &[u8]| bytes.windows(word.len()).any(|part| part == word);
    if !bytes.trim_ascii_start().starts_with(b"solid") {
        return true;
    }
    declared(bytes) == Some(bytes.len()) || !(has(b"facet") || has(b"endsolid"))
}

/// How long a binary file says that it is.
fn declared(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..HEADER_BYTES)?;
    let count = u32::from_le_bytes(count.try_into().ok()?) as usize;
    Some(HEADER_BYTES + TRIANGLE_BYTES * count)
}

fn check_length(bytes: &[u8], place: &str) -> Result<(), BakeError> {
    let found = bytes.len();
    let message = match declared(bytes) {
        Some(length) if found >= length => return Ok(()),
        Some(length) => format!("is cut off: its header announces {length} bytes, found {found}"),
        None => {
            format!("is neither STL text nor binary STL, which has at least {HEADER_BYTES} bytes")
        }
    };
    Err(BakeError::one("input", Place::file(place), message))
}

/// The solids of a text, each with its "endsolid".
fn solids(bytes: &[u8]) -> impl Iterator<Item = Vec<u8>> {
    let lines = bytes.split_inclusive(|&byte| byte == b'\n');
    let mut parts: Vec<Vec<u8>> = vec![Vec::new()];
    for line in lines {
        let words = line.trim_ascii();
        let part = parts.last_mut();
        let Some(part) = part else { break };
        if words == b"solid" {
            // A solid without a name, which `stl_io` takes for a binary file.
            part.extend(b"solid \n");
        } else if !part.is_empty() || !words.is_empty() {
            let indented = line.len() - line.trim_ascii_start().len();
            part.extend(&line[indented..]);
        }
        if words.starts_with(b"endsolid") {
            parts.push(Vec::new());
        }
    }
    parts.into_iter().filter(|part| !part.is_empty())
}

/// Triangles whose corners with equal coordinates are one vertex.
#[derive(Default)]
struct Welded {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[i64; 3]>,
    known: HashMap<[u32; 3], i64>,
}

impl Welded {
    fn read(&mut self, bytes: Vec<u8>, place: &str) -> Result<(), BakeError> {
        let mut bytes = Cursor::new(bytes);
        let first = self.triangles.len();
        let error = |triangle: usize, message: String| {
            let place = Place::file(place).at(Part::Triangle(triangle));
            BakeError::one("input", place, message)
        };
        let reader = stl_io::create_stl_reader(&mut bytes);
        for (k, triangle) in reader.map_err(|e| error(first, e.to_string()))?.enumerate() {
            let triangle = triangle.map_err(|e| error(first + k, e.to_string()))?;
            let corners = triangle.vertices;
            if corners
                .iter()
                .any(|Vector(x)| x.iter().any(|x| !x.is_finite()))
            {
                return Err(error(first + k, "a coordinate is not finite".to_string()));
            }
            let corners = corners.map(|corner| self.vertex(corner));
            self.triangles.push(corners);
        }
        Ok(())
    }

    fn vertex(&mut self, Vector(x): Vertex) -> i64 {
        let x = x.map(|x| x + 0.0); // −0 is 0
        let next = self.positions.len() as i64;
        let vertex = *self.known.entry(x.map(f32::to_bits)).or_insert(next);
        if vertex == next {
            self.positions.push(x.map(f64::from));
        }
        vertex
    }
}
