//! VegaFEM's text format `.veg`: vertices, elements of one kind, materials, sets, regions.

mod assign;
mod numbers;

use super::RawVolume;
use super::check::finish;
use super::draft::{Draft, Element};
use super::notes::{Notes, Tally};
use super::number::Kind;
use super::source::{Layout, Source, Stop};
use crate::error::BakeError;
use crate::input::obj::tokens::show;
use assign::Assignment;
use numbers::{Numbering, Numbers};

/// The volume in the text of a .veg file; `file` is its name in messages.
pub(super) fn parse(text: &[u8], file: &str) -> Result<RawVolume, BakeError> {
    let mut reader = Reader {
        source: Source::new(text, Layout::Lines).with_commas(),
        notes: Notes::new(file),
        draft: Draft::default(),
        assignment: Assignment::default(),
        vertices: None,
        elements: None,
    };
    match reader.sections() {
        Ok(elements) => {
            let (assignment, draft) = (reader.assignment, &mut reader.draft);
            assignment.resolve(elements.base, draft, &mut reader.notes);
        }
        Err((position, message)) => reader.notes.problem(position, message),
    }
    finish(reader.draft, reader.notes)
}

struct Reader<'a> {
    source: Source<'a>,
    notes: Notes<'a>,
    draft: Draft,
    assignment: Assignment,
    /// Set when the section has been read.
    vertices: Option<Numbering>,
    elements: Option<Numbering>,
}

impl<'a> Reader<'a> {
    /// All sections; how the elements are numbered.
    fn sections(&mut self) -> Result<Numbering, Stop> {
        while self.source.next_record() {
            let position = self.source.position();
            let keyword = self.source.field().unwrap_or_default();
            match keyword.to_ascii_uppercase().as_slice() {
                b"*VERTICES" => self.vertices(position)?,
                b"*ELEMENTS" => self.elements(position)?,
                b"*MATERIAL" => self.assignment.material(&mut self.source, &mut self.notes),
                b"*SET" => self.assignment.set(&mut self.source, &mut self.notes),
                b"*REGION" => self.assignment.region(&mut self.source, &mut self.notes),
                b"*INCLUDE" => {
                    let message = "*INCLUDE is not read: put the file's text in its place";
                    self.notes.problem(position, message.into());
                    self.source.skip_line();
                }
                [b'*', ..] => {
                    let message = format!("ignored unknown section {}", show(keyword));
                    self.notes.warn(position, &message);
                    self.source.skip_line();
                    while self.next_line_of_section() {
                        self.source.skip_line();
                    }
                }
                _ => {
                    let message = format!("`{}` before any section: no .veg text", show(keyword));
                    return Err((position, message));
                }
            }
        }
        match (self.vertices, self.elements) {
            (Some(_), Some(elements)) => Ok(elements),
            (None, _) => Err((0, "no *VERTICES section".into())),
            _ => Err((0, "no *ELEMENTS section".into())),
        }
    }

    /// Goes to the next line with a word; false where the next section or the file's end is.
    fn next_line_of_section(&mut self) -> bool {
        next_line_of_section(&mut self.source)
    }

