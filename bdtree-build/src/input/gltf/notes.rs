//! What is said about a file: problems up to a cap, warnings, oddities grouped by kind.

use std::fmt::Display;

use crate::error::{BakeError, Problem, one_line};

/// Most problems that are listed one by one.
const PROBLEM_CAP: usize = 100;
/// Most odd triangles of one kind that are listed one by one.
const ODDITY_CAP: u64 = 5;

/// Something odd about a triangle that is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Oddity {
    RepeatedCorner,
    ZeroArea,
}

impl Oddity {
    fn one(self) -> &'static str {
        match self {
            Oddity::RepeatedCorner => "repeats a corner",
            Oddity::ZeroArea => "has zero area",
        }
    }

    fn many(self) -> &'static str {
        match self {
            Oddity::RepeatedCorner => "triangles that repeat a corner",
            Oddity::ZeroArea => "triangles with zero area",
        }
    }
}

/// The notes on one file. Places are JSON paths (`meshes[0].primitives[1]`), empty for the file as
/// a whole.
pub(super) struct Notes {
    file: String,
    problems: Vec<Problem>,
    problem_count: u64,
    warnings: Vec<String>,
    oddities: [u64; 2],
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
            problems: Vec::new(),
            problem_count: 0,
            warnings: Vec::new(),
            oddities: [0; 2],
            points: 0,
            lines: 0,
        }
    }

    pub(super) fn problem(&mut self, at: impl Display, message: impl Into<String>) {
        self.problem_count += 1;
        if self.problems.len() < PROBLEM_CAP {
            let place = self.place(at);
            self.problems.push(Problem {
                stage: "input",
                place,
                message: message.into(),
            });
        }
    }

    pub(super) fn warn(&mut self, at: impl Display, message: impl Display) {
        let (place, message) = (self.place(at), message.to_string());
        let message = one_line(&message);
        self.warnings.push(format!("{place}: {message}"));
    }

    /// Notes an odd triangle of the primitive `at`; `triangle` is its id.
    pub(super) fn oddity(&mut self, kind: Oddity, at: impl Display, triangle: usize) {
        let count = &mut self.oddities[kind as usize];
        *count += 1;
        if *count <= ODDITY_CAP {
            self.warn(at, format!("triangle {triangle} {}", kind.one()));
        }
    }

    /// Nothing is wrong so far.
    pub(super) fn is_clean(&self) -> bool {
        self.problem_count == 0
    }

    /// More problems would only be counted.
    pub(super) fn is_full(&self) -> bool {
        self.problems.len() >= PROBLEM_CAP
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
        if self.problem_count > 0 {
            return Err(self.into_error());
        }
        for kind in [Oddity::RepeatedCorner, Oddity::ZeroArea] {
            let count = self.oddities[kind as usize];
            if count > ODDITY_CAP {
                self.warn("", format!("{} more {}", count - ODDITY_CAP, kind.many()));
            }
        }
        if let Some(skipped) = self.skipped() {
            self.warn("", format!("ignored {skipped}"));
        }
        Ok(self.warnings)
    }

    /// The problems; something must be wrong.
    pub(super) fn into_error(mut self) -> BakeError {
        let more = self.problem_count - self.problems.len() as u64;
        if more > 0 {
            self.problems.push(Problem {
                stage: "input",
                place: self.file,
                message: format!("{more} more problems"),
            });
        }
        BakeError {
            problems: self.problems,
        }
    }

    fn place(&self, at: impl Display) -> String {
        let (file, at) = (&self.file, at.to_string());
        if at.is_empty() {
            file.clone()
        } else {
            format!("{file}: {at}")
        }
    }
}
