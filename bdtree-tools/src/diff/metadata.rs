//! The metadata: computed errors as numbers, names of files not at all, everything else exactly.

use std::collections::{BTreeMap, BTreeSet};

use bdtree_format::{ErrorMetadata, Metadata};

use super::findings::Findings;
use super::words::{differences, known};
use crate::info::hexadecimal;
use crate::output::{digits, one_line, printable};

/// Everything in the metadata; the builder's version and the source's name are only noted.
pub(super) fn compare(a: &Metadata, b: &Metadata, findings: &mut Findings) {
    if a.builder != b.builder {
        let (a, b) = (printable(&a.builder), printable(&b.builder));
        let note = format!("builder (does not count): {a} and {b}");
        findings.notes.push(note);
    }
    let both = [a, b];
    if a.source_name != b.source_name {
        let (a, b) = (printable(&a.source_name), printable(&b.source_name));
        let note = format!("name of the source (does not count): {a} and {b}");
        findings.notes.push(note);
    }
    let hashes = both.map(|m| hexadecimal(&m.source_hash));
    findings.compare("section META: source_hash", hashes);
    findings.compare("section META: basis", both.map(|m| printable(&m.basis)));
    let changed = changed_settings(both.map(settings));
    if !changed.is_empty() {
        findings.differ("section META: settings", changed);
    }
    // A different number of modes is told with the header.
    if a.modes != b.modes && a.modes.len() == b.modes.len() {
        let pairs = a.modes.iter().zip(&b.modes).enumerate();
        let differ = pairs.filter(|(_, (a, b))| a != b);
        let differ = differ.map(|(j, (a, b))| format!("mode {j}: {}", differences(a, b)));
        findings.differ("section META: modes", differ.collect());
    }
    let warnings = changed_warnings(both);
    if !warnings.is_empty() {
        findings.differ("section META: warnings", warnings);
    }
    match (a.basis_error_rel, b.basis_error_rel) {
        (Some(a), Some(b)) => compare_errors(&a, &b, findings),
        (a, b) => {
            let told = [a, b].map(|error| known(error.map(|error| digits(error.max))));
            findings.compare("section META: basis_error_rel", told);
        }
    }
}

/// Settings whose values are names of files: what they held is compared, as fields, frames and hashes.
const FILE_NAMES: [&str; 7] = [
    "animation",
    "basis",
    "frequencies",
    "inverse-bind",
    "skin-joints",
    "skin-weights",
    "tets",
];

/// The settings without names of files: of `fix` what stands before `@`, the list of vertices.
fn settings(metadata: &Metadata) -> BTreeMap<&str, String> {
    let all = metadata.settings.iter();
    let all = all.filter(|(name, _)| !FILE_NAMES.contains(&name.as_str()));
    let all = all.map(|(name, value)| {
        let lists = value.split(' ').map(|part| match part.split_once('@') {
            Some((axes, _)) if name == "fix" => format!("{axes}@"),
            _ => part.to_string(),
        });
        let value: Vec<String> = lists.collect();
        (name.as_str(), value.join(" "))
    });
    all.collect()
}

/// A warning without the name of the file that it begins with, `frames:` or `frames/`.
fn without_name(warning: &str, metadata: &Metadata) -> String {
    let files = FILE_NAMES
        .iter()
        .filter_map(|name| metadata.settings.get(*name));
    let mut names = files.chain([&metadata.source_name]);
    let rest = names.find_map(|name| {
        let rest = warning.strip_prefix(name.as_str())?;
        (!name.is_empty() && rest.starts_with([':', '/'])).then_some(rest)
    });
    rest.unwrap_or(warning).to_string()
}

/// The warnings that only one file has, as [`without_name`] compares them; that their order differs where nothing else
/// does.
fn changed_warnings(both: [&Metadata; 2]) -> Vec<String> {
    let unnamed = both.map(|m| {
        let unnamed = m.warnings.iter().map(|warning| without_name(warning, m));
        unnamed.collect::<Vec<_>>()
    });
    let mut changed = Vec::new();
    for (own, other, file) in [(0, 1, "first"), (1, 0, "second")] {
        let mut others = unnamed[other].clone();
        for (warning, unnamed) in both[own].warnings.iter().zip(&unnamed[own]) {
            match others.iter().position(|other| other == unnamed) {
                Some(found) => {
                    others.swap_remove(found);
                }
                None => changed.push(format!("only the {file} file: {}", one_line(warning))),
            }
        }
    }
    if changed.is_empty() && unnamed[0] != unnamed[1] {
        changed.push("in another order".to_string());
    }
    changed
}

/// `setting leaf-size: 4 and 2` for each setting that is not the same in both files.
fn changed_settings([a, b]: [BTreeMap<&str, String>; 2]) -> Vec<String> {
    let names: BTreeSet<&str> = a.keys().chain(b.keys()).copied().collect();
    let values = |name: &str| [a.get(name), b.get(name)];
    let changed = names.into_iter().filter(|name| {
        let [a, b] = values(name);
        a != b
    });
    let line = |name: &str| {
        let told = values(name).map(|value| match value {
            Some(value) => printable(value),
            None => "not set".to_string(),
        });
        format!("setting {}: {}", printable(name), told.join(" and "))
    };
    changed.map(line).collect()
}

/// `frame 19, vertex 3`.
fn place((frame, vertex): (Option<u64>, Option<u64>)) -> String {
    let parts = [("frame", frame), ("vertex", vertex)];
    let parts = parts.map(|(what, number)| Some(format!("{what} {}", number?)));
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    known((!parts.is_empty()).then(|| parts.join(", ")))
}

/// Where there is a tolerance, the place of the largest error does not count: rounding decides
/// between places that are nearly as bad.
fn compare_errors(a: &ErrorMetadata, b: &ErrorMetadata, findings: &mut Findings) {
    let what = "section META: basis_error_rel";
    // Shares of the diagonal: a tolerance is one of the diagonal, too. Against errors that are rounding, nothing would
    // be the same.
    let mut numbers = findings.numbers(what, 1.0);
    numbers.compare(a.max, b.max, || "max".to_string());
    numbers.compare(a.rms, b.rms, || "rms".to_string());
    numbers.finish(findings);
    let places = [a, b].map(|error| (error.frame, error.vertex));
    if findings.tolerance_rel == 0.0 {
        findings.compare(&format!("{what}: frame and vertex"), places.map(place));
    } else if places[0] != places[1] {
        let [a, b] = places.map(place);
        let note = format!("place of the largest error of the basis (does not count): {a} and {b}");
        findings.notes.push(note);
    }
}
