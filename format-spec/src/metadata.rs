//! The metadata section: what people and reports want to know and no query needs (SPEC 8).

use std::collections::BTreeMap;
use std::string::String;
use std::vec::Vec;

use serde::{Deserialize, Serialize};
use wincode::{SchemaRead, SchemaWrite};

/// Where an asset came from and how it was made. No absolute paths, no time stamps.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, SchemaRead, SchemaWrite)]
pub struct Metadata {
    /// Version of the builder, such as `bdtree-build 0.1.0`.
    pub builder: String,
    /// File name of the source without its folder.
    pub source_name: String,
    /// SHA-256 of the source file.
    pub source_hash: [u8; 32],
    /// Where the basis came from: `rigid`, `given`, `elastic`, …
    pub basis: String,
    /// Settings of the bake as option name and value, sorted by name.
    pub settings: BTreeMap<String, String>,
    /// One entry per mode.
    pub modes: Vec<ModeMetadata>,
    /// Error of the basis against its source over the diagonal of the bounding box, if there is a
    /// source to measure against.
    pub basis_error_rel: Option<ErrorMetadata>,
    /// What was odd about the source but kept.
    pub warnings: Vec<String>,
}

/// What people want to know of a mode.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, SchemaRead, SchemaWrite)]
pub struct ModeMetadata {
    /// Name, if the source has one.
    pub name: Option<String>,
    /// The source's default weight, if it has one.
    pub default_q: Option<f64>,
}

/// How far a basis is from its source: distances over all vertices (and all frames, where there
/// are frames) over the diagonal of the bounding box.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, SchemaRead, SchemaWrite,
)]
pub struct ErrorMetadata {
    /// Largest.
    pub max: f64,
    /// Root mean square.
    pub rms: f64,
    /// The source's frame that has the largest, from 0.
    pub frame: Option<u64>,
    /// The vertex that has the largest.
    pub vertex: Option<u64>,
}

/// The metadata section could not be written or read.
#[derive(Debug)]
pub struct MetadataError(String);

impl std::fmt::Display for MetadataError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "section META: {}", self.0)
    }
}

impl std::error::Error for MetadataError {}

impl Metadata {
    /// The section's bytes: bincode's fixed-width little-endian wire format.
    ///
    /// # Errors
    /// When a length is beyond what the encoder takes (4 MiB).
    pub fn to_bytes(&self) -> Result<Vec<u8>, MetadataError> {
        wincode::serialize(self).map_err(|e| MetadataError(std::format!("{e}")))
    }

    /// Reads a section's bytes; trailing bytes are an error.
    ///
    /// # Errors
    /// When the bytes are not what [`Metadata::to_bytes`] writes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, MetadataError> {
        wincode::deserialize_exact(bytes).map_err(|e| MetadataError(std::format!("{e}")))
    }
}
