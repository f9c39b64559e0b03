//! Output files that are whole or absent: a command that fails, or whose disk is full, leaves what was there before.
//!
//! A file is written beside its target under the name `.bdtree-*.tmp` and takes the target's name when it is complete.
//! Only a process that is killed meanwhile leaves the temporary file. The target keeps its permissions, and a
//! write-protected one is refused; another hard link to it keeps the old content. Symbolic links are followed; a device
//! or a pipe is written to as it is.

use std::fs::{self, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// A file that could not be written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct OutputError {
    /// The file, as it was asked for.
    pub path: PathBuf,
    /// Why, without the file's name.
    pub reason: String,
}

impl OutputError {
    fn new(path: &Path, reason: impl Into<String>) -> Self {
        Self {
            path: path.to_path_buf(),
            reason: reason.into(),
        }
    }
}

/// Writes a file: `path` then holds all of `content`, or what it held before.
///
/// # Errors
/// A path that is a folder or write-protected, a folder that takes no new file, a full disk, what `content` returns.
pub fn write_whole(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    let temporary = temporary(path)?;
    let failed =
        |what: &str, error: &io::Error| OutputError::new(path, format!("{what}: {}", cause(error)));
    let cannot_write = |error| failed("cannot write", &error);
    let write = |file: &fs::File| {
        let mut writer = BufWriter::new(file);
        content(&mut writer)?;
        writer.flush()
    };
    let Some((file, target)) = temporary else {
        let device = OpenOptions::new().write(true).open(path);
        return device.and_then(|file| write(&file)).map_err(cannot_write);
    };
    let written = write(file.as_file()).and_then(|()| file.as_file().sync_all());
    written.map_err(cannot_write)?;
    file.persist(&target)
        .map_err(|e| failed("cannot put the finished file in place", &e.error))?;
    Ok(())
}

/// Whether [`write_whole`] could begin, before a long time is spent on what it is to write.
///
/// # Errors
/// A path that is a folder or write-protected, a folder that takes no new file.
pub fn check_writable(path: &Path) -> Result<(), OutputError> {
    temporary(path).map(drop)
}

/// A temporary file beside what `path` names, links followed, and that; `None` where it is a device or a pipe.
fn temporary(path: &Path) -> Result<Option<(NamedTempFile, PathBuf)>, OutputError> {
    let found = fs::metadata(path).ok();
    if found.as_ref().is_some_and(fs::Metadata::is_dir) {
        return Err(OutputError::new(path, "is a folder: name a file"));
    }
    if found.as_ref().is_some_and(|m| !m.is_file()) {
        return Ok(None);
    }
    // A new file takes the name, so that the folder's permissions decide; whoever protects a file means the name.
    let is_protected = |m: &fs::Metadata| {
        let opened = OpenOptions::new().write(true).open(path);
        m.permissions().readonly() || opened.is_err_and(|e| e.kind() == ErrorKind::PermissionDenied)
    };
    if found.as_ref().is_some_and(is_protected) {
        return Err(OutputError::new(path, "is write-protected"));
    }
    let target = fs::canonicalize(path).unwrap_or_else(|_| PathBuf::from(path));
    let folder = folder(&target);
    let mut builder = tempfile::Builder::new();
    builder.prefix(".bdtree-").suffix(".tmp");
    // Those of any file that a program creates, before the user's mask; temporary files have fewer.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    match builder.tempfile_in(folder) {
        Ok(file) => {
            if let Some(old) = found {
                // Whoever may read the old one may read the new one; where that cannot be set, what new files get.
                let _ = file.as_file().set_permissions(old.permissions());
            }
            Ok(Some((file, target)))
        }
        Err(error) => {
            let reason = no_file_in(as_given(path, folder), &error);
            Err(OutputError::new(path, reason))
        }
    }
}

/// The folder of a file.
fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The folder that is written to, as it was given where that is the same.
fn as_given<'p>(path: &'p Path, folder: &'p Path) -> &'p Path {
    let given = self::folder(path);
    let is_same = fs::canonicalize(given).ok() == fs::canonicalize(folder).ok();
    if is_same { given } else { folder }
}

/// Why a folder takes no file.
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
