//! Every method, experiment and claim of the paper, row by row: the paper's figure, ours, and what shows it.

mod experiments;
mod limitations;
mod model;
mod queries;
mod updates;

use super::measured::Measured;
use super::shown::Shown::{self, Page};
use experiments::EXPERIMENTS;
use limitations::LIMITATIONS;
use model::MODEL;
use queries::{BOXES, TRAVERSAL};
use updates::UPDATES;

/// How far a row is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Built {
    /// All of it.
    Whole,
    /// What the figure says.
    Part,
    /// Nothing that could be shown.
    Not,
}

/// A row.
pub(super) struct Row {
    /// P01 to P61.
    pub(super) id: &'static str,
    /// What the paper has.
    pub(super) what: &'static str,
    /// Its own figure.
    pub(super) paper: &'static str,
    /// Ours.
    pub(super) ours: fn(&Measured) -> String,
    /// How far it is.
    pub(super) built: Built,
    /// Where to look.
    pub(super) shown: &'static [Shown],
}

/// A row that is shown.
const fn whole(
    id: &'static str,
    what: &'static str,
    paper: &'static str,
    ours: fn(&Measured) -> String,
    shown: &'static [Shown],
) -> Row {
    let built = Built::Whole;
    Row {
        id,
        what,
        paper,
        ours,
        built,
        shown,
    }
}

/// A row of which a part is shown.
const fn part(
    id: &'static str,
    what: &'static str,
    paper: &'static str,
    ours: fn(&Measured) -> String,
    shown: &'static [Shown],
) -> Row {
    Row {
        built: Built::Part,
        ..whole(id, what, paper, ours, shown)
    }
}

/// A row that is not built yet.
const fn not_yet(id: &'static str, what: &'static str, paper: &'static str) -> Row {
    Row {
        built: Built::Not,
        ..whole(id, what, paper, |_| "–".to_string(), &[])
    }
}

/// Text that holds for every run.
macro_rules! says {
    ($text:literal) => {
        |_| $text.to_string()
    };
}
use says;

const BENCHMARKS: Shown = Page("docs/benchmarks.md");
const BOUNDS: Shown = Page("docs/node-bounds.md");
const DECISION: Shown = Page("format-spec/decisions/0011-node-bounds.md");

/// Section by section.
pub(super) const SECTIONS: [(&str, &[Row]); 6] = [
    ("Model and construction", MODEL),
    ("Updates", UPDATES),
    ("Boxes", BOXES),
    ("Traversal and use", TRAVERSAL),
    ("Experiments", EXPERIMENTS),
    ("Limitations and future work", LIMITATIONS),
];
