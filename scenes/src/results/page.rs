//! The text of `docs/measured/results.md`: `page.txt` with the figures of a run, then what the programs print.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::report::{Report, digits};

/// The page with `{/pointer}` where a figure stands: every method, experiment and claim of the paper is a row of it.
const PAGE: &str = include_str!("page.txt");

/// How far rows are that are not wholly built, at the beginning of what shows them.
const PART: &str = "in part: ";
const NOT: &str = "not built yet";

/// The cells of all rows: number, what the paper has, its figure, ours, and what shows it.
pub(super) fn rows() -> impl Iterator<Item = Vec<&'static str>> {
    let inside = PAGE.lines().filter_map(|line| {
        let line = line.strip_prefix("| ")?.strip_suffix(" |")?;
        line.starts_with('P').then_some(line)
    });
    inside.map(|line| line.split(" | ").collect())
}

/// What is wrong with the rows: tests, programs and pages that are named and not there.
pub(super) fn faults() -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut faults = Vec::new();
    for (number, row) in (1..).zip(rows()) {
        let [id, _, _, _, shown] = row[..] else {
            faults.push(format!("{}: {} columns", row[0], row.len()));
            continue;
        };
        if id != format!("P{number:02}") {
            faults.push(format!("{id} stands in the place of P{number:02}"));
        }
        let shown = shown.strip_prefix(PART).unwrap_or(shown).split(", ");
        let own = shown.filter_map(|shown| fault(shown, &root));
        faults.extend(own.map(|fault| format!("{id}: {fault}")));
    }
    faults
}

/// What is wrong with what shows a row, if the repository at `root` does not have it: a link to a test in its file or to
/// a page, or the name of a program.
fn fault(shown: &str, root: &Path) -> Option<String> {
    let link = shown.strip_prefix('[').and_then(|s| s.strip_suffix(')'));
    if let Some((name, file)) = link.and_then(|link| link.split_once("](")) {
        let Ok(text) = fs::read_to_string(root.join("docs/measured").join(file)) else {
            return Some(format!("{file}: cannot be read"));
        };
        let is_there = !name.starts_with('`') || is_test(&text, name.trim_matches('`'));
        return (!is_there).then(|| format!("{file}: has no test {name}"));
    }
    let main = format!("scenes/src/bin/{}/main.rs", shown.trim_matches('`'));
    (shown != NOT && !root.join(&main).is_file()).then(|| format!("{main}: is not there"))
}

/// Whether a function of that name stands right behind an attribute `#[test]`, other attributes between.
fn is_test(text: &str, name: &str) -> bool {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let head = format!("fn {name}(");
    let Some(at) = lines.iter().position(|line| line.starts_with(&head)) else {
        return false;
    };
    let above = lines[..at].iter().rev();
    above
        .take_while(|line| line.starts_with("#["))
        .any(|line| *line == "#[test]")
}

/// How many rows are built how far, and which are not.
pub(super) fn built() -> Value {
    let all: Vec<_> = rows().collect();
    let count = |begin: &str| all.iter().filter(|row| row[4].starts_with(begin)).count();
    let missing = all.iter().filter(|row| row[4] == NOT);
    let missing: Vec<&str> = missing.map(|row| row[0]).collect();
    json!({"rows": all.len(), "whole": all.len() - count(PART) - count(NOT), "part": count(PART), "not": count(NOT),
        "missing": missing.join(", ")})
}

/// A text with what stands in `value` at each `{/pointer}`: text and whole numbers as they are, three digits of other
/// numbers, `?` for what was not measured.
pub(super) fn fill(text: &str, value: &Value) -> String {
    let mut parts = text.split('{');
    let mut filled = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let (pointer, behind) = part.split_once('}').unwrap_or((part, ""));
        filled += &match value.pointer(pointer) {
            Some(Value::String(text)) => text.clone(),
            Some(Value::Number(number)) if number.is_u64() => number.to_string(),
            found => found
                .and_then(Value::as_f64)
                .map_or("?".to_string(), digits),
        };
        filled += behind;
    }
    filled
}

/// The page with what comes from logs, and what no figure is in, written again; the rest stays.
///
/// # Errors
/// A page that has not all other lines and rows.
pub(super) fn refreshed(old: &str, figures: &Value) -> Result<String, String> {
    let (old, tail) = old.split_at(old.find("\n## `").unwrap_or(old.len()));
    let missing = |what: &str| {
        format!(
            "has no line that begins with `{what}`: write the page with a run of `results` without --logs"
        )
    };
    let kept = |begin: &str| {
        let line = old.lines().find(|line| line.starts_with(begin));
        line.ok_or_else(|| missing(begin))
    };
    let mut text = String::new();
    for line in PAGE.lines() {
        let (begin, _) = line.split_once('{').unwrap_or((line, ""));
        if is_of_logs(line) {
            text += &fill(line, figures);
        } else if line.starts_with("| P") {
            let id = line.get(..7).unwrap_or(line);
            let old: Vec<&str> = kept(id)?.split(" | ").collect();
            let cells = line.split(" | ").enumerate();
            let cells: Option<Vec<String>> = cells
                .map(|(at, cell)| match is_of_logs(cell) {
                    true => Some(fill(cell, figures)),
                    false => old.get(at).map(|cell| (*cell).to_string()),
                })
                .collect();
            text += &cells.ok_or_else(|| missing(id))?.join(" | ");
        } else {
            text += kept(begin)?;
        }
        text += "\n";
    }
    Ok(text + tail.strip_prefix('\n').map_or("", |_| tail))
}

/// Whether all figures of a text are those of logs.
fn is_of_logs(text: &str) -> bool {
    let mut pointers = text.split('{').skip(1);
    pointers.all(|pointer| {
        ["/logs/", "/built/"]
            .iter()
            .any(|begin| pointer.starts_with(begin))
    })
}

/// The file of a picture below `images/`, or of a table beside the page.
pub(super) fn file(report: &Report, key: &str, ending: &str) -> String {
    let dash = if key.is_empty() { "" } else { "-" };
    format!("{}{dash}{key}.{ending}", report.name)
}

/// The page of all figures.
pub(super) fn page(figures: &Value, reports: &[Report]) -> String {
    let mut text = fill(PAGE, figures);
    for report in reports {
        let name = report.name;
        let _ = write!(text, "\n## `{name}`\n\n");
        for table in &report.tables {
            let file = file(report, table.key, "csv");
            let _ = writeln!(text, "* [{file}]({file}): {}", table.title);
        }
        for (key, _) in &report.pictures {
            let file = file(report, key, "svg");
            let _ = write!(text, "\n![Curves of {name}](../images/{file})\n");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{built, faults, fill, is_test, rows};
    use serde_json::json;

    #[test]
    fn every_row_names_what_is_there() {
        assert_eq!(faults(), Vec::<String>::new());
        assert_eq!(rows().count(), 61);
        assert_eq!(built()["missing"], "P59");
    }

    #[test]
    fn tests_are_told_from_other_functions() {
        let text = "#[test]\n#[ignore]\nfn one() {}\nfn two() {}\n    #[test]\n    fn three() {}\n";
        assert!(is_test(text, "one") && is_test(text, "three"));
        assert!(!is_test(text, "two") && !is_test(text, "on") && !is_test(text, "four"));
    }

    #[test]
    fn figures_stand_where_they_are_asked_for() {
        let value = json!({"a": {"b": 0.125}, "c": [35827], "d": "so"});
        let text = fill("{/a/b} of {/c/0}, {/d}: {/e}", &value);
        assert_eq!(text, "0.125 of 35827, so: ?");
    }
}
