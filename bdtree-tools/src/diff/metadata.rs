//! The metadata: computed errors as numbers, names of files not at all, everything else exactly.

use bdtree_format::{ErrorMetadata, Metadata};

use super::findings::{Findings, largest};
use crate::info::hexadecimal;

/// Everything in the metadata; the builder's version and the source's name are only noted.
pub(super) fn compare(a: &Metadata, b: &Metadata, findings: &mut Findings) {
    if a.builder != b.builder {
        let (a, b) = (&a.builder, &b.builder);
        let note = format!("builder (does not count): {a:?} and {b:?}");
        findings.notes.push(note);
    }
    let both = [a, b];
    if a.source_name != b.source_name {
        let (a, b) = (&a.source_name, &b.source_name);
        let note = format!("name of the source (does not count): {a:?} and {b:?}");
        findings.notes.push(note);
    }
    let hashes = both.map(|m| hexadecimal(&m.source_hash));
    findings.compare("section META: source_hash", hashes);
    findings.compare("section META: basis", both.map(|m| &m.basis));
    findings.compare("section META: settings", both.map(settings));
    findings.compare("section META: modes", both.map(|m| &m.modes));
    let count = both.map(|m| m.warnings.len());
    findings.compare("section META: number of warnings", count);
    let warnings = both.map(|m| {
        let unnamed = |warning: &String| match m.source_name.as_str() {
            "" => warning.clone(),
            name => warning.replace(name, "SOURCE"),
        };
        m.warnings.iter().map(unnamed).collect::<Vec<_>>()
    });
    let warnings = warnings.each_ref().map(Vec::as_slice);
    findings.compare_records("section META: warnings", "warning", warnings);
    match (a.basis_error_rel, b.basis_error_rel) {
        (Some(a), Some(b)) => compare_errors(&a, &b, findings),
        (a, b) => findings.compare("section META: basis_error_rel", [a, b]),
    }
}

/// Settings whose values are names of files: what they held is compared, as fields, frames and hashes.
const FILE_NAMES: [&str; 4] = ["animation", "basis", "frequencies", "tets"];

/// The settings without names of files.
fn settings(metadata: &Metadata) -> Vec<(&String, &String)> {
    let all = metadata.settings.iter();
    all.filter(|(name, _)| !FILE_NAMES.contains(&name.as_str()))
        .collect()
}

/// Where there is a tolerance, the place of the largest error does not count: rounding decides
/// between places that are nearly as bad.
fn compare_errors(a: &ErrorMetadata, b: &ErrorMetadata, findings: &mut Findings) {
    let what = "section META: basis_error_rel";
    let mut numbers = findings.numbers(what, largest([a.max, b.max]));
    numbers.compare(a.max, b.max, || "max".to_string());
    numbers.compare(a.rms, b.rms, || "rms".to_string());
    numbers.finish(findings);
    let places = [a, b].map(|error| (error.frame, error.vertex));
    let what = format!("{what}: frame and vertex");
    if findings.tolerance_rel == 0.0 {
        findings.compare(&what, places);
    } else if places[0] != places[1] {
        let [a, b] = places;
        let note = format!("{what} (does not count): {a:?} and {b:?}");
        findings.notes.push(note);
    }
}
