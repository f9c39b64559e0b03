//! Lists of vertices or nodes in a file, numbered from 1: Vega FEM's `.bou` and its like.

use std::path::Path;

use crate::error::{BakeError, Part, Place, Problems};
use crate::input::read_file::read_file;

/// Indices from 0, ascending, each once, of the numbers in a file: separated by commas or white
/// space, what follows `#` is ignored.
///
/// # Errors
/// A file that cannot be read, what is not a number from 1 to `count` (with its line), no number
/// at all. `what` names the things that are numbered.
pub(crate) fn read_list(path: &Path, count: usize, what: &str) -> Result<Vec<u32>, BakeError> {
    let text = read_file(path)
        .map_err(|e| BakeError::one("basis", path, format!("cannot be read: {e}")))?;
    let mut list = Vec::new();
    let mut problems = Problems::new("basis");
    for (line, bytes) in (1..).zip(text.split(|&b| b == b'\n')) {
        let bytes = bytes.split(|&b| b == b'#').next().unwrap_or_default();
        let words = bytes.split(|b| b.is_ascii_whitespace() || *b == b',');
        for word in words.filter(|w| !w.is_empty()) {
            let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
            match number {
                Some(n) if (1..=count as u64).contains(&n) => list.push((n - 1) as u32),
                _ => {
                    let place = || Place::from(path).at(Part::Line(line));
                    let word = shown(word);
                    let message =
                        || format!("`{word}` is not the number of a {what}, from 1 to {count}");
                    problems.add(|| (place(), message()));
                }
            }
        }
    }
    problems.into_result(path)?;
    if list.is_empty() {
        let message = format!("names no {what}");
        return Err(BakeError::one("basis", path, message));
    }
    list.sort_unstable();
    list.dedup();
    Ok(list)
}

/// The beginning of a word, as text.
fn shown(word: &[u8]) -> String {
    String::from_utf8_lossy(&word[..word.len().min(40)]).into_owned()
}
