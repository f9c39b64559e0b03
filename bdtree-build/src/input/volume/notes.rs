//! What is said about a volume file: problems in file order up to a cap, and warnings.

use crate::error::{BakeError, Part, Place, Problem, one_line};

/// Most problems that are listed one by one.
const PROBLEM_CAP: usize = 100;

/// The notes on one file.
pub(super) struct Notes<'a> {
    file: &'a str,
    /// Positions are bytes, not lines.
    pub(super) is_binary: bool,
    problems: Vec<(u64, String)>,
    problem_count: u64,
    warnings: Vec<String>,
}

/// Something odd that may happen often: how often, and where first.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally {
    pub(super) count: u64,
    pub(super) first: u64,
}

impl Tally {
    /// Once more, at `position`.
    pub(super) fn add(&mut self, position: u64) {
        if self.count == 0 {
            self.first = position;
        }
        self.count += 1;
    }
}

impl<'a> Notes<'a> {
    pub(super) fn new(file: &'a str) -> Self {
        Self {
            file,
            is_binary: false,
            problems: Vec::new(),
            problem_count: 0,
            warnings: Vec::new(),
        }
    }

    /// A problem at a line or byte; 0 stands for the file as a whole.
    pub(super) fn problem(&mut self, position: u64, message: String) {
        self.problem_count += 1;
        if self.problems.len() < PROBLEM_CAP {
            self.problems.push((position, message));
        }
    }

    /// Something is wrong already.
    pub(super) fn has_problems(&self) -> bool {
        self.problem_count > 0
    }

    /// Something odd at a line or byte; 0 stands for the file as a whole.
    pub(super) fn warn(&mut self, position: u64, message: &str) {
        let (place, message) = (self.place(position), one_line(message));
        self.warnings.push(format!("{place}: {message}"));
    }

    /// A warning that names the number and the first place, if there was any.
    pub(super) fn warn_tally(&mut self, tally: &Tally, message: &str) {
        if tally.count > 0 {
            self.warn(tally.first, &format!("{} {message}", tally.count));
        }
    }

    fn place(&self, position: u64) -> Place {
        let file = Place::file(self.file);
        match (position, self.is_binary) {
            (0, _) => file,
            (line, false) => file.at(Part::Line(line)),
            (byte, true) => file.at(Part::Byte(byte)),
        }
    }

    /// The warnings, if nothing is wrong.
    pub(super) fn into_warnings(mut self) -> Result<Vec<String>, BakeError> {
        if !self.has_problems() {
            return Ok(self.warnings);
        }
        // Stable: problems of one place stay in the order they were met.
        self.problems.sort_by_key(|&(position, _)| position);
        let more = self.problem_count - self.problems.len() as u64;
        let mut problems: Vec<Problem> = self
            .problems
            .iter()
            .map(|(position, message)| Problem {
                stage: "input",
                place: self.place(*position),
                message: message.clone(),
            })
            .collect();
        if more > 0 {
            problems.push(Problem {
                stage: "input",
                place: self.place(0),
                message: format!("{more} more problems"),
            });
        }
        Err(BakeError { problems })
    }
}
