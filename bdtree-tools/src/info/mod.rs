//! `bdtree info`: what a file holds.

mod mass;
mod report;
mod text;

pub use mass::Mass;
pub use report::{Bounds, Group, Info, Level, Mode, Section, Source};
pub(crate) use report::{bounds, hexadecimal, metadata, mode_name, section_start};

use std::io::Write;

pub use crate::cli::InfoArguments as Arguments;
use crate::error::ToolError;
use crate::output::write_json;
use crate::{AssetFile, DONE};

/// Prints what a file holds, as text or as one JSON object.
///
/// # Errors
/// A file that cannot be read or whose header, tables, tree or metadata break the format's rules;
/// an output stream that fails.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<u8, ToolError> {
    let file = AssetFile::map(&arguments.file)?;
    let info = Info::of(&file)?;
    if arguments.json {
        write_json(out, &info)?;
    } else {
        let text = text::text(&arguments.file, &info, arguments.sections);
        out.write_all(text.as_bytes()).map_err(ToolError::Stdout)?;
    }
    Ok(DONE)
}
