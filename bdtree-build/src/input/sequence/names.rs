//! The frames of a folder: which files, in which order.

use std::cmp::Ordering;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Most names that a warning lists.
const LISTED_MAX: usize = 3;

/// The OBJ files of a folder.
#[derive(Debug, Default)]
pub(super) struct Frames {
    /// Paths in byte order of the names.
    pub(super) paths: Vec<PathBuf>,
    /// Names for people, in the same order.
    pub(super) names: Vec<String>,
    /// What is odd about the folder.
    pub(super) warnings: Vec<String>,
    /// Names of what is no frame.
    pub(super) others: Vec<String>,
}

/// The path without what only says that it is a folder, `frames/` or `.`: warnings go into the file, which must not depend
/// on how a path was typed.
pub(super) fn plain(path: &Path) -> PathBuf {
    match path.file_name() {
        Some(_) => path.components().collect(),
        None => path.canonicalize().unwrap_or_else(|_| path.to_path_buf()),
    }
}

/// The frames in `folder`: `.obj` and `.obj.gz`, in any case.
pub(super) fn list(folder: &Path) -> io::Result<Frames> {
    let mut entries = Vec::new();
    let mut others = Vec::new();
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name();
        let path = folder.join(&name);
        let shown = name.to_string_lossy().into_owned();
        if stem(&shown).is_some() && !path.is_dir() {
            entries.push((name.as_encoded_bytes().to_vec(), shown, path));
        } else {
            others.push(shown);
        }
    }
    entries.sort();
    others.sort();
    let mut frames = Frames::default();
    for (_, name, path) in entries {
        frames.names.push(name);
        frames.paths.push(path);
    }
    let place = folder.display();
    if !others.is_empty() {
        let mut names = others[..others.len().min(LISTED_MAX)].join(", ");
        if others.len() > LISTED_MAX {
            names.push_str(", …");
        }
        let text = match others.len() {
            1 => format!("{place}: left out, since it is no OBJ frame: {names}"),
            count => {
                format!("{place}: left out, since they are no OBJ frames, {count} entries: {names}")
            }
        };
        frames.warnings.push(text);
    }
    for pair in frames.names.windows(2) {
        if stem(&pair[0]) == stem(&pair[1]) {
            let text = format!("{place}: {} and {} are two frames", pair[0], pair[1]);
            frames.warnings.push(text);
        }
    }
    let swapped = frames
        .names
        .windows(2)
        .find(|pair| by_numbers(&pair[0], &pair[1]) == Ordering::Greater);
    if let Some(pair) = swapped {
        frames.warnings.push(format!(
            "{place}: frames are in byte order of their names, {} before {}: name them with leading zeros (f_02 before \
             f_10) if they should be counted",
            pair[0], pair[1]
        ));
    }
    frames.others = others;
    Ok(frames)
}

/// The name without `.obj` or `.obj.gz`; `None` if it is no OBJ file's.
fn stem(name: &str) -> Option<&str> {
    let ending = |name: &str, end: &str| -> Option<usize> {
        let at = name.len().checked_sub(end.len())?;
        let found = name.get(at..)?.eq_ignore_ascii_case(end);
        found.then_some(at)
    };
    let at = ending(name, ".obj").or_else(|| ending(name, ".obj.gz"))?;
    name.get(..at)
}

/// The order in which runs of digits count as numbers.
fn by_numbers(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a.as_bytes(), b.as_bytes());
    loop {
        let (Some(&x), Some(&y)) = (a.first(), b.first()) else {
            return a.len().cmp(&b.len());
        };
        if x.is_ascii_digit() && y.is_ascii_digit() {
            let (number_a, number_b) = (number(&mut a), number(&mut b));
            // Without leading zeros the longer one is larger.
            let order = number_a
                .len()
                .cmp(&number_b.len())
                .then(number_a.cmp(number_b));
            if order != Ordering::Equal {
                return order;
            }
        } else if x != y {
            return x.cmp(&y);
        } else {
            (a, b) = (&a[1..], &b[1..]);
        }
    }
}

/// Takes the digits at the start of `text`; without leading zeros.
fn number<'t>(text: &mut &'t [u8]) -> &'t [u8] {
    let end = text.iter().position(|b| !b.is_ascii_digit());
    let (digits, rest) = text.split_at(end.unwrap_or(text.len()));
    *text = rest;
    let first = digits.iter().position(|&b| b != b'0');
    &digits[first.unwrap_or(digits.len())..]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_count_as_numbers() {
        let order = |a, b| by_numbers(a, b);
        assert_eq!(order("f_2.obj", "f_10.obj"), Ordering::Less);
        assert_eq!(order("f_010.obj", "f_2.obj"), Ordering::Greater);
        assert_eq!(order("f_1_9", "f_1_10"), Ordering::Less);
        assert_eq!(order("a9", "b1"), Ordering::Less);
        assert_eq!(order("a", "a1"), Ordering::Less);
        assert_eq!(order("7", "007"), Ordering::Equal);
    }

    #[test]
    fn frames_end_in_obj() {
        assert_eq!(stem("a.obj"), Some("a"));
        assert_eq!(stem("a.OBJ.gz"), Some("a"));
        assert_eq!(stem(".obj"), Some(""));
        assert_eq!(stem("é"), None);
        assert_eq!(stem("a.obj.bak"), None);
        assert_eq!(stem("aé.obj"), Some("aé"));
    }
}
