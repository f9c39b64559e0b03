//! Wavefront OBJ: positions, faces and groups; everything else is skipped and counted.
//!
//! Our own reader, because a basis made elsewhere refers to the file's `v` lines in order; why not
//! a crate, and every decision on odd input: `docs/design/decisions/obj-reader.md`.

mod face;
mod finish;
mod lines;
mod notes;
pub(super) mod tokens;

use super::faces::out_of_range;
use super::{BadFaces, GroupKind, RawGroup, RawMesh};
use crate::error::BakeError;
use face::{Corner, Deferred};
use lines::Lines;
use notes::Notes;
use tokens::Tokens;

/// The mesh in the OBJ text `text`; `name` and `hash` are left empty.
///
/// `place` is the file's name in problems and warnings: `place:line`. Vertices are the `v` lines in
/// order, all of them; triangles are the fans of all faces in file order; coordinates are the
/// nearest f64. Indices may be relative or refer to vertices that come later. One pass over the
/// text, no allocation per line.
///
/// # Errors
/// All of: a vertex without three finite numbers, a face with fewer than three corners or an index
/// that is no index, 0 or out of range, text that is not UTF-8-compatible (UTF-16, binary), a file
/// that is empty or has no vertices or no faces, more than `u32::MAX` vertices or triangles. The
/// first 100 are listed, in line order, then how many more there are. With [`BadFaces::Skip`] faces are no errors.
pub fn parse(text: &[u8], place: &str, bad_faces: BadFaces) -> Result<RawMesh, BakeError> {
    let text = lines::check_encoding(text, place)?;
    let mut reader = Reader::new(place, u32::MAX);
    if bad_faces == BadFaces::Skip {
        // Which faces are bad must be known when they are met: ids count those that are not.
        reader.skip_beyond = Some(vertex_count(text));
    }
    let mut lines = Lines::new(text);
    while let Some((number, line)) = lines.next_line() {
        reader.statement(number, line);
        if reader.full {
            break;
        }
    }
    reader.finish()
}

/// Number of `v` statements.
fn vertex_count(text: &[u8]) -> usize {
    let mut lines = Lines::new(text);
    let mut count = 0;
    while let Some((_, line)) = lines.next_line() {
        count += usize::from(Tokens::new(line).next() == Some(b"v"));
    }
    count
}

/// What is known so far while the lines go by.
struct Reader<'a> {
    notes: Notes<'a>,
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    groups: Vec<RawGroup>,
    /// The group that is open, per [`GroupKind`].
    open: [Option<usize>; 3],
    /// Corners of the face being read.
    corners: Vec<u32>,
    /// Faces that name vertices not read yet.
    deferred: Vec<Deferred>,
    /// Greatest number of vertices, and of triangles.
    limit: u32,
    /// A limit was passed: nothing more can be read.
    full: bool,
    /// Bad faces are skipped; this is the number of vertices in the whole file.
    skip_beyond: Option<usize>,
    vertex_statements: u64,
    face_statements: u64,
}

impl<'a> Reader<'a> {
    fn new(place: &'a str, limit: u32) -> Self {
        Self {
            notes: Notes::new(place),
            positions: Vec::new(),
            triangles: Vec::new(),
            groups: Vec::new(),
            open: [None; 3],
            corners: Vec::new(),
            deferred: Vec::new(),
            limit,
            full: false,
            skip_beyond: None,
            vertex_statements: 0,
            face_statements: 0,
        }
    }

    /// Takes one logical line (continuations joined, without its end).
    fn statement(&mut self, line: u64, bytes: &[u8]) {
        let mut tokens = Tokens::new(bytes);
        let Some(keyword) = tokens.next() else {
            return;
        };
        match keyword {
            b"v" => self.vertex(line, tokens),
            b"f" => self.face(line, tokens),
            b"vt" | b"vn" | b"vp" | b"s" | b"mtllib" => {}
            b"o" => self.group(GroupKind::Object, tokens.rest()),
            b"g" => self.group(GroupKind::Group, tokens.rest()),
            b"usemtl" => self.group(GroupKind::Material, tokens.rest()),
            b"p" => self.notes.points += 1,
            b"l" => self.notes.lines += 1,
            b"curv" | b"curv2" | b"surf" => self.notes.curves += 1,
            // The bodies of curves and surfaces.
            b"cstype" | b"deg" | b"bmat" | b"step" | b"parm" | b"trim" | b"hole" | b"scrv"
            | b"sp" | b"end" | b"con" => {}
            // Display attributes.
            b"mg" | b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"shadow_obj"
            | b"trace_obj" | b"ctech" | b"stech" | b"maplib" | b"usemap" => {}
            other => self.notes.unknown(other),
        }
    }

