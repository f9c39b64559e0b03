//! Mapping a file: the only `unsafe` outside `simd`.
#![allow(unsafe_code)] // one block, proof below

use std::fs::File;
use std::io;
use std::path::Path;

use crate::memory::plain_len;

/// The usual page size; where pages are larger the system rounds up.
#[cfg(unix)]
const PAGE: usize = 4096;

/// A read-only memory mapping of a file. Pages are read when queries touch them.
pub(crate) struct MappedFile {
    map: memmap2::Mmap,
}

impl MappedFile {
    /// Maps a file, which must not be changed or truncated while it is mapped: see
    /// [`Model::load`](crate::Model::load). `None`: it is empty, and nothing can be mapped.
    ///
    /// # Errors
    /// When it cannot be opened or mapped, or is no plain file.
    pub(crate) fn open(path: &Path) -> io::Result<Option<Self>> {
        if plain_len(path)? == 0 {
            return Ok(None);
        }
        let file = File::open(path)?;
        // SAFETY: the map is read-only and private to this struct, and `as_slice` borrows it, so
        // no slice outlives it. That nobody changes the file meanwhile is the documented
        // condition of this call; memory safety of the readers does not rest on what the bytes
        // say, since every access is checked.
        let map = unsafe { memmap2::Mmap::map(&file) }?;
        // Opening an asset reads the first page only. Advice of its own makes that page a mapping
        // of its own, so that the kernel does not map the pages around it (or a huge page) too:
        // without it a cached file grew the resident set by 64 KiB to 2 MiB. Failing is harmless.
        #[cfg(unix)]
        let _ = map.advise_range(memmap2::Advice::Random, 0, map.len().min(PAGE));
        Ok(Some(Self { map }))
    }

    /// The bytes, page-aligned.
    pub(crate) fn as_slice(&self) -> &[u8] {
        &self.map
    }
}
