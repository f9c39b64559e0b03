//! The metadata: everything exactly but computed errors, which are numbers.

use bdtree_format::{ErrorMetadata, Metadata};

use super::findings::{Findings, Numbers, largest};
use crate::info::hexadecimal;

/// Everything in the metadata but the builder's version, which is only noted.
pub(super) fn compare(
    a: Option<&Metadata>,
    b: Option<&Metadata>,
    tolerance_rel: f64,
    findings: &mut Findings,
) {
    let (Some(a), Some(b)) = (a, b) else {
        return; // the section tables differ, or there is none
    };
    if a.builder != b.builder {
        let note = format!(
            "builder (does not count): {:?} and {:?}",
            a.builder, b.builder
        );
        findings.notes.push(note);
    }
    findings.compare("section META: source_name", &a.source_name, &b.source_name);
    findings.compare(
        "section META: source_hash",
        hexadecimal(&a.source_hash),
        hexadecimal(&b.source_hash),
    );
    findings.compare("section META: basis", &a.basis, &b.basis);
    findings.compare("section META: settings", &a.settings, &b.settings);
    findings.compare("section META: modes", &a.modes, &b.modes);
    findings.compare(
        "section META: number of warnings",
        a.warnings.len(),
        b.warnings.len(),
    );
    findings.compare_records(
        "section META: warnings",
        "warning",
        &a.warnings,
        &b.warnings,
    );
    match (a.basis_error_rel, b.basis_error_rel) {
        (Some(a), Some(b)) => compare_errors(&a, &b, tolerance_rel, findings),
        (a, b) => findings.compare("section META: basis_error_rel", a, b),
    }
}

/// Where there is a tolerance, the place of the largest error does not count: rounding decides
/// between places that are nearly as bad.
fn compare_errors(
    a: &ErrorMetadata,
    b: &ErrorMetadata,
    tolerance_rel: f64,
    findings: &mut Findings,
) {
    let what = "section META: basis_error_rel";
    let mut numbers = Numbers::new(what.to_string(), tolerance_rel, largest([a.max, b.max]));
    numbers.compare(a.max, b.max, || "max".to_string());
    numbers.compare(a.rms, b.rms, || "rms".to_string());
    numbers.finish(findings);
    let place = |error: &ErrorMetadata| (error.frame, error.vertex);
    let what = format!("{what}: frame and vertex");
    if tolerance_rel == 0.0 {
        findings.compare(&what, place(a), place(b));
    } else if place(a) != place(b) {
        let note = format!("{what} (does not count): {:?} and {:?}", place(a), place(b));
        findings.notes.push(note);
    }
}
