//! One frequency per field, from a `.npy` or a text file.

use std::f64::consts::TAU;
use std::path::Path;

use crate::error::{BakeError, Problem};
use crate::input::npy;

/// Most problems that are listed one by one.
const PROBLEM_CAP: usize = 100;

/// Angular frequencies in rad/s from the `mode_count` frequencies in Hz in the file at `path`.
///
/// Text: numbers apart by blanks, commas, semicolons or line ends; `#` begins a comment.
pub(super) fn read(path: &Path, mode_count: usize) -> Result<Vec<f64>, BakeError> {
    let place = path.display().to_string();
    let bytes = super::read(path)?;
    let mut problems = Vec::new();
    let hertz = if bytes.starts_with(b"\x93NUMPY") {
        let array = npy::parse(&bytes, "basis", &place)?;
        let locate = |(j, value)| (value, format!("{place}: entry {j}"));
        array.values.into_iter().enumerate().map(locate).collect()
    } else {
        text(&bytes, &place, &mut problems)
    };
    for (value, at) in &hertz {
        if !(value.is_finite() && *value >= 0.0) {
            problems.push(problem(
                at.clone(),
                format!("{value} is not a frequency in Hz (finite, 0 or more)"),
            ));
        }
    }
    if problems.is_empty() && hertz.len() != mode_count {
        let found = hertz.len();
        problems.push(problem(
            place.clone(),
            format!("{found} frequencies for {mode_count} fields"),
        ));
    }
    if problems.len() > PROBLEM_CAP {
        let more = problems.len() - PROBLEM_CAP;
        problems.truncate(PROBLEM_CAP);
        problems.push(problem(place, format!("{more} more problems")));
    }
    if problems.is_empty() {
        Ok(hertz.into_iter().map(|(value, _)| value * TAU).collect())
    } else {
        Err(BakeError { problems })
    }
}

/// The numbers of a text, each with its place.
fn text(bytes: &[u8], place: &str, problems: &mut Vec<Problem>) -> Vec<(f64, String)> {
    let mut hertz = Vec::new();
    let text = String::from_utf8_lossy(bytes);
    for (number, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let words = line.split(|c: char| c.is_whitespace() || c == ',' || c == ';');
        for word in words.filter(|word| !word.is_empty()) {
            let at = format!("{place}:{}", number + 1);
            match word.parse() {
                Ok(value) => hertz.push((value, at)),
                Err(_) => {
                    let shown: String =
                        word.chars().take(32).flat_map(char::escape_debug).collect();
                    problems.push(problem(at, format!("`{shown}` is not a number")));
                }
            }
        }
    }
    hertz
}

fn problem(place: String, message: String) -> Problem {
    Problem {
        stage: "basis",
        place,
        message,
    }
}
