//! One frequency per field, from a `.npy` or a text file.

use std::f64::consts::TAU;
use std::path::Path;

use crate::error::{BakeError, Part, Place, Problems};

/// Angular frequencies in rad/s from the `mode_count` frequencies in Hz in the file at `path`.
///
/// Text: numbers apart by blanks, commas, semicolons or line ends; `#` begins a comment.
pub(super) fn read(path: &Path, mode_count: usize) -> Result<Vec<f64>, BakeError> {
    let file = Place::from(path);
    let bytes = super::read(path)?;
    let mut problems = Problems::new("basis");
    let hertz: Vec<(f64, Part)> = if bytes.starts_with(b"\x93NUMPY") {
        let array = super::array(&bytes, &file)?;
        let locate = |(j, value)| (value, Part::Entry(j));
        array.values.into_iter().enumerate().map(locate).collect()
    } else {
        text(&bytes, &file, &mut problems)
    };
    for (value, at) in &hertz {
        if !(value.is_finite() && *value >= 0.0) {
            let message = || format!("{value} is not a frequency in Hz (finite, 0 or more)");
            problems.add(|| (file.clone().at(at.clone()), message()));
        }
    }
    if problems.is_empty() && hertz.len() != mode_count {
        let message = format!("{} frequencies for {mode_count} fields", hertz.len());
        problems.add(|| (file.clone(), message));
    }
    problems.into_result(file)?;
    Ok(hertz.into_iter().map(|(value, _)| value * TAU).collect())
}

/// The numbers of a text, each with its line.
fn text(bytes: &[u8], file: &Place, problems: &mut Problems) -> Vec<(f64, Part)> {
    let mut hertz = Vec::new();
    let text = String::from_utf8_lossy(bytes);
    for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let line = line.split('#').next().unwrap_or_default();
        let words = line.split(|c: char| c.is_whitespace() || c == ',' || c == ';');
        for word in words.filter(|word| !word.is_empty()) {
            let at = Part::Line(number);
            match word.parse() {
                Ok(value) => hertz.push((value, at)),
                Err(_) => {
                    let shown: String =
                        word.chars().take(32).flat_map(char::escape_debug).collect();
                    let message = format!("`{shown}` is not a number");
                    problems.add(|| (file.clone().at(at), message));
                }
            }
        }
    }
    hertz
}
