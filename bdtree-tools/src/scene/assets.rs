//! The assets that a scene's instances name.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::fields::At;
use crate::asset_file::AssetFile;

/// The assets that instances name, each opened once.
#[derive(Debug)]
pub(super) struct Assets {
    folder: PathBuf,
    verify: bool,
    /// By canonical path, so that two spellings are one file; `None`: already reported.
    known: HashMap<PathBuf, Option<usize>>,
    files: Vec<AssetFile>,
}

impl Assets {
    /// Assets relative to a folder; `verify` checks their checksums.
    pub(super) fn new(folder: &Path, verify: bool) -> Self {
        Self {
            folder: folder.to_path_buf(),
            verify,
            known: HashMap::new(),
            files: Vec::new(),
        }
    }

    /// An opened file.
    pub(super) fn file(&self, index: usize) -> &AssetFile {
        &self.files[index]
    }

    /// The opened files.
    pub(super) fn into_files(self) -> Vec<AssetFile> {
        self.files
    }

    /// Index of the asset with this path, opened and checked when it is met first; what is wrong
    /// with a file is told once, at the first place that names it.
    pub(super) fn open(&mut self, path: &str, at: &At<'_>) -> Option<usize> {
        let path = self.folder.join(path);
        let key = path.canonicalize().unwrap_or_else(|_| path.clone());
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let opened = AssetFile::map(&path).and_then(|file| {
            file.checked_asset(self.verify)?;
            Ok(file)
        });
        let file = opened.map_err(|error| at.fail::<()>(error)).ok();
        let index = file.map(|file| {
            self.files.push(file);
            self.files.len() - 1
        });
        self.known.insert(key, index);
        index
    }
}