    /// `v x y z`, then a weight or a colour, which are not used and not looked at.
    fn vertex(&mut self, line: u64, tokens: Tokens<'_>) {
        self.vertex_statements += 1;
        match tokens::position(tokens) {
            Ok(_) if self.positions.len() >= self.limit as usize => {
                self.full = true;
                let message = format!("more than {} vertices", self.limit);
                self.notes.problem(line, message);
            }
            Ok(position) => self.positions.push(position),
            Err(message) => {
                self.notes.problem(line, message);
                // Keeps the count, so that later faces are not blamed for this line.
                self.positions.push([0.0; 3]);
            }
        }
    }

    /// `f` with three corners or more: a fan around the first.
    fn face(&mut self, line: u64, tokens: Tokens<'_>) {
        self.face_statements += 1;
        let known = self.positions.len();
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        let mut later = false;
        for (i, token) in tokens.enumerate() {
            let message = match face::corner(token, known, self.limit) {
                Ok(Corner { index, .. }) if self.is_beyond(index) => out_of_range(
                    i,
                    &tokens::show(token),
                    self.skip_beyond.unwrap_or_default(),
                ),
                Ok(Corner { index, is_later }) => {
                    corners.push(index);
                    later |= is_later;
                    continue;
                }
                Err(message) => format!("corner {} `{}`: {message}", i + 1, tokens::show(token)),
            };
            self.bad_face(line, message);
            self.corners = corners;
            return;
        }
        if corners.len() < 3 {
            let message = format!("a face needs 3 corners or more, found {}", corners.len());
            self.bad_face(line, message);
        } else if corners.len() - 2 > self.limit as usize - self.triangles.len() {
            self.full = true;
            let message = format!("more than {} triangles", self.limit);
            self.notes.problem(line, message);
        } else {
            let first = self.triangles.len();
            let fan = corners[1..].windows(2);
            self.triangles
                .extend(fan.map(|pair| [corners[0], pair[0], pair[1]]));
            if later {
                self.deferred.push(Deferred {
                    line,
                    triangles: first..self.triangles.len(),
                });
            } else {
                let new = &self.triangles[first..];
                face::check_shape(new, first, &self.positions, line, &mut self.notes);
            }
        }
        self.corners = corners;
    }

    /// Bad faces are skipped, and the file never has this vertex.
    fn is_beyond(&self, index: u32) -> bool {
        self.skip_beyond
            .is_some_and(|count| index as usize >= count)
    }

    /// A face that cannot be read.
    fn bad_face(&mut self, line: u64, message: String) {
        if self.skip_beyond.is_some() {
            self.notes.skipped_face(line, &message);
        } else {
            self.notes.problem(line, message);
        }
    }

    /// A statement that names the faces from here on.
    fn group(&mut self, kind: GroupKind, name: &[u8]) {
        self.close(kind);
        self.open[kind as usize] = Some(self.groups.len());
        self.groups.push(RawGroup {
            kind,
            name: String::from_utf8_lossy(name).into_owned(),
            // No truncation: the number of triangles is limited to u32.
            first_triangle: self.triangles.len() as u32,
            triangle_count: 0,
        });
    }

    /// Ends the open group of `kind`, if there is one.
    fn close(&mut self, kind: GroupKind) {
        if let Some(open) = self.open[kind as usize].take() {
            let group = &mut self.groups[open];
            group.triangle_count = self.triangles.len() as u32 - group.first_triangle;
        }
    }
}
