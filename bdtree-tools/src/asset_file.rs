//! Opening `.bdt` files with errors that name them.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use bdtree_format::{Header, MAGIC};
use bdtree_runtime::{AlignedBytes, Asset, FormatError, MappedFile};

use crate::error::ToolError;

/// A `.bdt` file's bytes, mapped or copied, and where they came from.
#[derive(Debug)]
pub struct AssetFile {
    path: PathBuf,
    bytes: Bytes,
}

#[derive(Debug)]
enum Bytes {
    Mapped(MappedFile),
    Copied(AlignedBytes),
}

impl AssetFile {
    /// Maps a file. It must not change while the result lives (see [`MappedFile::open`]).
    ///
    /// # Errors
    /// When it cannot be opened or mapped.
    pub fn map(path: &Path) -> Result<Self, ToolError> {
        let error = |source| ToolError::Read {
            path: path.to_path_buf(),
            source,
        };
        let meta = fs::metadata(path).map_err(error)?;
        if !meta.is_file() {
            let why = "it is not a plain file";
            return Err(error(io::Error::new(io::ErrorKind::InvalidInput, why)));
        }
        // Empty files cannot be mapped; they are for `Asset::open` to refuse.
        let bytes = if meta.len() == 0 {
            Bytes::Copied(AlignedBytes::copy_of(&[]))
        } else {
            Bytes::Mapped(MappedFile::open(path).map_err(error)?)
        };
        Ok(Self {
            path: path.to_path_buf(),
            bytes,
        })
    }

    /// Copies a file into memory: the safe way for files that others may change. Of one that does not
    /// begin as a `.bdt` file, whatever its size, the beginning alone, which [`AssetFile::asset`] refuses.
    ///
    /// # Errors
    /// When it cannot be opened or read.
    pub fn read(path: &Path) -> Result<Self, ToolError> {
        let error = |source| ToolError::Read {
            path: path.to_path_buf(),
            source,
        };
        let bytes = match other_start(path).map_err(error)? {
            Some(start) => AlignedBytes::copy_of(&start),
            None => AlignedBytes::read(path).map_err(error)?,
        };
        Ok(Self {
            path: path.to_path_buf(),
            bytes: Bytes::Copied(bytes),
        })
    }

    /// Where the file lies, as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The view of the file: header and tables only are read.
    ///
    /// # Errors
    /// The first rule that header or tables break.
    pub fn asset(&self) -> Result<Asset<'_>, ToolError> {
        self.open().map_err(|error| self.error(error))
    }

    /// The view of the file after a check of all checksums, unless `verify` is false.
    ///
    /// # Errors
    /// The first rule that header or tables break, or the first section whose checksum is wrong.
    pub fn checked_asset(&self, verify: bool) -> Result<Asset<'_>, ToolError> {
        let asset = self.asset()?;
        if verify {
            asset
                .verify_checksums()
                .map_err(|error| self.error(error))?;
        }
        Ok(asset)
    }

    /// The view of the file, with the bare error.
    pub(crate) fn open(&self) -> Result<Asset<'_>, FormatError> {
        Asset::open(match &self.bytes {
            Bytes::Mapped(map) => map.as_slice(),
            Bytes::Copied(bytes) => bytes.as_slice(),
        })
    }

    /// An error of the format with the file's name.
    pub(crate) fn error(&self, error: FormatError) -> ToolError {
        ToolError::Format {
            path: self.path.clone(),
            error,
        }
    }
}

/// The first bytes of a plain file that does not begin as a `.bdt` file.
fn other_start(path: &Path) -> io::Result<Option<Vec<u8>>> {
    if !fs::metadata(path)?.is_file() {
        return Ok(None); // the reader says so
    }
    let mut start = Vec::new();
    File::open(path)?
        .take(size_of::<Header>() as u64)
        .read_to_end(&mut start)?;
    Ok((!start.starts_with(&MAGIC)).then_some(start))
}
