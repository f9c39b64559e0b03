//! `--advise`: the same source, but instead of a file the command line that bakes it best.

mod command;

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

use bdtree_build::advise::subject::kept_fields;
use bdtree_build::advise::{Advice, AdviceError, Goal, Subject, advise};
use bdtree_build::error::{BakeError, Place};
use bdtree_build::progress::Progress;
use bdtree_build::recipe::{Recipe, Source};
use serde_json::{Value, json};

use super::Arguments;
use super::arguments::Modes;
use super::output::{print_warnings, to_stdout};

/// Numbers of modes that `--json` has figures of.
const CURVE_POINTS: usize = 6;

/// Advice and the command line that follows it.
pub(super) struct Advised {
    advice: Advice,
    command: Vec<OsString>,
    warnings: Vec<String>,
}

pub(super) fn run(
    arguments: &Arguments,
    recipe: &Recipe,
    progress: &dyn Progress,
) -> Result<Advised, BakeError> {
    let is_open = arguments.modes() == Modes::Unsaid;
    let max_error_rel = arguments.goal();
    let subject = Subject::of_recipe(recipe, is_open.then_some(max_error_rel), progress)?;
    // What --max-error-rel alone would keep, where any field may go and not only the last ones.
    let subset = || {
        let kind = &subject.provenance.kind;
        kept_fields(kind, &subject.mesh, &subject.basis, max_error_rel)
    };
    let goal = Goal {
        max_error_rel,
        subset: is_open.then(subset).flatten(),
        leaf_sizes: match arguments.leaf_size {
            Some(_) => Vec::new(),
            None => Goal::default().leaf_sizes,
        },
        curve_points: if arguments.json { CURVE_POINTS } else { 0 },
        ..Goal::default()
    };
    let advice = advise(&subject, &goal, progress).map_err(|error| match error {
        AdviceError::Bake(error) => error.in_file(recipe.source.main_file()),
        other => BakeError::one("advise", Place::NOWHERE, other.to_string()),
    })?;
    Ok(Advised {
        command: command::recommended(std::env::args_os(), &advice),
        advice,
        warnings: subject.provenance.warnings,
    })
}

impl Advised {
    /// Sentences and the command on the last line, or one JSON object. A reader that closes the pipe is no error.
    pub(super) fn print(&self, source: &Source, is_json: bool) -> ExitCode {
        if !is_json {
            print_warnings(&self.warnings, source);
        }
        to_stdout(|out| {
            if is_json {
                writeln!(out, "{}", self.json())
            } else {
                self.text(out)
            }
        })
    }

    fn text(&self, out: &mut impl Write) -> std::io::Result<()> {
        for sentence in self.advice.sentences() {
            writeln!(out, "{sentence}")?;
        }
        writeln!(out, "{}", command::shell(&self.command))
    }

    fn json(&self) -> Value {
        let advice = &self.advice;
        let (source, count) = advice.samples;
        let arguments = self.command.iter().map(|part| part.to_string_lossy());
        json!({
            "command": command::shell(&self.command),
            "arguments": arguments.collect::<Vec<_>>(),
            "sentences": advice.sentences(),
            "max_error_rel": advice.max_error_rel,
            "is_met": advice.is_met,
            "error_rel": advice.error_rel,
            "error_of_fewer_rel": advice.error_of_fewer_rel,
            "error_over": advice.over,
            "samples": { "source": source, "count": count, "bones": advice.bones },
            "modes": advice.chosen.modes.len(),
            "leaf_size": advice.chosen.leaf_size,
            "chosen": advice.chosen,
            "all": advice.all,
            "leaves": advice.leaves,
            "curve": advice.curve,
            "refining": advice.refining,
            "missing": advice.missing,
            "warnings": self.warnings,
        })
    }
}
