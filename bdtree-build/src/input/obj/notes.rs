//! What is said about a file: problems in line order up to a cap, oddities grouped by kind.

use std::collections::BTreeMap;

use super::tokens;
use crate::error::{BakeError, Part, Place, Problems};
use crate::input::degenerate::Oddity;
use crate::input::faces::{LISTED_MAX, skipped_in_all};

/// Most different unknown keywords that are listed.
const KEYWORD_CAP: usize = 16;

/// The notes on one file.
pub(super) struct Notes<'a> {
    place: &'a str,
    problems: Problems,
    oddities: [u64; Oddity::ALL.len()],
    skipped_faces: u64,
    /// Odd and skipped faces, each with its line.
    listed: Vec<(u64, String)>,
    keywords: BTreeMap<String, u64>,
    other_keywords: u64,
    /// `p` statements.
    pub(super) points: u64,
    /// `l` statements.
    pub(super) lines: u64,
    /// `curv`, `curv2` and `surf` statements.
    pub(super) curves: u64,
}

impl<'a> Notes<'a> {
    pub(super) fn new(place: &'a str) -> Self {
        Self {
            place,
            problems: Problems::new("input"),
            oddities: Default::default(),
            skipped_faces: 0,
            listed: Vec::new(),
            keywords: BTreeMap::new(),
            other_keywords: 0,
            points: 0,
            lines: 0,
            curves: 0,
        }
    }

    /// A problem on `line`; line 0 stands for the file as a whole.
    pub(super) fn problem(&mut self, line: u64, message: String) {
        let file = Place::file(self.place);
        let place = match line {
            0 => file,
            _ => file.at(Part::Line(line)),
        };
        self.problems.add(|| (place, message));
    }

    pub(super) fn oddity(&mut self, kind: Oddity, line: u64, triangle: usize) {
        let count = &mut self.oddities[kind as usize];
        *count += 1;
        if *count <= LISTED_MAX {
            let text = format!("{}:{line}: triangle {triangle} {}", self.place, kind.one());
            self.listed.push((line, text));
        }
    }

    /// A face that is left out.
    pub(super) fn skipped_face(&mut self, line: u64, message: &str) {
        self.skipped_faces += 1;
        if self.skipped_faces <= LISTED_MAX {
            let text = format!("{}:{line}: skipped: {message}", self.place);
            self.listed.push((line, text));
        }
    }

    /// A statement that no OBJ specification knows, or none that matters here.
    pub(super) fn unknown(&mut self, keyword: &[u8]) {
        let keyword = tokens::show(keyword);
        if let Some(count) = self.keywords.get_mut(&keyword) {
            *count += 1;
        } else if self.keywords.len() < KEYWORD_CAP {
            self.keywords.insert(keyword, 1);
        } else {
            self.other_keywords += 1;
        }
    }

    /// How many points, lines and curves were skipped, in words; `None` if there were none.
    pub(super) fn skipped(&self) -> Option<String> {
        let kinds = [
            (self.points, "point"),
            (self.lines, "line"),
            (self.curves, "curve or surface"),
        ];
        let words: Vec<String> = kinds
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, kind)| format!("{count} {kind}"))
            .collect();
        (!words.is_empty()).then(|| format!("{} statements", words.join(", ")))
    }

    /// Whether all of `count` faces were skipped.
    pub(super) fn has_skipped_all(&self, count: u64) -> bool {
        self.skipped_faces == count
    }

    /// The warnings, if nothing is wrong.
    pub(super) fn into_warnings(mut self) -> Result<Vec<String>, BakeError> {
        let (file, skipped) = (Place::file(self.place), self.skipped());
        self.problems.sorted().into_result(file)?;
        // Faces that refer ahead are only looked at in the end.
        self.listed.sort_by_key(|(line, _)| *line);
        let mut warnings: Vec<String> = self.listed.into_iter().map(|(_, text)| text).collect();
        for kind in Oddity::ALL {
            let more = self.oddities[kind as usize].saturating_sub(LISTED_MAX);
            if more > 0 {
                let place = self.place;
                warnings.push(format!("{place}: {more} more {}", kind.many()));
            }
        }
        warnings.extend(skipped_in_all(self.place, self.skipped_faces));
        if let Some(skipped) = skipped {
            warnings.push(format!("{}: ignored {skipped}", self.place));
        }
        if !self.keywords.is_empty() {
            let mut words: Vec<String> = self
                .keywords
                .iter()
                .map(|(keyword, count)| format!("{count} × `{keyword}`"))
                .collect();
            if self.other_keywords > 0 {
                words.push(format!("{} others", self.other_keywords));
            }
            let place = self.place;
            let words = words.join(", ");
            warnings.push(format!("{place}: ignored unknown statements: {words}"));
        }
        Ok(warnings)
    }
}
