//! `.bdt` files as assets of Bevy.

use bdtree_runtime::{FormatError, Model};
use bevy_asset::io::Reader;
use bevy_asset::{Asset, AssetLoader, LoadContext};
use bevy_reflect::TypePath;
use thiserror::Error;

/// A `.bdt` file: a baked mesh with its modes, skin and tree. Cheap to clone.
#[derive(Asset, TypePath, Debug, Clone)]
pub struct BdtModel {
    /// The file as `bdtree-runtime` has it.
    pub model: Model,
}

impl From<Model> for BdtModel {
    fn from(model: Model) -> Self {
        Self { model }
    }
}

/// Loads files that end in `.bdt`. All of a file is checked as it is opened; one that changes on the disk is loaded anew
/// where the program turned on Bevy's feature `file_watcher`, and an error leaves the old model in its place.
#[derive(TypePath, Debug, Default, Clone, Copy)]
pub struct BdtLoader;

/// Why a `.bdt` file cannot be loaded.
#[derive(Debug, Error)]
pub enum BdtLoadError {
    /// The file cannot be read.
    #[error("cannot read the file: {0}")]
    Io(#[from] std::io::Error),
    /// The file is no `.bdt` file of this version, or it is damaged; says where.
    #[error(transparent)]
    Format(#[from] FormatError),
}

impl AssetLoader for BdtLoader {
    type Asset = BdtModel;
    type Settings = ();
    type Error = BdtLoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        _context: &mut LoadContext<'_>,
    ) -> Result<BdtModel, BdtLoadError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        Ok(Model::from_bytes(&bytes)?.into())
    }

    fn extensions(&self) -> &[&str] {
        &["bdt"]
    }
}
