//! `bdtree diff`: whether two files hold the same asset.
//!
//! Structure (counts, sections, tree, triangles, groups, frames, names, settings) is compared exactly,
//! numbers within a tolerance relative to a scale. File length, offsets and checksums follow from
//! the rest and are not compared. The builder's version and the names of the files that were baked do not count, so
//! that a new builder that bakes the same, and a renamed source, are seen to do so.

mod effects;
mod findings;
mod frames;
mod mass;
mod metadata;
mod numbers;
mod skin;
mod structure;
mod words;

pub use effects::Effect;
pub use findings::{Difference, Findings};

use std::io::Write;

use serde::Serialize;

use crate::AssetFile;
pub use crate::cli::DiffArguments as Arguments;
use crate::error::ToolError;
use crate::info;
use crate::output::{digits, write_json};
use words::short;

/// Exit code: nothing that counts differs.
pub const SAME: u8 = 0;
/// Exit code: something differs.
pub const DIFFER: u8 = 1;

/// How the note begins that tells what could not be compared.
const NOT_COMPARED: &str = "not compared, since the structure differs: ";

/// Compares two files and prints each kind of difference with its first places.
///
/// Both are verified first: what is compared leaves out checksums and padding, so that a damaged copy would pass as the
/// same.
///
/// # Errors
/// A file that cannot be read or breaks a rule of the format, an output stream that fails.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<u8, ToolError> {
    let (a, b) = (AssetFile::map(&arguments.a)?, AssetFile::map(&arguments.b)?);
    a.verify()?;
    b.verify()?;
    let findings = compare(&a, &b, arguments.tolerance_rel)?;
    if arguments.json {
        write_json(
            out,
            &Json {
                same: findings.is_same(),
                findings: &findings,
            },
        )?;
    } else {
        print(&findings, out).map_err(ToolError::Stdout)?;
    }
    Ok(if findings.is_same() { SAME } else { DIFFER })
}

/// Everything that differs between two files that keep the format's rules.
///
/// # Errors
/// One that does not, as far as the comparison meets it.
pub fn compare(
    file_a: &AssetFile,
    file_b: &AssetFile,
    tolerance_rel: f64,
) -> Result<Findings, ToolError> {
    let (a, b) = (file_a.asset(), file_b.asset());
    let metadata_a = info::metadata(file_a)?;
    let metadata_b = info::metadata(file_b)?;
    let mut findings = Findings {
        tolerance_rel,
        ..Findings::default()
    };
    let comparable = structure::compare(a, b, &mut findings);
    numbers::compare_header(a, b, &mut findings);
    if comparable.modes {
        numbers::compare_modes(a, b, &mut findings);
    }
    if comparable.rows {
        let rows = numbers::compare_rows(a, b, &mut findings);
        rows.map_err(|error| file_a.error(error))?;
    }
    if comparable.vertices {
        numbers::compare_positions(a, b, &mut findings);
    }
    if comparable.modes {
        numbers::compare_displacements([file_a, file_b], &mut findings)?;
    }
    mass::compare(a, b, &mut findings);
    if comparable.frames {
        frames::compare(a, b, &mut findings);
    }
    skin::compare(a, b, &mut findings);
    let animated = a.frame_count() + b.frame_count() > 0;
    let not_compared = [
        ("rest positions", comparable.vertices),
        ("ranges and displacements of modes", comparable.modes),
        ("spheres of the tree", comparable.rows),
        ("frames of the animation", comparable.frames || !animated),
    ];
    let not_compared = not_compared.iter().filter(|(_, compared)| !compared);
    let not_compared: Vec<&str> = not_compared.map(|(what, _)| *what).collect();
    // The section tables differ where only one has metadata.
    if let (Some(a), Some(b)) = (&metadata_a, &metadata_b) {
        metadata::compare(a, b, &mut findings);
    }
    if comparable.vertices && !findings.is_same() {
        findings.effects =
            effects::effects([file_a, file_b], comparable.modes, &findings.differences)?;
    }
    if !not_compared.is_empty() {
        let note = format!("{NOT_COMPARED}{}", not_compared.join(", "));
        findings.notes.push(note);
    }
    Ok(findings)
}

/// What `--json` prints.
#[derive(Serialize)]
struct Json<'f> {
    same: bool,
    #[serde(flatten)]
    findings: &'f Findings,
}

fn print(findings: &Findings, out: &mut dyn Write) -> std::io::Result<()> {
    let is_last = |note: &&String| note.starts_with(NOT_COMPARED);
    for note in findings.notes.iter().filter(|note| !is_last(note)) {
        writeln!(out, "{note}")?;
    }
    for effect in &findings.effects {
        let at = effect.q.map_or(String::new(), |q| {
            format!(", at q = {} (its q_range)", digits(q.into()))
        });
        let negated = effect.negated_distance.map_or(String::new(), |distance| {
            let left = match distance {
                0.0 => "nothing".to_string(),
                distance => format!("{} mesh units", short(distance)),
            };
            format!("; the mode is negated: -q leaves {left}")
        });
        let tolerated = if effect.tolerated { " (tolerated)" } else { "" };
        writeln!(
            out,
            "{}: vertex {} lies farthest apart, by {} mesh units ({} % of the diagonal){at}{negated}{tolerated}",
            effect.what,
            effect.vertex,
            short(effect.distance),
            short(100.0 * effect.distance_rel)
        )?;
    }
    for difference in &findings.differences {
        writeln!(out, "{difference}")?;
    }
    for note in findings.notes.iter().filter(is_last) {
        writeln!(out, "{note}")?;
    }
    match findings.tolerated_rel {
        _ if !findings.is_same() => Ok(()),
        0.0 => writeln!(out, "same"),
        rel => writeln!(
            out,
            "same: numbers differ by at most {} of their scale",
            short(rel)
        ),
    }
}
