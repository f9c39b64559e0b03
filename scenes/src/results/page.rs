//! The text of `docs/results.md`.

use std::fmt::Write;

use bdtree_measure::machine;

use super::goals::goals;
use super::measured::Measured;
use super::rows::{Built, SECTIONS};
use crate::report::Report;

/// The command of the page.
const COMMAND: &str = "cargo run --release -p bdtree-scenes --bin results";

/// The file of a picture below `images/`.
pub(super) fn picture(report: &Report, key: &str) -> String {
    let dash = if key.is_empty() { "" } else { "-" };
    format!("{}{dash}{key}.svg", report.name)
}

/// The page.
pub(super) fn page(measured: &Measured, reports: &[Report], commit: &str) -> String {
    let all = || SECTIONS.iter().flat_map(|(_, rows)| rows.iter());
    let count = |built: Built| all().filter(|row| row.built == built).count();
    let missing: Vec<&str> = all()
        .filter(|r| r.built == Built::Not)
        .map(|r| r.id)
        .collect();
    let mut text = format!(
        "# The paper's figures and ours\n\n\
         D. L. James and D. K. Pai, *BD-Tree: Output-Sensitive Collision Detection for Reduced Deformable \
         Models*, SIGGRAPH 2004, row by row. Written by\n\n    {COMMAND}\n\n\
         on {}, at commit `{}`. Counts and radii are the same in every run; times are medians, and of a machine \
         that does other work. A program named in the last column is `cargo run --release -p bdtree-scenes --bin NAME`, \
         with its own `--help`; a test is checked to exist when this page is written.\n\n\
         {} rows are shown, {} in part, {} not built yet: {}.\n",
        machine::processor(),
        commit,
        count(Built::Whole),
        count(Built::Part),
        missing.len(),
        missing.join(", "),
    );
    text += &goals(measured);
    for (section, rows) in SECTIONS {
        let _ = write!(
            text,
            "\n## {section}\n\n| row | what | the paper | ours | shown by |\n|---|---|---|---|---|\n"
        );
        for row in rows {
            let shown: Vec<String> = row.shown.iter().map(|s| s.markdown()).collect();
            let shown = match row.built {
                Built::Not => "not built yet".to_string(),
                Built::Part => format!("in part: {}", shown.join(", ")),
                Built::Whole => shown.join(", "),
            };
            let ours = (row.ours)(measured).replace('|', "\\|");
            let what = row.what.replace('|', "\\|");
            let _ = writeln!(
                text,
                "| {} | {what} | {} | {ours} | {shown} |",
                row.id, row.paper
            );
        }
    }
    for report in reports {
        let _ = write!(
            text,
            "\n## What `{}` prints\n\n{}",
            report.name,
            report.markdown()
        );
        for (key, _) in &report.pictures {
            let file = picture(report, key);
            let _ = write!(text, "\n![Curves of {}](images/{file})\n", report.name);
        }
    }
    text
}
