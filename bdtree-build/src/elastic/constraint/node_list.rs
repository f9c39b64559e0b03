//! Lists of vertices or nodes in a file, numbered from 1: Vega FEM's `.bou` and its like.

use std::path::Path;

use crate::error::{BakeError, Problem};

/// Problems listed at most.
const PROBLEMS_MAX: usize = 100;

/// Indices from 0, ascending, each once, of the numbers in a file: separated by commas or white
/// space, what follows `#` is ignored.
///
/// # Errors
/// A file that cannot be read, what is not a number from 1 to `count` (with its line), no number
/// at all. `what` names the things that are numbered.
pub(crate) fn read_list(path: &Path, count: usize, what: &str) -> Result<Vec<u32>, BakeError> {
    let name = path.display();
    let text = crate::input::whole::read(path).map_err(|e| {
        let message = format!("cannot be read: {e}");
        BakeError::one("basis", name.to_string(), message)
    })?;
    let mut list = Vec::new();
    let (mut problems, mut more) = (Vec::new(), 0usize);
    for (line, bytes) in text.split(|&b| b == b'\n').enumerate() {
        let bytes = bytes.split(|&b| b == b'#').next().unwrap_or_default();
        let words = bytes.split(|b| b.is_ascii_whitespace() || *b == b',');
        for word in words.filter(|w| !w.is_empty()) {
            let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
            match number {
                Some(n) if (1..=count as u64).contains(&n) => list.push((n - 1) as u32),
                _ if problems.len() < PROBLEMS_MAX => problems.push(Problem {
                    stage: "basis",
                    place: format!("{name}:{}", line + 1),
                    message: format!(
                        "`{}` is not the number of a {what}, from 1 to {count}",
                        shown(word)
                    ),
                }),
                _ => more += 1,
            }
        }
    }
    if more > 0 {
        problems.push(Problem {
            stage: "basis",
            place: name.to_string(),
            message: format!("{more} more problems"),
        });
    }
    if !problems.is_empty() {
        return Err(BakeError { problems });
    }
    if list.is_empty() {
        let message = format!("names no {what}");
        return Err(BakeError::one("basis", name.to_string(), message));
    }
    list.sort_unstable();
    list.dedup();
    Ok(list)
}

/// The beginning of a word, as text.
fn shown(word: &[u8]) -> String {
    String::from_utf8_lossy(&word[..word.len().min(40)]).into_owned()
}
