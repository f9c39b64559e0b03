//! An asset that owns its bytes.

use alloc::sync::Arc;
use core::fmt;
#[cfg(feature = "std")]
use std::path::{Path, PathBuf};

use self_cell::self_cell;

use crate::error::FormatError;
#[cfg(feature = "std")]
use crate::error::{HEADER_SECTION, MAGIC_BYTES, WHOLE_HEADER};
use crate::memory::AlignedBytes;
#[cfg(feature = "mmap")]
use crate::mmap::MappedFile;
use crate::view::Asset;

/// A `.bdt` file that owns its bytes: opened and checked once, cheap to clone, shared between threads and
/// instances. Store it in an engine component or behind an FFI handle.
///
/// [`Model::asset`] is the view that poses are made from.
#[derive(Clone)]
pub struct Model {
    shared: Arc<Owned>,
}

/// Where the bytes are.
enum Bytes {
    Copied(AlignedBytes),
    Embedded(&'static [u8]),
    #[cfg(feature = "mmap")]
    Mapped(MappedFile),
}

impl Bytes {
    fn as_slice(&self) -> &[u8] {
        match self {
            Self::Copied(bytes) => bytes.as_slice(),
            Self::Embedded(bytes) => bytes,
            #[cfg(feature = "mmap")]
            Self::Mapped(file) => file.as_slice(),
        }
    }
}

self_cell!(
    struct Owned {
        owner: Bytes,

        #[covariant]
        dependent: Asset,
    }
);

impl Model {
    /// Maps a file: pages are read when queries touch them. Reads header and tables; [`Asset::verify_checksums`] finds
    /// damage in the rest.
    ///
    /// The file must not be changed or truncated while it is mapped. If the file changes, results are arbitrary or
    /// [`QueryError::Corrupt`](crate::QueryError::Corrupt), and it is a data race (undefined behavior). If it is
    /// truncated, reading past the new end is a bus error (SIGBUS), which ends the program. Replacing a file by
    /// renaming another over it, as `bdtree-build` does, is safe: the map keeps the old one. Use [`Model::read`] for
    /// files that others may change. `docs/design/unsafe.md` lists this condition.
    ///
    /// # Errors
    /// When it cannot be opened or mapped, is no plain file, or is not a `.bdt` file.
    #[cfg(feature = "mmap")]
    pub fn load(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        let path = path.as_ref();
        let file = MappedFile::open(path).map_err(|error| LoadError::io(path, error))?;
        let bytes = match file {
            Some(file) => Bytes::Mapped(file),
            None => Bytes::Copied(AlignedBytes::copy_of(&[])),
        };
        Self::open(bytes).map_err(|error| LoadError::format(path, error))
    }

    /// Reads a whole file into memory: a copy that nobody else can change. If the file does not start with a
    /// `.bdt` header, only its first bytes are read.
    ///
    /// # Errors
    /// When it cannot be opened or read, is no plain file (a pipe would be waited for, and a device may have no
    /// end), becomes shorter meanwhile, or is not a `.bdt` file; when there is no memory for it.
    #[cfg(feature = "std")]
    pub fn read(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        let path = path.as_ref();
        let bytes = AlignedBytes::read(path).map_err(|error| LoadError::io(path, error))?;
        Self::open(Bytes::Copied(bytes)).map_err(|error| LoadError::format(path, error))
    }

    /// A copy of a file's bytes, which may lie at any address.
    ///
    /// # Errors
    /// The first rule of the format that header or tables break, with its place.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::open(Bytes::Copied(AlignedBytes::copy_of(bytes)))
    }

    /// Opens static bytes aligned to 4, as [`include_bdt!`](crate::include_bdt) makes them.
    ///
    /// # Errors
    /// Those of [`Model::from_bytes`]; an address that is not a multiple of 4.
    pub fn from_static(bytes: &'static [u8]) -> Result<Self, FormatError> {
        Self::open(Bytes::Embedded(bytes))
    }

    fn open(bytes: Bytes) -> Result<Self, FormatError> {
        let owned = Owned::try_new(bytes, |bytes| Asset::open(bytes.as_slice()))?;
        Ok(Self {
            shared: Arc::new(owned),
        })
    }

    /// The view of the bytes; takes constant time, since they were checked when the model was opened.
    #[inline]
    pub fn asset(&self) -> &Asset<'_> {
        self.shared.borrow_dependent()
    }
}

impl fmt::Debug for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Model")
            .field("bytes", &self.asset().bytes().len())
            .field("triangles", &self.asset().triangle_count())
            .field("modes", &self.asset().mode_count())
            .finish()
    }
}

/// Why a file cannot be loaded. Print with `{error}`: one line with the problem, the file and the cause. So
/// [`source`](core::error::Error::source) does not return the cause again, but what lies behind it, if anything.
#[cfg(feature = "std")]
#[derive(Debug)]
#[non_exhaustive]
pub enum LoadError {
    /// It cannot be opened, mapped or read.
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        error: std::io::Error,
    },
    /// Its header or tables break a rule of the format.
    Format {
        /// The file.
        path: PathBuf,
        /// Which rule, and where.
        error: FormatError,
    },
}

#[cfg(feature = "std")]
impl LoadError {
    fn io(path: &Path, error: std::io::Error) -> Self {
        let path = path.to_path_buf();
        Self::Io { path, error }
    }

    fn format(path: &Path, error: FormatError) -> Self {
        let path = path.to_path_buf();
        Self::Format { path, error }
    }
}

#[cfg(feature = "std")]
impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, error } => write!(f, "{}: cannot be read: {error}", path.display()),
            Self::Format { path, error } => {
                let path = path.display();
                if error.rule == MAGIC_BYTES {
                    return write!(f, "{path}: not a .bdt file ({})", error.rule);
                }
                let problem = match error.section {
                    // The first eight bytes are the format's name, the next four its version.
                    HEADER_SECTION if error.byte < 8 => "not a .bdt file",
                    // Cut off before the header's end, which is then the place.
                    _ if error.rule == WHOLE_HEADER => "damaged .bdt file",
                    HEADER_SECTION if error.byte < 12 => "a .bdt file of another version",
                    _ => "damaged .bdt file",
                };
                write!(f, "{path}: {problem}: {error}")
            }
        }
    }
}

#[cfg(feature = "std")]
impl std::error::Error for LoadError {
    /// The message holds the cause, so a chain of messages must not repeat it.
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io { error, .. } => error.source(),
            Self::Format { error, .. } => error.source(),
        }
    }
}

/// A shared model may be held by any thread.
const _: () = {
    const fn is_shareable<T: Send + Sync>() {}
    is_shareable::<Model>();
};
