//! What is said about a file: problems up to a cap, warnings, oddities grouped by kind.

use std::fmt::Display;

use crate::error::{BakeError, Part, Place, Problems, one_line};
use crate::input::degenerate::Oddity;
use crate::input::faces::LISTED_MAX;

/// The notes on one file. Places are JSON paths (`meshes[0].primitives[1]`), empty for the file as
/// a whole.
pub(super) struct Notes {
    file: String,
    problems: Problems,
    warnings: Vec<String>,
    oddities: [u64; Oddity::ALL.len()],
    /// Primitives made of points.
    pub(super) points: u64,
    /// Primitives made of lines.
    pub(super) lines: u64,
}

impl Notes {
    /// `file` is the path as given.
    pub(super) fn new(file: String) -> Self {
        Self {
            file,
            problems: Problems::new("input"),
            warnings: Vec::new(),
            oddities: Default::default(),
            points: 0,
            lines: 0,
        }
    }

    pub(super) fn problem(&mut self, at: impl Display, message: impl Into<String>) {
        let place = place(&self.file, at);
        self.problems.add(|| (place, message));
    }

    /// The same, for what can then not be read.
    pub(super) fn refuse<T>(&mut self, at: impl Display, message: impl Into<String>) -> Option<T> {
        self.problem(at, message);
        None
    }

    pub(super) fn warn(&mut self, at: impl Display, message: impl Display) {
        let (place, message) = (place(&self.file, at), message.to_string());
        let message = one_line(&message);
        self.warnings.push(format!("{place}: {message}"));
    }

    /// Notes an odd triangle of the primitive `at`; `triangle` is its id.
    pub(super) fn oddity(&mut self, kind: Oddity, at: impl Display, triangle: usize) {
        let count = &mut self.oddities[kind as usize];
        *count += 1;
        if *count <= LISTED_MAX {
            self.warn(at, format!("triangle {triangle} {}", kind.one()));
        }
    }

    /// Nothing is wrong so far.
    pub(super) fn is_clean(&self) -> bool {
        self.problems.is_empty()
    }

    /// More problems would only be counted.
    pub(super) fn is_full(&self) -> bool {
        self.problems.is_full()
    }

    /// How many primitives were skipped, in words; `None` if there were none.
    pub(super) fn skipped(&self) -> Option<String> {
        let words: Vec<String> = [(self.points, "points"), (self.lines, "lines")]
            .into_iter()
            .filter(|&(count, _)| count > 0)
            .map(|(count, kind)| format!("{count} of {kind}"))
            .collect();
        (!words.is_empty())
            .then(|| format!("primitives that are not triangles: {}", words.join(", ")))
    }

    /// The warnings, if nothing is wrong.
    pub(super) fn into_warnings(mut self) -> Result<Vec<String>, BakeError> {
        if !self.problems.is_empty() {
            return Err(self.into_error());
        }
        for kind in Oddity::ALL {
            let count = self.oddities[kind as usize];
            if count > LISTED_MAX {
                self.warn("", format!("{} more {}", count - LISTED_MAX, kind.many()));
            }
        }
        if let Some(skipped) = self.skipped() {
            self.warn("", format!("ignored {skipped}"));
        }
        Ok(self.warnings)
    }

    /// The problems; something must be wrong.
    pub(super) fn into_error(self) -> BakeError {
        self.problems.into_error(Place::file(self.file))
    }
}

/// A JSON path of a file; empty for the file as a whole.
fn place(file: &str, at: impl Display) -> Place {
    let (file, path) = (Place::file(file), at.to_string());
    if path.is_empty() {
        file
    } else {
        file.at(Part::JsonPath(path))
    }
}
