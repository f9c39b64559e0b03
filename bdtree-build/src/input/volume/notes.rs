//! What is said about a volume file: problems in file order up to a cap, and warnings.

use crate::error::{BakeError, Part, Place, Problems, one_line};

/// The notes on one file.
pub(super) struct Notes<'a> {
    file: &'a str,
    /// Positions are bytes, not lines.
    pub(super) is_binary: bool,
    problems: Problems,
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
            problems: Problems::new("input"),
            warnings: Vec::new(),
        }
    }

    /// A problem at a line or byte; 0 stands for the file as a whole.
    pub(super) fn problem(&mut self, position: u64, message: String) {
        let place = self.place(position);
        self.problems.add(|| (place, message));
    }

    /// Something is wrong already.
    pub(super) fn has_problems(&self) -> bool {
        !self.problems.is_empty()
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
    pub(super) fn into_warnings(self) -> Result<Vec<String>, BakeError> {
        let file = Place::file(self.file);
        self.problems.sorted().into_result(file)?;
        Ok(self.warnings)
    }
}
