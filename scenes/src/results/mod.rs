//! `docs/measured/results.md`: the paper's rows beside ours, from one run of all programs and from the logs of longer runs.

mod figures;
mod logs;
mod page;
mod updates;

use std::error::Error;
use std::fs;
use std::iter::once;
use std::path::PathBuf;

use bdtree_measure::machine;
use clap::Parser;
use serde_json::{Value, json};

use crate::report::{Report, commit, write};
use crate::{curtain, growth, tables};
use page::{faults, file, page, refreshed};

/// Runs the paper's experiments and writes docs/measured/results.md with its pictures
#[derive(Debug, Clone, Parser)]
pub struct Arguments {
    /// Small meshes and few repetitions: to try it out
    #[arg(long)]
    pub small: bool,
    /// Runs nothing: of the page, only what comes from the logs is written again
    #[arg(long, conflicts_with_all = ["small", "out"])]
    pub logs: bool,
    /// Folder of the pages: results.md and its tables (CSV) are written below measured/, its curves below images/; logs are
    /// read from measured/logs/
    #[arg(long, default_value = "docs")]
    pub docs: PathBuf,
    /// Folder for the programs' JSON, CSV and SVG files
    #[arg(long, default_value = "target/results")]
    pub out: PathBuf,
}

/// Runs everything and writes the page.
///
/// # Errors
/// Rows that name what is not there; damaged logs; those of the programs; files that cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let faults = faults();
    if !faults.is_empty() {
        return Err(faults.join("\n").into());
    }
    let logs = logs::figures(&arguments.docs.join("measured/logs"))?;
    let place = arguments.docs.join("measured/results.md");
    if arguments.logs {
        let old = fs::read_to_string(&place).map_err(|e| format!("{}: {e}", place.display()))?;
        let page = refreshed(&old, &json!({"logs": logs, "built": page::built()}))
            .map_err(|why| format!("{}: {why}", place.display()))?;
        return write(&place, &page);
    }
    // As on the command line, so that defaults stand in one place.
    let options = if arguments.small {
        [
            "--triangles 3000 --frames 60 --repeat 3",
            "--triangles 2000,8000 --contacts 30 --body-triangles 1280 --repeat 1",
            "--meshes chair --amplitudes 0.05,0.2 --poses 1 --pair-vertices 64",
        ]
    } else {
        [""; 3]
    };
    let [curtain, growth, tables] = options.map(|own| once("").chain(own.split_whitespace()));
    let repeats = if arguments.small { 1 } else { 8 };
    // First what is timed most finely.
    let chair = tables::chair()?;
    let updates = updates::measure(chair.asset(), repeats)?;
    let reports = [
        curtain::run(&curtain::Arguments::parse_from(curtain))?,
        growth::run(&growth::Arguments::parse_from(growth))?,
        tables::run(&tables::Arguments::parse_from(tables))?,
    ];
    let [of_curtain, of_growth, of_tables] = &reports;
    let all = Report {
        name: "results",
        value: json!({"curtain": of_curtain.value, "growth": of_growth.value,
            "tables": of_tables.value, "updates": updates}),
        tables: Vec::new(),
        pictures: Vec::new(),
    };
    // Before a tracked file is written again.
    let commit = commit();
    for report in reports.iter().chain([&all]) {
        report.write(&arguments.out)?;
    }
    for report in &reports {
        for (key, svg) in &report.pictures {
            let path = arguments.docs.join("images").join(file(report, key, "svg"));
            write(&path, svg)?;
        }
        for table in &report.tables {
            let path = arguments
                .docs
                .join("measured")
                .join(file(report, table.key, "csv"));
            write(&path, &table.csv())?;
        }
    }
    let page = page(&figures(all.value, logs, &commit), &reports);
    write(&place, &page)
}

/// All figures of the page: what was measured, and what follows from it.
fn figures(mut measured: Value, logs: Value, commit: &str) -> Value {
    let mut rows = figures::of_rows(&measured);
    rows["goals"] = json!(figures::of_goals(&measured));
    rows["logs"] = logs;
    rows["built"] = page::built();
    rows["machine"] = json!(machine::processor());
    rows["commit"] = json!(commit);
    if let (Some(all), Some(rows)) = (measured.as_object_mut(), rows.as_object_mut()) {
        all.append(rows);
    }
    measured
}
