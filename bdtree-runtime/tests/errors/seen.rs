//! A sound file, and the rules of the errors that others lead to.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use bdtree_fixtures::rules::several;
use bdtree_runtime::{Datum, FormatError, Model};

/// Several nodes, six local modes, frames, groups, mass and momenta, metadata.
pub(crate) static FILE: LazyLock<Model> =
    LazyLock::new(|| Model::from_bytes(&several()).expect("a sound file"));

/// The rules of the errors seen so far; each error's text is checked when it is noted.
#[derive(Default)]
pub(crate) struct Seen(pub(crate) BTreeSet<String>);

impl Seen {
    pub(crate) fn note(&mut self, error: &FormatError) {
        let text = error.to_string();
        // What a caller gave has no place in the file.
        let arguments = [
            "SPEC 7.1: a vertex id",
            "SPEC 7.2: a triangle id",
            "argument",
        ];
        if arguments.iter().any(|rule| error.rule.starts_with(rule)) {
            let told = ["there is no ", "argument `out` holds "];
            assert!(told.iter().any(|start| text.starts_with(start)), "{text}");
            self.0.insert(error.rule.to_string());
            return;
        }
        let place = format!("section {} at byte {}: ", error.section, error.byte);
        let rest = text.strip_prefix(&place).expect("the place comes first");
        let fault = rest.strip_suffix(&format!(" ({})", error.rule));
        let fault = fault.expect("the rule comes last");
        let number = |datum| match datum {
            Datum::Integer(x) => x,
            other => panic!("{other} is no whole number"),
        };
        let least = |datum| match datum {
            Datum::AtLeast(x) => x,
            other => panic!("{other} is no least number"),
        };
        let (expected, found) = (error.expected, error.found);
        let told = match &error.rule[..8] {
            _ if error.rule.contains("magic bytes") => {
                "not a .bdt file, or one that was transferred as text".to_string()
            }
            "SPEC 9.1" => {
                format!("format version {found} is not supported (this program reads {expected})")
            }
            "SPEC 2.4" if error.rule.contains("CRC-32") => format!(
                "checksum mismatch: the header says {:08x}, the bytes give {:08x}",
                number(found),
                number(expected)
            ),
            "SPEC 4.1" if error.rule.contains("checksum") => format!(
                "checksum mismatch: the section table says {:08x}, the bytes give {:08x}",
                number(expected),
                number(found)
            ),
            "SPEC 2.1" if error.rule.contains("whole header") => {
                format!(
                    "the file has {found} bytes, its header needs {}",
                    least(expected)
                )
            }
            "SPEC 3.4" if error.rule.contains("header block") => format!(
                "the file has {found} bytes, its header and tables need {}",
                least(expected)
            ),
            "SPEC 3.4" if error.rule.contains("file_bytes") => {
                format!("the file has {found} bytes, its header says {expected}")
            }
            _ => format!("found {found}, expected {expected}"),
        };
        assert_eq!(fault, told);
        self.0.insert(error.rule.to_string());
    }
}
