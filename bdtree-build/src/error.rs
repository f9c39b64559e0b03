//! What can be wrong with a bake: every problem with its stage and place, not only the first.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt;
use std::path::Path;

use bdtree_output::OutputError;

/// Where a problem is: a file and a place in it, or a part of the mesh and its fields.
///
/// Stages that do not know which file their mesh came from leave [`Place::file`] out; [`crate::bake`] adds it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Place {
    /// The file as it was named, or its name alone where a stage knows no more.
    pub file: Option<String>,
    /// From the outer part to the inner one: a mode, then a vertex. Empty for the file as a whole.
    pub parts: Vec<Part>,
}

/// One step of a [`Place`]. Numbers count from 0 unless said otherwise.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Part {
    /// A line of a text, from 1.
    Line(u64),
    /// A byte of a binary file.
    Byte(u64),
    /// A value of a JSON document: `meshes[0].primitives[1]`.
    JsonPath(String),
    /// A number of an array.
    Entry(usize),
    /// A vertex of the mesh.
    Vertex(usize),
    /// x, y or z.
    Axis(usize),
    /// A triangle of the mesh.
    Triangle(usize),
    /// A face of the file, which becomes one triangle or more.
    Face(usize),
    /// A group of the mesh.
    Group(String),
    /// A field of the basis.
    Mode(usize),
    /// A frame of an animation.
    Frame(usize),
    /// A frame that is a file of its own.
    FrameFile(String),
    /// A node of a volume mesh; shown from 1, as files count them.
    Node(u32),
    /// An element of a volume mesh; shown from 1.
    Element(usize),
    /// The connected part of a volume mesh that this node belongs to; shown from 1.
    Body(u32),
    /// A material of a volume mesh, by name or number.
    Material(String),
    /// An option by its name on the command line, and what it was given where several may be.
    Option(&'static str, Option<String>),
    /// What there is only one of: the shape of an array, the leaf size.
    The(&'static str),
}

impl Place {
    /// No place in particular.
    pub const NOWHERE: Self = Self {
        file: None,
        parts: Vec::new(),
    };

    /// A file as a whole; without a name: nowhere.
    pub fn file(name: impl Into<String>) -> Self {
        let name = name.into();
        Self {
            file: (!name.is_empty()).then_some(name),
            parts: Vec::new(),
        }
    }

    /// An option by its name on the command line.
    pub fn option(name: &'static str) -> Self {
        Part::Option(name, None).into()
    }

    /// A part of this place.
    #[must_use]
    pub fn at(mut self, part: Part) -> Self {
        self.parts.push(part);
        self
    }

    /// The place in the file: `line 12`, `mode 1, vertex 3`.
    fn inside(&self) -> String {
        let part = |part: &Part| match part {
            Part::Line(line) => format!("line {line}"),
            other => other.to_string(),
        };
        let parts: Vec<String> = self.parts.iter().map(part).collect();
        parts.join(", ")
    }

    /// Whether it is a part of the mesh, its fields or its frames, in no file in particular.
    fn is_in_mesh(&self) -> bool {
        let first = self.parts.first();
        self.file.is_none()
            && matches!(
                first,
                Some(Part::Vertex(_) | Part::Triangle(_) | Part::Mode(_) | Part::Frame(_))
            )
    }
}

impl From<Part> for Place {
    fn from(part: Part) -> Self {
        Self::NOWHERE.at(part)
    }
}

impl From<&Path> for Place {
    fn from(path: &Path) -> Self {
        Self::file(path.display().to_string())
    }
}

impl fmt::Display for Place {
    /// `mesh.obj:12`, `U.npy: mode 1, vertex 3, x`, `--fix legs`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.file.as_deref().unwrap_or_default())?;
        for (i, part) in self.parts.iter().enumerate() {
            f.write_str(match (i, &self.file, part) {
                (0, None, _) => "",
                (0, Some(_), Part::Line(_)) => ":",
                (0, Some(_), _) => ": ",
                _ => ", ",
            })?;
            write!(f, "{part}")?;
        }
        Ok(())
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "{line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
            Self::JsonPath(text) | Self::FrameFile(text) => f.write_str(text),
            Self::Entry(entry) => write!(f, "entry {entry}"),
            Self::Vertex(vertex) => write!(f, "vertex {vertex}"),
            Self::Axis(axis) => f.write_str(["x", "y", "z"].get(*axis).unwrap_or(&"?")),
            Self::Triangle(triangle) => write!(f, "triangle {triangle}"),
            Self::Face(face) => write!(f, "face {face}"),
            Self::Group(name) => write!(f, "group {name:?}"),
            Self::Mode(mode) => write!(f, "mode {mode}"),
            Self::Frame(frame) => write!(f, "frame {frame}"),
            Self::Node(node) => write!(f, "node {}", u64::from(*node) + 1),
            Self::Element(element) => write!(f, "element {}", element + 1),
            Self::Body(node) => write!(f, "the part of node {}", u64::from(*node) + 1),
            Self::Material(name) => write!(f, "material {name}"),
            Self::Option(name, None) => f.write_str(name),
            Self::Option(name, Some(value)) => write!(f, "{name} {value}"),
            Self::The(what) => f.write_str(what),
        }
    }
}

