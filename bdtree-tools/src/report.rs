//! `bdtree report`: what each choice costs and buys for an asset, measured on the asset itself by
//! [`bdtree_measure::report`].

use std::ffi::OsStr;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

use bdtree_measure::report::content::{Content, Margin};
use bdtree_measure::report::{Subject, measure, page};
use bdtree_runtime::{Asset, FormatError};

pub use crate::cli::ReportArguments as Arguments;
use crate::error::ToolError;
use crate::info::Info;
use crate::output::{check_writable, printable, write_whole};
use crate::{AssetFile, DONE, stress};

/// Writes the report on a file.
///
/// # Errors
/// A file that cannot be read or breaks the format's rules, an output that cannot be written.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<u8, ToolError> {
    let target = target(arguments)?;
    let file = AssetFile::map(&arguments.file)?;
    if let Some(path) = &target {
        let both = (path.canonicalize(), arguments.file.canonicalize());
        if matches!(both, (Ok(to), Ok(from)) if to == from) {
            let message = "is the input: it would be overwritten";
            return Err(ToolError::input(path.display(), message));
        }
        check_writable(path)?;
    }
    let content = content(&file, !arguments.no_verify)?;
    if let Some(path) = &target {
        let page = page(&content);
        write_whole(path, |w| w.write_all(page.as_bytes()))?;
    }
    if arguments.json {
        serde_json::to_writer(&mut *out, &content).map_err(|e| ToolError::Stdout(e.into()))?;
        writeln!(out).map_err(ToolError::Stdout)?;
        return Ok(DONE);
    }
    let advice = content.advice.iter().map(|a| &a.text);
    for line in content.missing.iter().chain(advice) {
        writeln!(out, "{line}").map_err(ToolError::Stdout)?;
    }
    if let Some(path) = &target {
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

/// Checks a file and measures it; `verify`: checksums and records are checked too, which measuring follows.
fn content(file: &AssetFile, verify: bool) -> Result<Content, ToolError> {
    let start = Instant::now();
    let asset = file.checked_asset(verify)?;
    let mut broken = None;
    if verify {
        asset.verify(&mut |error| {
            broken = Some(error);
            ControlFlow::Break(())
        });
    }
    if let Some(error) = broken {
        return Err(file.error(error));
    }
    let info = Info::of(file)?;
    let name = file.path().file_name().unwrap_or(file.path().as_os_str());
    let subject = Subject {
        name: printable(&name.to_string_lossy()),
        basis_error_rel: info.basis_error_rel.map(|error| error.max),
        check_seconds: start.elapsed().as_secs_f64(),
        margin: &margin,
    };
    measure(asset, &subject).map_err(|error| ToolError::input(file.path().display(), error))
}

/// The tightest that a search with so many cases finds.
fn margin(asset: &Asset<'_>, cases: u64) -> Result<Margin, FormatError> {
    let options = stress::Options { cases, seed: 0 };
    let report = stress::run(asset, options, &|_| ())?;
    let certainty = stress::certainty(asset, options.seed)?;
    let tightest = report.tightest.as_ref();
    Ok(Margin {
        cases: report.cases,
        violations: report.violations.len(),
        least: tightest
            .map(stress::Tight::margin)
            .filter(|margin| margin.is_finite()),
        certainty_rel: Some(certainty).filter(|c| c.is_finite()),
    })
}
