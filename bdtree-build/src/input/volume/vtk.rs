//! Legacy VTK files (`.vtk`): unstructured grids, text or binary, versions 1 to 5.1.

mod arrays;
mod cells;
mod field;
mod kinds;

use super::RawVolume;
use super::check::finish;
use super::draft::Draft;
use super::notes::Notes;
use super::number::{ByteOrder, Kind};
use super::source::{Layout, Source, Stop};
use crate::error::BakeError;
use crate::input::obj::tokens::show;
use cells::Cells;

/// The volume in the bytes of a legacy VTK file; `file` is its name in messages.
pub(super) fn parse(bytes: &[u8], file: &str) -> Result<RawVolume, BakeError> {
    let mut reader = Reader {
        source: Source::new(bytes, Layout::Words),
        notes: Notes::new(file),
        draft: Draft::default(),
        cells: Cells::default(),
        has_points: false,
    };
    let read = reader.header().and_then(|()| reader.sections());
    if let Err((position, message)) = read {
        reader.notes.problem(position, message);
    } else {
        reader.cells.build(&mut reader.draft, &mut reader.notes);
    }
    finish(reader.draft, reader.notes)
}

struct Reader<'a> {
    source: Source<'a>,
    notes: Notes<'a>,
    draft: Draft,
    cells: Cells,
    has_points: bool,
}

/// The words that begin a section.
const KEYWORDS: [&[u8]; 8] = [
    b"points",
    b"cells",
    b"cell_types",
    b"offsets",
    b"connectivity",
    b"point_data",
    b"cell_data",
    b"metadata",
];

/// A keyword where a number is due: the numbers before it ended early.
fn ends_early(source: &mut Source<'_>) -> bool {
    if source.binary.is_some() {
        return false;
    }
    source.next_record();
    let rest = source.rest();
    rest.first().is_some_and(u8::is_ascii_alphabetic)
        && KEYWORDS.iter().any(|keyword| {
            let word = rest.get(..keyword.len());
            let after = rest.get(keyword.len());
            word.is_some_and(|w| w.eq_ignore_ascii_case(keyword))
                && after.is_none_or(u8::is_ascii_whitespace)
        })
}

impl Reader<'_> {
    /// The first four lines: version, title, `ASCII` or `BINARY`, the kind of data set.
    fn header(&mut self) -> Result<(), Stop> {
        let first = self.source.line_rest();
        if !first.starts_with(b"# vtk DataFile Version ") {
            let is_xml = first.trim_ascii_start().starts_with(b"<");
            let hint = if is_xml {
                " (XML files are not read)"
            } else {
                ""
            };
            return Err((
                1,
                format!("no legacy VTK file: it begins with `{}`{hint}", show(first)),
            ));
        }
        self.source.skip_line();
        // The title, which may be blank.
        self.source.skip_line();
        let format = self.source.word().unwrap_or_default();
        let binary = match format.to_ascii_uppercase().as_slice() {
            b"ASCII" => None,
            b"BINARY" => Some(ByteOrder::Big),
            _ => {
                let message = format!("expected ASCII or BINARY, found `{}`", show(format));
                return Err((self.source.position(), message));
            }
        };
        let keyword = self.source.word().unwrap_or_default();
        let kind = self.source.word().unwrap_or_default();
        if !keyword.eq_ignore_ascii_case(b"DATASET")
            || !kind.eq_ignore_ascii_case(b"UNSTRUCTURED_GRID")
        {
            let found = format!("{} {}", show(keyword), show(kind));
            let message = format!("`{found}`: only DATASET UNSTRUCTURED_GRID is read");
            return Err((self.source.position(), message));
        }
        self.source.binary = binary;
        self.notes.is_binary = binary.is_some();
        Ok(())
    }

    fn sections(&mut self) -> Result<(), Stop> {
        while let Some(keyword) = self.source.word() {
            let position = self.source.position();
            match keyword.to_ascii_lowercase().as_slice() {
                b"points" => self.points(position)?,
                b"cells" => self.cells.connectivity(&mut self.source, position)?,
                b"cell_types" => self.cells.types(&mut self.source, position)?,
                b"field" => field::skip(&mut self.source, position)?,
                b"metadata" => field::skip_metadata(&mut self.source),
                // Values at points and cells: nothing of the grid comes after them.
                b"point_data" | b"cell_data" => break,
                _ => return Err((position, format!("unknown keyword `{}`", show(keyword)))),
            }
        }
        let parts = [
            (self.has_points, "POINTS"),
            (self.cells.has_connectivity, "CELLS"),
            (self.cells.has_types, "CELL_TYPES"),
        ];
        let missing: Vec<&str> = parts.iter().filter(|p| !p.0).map(|p| p.1).collect();
        if !missing.is_empty() {
            return Err((0, format!("no {}", missing.join(", no "))));
        }
        Ok(())
    }

    /// `POINTS count type`, then the coordinates.
    fn points(&mut self, position: u64) -> Result<(), Stop> {
        if self.has_points {
            return Err((position, "a second POINTS section".into()));
        }
        self.has_points = true;
        let (count, kind) = array(&mut self.source, "the number of points", 3)
            .map_err(|message| (position, message))?;
        for point in 0..count {
            let mut coordinates = [0.0; 3];
            for (value, axis) in coordinates.iter_mut().zip(["x", "y", "z"]) {
                if ends_early(&mut self.source) {
                    return Err((position, format!("{count} points declared, {point} found")));
                }
                let at = self.source.position();
                match self.source.real(axis, kind) {
                    Ok(read) => *value = read,
                    Err(message) if self.source.rest().is_empty() => return Err((at, message)),
                    Err(message) => self.notes.problem(at, format!("point {point}: {message}")),
                }
            }
            self.draft.nodes.push(coordinates);
        }
        Ok(())
    }
}

/// Reads `count type`, checks the count for `width` numbers each, and goes to the first of them.
fn array(source: &mut Source<'_>, what: &str, width: usize) -> Result<(usize, Kind), String> {
    let count = source.text_integer(what)?;
    let kind = kind(source)?;
    let each = if source.binary.is_some() {
        kind.bytes()
    } else {
        2
    };
    let count = source.fits(what, count, width * each)?;
    Ok((count, kind))
}

/// Reads the name of a type; in binary files, the end of its line too.
fn kind(source: &mut Source<'_>) -> Result<Kind, String> {
    let word = source.word().unwrap_or_default();
    let kind = kinds::number(word).ok_or_else(|| format!("numbers of type `{}`", show(word)))?;
    start(source);
    Ok(kind)
}

/// Goes to the first number after a keyword's line.
fn start(source: &mut Source<'_>) {
    if source.binary.is_some() {
        source.skip_line();
    }
}
