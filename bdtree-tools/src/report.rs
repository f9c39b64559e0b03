//! `bdtree report`: what each choice costs and buys for an asset, measured on the asset itself by
//! [`bdtree_measure::report`].

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

use bdtree_format::Metadata;
use bdtree_measure::report::content::{Content, Margin};
use bdtree_measure::report::{Picture, Subject, measure, page};
use bdtree_measure::{MeasureError, Progress};
use bdtree_output::{check_writable, write_whole};
use bdtree_render::Image;
use bdtree_runtime::{Asset, FormatError};

use crate::bar::Bar;
pub use crate::cli::ReportArguments as Arguments;
use crate::error::ToolError;
use crate::info::Info;
use crate::output::{check_target, printable, write_json};
use crate::render::portraits;
use crate::verify::broken_rules;
use crate::{AssetFile, DONE, stress};

/// Writes the report on a file.
///
/// # Errors
/// A file that cannot be read or breaks the format's rules, an output that cannot be written.
pub fn run(
    arguments: &Arguments,
    out: &mut dyn Write,
    err: &mut dyn Write,
) -> Result<u8, ToolError> {
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
    let bar = Bar::with_lines();
    let content = content(&file, !arguments.no_verify, &bar);
    bar.clear();
    let content = content?;
    if let Some(path) = &target {
        // A machine without Vulkan gets the page without pictures.
        let pictures = portraits(&file, arguments.upright.up);
        let pictures = pictures.and_then(|all| all.into_iter().map(picture).collect());
        let pictures = pictures.unwrap_or_else(|error| {
            let _ = writeln!(err, "the report has no pictures: {error}");
            Vec::new()
        });
        let page = page(&content, &pictures);
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

/// As a file.
fn picture((caption, image): (String, Image)) -> Result<Picture, ToolError> {
    let mut png = Vec::new();
    let written = image.write_png(&mut png);
    written.map_err(|error| ToolError::Input(vec![error.to_string()]))?;
    Ok(Picture { caption, png })
}

/// The day, UTC, as 2026-01-31.
fn today() -> String {
    let mut time = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    time.truncate("2026-01-31".len());
    time
}

impl Progress for Bar {
    fn stage(&self, name: &str, steps: Option<u64>) {
        Bar::stage(self, name, steps);
    }

    fn advance(&self, steps: u64) {
        Bar::advance(self, steps);
    }
}

/// Checks a file and measures it; `verify`: checksums and records are checked too, which measuring follows.
fn content(file: &AssetFile, verify: bool, bar: &Bar) -> Result<Content, ToolError> {
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
    let stem = file.path().file_stem().unwrap_or(name).to_string_lossy();
    let advised = file.path().with_file_name(format!("{stem}-advised.bdt"));
    let subject = Subject {
        name: printable(&name.to_string_lossy()),
        input: source(file).map(|path| printable(&path.to_string_lossy())),
        advised: printable(&advised.to_string_lossy()),
        basis_error_rel: info.basis_error_rel.map(|error| error.max),
        date: today(),
        check_seconds: start.elapsed().as_secs_f64(),
        margin: &margin,
    };
    measure(asset, &subject, bar).map_err(|error| match error {
        MeasureError::Format(error) => file.error(error),
        error => ToolError::input(file.path().display(), error),
    })
}

/// Where the file's source lies: its metadata have the name alone, which is looked for beside the file and in the
/// current folder.
fn source(file: &AssetFile) -> Option<PathBuf> {
    let name = Metadata::from_bytes(file.asset().metadata())
        .ok()?
        .source_name;
    let is_name = Path::new(&name).file_name() == Some(name.as_ref()) && !name.starts_with('-');
    let folders = [file.path().with_file_name(&name), PathBuf::from(&name)];
    let mut found = folders.into_iter().filter(|path| is_name && path.is_file());
    found.next()
}

/// The tightest that a search with so many cases finds.
fn margin(
    asset: &Asset<'_>,
    cases: u64,
    tried: &(dyn Fn(u64) + Sync),
) -> Result<Margin, FormatError> {
    let options = stress::Options { cases, seed: 0 };
    let report = stress::run(asset, options, tried)?;
    let slack_rel = stress::rounding_slack(asset, options.seed)?;
    let least = report.tightest.map(|tight| tight.margin_slacks);
    Ok(Margin {
        cases: report.cases,
        violations: report.violations.len(),
        least: least.filter(|margin| margin.is_finite()),
        rounding_slack_rel: Some(slack_rel).filter(|c| c.is_finite()),
    })
}
