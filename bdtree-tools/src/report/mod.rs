//! `bdtree report`: what each choice costs and buys for an asset, measured on the asset itself.
//!
//! [`measure`] fills a [`content::Content`]; the page and `--json` are made of it. Counts and errors are the
//! same in every run on processors of the same kind, times are not.

mod advice;
pub mod content;
mod contest;
mod depth;
mod lanes;
mod measure;
mod modes;
mod page;
mod plot;
mod sample;
mod sections;
mod text;
mod tightness;
mod tolerance;
mod words;

use std::ffi::OsStr;
use std::io::Write;
use std::path::PathBuf;

use bdtree_runtime::{FormatError, PoseError, QueryError};

pub use crate::cli::ReportArguments as Arguments;
use crate::error::ToolError;
use crate::output::{check_writable, write_whole};
use crate::{AssetFile, DONE};
pub use measure::measure;

/// Repetitions of which times are medians.
pub(crate) const REPETITIONS: usize = 5;

/// Writes the report on a file.
///
/// # Errors
/// A file that cannot be read or breaks the format's rules, an output that cannot be written.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<u8, ToolError> {
    let page = target(arguments)?;
    let file = AssetFile::map(&arguments.file)?;
    if let Some(path) = &page {
        let both = (path.canonicalize(), arguments.file.canonicalize());
        if matches!(both, (Ok(to), Ok(from)) if to == from) {
            let message = "is the input: it would be overwritten";
            return Err(ToolError::input(path.display(), message));
        }
    }
    if let Some(path) = &page {
        check_writable(path)?;
    }
    let content = measure(&file, !arguments.no_verify)?;
    if let Some(path) = &page {
        let page = page::page(&content);
        write_whole(path, |w| w.write_all(page.as_bytes()))?;
    }
    if arguments.json {
        serde_json::to_writer(&mut *out, &content).map_err(|e| ToolError::Stdout(e.into()))?;
        writeln!(out).map_err(ToolError::Stdout)?;
        return Ok(DONE);
    }
    for line in content
        .missing
        .iter()
        .chain(content.advice.iter().map(|a| &a.text))
    {
        writeln!(out, "{line}").map_err(ToolError::Stdout)?;
    }
    if let Some(path) = &page {
        writeln!(out, "wrote {}", path.display()).map_err(ToolError::Stdout)?;
    }
    Ok(DONE)
}

/// Where the page goes: beside the file unless told otherwise; with `--json` alone there is none.
fn target(arguments: &Arguments) -> Result<Option<PathBuf>, ToolError> {
    match &arguments.output {
        Some(path) => {
            let is_html =
                |e: &OsStr| e.eq_ignore_ascii_case("html") || e.eq_ignore_ascii_case("htm");
            if !path.extension().is_some_and(is_html) {
                let message = "unknown extension: .html can be written";
                return Err(ToolError::input(path.display(), message));
            }
            Ok(Some(path.clone()))
        }
        None if arguments.json => Ok(None),
        None => Ok(Some(arguments.file.with_extension("html"))),
    }
}

/// Of a file whose rules were checked before: one that changed since, say.
fn problem(error: FormatError) -> ToolError {
    ToolError::Input(vec![error.to_string()])
}

fn refused(error: QueryError) -> ToolError {
    ToolError::Input(vec![error.to_string()])
}

fn pose_refused(error: &PoseError) -> ToolError {
    ToolError::Input(vec![error.to_string()])
}
