//! A film's pictures as files.

use std::fs::{self, File};
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use bdtree_output::{OutputError, write_whole};
use bdtree_render::Image;

/// Writes `frame-00000.png`, `frame-00001.png`, … into a folder, each whole or not at all.
///
/// All pictures have one size, that of the one before the first included, or no film could be made of them. A
/// picture that is there is replaced; anything else of its name is refused.
#[derive(Debug)]
pub struct Frames {
    folder: PathBuf,
    next: u32,
    size: Option<[u32; 2]>,
}

/// Five digits.
const COUNT_MAX: u32 = 100_000;

impl Frames {
    /// Begins at number `first`; makes the folder.
    ///
    /// # Errors
    /// A folder that cannot be made; a number of more than five digits.
    pub fn from(folder: &Path, first: u32) -> Result<Self, OutputError> {
        fs::create_dir_all(folder).map_err(|error| refused(folder, error.to_string()))?;
        let mut frames = Self {
            folder: folder.to_path_buf(),
            next: first,
            size: None,
        };
        if first > COUNT_MAX {
            return Err(refused(&frames.path(first), "more than five digits"));
        }
        // Whatever else has that name says nothing about the size.
        if let Some(before) = first.checked_sub(1) {
            frames.size = size_of_png(&frames.path(before)).ok().flatten();
        }
        Ok(frames)
    }

    /// Goes on behind the pictures that are there without a gap: at 0 in an empty folder.
    ///
    /// # Errors
    /// Those of [`Frames::from`].
    pub fn resume(folder: &Path) -> Result<Self, OutputError> {
        let is_there = |number: &u32| {
            let path = folder.join(name(*number));
            matches!(size_of_png(&path), Ok(Some(_)))
        };
        let first = (0..COUNT_MAX).take_while(is_there).count() as u32;
        Self::from(folder, first)
    }

    /// The number of the picture that is written next.
    pub fn next(&self) -> u32 {
        self.next
    }

    /// Where a picture is.
    pub fn path(&self, number: u32) -> PathBuf {
        self.folder.join(name(number))
    }

    /// Writes the next picture; returns its path.
    ///
    /// # Errors
    /// A picture of another size; something of that name that is no picture; those of [`write_whole`]; more than
    /// 100 000 pictures.
    pub fn write(&mut self, image: &Image) -> Result<PathBuf, OutputError> {
        let path = self.path(self.next);
        if self.next >= COUNT_MAX {
            return Err(refused(&path, "more than five digits"));
        }
        let (size, all) = (image.size(), self.size.unwrap_or(image.size()));
        if size != all {
            let [[width, height], [w, h]] = [size, all];
            let reason = format!("{width} x {height} pixels, the pictures before it {w} x {h}");
            return Err(refused(&path, reason));
        }
        match size_of_png(&path) {
            Ok(Some(_)) => {}
            Ok(None) => {
                return Err(refused(
                    &path,
                    "is not a picture of a film: it is left alone",
                ));
            }
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => return Err(refused(&path, error.to_string())),
        }
        write_whole(&path, |out| image.write_png_fast(out))?;
        self.next += 1;
        self.size = Some(size);
        Ok(path)
    }
}

fn name(number: u32) -> String {
    format!("frame-{number:05}.png")
}

fn refused(path: &Path, reason: impl Into<String>) -> OutputError {
    OutputError {
        path: path.to_path_buf(),
        reason: reason.into(),
    }
}

/// Width and height of a PNG file; `None` of anything else, a link to one included.
fn size_of_png(path: &Path) -> std::io::Result<Option<[u32; 2]>> {
    if !fs::symlink_metadata(path)?.is_file() {
        return Ok(None);
    }
    let mut head = [0; 24];
    match File::open(path)?.read_exact(&mut head) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(None),
        read => read?,
    }
    let number = |at: usize| u32::from_be_bytes([0, 1, 2, 3].map(|k| head[at + k]));
    let is_png = head.starts_with(b"\x89PNG\r\n\x1a\n") && &head[12..16] == b"IHDR";
    Ok(is_png.then(|| [number(16), number(20)]))
}