/// One problem, and where it is.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Problem {
    /// The stage of the bake that found it: `input`, `basis`, `tree`, `encode`, `file`.
    pub stage: &'static str,
    /// Where.
    pub place: Place,
    /// What is wrong and, where it is known, what would be right.
    pub message: String,
}

impl Problem {
    fn new(stage: &'static str, place: impl Into<Place>, message: impl Into<String>) -> Self {
        let (place, message) = (place.into(), message.into());
        Self {
            stage,
            place,
            message,
        }
    }
}

impl fmt::Display for Problem {
    /// Two parts of one line, whatever a file's names hold: control characters escaped, long text cut.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = self.place.to_string();
        if place.is_empty() {
            write!(f, "{}", one_line(&self.message))
        } else if self.message.starts_with("is a folder") {
            // A sentence: `. is a folder: name a file`, not `.: is …`.
            write!(f, "{} {}", one_line(&place), one_line(&self.message))
        } else {
            write!(f, "{}: {}", one_line(&place), one_line(&self.message))
        }
    }
}

/// Characters at the start and at the end of long text that are shown.
const SHOWN: (usize, usize) = (320, 80);

/// Text that files have a part in, fit to be shown: control characters, which terminals obey and
/// which end lines, are escaped; of long text the middle is left out.
pub(crate) fn one_line(text: &str) -> Cow<'_, str> {
    let count = text.chars().count();
    let is_long = count > SHOWN.0 + SHOWN.1;
    if !is_long && !text.chars().any(char::is_control) {
        return Cow::Borrowed(text);
    }
    let shown = |(k, c): (usize, char)| match (is_long, k) {
        (true, k) if k == SHOWN.0 => Some('…'.to_string()),
        (true, k) if k > SHOWN.0 && k < count - SHOWN.1 => None,
        _ if c.is_control() => Some(c.escape_default().to_string()),
        _ => Some(c.to_string()),
    };
    Cow::Owned(text.chars().enumerate().filter_map(shown).collect())
}

/// Why a bake failed: one problem or more, in the order they were met.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct BakeError {
    /// Never empty.
    pub problems: Vec<Problem>,
}

impl From<OutputError> for BakeError {
    fn from(error: OutputError) -> Self {
        Self::one("file", error.path.as_path(), error.reason)
    }
}

impl BakeError {
    /// A failure with a single problem.
    pub fn one(stage: &'static str, place: impl Into<Place>, message: impl Into<String>) -> Self {
        let problems = vec![Problem::new(stage, place, message)];
        Self { problems }
    }

    /// The same, with the mesh's file as it is given here where a place is one in the mesh, or in this file by its name
    /// alone.
    #[must_use]
    pub fn in_file(mut self, file: &Path) -> Self {
        let name = file.file_name().map(|name| name.to_string_lossy());
        for problem in &mut self.problems {
            let place = &problem.place;
            let is_named = place.file.is_some() && place.file.as_deref() == name.as_deref();
            if is_named || place.is_in_mesh() {
                problem.place.file = Some(file.display().to_string());
            }
        }
        self
    }

    /// The problems of an earlier failure, if there was one, and then these.
    pub(crate) fn after(self, earlier: Result<(), BakeError>) -> Self {
        let mut problems = earlier.map_or_else(|error| error.problems, |()| Vec::new());
        problems.extend(self.problems);
        Self { problems }
    }
}

/// Problems in the order they are met, the first hundred in full and the others counted.
#[derive(Debug)]
pub(crate) struct Problems {
    stage: &'static str,
    listed_max: usize,
    more: fn(usize) -> String,
    listed: Vec<Problem>,
    count: usize,
}

impl Problems {
    /// None yet; a hundred will be listed.
    pub(crate) fn new(stage: &'static str) -> Self {
        Self::listing(100, stage, |more| format!("{more} more problems"))
    }

    /// None yet; at most `listed_max` will be listed, and `more` tells of the others.
    pub(crate) fn listing(
        listed_max: usize,
        stage: &'static str,
        more: fn(usize) -> String,
    ) -> Self {
        Self {
            stage,
            listed_max,
            more,
            listed: Vec::new(),
            count: 0,
        }
    }

    /// One more; what it says is asked for only if it is listed.
    pub(crate) fn add<P: Into<Place>, M: Into<String>>(&mut self, say: impl FnOnce() -> (P, M)) {
        self.count += 1;
        if !self.is_full() {
            let (place, message) = say();
            self.listed.push(Problem::new(self.stage, place, message));
        }
    }

    /// All problems of another failure.
    pub(crate) fn join(&mut self, error: BakeError) {
        for problem in error.problems {
            self.add(|| (problem.place, problem.message));
        }
    }

