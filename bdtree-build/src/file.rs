//! Putting a finished file in its place: all of it or nothing.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::BakeError;

/// Writes a file so that `path` holds either what it held before or all of `bytes`: into a
/// temporary file in the same folder, which then takes the name. Links are followed; a device or
/// a pipe is written to and stays what it is. A process that is killed meanwhile leaves the
/// temporary file, `.bdtree-*.tmp`.
///
/// # Errors
/// A folder that is missing or may not be written, a full disk.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), BakeError> {
    if is_special(path) {
        return fs::OpenOptions::new()
            .write(true)
            .open(path)
            .and_then(|mut device| device.write_all(bytes))
            .map_err(|e| failed(path, "cannot write", &e));
    }
    let target = fs::canonicalize(path).unwrap_or_else(|_| PathBuf::from(path));
    let mut file = temporary(path, &target)?;
    file.write_all(bytes)
        .and_then(|()| file.as_file().sync_all())
        .map_err(|e| failed(path, "cannot write", &e))?;
    file.persist(&target)
        .map_err(|e| failed(path, "cannot put the finished file in place", &e.error))?;
    Ok(())
}

/// Nothing, if [`write_atomically`] could begin now: told before a bake that takes minutes.
///
/// # Errors
/// A path that is a folder, a folder that is missing or may not be written.
pub fn check_writable(path: &Path) -> Result<(), BakeError> {
    if path.is_dir() {
        return Err(BakeError::one("file", path, "is a folder: name a file"));
    }
    if !is_special(path) {
        let target = fs::canonicalize(path).unwrap_or_else(|_| PathBuf::from(path));
        temporary(path, &target)?;
    }
    Ok(())
}

/// A device or a pipe.
fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir())
}

/// An empty file beside `target`, gone when it is dropped; `path` is what errors name.
fn temporary(path: &Path, target: &Path) -> Result<NamedTempFile, BakeError> {
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".bdtree-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // What any new file gets (the process's mask applies), not the private mode of
        // temporary files.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder
        .tempfile_in(folder)
        .map_err(|e| BakeError::one("file", path, no_file_in(&folder_of(path, folder), &e)))
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

/// Why a folder takes no file.
fn no_file_in(folder: &Path, error: &std::io::Error) -> String {
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

fn failed(path: &Path, what: &str, error: &std::io::Error) -> BakeError {
    let message = format!("{what}: {}", cause(error));
    BakeError::one("file", path, message)
}

/// An error without the name of the temporary file, which says nothing to anyone. (`tempfile` puts
/// it behind the system's text, and hides the system's error number.)
fn cause(error: &std::io::Error) -> String {
    let text = error.to_string();
    match text.split_once(" at path ") {
        Some((cause, _)) => cause.to_string(),
        None => text,
    }
}
