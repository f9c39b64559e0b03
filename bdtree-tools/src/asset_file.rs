//! Opening `.bdt` files with errors that name them.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use bdtree_runtime::{Asset, FormatError, HEADER_SECTION, LoadError, Model};

use crate::error::ToolError;

/// An opened `.bdt` file and where it came from.
#[derive(Debug)]
pub struct AssetFile {
    path: PathBuf,
    model: Model,
}

impl AssetFile {
    /// Maps a file. It must not change while the result lives (see [`Model::load`]).
    ///
    /// # Errors
    /// When it cannot be opened or mapped, or is not a `.bdt` file.
    pub fn map(path: &Path) -> Result<Self, ToolError> {
        Ok(Self::of(path, Model::load(path).map_err(with_remedy)?))
    }

    /// Copies a file into memory: the safe way for files that others may change.
    ///
    /// # Errors
    /// When it cannot be opened or read, or is not a `.bdt` file.
    pub fn read(path: &Path) -> Result<Self, ToolError> {
        Ok(Self::of(path, Model::read(path).map_err(with_remedy)?))
    }

    fn of(path: &Path, model: Model) -> Self {
        let path = path.to_path_buf();
        Self { path, model }
    }

    /// Where the file lies, as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file's bytes, which instances share.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The view of the file.
    pub fn asset(&self) -> &Asset<'_> {
        self.model.asset()
    }

    /// The view of the file after a check of all checksums, unless `verify` is false.
    ///
    /// # Errors
    /// The first section whose checksum is wrong.
    pub fn checked_asset(&self, verify: bool) -> Result<&Asset<'_>, ToolError> {
        let asset = self.asset();
        if verify {
            asset
                .verify_checksums()
                .map_err(|error| self.error(error))?;
        }
        Ok(asset)
    }

    /// Checks every rule of the format, as `bdtree verify` does.
    ///
    /// # Errors
    /// The first rule that the file breaks.
    pub fn verify(&self) -> Result<(), ToolError> {
        let mut first = Ok(());
        self.asset().verify(&mut |error| {
            first = Err(error);
            ControlFlow::Break(())
        });
        first.map_err(|error| self.error(error))
    }

    /// An error of the format with the file's name.
    pub(crate) fn error(&self, error: FormatError) -> ToolError {
        let path = self.path.clone();
        LoadError::Format { path, error }.into()
    }
}

/// The error of a file that cannot be loaded; of a mesh, with what to do first.
fn with_remedy(error: LoadError) -> ToolError {
    const MESHES: [&str; 6] = ["obj", "gz", "ply", "stl", "glb", "gltf"];
    match &error {
        LoadError::Format { path, error } if error.section == HEADER_SECTION && error.byte < 8 => {
            let extension = path.extension().unwrap_or_default();
            if MESHES
                .iter()
                .any(|mesh| extension.eq_ignore_ascii_case(mesh))
            {
                let path = path.display();
                let message = format!("not a .bdt file: bake it first with `bdtree-build {path}`");
                return ToolError::input(path, message);
            }
        }
        _ => {}
    }
    error.into()
}