    /// The same in the order of their lines or bytes; those of a file as a whole come first, those of one place stay
    /// in the order they were met.
    pub(crate) fn sorted(mut self) -> Self {
        self.listed
            .sort_by_key(|problem| match problem.place.parts.last() {
                Some(Part::Line(position) | Part::Byte(position)) => *position,
                _ => 0,
            });
        self
    }

    /// Nothing is wrong so far.
    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// More problems would only be counted.
    pub(crate) fn is_full(&self) -> bool {
        self.listed.len() >= self.listed_max
    }

    /// A failure if there are problems; `place` is where those that are only counted lie.
    pub(crate) fn into_result(self, place: impl Into<Place>) -> Result<(), BakeError> {
        if self.is_empty() {
            Ok(())
        } else {
            Err(self.into_error(place))
        }
    }

    /// The failure; something must be wrong.
    pub(crate) fn into_error(mut self, place: impl Into<Place>) -> BakeError {
        let more = self.count - self.listed.len();
        if more > 0 {
            let message = (self.more)(more);
            self.listed.push(Problem::new(self.stage, place, message));
        }
        BakeError {
            problems: grouped(self.listed),
        }
    }
}

/// Problems of one kind that are listed one by one; of more, the first stands for all.
const SIMILAR_MAX: usize = 10;

/// Places that are named where one problem stands for many.
const SIMILAR_SHOWN: usize = 10;

/// Problems that differ in their place and in numbers and quotes alone, as one with the other places behind it: a
/// hundred lines that say the same hide the one that does not.
fn grouped(problems: Vec<Problem>) -> Vec<Problem> {
    let key = |problem: &Problem| (problem.place.file.clone(), pattern(&problem.message));
    let mut groups: HashMap<_, Vec<usize>> = HashMap::new();
    for (i, problem) in problems.iter().enumerate() {
        groups.entry(key(problem)).or_default().push(i);
    }
    let is_large = |group: &Vec<usize>| {
        let has_place = |&i: &usize| !problems[i].place.parts.is_empty();
        group.len() > SIMILAR_MAX && group.iter().all(has_place)
    };
    // What becomes of the problems of large groups: the first says where the others are.
    let mut told: HashMap<usize, Option<String>> = HashMap::new();
    for group in groups.values().filter(|group| is_large(group)) {
        let (first, others) = (group[0], &group[1..]);
        let shown = others.iter().take(SIMILAR_SHOWN);
        let mut places: Vec<String> = shown.map(|&i| problems[i].place.inside()).collect();
        if places.len() < others.len() {
            places.push("…".to_string());
        }
        let (count, places) = (others.len(), places.join("; "));
        told.insert(
            first,
            Some(format!(" (and {count} problems like it, at {places})")),
        );
        told.extend(others.iter().map(|&i| (i, None)));
    }
    let problems = problems.into_iter().enumerate();
    let tell = |(i, mut problem): (usize, Problem)| match told.get(&i) {
        None => Some(problem),
        Some(None) => None,
        Some(Some(others)) => {
            problem.message += others;
            Some(problem)
        }
    };
    problems.filter_map(tell).collect()
}

/// A message without its numbers and quotes.
fn pattern(message: &str) -> String {
    let unquoted = message.split('`').step_by(2);
    let is_kept = |c: &char| !c.is_ascii_digit();
    unquoted.flat_map(str::chars).filter(is_kept).collect()
}

impl fmt::Display for BakeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.problems.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{problem}")?;
        }
        Ok(())
    }
}

impl std::error::Error for BakeError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn problems_of_one_kind_are_told_once() {
        let mut problems = Problems::new("input");
        let at = |line| Place::file("a.obj").at(Part::Line(line));
        for line in 5..20 {
            problems.add(|| {
                (
                    at(line),
                    format!("corner 1 `{line}x`: is not a vertex index"),
                )
            });
        }
        problems.add(|| (at(30), "a face needs 3 corners or more, found 2"));
        problems.add(|| (at(31), "a face needs 3 corners or more, found 1"));
        let text = problems.into_error(Place::file("a.obj")).to_string();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines,
            [
                "a.obj:5: corner 1 `5x`: is not a vertex index (and 14 problems like it, at line 6; line 7; line 8; \
                 line 9; line 10; line 11; line 12; line 13; line 14; line 15; …)",
                "a.obj:30: a face needs 3 corners or more, found 2",
                "a.obj:31: a face needs 3 corners or more, found 1",
            ]
        );
    }

    #[test]
    fn problems_are_one_line_whatever_names_hold() {
        let name = format!("red \u{1b}[31m\nsecond line{}", "x".repeat(5000));
        let error = BakeError::one(
            "input",
            Place::file("a\rb.glb"),
            format!("{name} is not read"),
        );
        let text = error.to_string();
        assert!(text.starts_with("a\\rb.glb: red \\u{1b}[31m\\nsecond linexxx"));
        assert!(text.ends_with("xxx is not read"), "{text}");
        assert!(
            !text.chars().any(char::is_control) && text.len() < 500,
            "{text}"
        );
        let plain = "ordinary: a text – as it is";
        assert!(matches!(one_line(plain), Cow::Borrowed(text) if text == plain));
    }
}
