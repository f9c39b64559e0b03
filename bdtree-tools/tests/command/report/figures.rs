//! What holds for the figures and pages of all assets.

use std::collections::BTreeSet;

use serde_json::Value;

pub(super) fn list<'v>(value: &'v Value, name: &str) -> &'v [Value] {
    value[name].as_array().expect("a list")
}

pub(super) fn number(value: &Value, name: &str) -> f64 {
    let number = value[name].as_f64();
    number.unwrap_or_else(|| panic!("{name} of {value} is no number"))
}

/// The figures without what differs between runs: times and what follows from them.
pub(super) fn without_times(value: &Value) -> Value {
    match value {
        Value::Object(map) => {
            const STANDING: [&str; 6] = ["ahead", "below", "above", "from", "to", "break_even"];
            let is_timed = |key: &str| {
                key.contains("micros")
                    || ["seconds", "ratio", "time_rel", "advice", "date", "verdict"].contains(&key)
                    || STANDING.contains(&key)
            };
            let kept = map.iter().filter(|(key, _)| !is_timed(key));
            kept.map(|(key, value)| (key.clone(), without_times(value)))
                .collect()
        }
        Value::Array(all) => all.iter().map(without_times).collect(),
        other => other.clone(),
    }
}

/// Of all levels nothing is missed, and at the last all is exact. Returns them.
pub(super) fn exact_levels(report: &Value) -> &[Value] {
    let depth = list(report, "depth");
    assert_eq!(depth.len() as f64, number(&report["asset"], "depth"));
    let missed = |row: &Value| number(row, "missed_area_rel");
    assert!(depth.iter().all(|row| missed(row) == 0.0));
    let last = depth.last().expect("levels");
    for name in ["extra_area_rel", "penetration_error_rel", "false_rel"] {
        assert_eq!(number(last, name), 0.0, "{name}");
    }
    depth
}

/// What a curve says of itself follows from its points: ratios from 0.9 to 1.1 are noise, equal amounts one, and a last
/// one that alone leaves the noise does not count up to 0.8 and 1.2.
pub(super) fn standing_is_that_of_the_points(curve: &Value) {
    let mut points: Vec<(f64, Vec<f64>)> = Vec::new();
    for point in list(curve, "points") {
        let (amount, log) = (number(point, "amount"), number(point, "ratio").ln());
        match points.last_mut() {
            Some((last, logs)) if *last == amount => logs.push(log),
            Some((last, _)) => {
                assert!(*last < amount, "{curve}");
                points.push((amount, vec![log]));
            }
            None => points.push((amount, vec![log])),
        }
    }
    let ratio = |logs: &[f64]| (logs.iter().sum::<f64>() / logs.len() as f64).exp();
    let mut sides: Vec<(f64, Value)> = points
        .iter()
        .map(|(amount, logs)| {
            let side = match ratio(logs) {
                r if r > 1.1 => "bdtree".into(),
                r if r < 0.9 => "refit".into(),
                _ => Value::Null,
            };
            (*amount, side)
        })
        .collect();
    let is_doubted = points
        .last()
        .is_some_and(|(_, logs)| (0.8..=1.2).contains(&ratio(logs)));
    if let [.., before, last] = &mut sides[..]
        && before.1.is_null()
        && is_doubted
    {
        last.1 = Value::Null;
    }
    let (first, last) = (&sides[0], &sides[sides.len() - 1]);
    assert_eq!(
        (&curve["below"], &curve["above"]),
        (&first.1, &last.1),
        "{curve}"
    );
    let ahead = curve["ahead"].as_str().expect("a word");
    let (from, to) = (curve["from"].as_f64(), curve["to"].as_f64());
    match ahead {
        "bdtree" | "refit" => {
            assert!(sides.iter().all(|s| s.1 == *ahead), "{curve}");
            assert_eq!((from, to), (None, None));
        }
        "crosses" | "partly" | "close" => {
            let (from, to) = (from.expect("an end"), to.expect("an end"));
            assert!(first.0 <= from && from <= to && to <= last.0, "{curve}");
            for (amount, side) in &sides {
                assert!(*amount > from || from == first.0 || *side == first.1);
                assert!(*amount < to || to == last.0 || *side == last.1);
            }
            let is_noise = |s: &(f64, Value)| s.0 <= from || s.0 >= to || s.1.is_null();
            let crosses = !first.1.is_null()
                && !last.1.is_null()
                && first.1 != last.1
                && sides.iter().all(is_noise);
            assert_eq!(crosses, ahead == "crosses", "{curve}");
            let is_close = first.1.is_null() && last.1.is_null();
            assert_eq!(is_close, ahead == "close", "{curve}");
        }
        other => panic!("{other}"),
    }
    let even = curve["break_even"].as_f64();
    assert_eq!(even.is_some(), ahead == "crosses", "{curve}");
    if let (Some(at), Some(from), Some(to)) = (even, from, to) {
        // Two digits: rounded by up to a twentieth.
        assert!((0.95 * from..=1.05 * to).contains(&at), "{curve}");
        assert_eq!(format!("{at:.1e}").parse(), Ok(at));
    }
}

/// Names of all fields, but for options of `bdtree-build`.
fn names(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) => {
            for (name, value) in map {
                found.insert(name.clone());
                if name != "settings" {
                    names(value, found);
                }
            }
        }
        Value::Array(all) => all.iter().for_each(|value| names(value, found)),
        _ => {}
    }
}

/// docs/reference/report.md names every field of a report.
pub(super) fn names_are_documented(report: &Value) {
    let manual = include_str!("../../../../docs/reference/report.md");
    let mut all = BTreeSet::new();
    names(report, &mut all);
    assert!(all.len() > 80);
    for name in all {
        let is_named = ["`", "[]`"]
            .iter()
            .any(|end| manual.contains(&format!("`{name}{end}")));
        assert!(is_named, "docs/reference/report.md does not name {name}");
    }
}

/// Number of cells of all tables.
pub(super) fn cells(page: &str) -> usize {
    page.matches("<td").count()
}

/// All numbers of a value.
fn numbers(value: &Value, found: &mut Vec<f64>) {
    match value {
        Value::Object(map) => map.values().for_each(|value| numbers(value, found)),
        Value::Array(all) => all.iter().for_each(|value| numbers(value, found)),
        other => found.extend(other.as_f64()),
    }
}

/// The numbers in the number cells of a page's tables, with the digits that are shown.
fn shown(page: &str) -> Vec<f64> {
    let cells = page.split("<td>").skip(1);
    let cells = cells.filter_map(|rest| rest.split("</td>").next());
    let parts = cells.flat_map(|cell| cell.split('/'));
    let numbers = parts.filter_map(|part| {
        // Per cent below what is shown are no number.
        let text = part.replace([' ', '\u{202f}', '%'], "");
        text.replace('\u{2212}', "-").parse().ok()
    });
    numbers.collect()
}

/// Every number of the page's tables is one of the figures, or a hundred times one (per cent), to the digits shown.
pub(super) fn numbers_are_the_figures(page: &str, report: &Value) {
    let mut figures = Vec::new();
    numbers(report, &mut figures);
    let shown = shown(page);
    assert!(shown.len() > 100);
    for number in shown {
        let is_it = |figure: &f64| (figure - number).abs() <= 6e-3 * number.abs();
        let is_one = figures.iter().any(|x| is_it(x) || is_it(&(100.0 * x)));
        assert!(is_one, "{number} is on the page alone");
    }
}
