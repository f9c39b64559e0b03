//! `bdtree report`: what each choice costs and buys for an asset, measured on the asset itself by
//! [`bdtree_measure::report`].

use std::io::Write;
use std::time::Instant;

use bdtree_measure::report::content::{Content, Margin};
use bdtree_measure::report::{Subject, measure, page};
use bdtree_runtime::{Asset, FormatError};

pub use crate::cli::ReportArguments as Arguments;
use crate::error::ToolError;
use crate::info::Info;
use crate::output::{check_target, check_writable, printable, write_json, write_whole};
use crate::verify::broken_rules;
use crate::{AssetFile, DONE, stress};

/// Writes the report on a file.
///
/// # Errors
/// A file that cannot be read or breaks the format's rules, an output that cannot be written.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<u8, ToolError> {
    let beside = arguments.file.with_extension("html");
    // With `--json` alone there is no page.
    let beside = (!arguments.json).then_some(beside);
    let target = arguments.output.clone().or(beside);
    if let Some(path) = &target {
        check_target(path, &arguments.file, &["html", "htm"], ".html")?;
    }
    let file = AssetFile::map(&arguments.file)?;
    if let Some(path) = &target {
        check_writable(path)?;
    }
    let content = content(&file, !arguments.no_verify)?;
    if let Some(path) = &target {
        let page = page(&content);
        write_whole(path, |w| w.write_all(page.as_bytes()))?;
    }
    if arguments.json {
        write_json(out, &content)?;
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

/// Checks a file and measures it; `verify`: checksums and records are checked too, which measuring follows.
fn content(file: &AssetFile, verify: bool) -> Result<Content, ToolError> {
    let start = Instant::now();
    let asset = file.checked_asset(verify)?;
    let broken = if verify {
        broken_rules(asset, 1)
    } else {
        Vec::new()
    };
    if let Some(error) = broken.first() {
        return Err(file.error(*error));
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
    let slack_rel = stress::rounding_slack(asset, options.seed)?;
    let least = report.tightest.map(|tight| tight.margin_slacks);
    Ok(Margin {
        cases: report.cases,
        violations: report.violations.len(),
        least: least.filter(|margin| margin.is_finite()),
        rounding_slack_rel: Some(slack_rel).filter(|c| c.is_finite()),
    })
}
