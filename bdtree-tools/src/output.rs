//! Where results go: a stream that may close early, files that are whole or absent, numbers that
//! read back equal.

use std::fmt;
use std::fs::{self, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

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

/// Writes a file through a temporary one beside it, renamed when complete: a failed or killed
/// run leaves no half file (a killed one the temporary file, `.bdtree-*.tmp`). Links are followed; a
/// device or a pipe is written to and stays what it is.
///
/// # Errors
/// A path that is a folder, a folder that takes no new file, [`ToolError::Write`].
pub fn write_whole(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), ToolError> {
    let temporary = temporary(path)?;
    let attempt = || {
        let Some((mut file, target)) = temporary else {
            let mut writer = BufWriter::new(OpenOptions::new().write(true).open(path)?);
            content(&mut writer)?;
            return writer.flush();
        };
        let mut writer = BufWriter::new(file.as_file_mut());
        content(&mut writer)?;
        writer.flush()?;
        drop(writer);
        file.as_file().sync_all()?;
        file.persist(&target).map_err(|e| e.error)?;
        Ok(())
    };
    attempt().map_err(|error| write_error(path, &error))
}

/// Whether [`write_whole`] could begin, before a long time is spent on what it is to write.
///
/// # Errors
/// A path that is a folder, a folder that takes no new file.
pub fn check_writable(path: &Path) -> Result<(), ToolError> {
    temporary(path).map(drop)
}

/// A temporary file beside what `path` names, links followed, and that; `None` where it is a device or a pipe,
/// which is written to as it is.
fn temporary(path: &Path) -> Result<Option<(tempfile::NamedTempFile, PathBuf)>, ToolError> {
    let found = fs::metadata(path);
    if found.as_ref().is_ok_and(fs::Metadata::is_dir) {
        return Err(ToolError::input(path.display(), "is a folder: name a file"));
    }
    if found.is_ok_and(|m| !m.is_file()) {
        return Ok(None);
    }
    let target = fs::canonicalize(path).unwrap_or_else(|_| PathBuf::from(path));
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".bdtree-").suffix(".tmp");
    // Those of a file that a program creates, before the user's mask; temporary files have fewer.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    match builder.tempfile_in(folder) {
        Ok(file) => Ok(Some((file, target))),
        Err(error) => {
            let message = no_file_in(&folder_of(path, folder), &error);
            Err(ToolError::input(path.display(), message))
        }
    }
}

/// The folder that is written to, as it was given where that is the same.
fn folder_of(path: &Path, folder: &Path) -> PathBuf {
    let given = match path.parent() {
        Some(given) if !given.as_os_str().is_empty() => given,
        _ => Path::new("."),
    };
    let is_same = fs::canonicalize(given).ok() == fs::canonicalize(folder).ok();
    if is_same { given } else { folder }.to_path_buf()
}

/// Why a folder takes no file, in the words of `bdtree-build`.
fn no_file_in(folder: &Path, error: &io::Error) -> String {
    let name = match folder.display().to_string() {
        name if name == "." => "the current folder".to_string(),
        name => format!("folder {name}"),
    };
    match error.kind() {
        ErrorKind::NotFound => format!("{name} does not exist"),
        ErrorKind::NotADirectory => format!("{} is not a folder", folder.display()),
        ErrorKind::PermissionDenied => format!("{name} does not allow new files"),
        ErrorKind::ReadOnlyFilesystem => format!("{name} is on a read-only file system"),
        _ => format!("cannot create a file in {name}: {}", cause(error)),
    }
}

/// An error without the name of the temporary file, which says nothing to anyone. (`tempfile` puts it behind the
/// system's text, and hides the system's error number.)
fn cause(error: &io::Error) -> String {
    let text = error.to_string();
    match text.split_once(" at path ") {
        Some((cause, _)) => cause.to_string(),
        None => text,
    }
}

fn write_error(path: &Path, error: &io::Error) -> ToolError {
    ToolError::Write {
        path: path.to_path_buf(),
        cause: cause(error),
    }
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
