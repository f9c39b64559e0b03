//! `docs/results.md`: the paper's rows beside ours, from one run of all programs.

mod goals;
mod measured;
mod page;
mod pile;
mod rows;
mod shown;
mod updates;

use std::error::Error;
use std::path::{Path, PathBuf};

use bdtree_measure::machine;
use clap::Parser;
use serde_json::json;

use crate::report::{commit, write};
use crate::{curtain, growth, tables};
use measured::Measured;
use page::{page, picture};
use rows::{Built, SECTIONS};

/// Runs the paper's experiments and writes docs/results.md with its pictures
#[derive(Debug, Clone, Parser)]
pub struct Arguments {
    /// Small meshes and few repetitions: to try it out
    #[arg(long)]
    pub small: bool,
    /// Folder for results.md and images/
    #[arg(long, default_value = "docs")]
    pub docs: PathBuf,
    /// Folder for the programs' JSON, CSV and SVG files
    #[arg(long, default_value = "target/results")]
    pub out: PathBuf,
}

/// What is wrong with the rows: tests, programs and pages that are named and not there.
pub fn faults() -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut faults = Vec::new();
    let rows = SECTIONS.iter().flat_map(|(_, rows)| rows.iter());
    for (number, row) in (1..).zip(rows) {
        if row.id != format!("P{number:02}") {
            faults.push(format!("{} stands in the place of P{number:02}", row.id));
        }
        if row.shown.is_empty() != (row.built == Built::Not) {
            faults.push(format!(
                "{}: shown by nothing, or shown and not built",
                row.id
            ));
        }
        let own = row.shown.iter().filter_map(|shown| shown.fault(&root));
        faults.extend(own.map(|fault| format!("{}: {fault}", row.id)));
    }
    faults
}

/// Runs everything and writes the page.
///
/// # Errors
/// Rows that name what is not there; those of the programs; files that cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let faults = faults();
    if !faults.is_empty() {
        return Err(faults.join("\n").into());
    }
    // As on the command line, so that defaults stand in one place.
    let (curtain, tables, growth): (&[&str], &[&str], &[&str]) = if arguments.small {
        (
            &["", "--triangles", "3000", "--frames", "60", "--repeat", "3"],
            &[
                "",
                "--meshes",
                "chair",
                "--amplitudes",
                "0.05,0.2",
                "--poses",
                "1",
                "--pair-vertices",
                "64",
            ],
            &[
                "",
                "--triangles",
                "2000,8000",
                "--contacts",
                "30",
                "--body-triangles",
                "1280",
                "--repeat",
                "1",
            ],
        )
    } else {
        (&[""], &[""], &[""])
    };
    let repeats = if arguments.small { 1 } else { 8 };
    // First what is timed most finely.
    let chair = tables::chair()?;
    let updates = updates::measure(chair.asset(), repeats)?;
    let reports = [
        curtain::run(&curtain::Arguments::parse_from(curtain))?,
        growth::run(&growth::Arguments::parse_from(growth))?,
        tables::run(&tables::Arguments::parse_from(tables))?,
    ];
    let pile = pile::measure(2 * repeats)?;
    // Before a tracked file is written again.
    let commit = commit();
    for report in &reports {
        report.write(&arguments.out)?;
    }
    for report in &reports {
        for (key, svg) in &report.pictures {
            let path = arguments.docs.join("images").join(picture(report, key));
            write(&path, svg)?;
        }
    }
    let [curtain, growth, tables] = &reports;
    let measured = Measured(json!({"curtain": curtain.value, "growth": growth.value,
        "tables": tables.value, "updates": updates, "pile": pile}));
    let json = json!({"program": "results", "machine": machine::processor(), "commit": &commit,
        "results": measured.0});
    let path = arguments.out.join("results.json");
    write(&path, &format!("{json:#}\n"))?;
    let path = arguments.docs.join("results.md");
    write(&path, &page(&measured, &reports, &commit))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{faults, rows::SECTIONS};

    #[test]
    fn every_row_names_what_is_there() {
        assert_eq!(faults(), Vec::<String>::new());
        let count: usize = SECTIONS.iter().map(|(_, rows)| rows.len()).sum();
        assert_eq!(count, 61);
    }
}
