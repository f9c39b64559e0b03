//! Where results go: a stream that may close early, files that do not take the input's place, numbers that read back
//! equal.

use std::fmt;
use std::io::{self, ErrorKind, Write};
use std::path::Path;

use serde::Serialize;

use crate::error::ToolError;

/// A stream whose reader may leave: from then on everything is swallowed, so that commands still
/// finish with their exit code.
pub(crate) struct QuietPipe<'w> {
    stream: &'w mut dyn Write,
    closed: bool,
}

impl<'w> QuietPipe<'w> {
    pub(crate) fn new(stream: &'w mut dyn Write) -> Self {
        Self {
            stream,
            closed: false,
        }
    }

    fn unless_closed<T>(&mut self, result: io::Result<T>, swallowed: T) -> io::Result<T> {
        match result {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => {
                self.closed = true;
                Ok(swallowed)
            }
            other => other,
        }
    }
}

impl Write for QuietPipe<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.closed {
            return Ok(bytes.len());
        }
        let result = self.stream.write(bytes);
        self.unless_closed(result, bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.closed {
            return Ok(());
        }
        let result = self.stream.flush();
        self.unless_closed(result, ())
    }
}

/// One JSON value on a line of its own.
pub(crate) fn write_json(out: &mut dyn Write, value: &impl Serialize) -> Result<(), ToolError> {
    serde_json::to_writer(&mut *out, value).map_err(|e| ToolError::Stdout(e.into()))?;
    writeln!(out).map_err(ToolError::Stdout)
}

/// Checks that a file may be written there: its extension is one of `known`, which people are told as `told`, and
/// it is not the input.
///
/// # Errors
/// What is wrong.
pub fn check_target(
    path: &Path,
    input: &Path,
    known: &[&str],
    told: &str,
) -> Result<(), ToolError> {
    let extension = path.extension().unwrap_or_default();
    if !known.iter().any(|e| extension.eq_ignore_ascii_case(e)) {
        let message = format!("unknown extension: {told} can be written");
        return Err(ToolError::Usage(format!("{}: {message}", path.display())));
    }
    let both = (path.canonicalize(), input.canonicalize());
    if matches!(both, (Ok(to), Ok(from)) if to == from) {
        let message = "is the input: it would be overwritten";
        return Err(ToolError::input(path.display(), message));
    }
    Ok(())
}

/// Characters at the start and at the end of long text that are shown.
const SHOWN: (usize, usize) = (320, 80);

/// Text that files have a part in, fit to be shown: control characters, which terminals obey and
/// which end lines, are escaped; of long text the middle is left out.
pub(crate) fn one_line(text: &str) -> String {
    let count = text.chars().count();
    let is_long = count > SHOWN.0 + SHOWN.1;
    let shown = |(k, c): (usize, char)| match (is_long, k) {
        (true, k) if k == SHOWN.0 => Some('…'.to_string()),
        (true, k) if k > SHOWN.0 && k < count - SHOWN.1 => None,
        _ if c.is_control() => Some(c.escape_default().to_string()),
        _ => Some(c.to_string()),
    };
    text.chars().enumerate().filter_map(shown).collect()
}

/// A number as the shortest text that reads back equal, with an exponent where digits would only
/// be zeros.
pub(crate) struct Shortest(pub(crate) f64);

impl fmt::Display for Shortest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let magnitude = self.0.abs();
        if magnitude == 0.0 || (1e-5..1e16).contains(&magnitude) || !magnitude.is_finite() {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

/// At most six significant digits, for people.
pub(crate) fn digits(x: f64) -> String {
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    Shortest(rounded).to_string()
}

/// A title, and below it rows of cells with aligned columns: the first row is the heading (commas between
/// its cells), the first column is text and the others numbers.
pub(crate) fn table(title: &str, heading: &str, rows: impl Iterator<Item = Vec<String>>) -> String {
    let heading: Vec<String> = heading.split(',').map(str::to_string).collect();
    let columns = heading.len();
    let rows: Vec<Vec<String>> = std::iter::once(heading).chain(rows).collect();
    let width = |c: usize| {
        rows.iter()
            .map(|row| row[c].chars().count())
            .max()
            .unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate();
        let cells = cells.map(|(c, (cell, width))| match c {
            0 => format!("{cell:<width$}"),
            _ => format!("{cell:>width$}"),
        });
        format!("  {}\n", cells.collect::<Vec<_>>().join("  ").trim_end())
    };
    format!("{title}\n{}", rows.iter().map(line).collect::<String>())
}

/// Text for a terminal: control characters of names in files are replaced.
pub fn printable(text: &str) -> String {
    text.replace(char::is_control, "\u{fffd}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_equal() {
        for x in [
            0.0,
            -0.0,
            0.1,
            -1.5,
            1e-5,
            9.9e-6,
            1e16,
            1e300,
            f64::MIN_POSITIVE,
            1.0 / 3.0,
        ] {
            let text = Shortest(x).to_string();
            let back: f64 = text.parse().unwrap();
            assert_eq!(back.to_bits(), x.to_bits(), "{text}");
            assert!(text.len() <= 24, "{text}");
        }
    }

    struct Closed;

    impl Write for Closed {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(ErrorKind::BrokenPipe.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Err(ErrorKind::BrokenPipe.into())
        }
    }

    #[test]
    fn a_closed_pipe_is_quiet() {
        let mut closed = Closed;
        let mut pipe = QuietPipe::new(&mut closed);
        pipe.write_all(b"x").unwrap();
        pipe.write_all(b"y").unwrap();
        pipe.flush().unwrap();
    }
}
