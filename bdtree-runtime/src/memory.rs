//! Files in memory at the alignment that the format advises.

use alloc::vec::Vec;
#[cfg(feature = "std")]
use bdtree_format::{Header, MAGIC};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// 64 bytes at a multiple of 64.
#[derive(Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C, align(64))]
struct Block([u8; 64]);

/// An owned copy of a file's bytes, 64-byte aligned.
pub(crate) struct AlignedBytes {
    blocks: Vec<Block>,
    len: usize,
}

impl AlignedBytes {
    /// A copy of `bytes`.
    pub(crate) fn copy_of(bytes: &[u8]) -> Self {
        let mut copy = Self {
            blocks: alloc::vec![Block([0; 64]); bytes.len().div_ceil(64)],
            len: bytes.len(),
        };
        copy.bytes_mut().copy_from_slice(bytes);
        copy
    }

    /// Reads a whole file, which takes as much memory as it has bytes; of one that does not begin as a
    /// `.bdt` file the beginning alone, which is refused when it is opened.
    ///
    /// # Errors
    /// When it cannot be opened or read, or is no plain file. When there is no memory for it, or it becomes
    /// shorter meanwhile.
    #[cfg(feature = "std")]
    pub(crate) fn read(path: &std::path::Path) -> std::io::Result<Self> {
        use std::io::{ErrorKind, Read};
        let len = usize::try_from(plain_len(path)?).map_err(|_| ErrorKind::OutOfMemory)?;
        let mut file = std::fs::File::open(path)?;
        let mut start = [0; size_of::<Header>()];
        let start = &mut start[..len.min(size_of::<Header>())];
        file.read_exact(start)?;
        if !start.starts_with(&MAGIC) {
            return Ok(Self::copy_of(start));
        }
        let mut blocks = Vec::new();
        blocks.try_reserve_exact(len.div_ceil(64))?;
        blocks.resize(len.div_ceil(64), Block([0; 64]));
        let mut read = Self { blocks, len };
        let (first, rest) = read.bytes_mut().split_at_mut(start.len());
        first.copy_from_slice(start);
        file.read_exact(rest)?;
        Ok(read)
    }

    fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.blocks.as_mut_bytes()[..self.len]
    }

    /// The bytes.
    pub(crate) fn as_slice(&self) -> &[u8] {
        &self.blocks.as_bytes()[..self.len]
    }
}

/// The length of a plain file. A pipe would be waited for, and a device may have no end.
///
/// # Errors
/// When there is no such file, or it is another kind of file.
#[cfg(feature = "std")]
pub(crate) fn plain_len(path: &std::path::Path) -> std::io::Result<u64> {
    let meta = std::fs::metadata(path)?;
    if !meta.is_file() {
        let kind = std::io::ErrorKind::InvalidInput;
        return Err(std::io::Error::new(kind, "it is not a plain file"));
    }
    Ok(meta.len())
}
