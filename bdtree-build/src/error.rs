//! What can be wrong with a bake: every problem with its stage and place, not only the first.

use std::borrow::Cow;
use std::fmt;

/// One problem, and where it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// The stage of the bake that found it: `input`, `basis`, `tree`, `encode`, `file`.
    pub stage: &'static str,
    /// Where: `mesh.obj:12`, `U.npy: shape`, `vertex 7`. Empty when the problem has no place.
    pub place: String,
    /// What is wrong and, where it is known, what would be right.
    pub message: String,
}

impl fmt::Display for Problem {
    /// Two parts of one line, whatever a file's names hold: control characters escaped, long text cut.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.place.is_empty() {
            write!(f, "{}", one_line(&self.message))
        } else {
            write!(f, "{}: {}", one_line(&self.place), one_line(&self.message))
        }
    }
}

/// Characters at the start and at the end of long text that are shown.
const SHOWN: (usize, usize) = (320, 80);

/// Text that files have a part in, fit to be shown: control characters, which terminals obey and
/// which end lines, are escaped; of long text the middle is left out.
pub(crate) fn one_line(text: &str) -> Cow<'_, str> {
    let count = text.chars().count();
    let is_long = count > SHOWN.0 + SHOWN.1;
    if !is_long && !text.chars().any(char::is_control) {
        return Cow::Borrowed(text);
    }
    let shown = |(k, c): (usize, char)| match (is_long, k) {
        (true, k) if k == SHOWN.0 => Some('…'.to_string()),
        (true, k) if k > SHOWN.0 && k < count - SHOWN.1 => None,
        _ if c.is_control() => Some(c.escape_default().to_string()),
        _ => Some(c.to_string()),
    };
    Cow::Owned(text.chars().enumerate().filter_map(shown).collect())
}

/// Why a bake failed: one problem or more, in the order they were met.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BakeError {
    /// Never empty.
    pub problems: Vec<Problem>,
}

impl BakeError {
    /// A failure with a single problem.
    pub fn one(stage: &'static str, place: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            problems: vec![Problem {
                stage,
                place: place.into(),
                message: message.into(),
            }],
        }
    }
}

impl fmt::Display for BakeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.problems.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{problem}")?;
        }
        Ok(())
    }
}

impl std::error::Error for BakeError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn problems_are_one_line_whatever_names_hold() {
        let name = format!("red \u{1b}[31m\nsecond line{}", "x".repeat(5000));
        let error = BakeError::one("input", "a\rb.glb", format!("{name} is not read"));
        let text = error.to_string();
        assert!(text.starts_with("a\\rb.glb: red \\u{1b}[31m\\nsecond linexxx"));
        assert!(text.ends_with("xxx is not read"), "{text}");
        assert!(
            !text.chars().any(char::is_control) && text.len() < 500,
            "{text}"
        );
        let plain = "ordinary: a text – as it is";
        assert!(matches!(one_line(plain), Cow::Borrowed(text) if text == plain));
    }
}