    /// `count 3 0 0`, then `number x y z` lines.
    fn vertices(&mut self, position: u64) -> Result<(), Stop> {
        if self.vertices.is_some() {
            return Err((position, "a second *VERTICES section".into()));
        }
        self.source.skip_line();
        let (declared, count_at) = self.count("the number of vertices", 7)?;
        let mut numbers = Numbers::default();
        let mut longer = Tally::default();
        while self.next_line_of_section() {
            let position = self.source.position();
            let read = |source: &mut Source<'_>| -> Result<(i64, [f64; 3]), String> {
                let number = source.text_integer("the number of the vertex")?;
                let mut axis = |name| source.real(name, Kind::F64);
                Ok((number, [axis("x")?, axis("y")?, axis("z")?]))
            };
            match read(&mut self.source) {
                Ok((number, point)) => {
                    numbers.next(number, position, "vertex", &mut self.notes);
                    self.draft.nodes.push(point);
                    if self.source.field().is_some() {
                        longer.add(position);
                    }
                }
                Err(message) => {
                    self.notes.problem(position, message);
                    // Keeps the count, so that no element is blamed for this line.
                    numbers.skip();
                    self.draft.nodes.push([0.0; 3]);
                }
            }
            self.source.skip_line();
        }
        self.compare("vertices", declared, numbers.count, count_at);
        let message = "vertices have more than three coordinates; the first three are used";
        self.notes.warn_tally(&longer, message);
        self.vertices = Some(numbers.numbering());
        Ok(())
    }

    /// `TET` or `CUBIC`, then `count corners 0`, then `number corner …` lines.
    fn elements(&mut self, position: u64) -> Result<(), Stop> {
        if self.elements.is_some() {
            return Err((position, "a second *ELEMENTS section".into()));
        }
        let Some(vertices) = self.vertices else {
            return Err((position, "*ELEMENTS before *VERTICES".into()));
        };
        self.source.skip_line();
        let found = self.next_line_of_section();
        let position = self.source.position();
        let kind = self.source.field().filter(|_| found).unwrap_or_default();
        self.source.skip_line();
        match kind.to_ascii_uppercase().as_slice() {
            b"TET" => self.draft.tetrahedra = self.element_lines(vertices)?,
            // Vega's order is VTK's: around the bottom, then around the top.
            b"CUBIC" => self.draft.hexahedra = self.element_lines(vertices)?,
            _ => {
                let kind = show(kind);
                let message = format!("elements of type `{kind}`; TET and CUBIC are read");
                return Err((position, message));
            }
        }
        Ok(())
    }

    fn element_lines<const N: usize>(
        &mut self,
        vertices: Numbering,
    ) -> Result<Vec<Element<N>>, Stop> {
        let (declared, count_at) = self.count("the number of elements", 2 * N + 1)?;
        let mut elements = Vec::new();
        let known = self.draft.nodes.len();
        let mut numbers = Numbers::default();
        while self.next_line_of_section() {
            let position = self.source.position();
            let read = |source: &mut Source<'_>| -> Result<(i64, [u32; N]), String> {
                let number = source.text_integer("the number of the element")?;
                let mut corners = [0; N];
                for (i, corner) in corners.iter_mut().enumerate() {
                    let named = source.text_integer(&format!("corner {}", i + 1))?;
                    *corner = u32::try_from(named.saturating_sub(vertices.base))
                        .ok()
                        .filter(|&corner| (corner as usize) < known)
                        .ok_or_else(|| {
                            format!("corner {}: vertex {named} is not one of the {known}", i + 1)
                        })?;
                }
                if source.field().is_some() {
                    return Err(format!("has more than {N} corners"));
                }
                Ok((number, corners))
            };
            match read(&mut self.source) {
                Ok((number, corners)) => {
                    numbers.next(number, position, "element", &mut self.notes);
                    elements.push(Element::new(corners, number, position));
                }
                Err(message) => {
                    self.notes.problem(position, message);
                    // As above: the elements of sets keep their indices.
                    numbers.skip();
                    elements.push(Element::new([0; N], 0, position));
                }
            }
            self.source.skip_line();
        }
        self.compare("elements", declared, numbers.count, count_at);
        self.elements = Some(numbers.numbering());
        Ok(elements)
    }

    /// The number at the start of the next line, and where that is.
    fn count(&mut self, what: &str, each: usize) -> Result<(usize, u64), Stop> {
        let found = self.next_line_of_section();
        let position = self.source.position();
        let count = if found {
            let count = self.source.text_integer(what);
            count.and_then(|count| self.source.fits(what, count, each))
        } else {
            Err(format!("{what} is missing"))
        };
        self.source.skip_line();
        count
            .map(|count| (count, position))
            .map_err(|message| (position, message))
    }

    fn compare(&mut self, what: &str, declared: usize, found: i64, position: u64) {
        if i64::try_from(declared) != Ok(found) {
            let message = format!("{declared} {what} declared, {found} found");
            self.notes.problem(position, message);
        }
    }
}

/// As [`Reader::next_line_of_section`].
fn next_line_of_section(source: &mut Source<'_>) -> bool {
    source.next_record() && !source.rest().starts_with(b"*")
}
