//! `bdtree verify`: every rule of the format, checked.

use std::io::Write;
use std::ops::ControlFlow;

use bdtree_runtime::{Asset, Datum, FormatError, LoadError};
use serde::Serialize;
use serde_json::Value;

use crate::bar::Bar;
pub use crate::cli::VerifyArguments as Arguments;
use crate::error::ToolError;
use crate::output::write_json;
use crate::stress::{self, Summary};
use crate::{AssetFile, BAD_INPUT, DONE};

/// Most broken rules that are listed.
pub const ERRORS_MAX: usize = 1000;

/// What `--json` prints.
#[derive(Debug, Serialize)]
pub struct Report {
    /// No rule is broken.
    pub ok: bool,
    /// The broken rules, at most [`ERRORS_MAX`].
    pub errors: Vec<BrokenRule>,
    /// What `--stress` tried.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stress: Option<Summary>,
}

/// A broken rule.
#[derive(Debug, Serialize)]
pub struct BrokenRule {
    /// The section's four letters, `HEAD` for the header block.
    pub section: String,
    /// Offset from the start of the file.
    pub byte: u64,
    /// Number and words of the rule in `SPEC.md`, or of the promise in `docs/design/guarantees.md`.
    pub rule: String,
    /// What the rule asks for: a number, or text, which has the words of a limit (`less than 98`).
    pub expected: Value,
    /// What the file holds.
    pub found: Value,
}

impl From<&FormatError> for BrokenRule {
    fn from(error: &FormatError) -> Self {
        Self {
            section: error.section.to_string(),
            byte: error.byte,
            rule: error.rule.to_string(),
            expected: value(error.expected),
            found: value(error.found),
        }
    }
}

/// Numbers stay numbers; what JSON cannot write as one is text.
fn value(datum: Datum) -> Value {
    match datum {
        Datum::Integer(x) => x.into(),
        Datum::Signed(x) => x.into(),
        Datum::Real(x) if x.is_finite() => x.into(),
        other => other.to_string().into(),
    }
}

/// The rules that an opened file breaks, at most `limit`. A number that several vertices show to be too small is told once,
/// with the least that all of them need.
pub fn broken_rules(asset: &Asset<'_>, limit: usize) -> Vec<FormatError> {
    let mut errors: Vec<FormatError> = Vec::new();
    asset.verify(&mut |error| {
        let place = |e: &FormatError| (e.section, e.byte, e.rule);
        // Backwards: what is told again was told last.
        match errors.iter_mut().rev().find(|e| place(e) == place(&error)) {
            Some(told) => {
                if let (Datum::AtLeast(x), Datum::AtLeast(y)) = (error.expected, told.expected)
                    && x > y
                {
                    *told = error;
                }
            }
            None => errors.push(error),
        }
        match errors.len() < limit {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        }
    });
    errors
}

/// Checks a file: broken rules go to `err`, one per line, and so do vertices that a stress run finds
/// outside their spheres.
///
/// # Errors
/// A file that cannot be read, an output stream that fails.
pub fn run(
    arguments: &Arguments,
    out: &mut dyn Write,
    err: &mut dyn Write,
) -> Result<u8, ToolError> {
    let path = arguments.file.display();
    let (mut errors, mut tried) = (Vec::new(), None);
    match AssetFile::read(&arguments.file) {
        Ok(file) => {
            errors = broken_rules(file.asset(), ERRORS_MAX);
            let stopped = errors.len() >= ERRORS_MAX;
            // Bounds that break a rule need not be tried.
            if arguments.stress && errors.is_empty() {
                let summary;
                (errors, summary) = stressed(&file, arguments)?;
                tried = Some(summary);
            }
            for error in &errors {
                let _ = writeln!(err, "{path}: {error}");
            }
            if stopped {
                let _ = writeln!(err, "{path}: stopped after {ERRORS_MAX} broken rules");
            }
        }
        Err(ToolError::Load(error @ LoadError::Format { error: rule, .. })) => {
            let _ = writeln!(err, "{error}");
            errors.push(rule);
        }
        Err(error) => return Err(error),
    }
    let ok = errors.is_empty();
    if arguments.json {
        let report = Report {
            ok,
            errors: errors.iter().map(BrokenRule::from).collect(),
            stress: tried,
        };
        write_json(out, &report)?;
    } else {
        if ok {
            writeln!(out, "{path}: ok").map_err(ToolError::Stdout)?;
        }
        if let Some(tried) = tried {
            for fact in tried.to_string().lines() {
                writeln!(out, "{path}: {fact}").map_err(ToolError::Stdout)?;
            }
        }
    }
    Ok(if ok { DONE } else { BAD_INPUT })
}

/// Tries the bounds of a sound file.
fn stressed(
    file: &AssetFile,
    arguments: &Arguments,
) -> Result<(Vec<FormatError>, Summary), ToolError> {
    let format = |error| file.error(error);
    let asset = file.asset();
    let options = stress::Options {
        cases: arguments.cases,
        seed: arguments.seed,
    };
    let bar = Bar::new();
    bar.stage("cases", Some(options.cases));
    let report = stress::run(asset, options, &|cases| bar.advance(cases));
    bar.clear();
    let report = report.map_err(format)?;
    let slack_rel = stress::rounding_slack(asset, options.seed).map_err(format)?;
    let errors = report.errors(asset);
    Ok((errors, report.summary(asset, options, slack_rel)))
}
