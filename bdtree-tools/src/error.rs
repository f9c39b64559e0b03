//! What a command can fail with: one line per problem, each with its place.

use std::io;
use std::path::PathBuf;

use bdtree_format::MetadataError;
use bdtree_output::OutputError;
use bdtree_runtime::LoadError;

/// Why a command gave up.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ToolError {
    /// A `.bdt` file could not be read, or breaks a rule of the format.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A file's metadata section is not what the format says.
    #[error("{}: {error}", path.display())]
    Metadata {
        /// The file.
        path: PathBuf,
        /// Why.
        error: MetadataError,
    },
    /// Arguments or a scene with problems: one line each, place first.
    #[error("{}", .0.join("\n"))]
    Input(Vec<String>),
    /// Arguments that no file could make right.
    #[error("{0}")]
    Usage(String),
    /// An output file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The output stream failed otherwise than by closing.
    #[error("standard output: {0}")]
    Stdout(io::Error),
}

impl ToolError {
    /// The exit code: `unreadable` unless no file could make the arguments right.
    pub fn code(&self, unreadable: u8) -> u8 {
        match self {
            Self::Usage(_) => crate::USAGE,
            _ => unreadable,
        }
    }

    /// One problem with its place.
    pub fn input(place: impl std::fmt::Display, message: impl std::fmt::Display) -> Self {
        Self::Input(vec![format!("{place}: {message}")])
    }
}
