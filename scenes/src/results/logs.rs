//! Figures of runs that take longer than all programs together, read from the logs that were kept of them.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use bdtree_measure::stats::median;
use serde_json::{Map, Value, json};

use super::figures::reached;
use crate::logs::file::LogFile;
use crate::logs::ratios::VARIANTS;

/// Names of figures, and the logs that they are from.
const LOGS: [(&str, &str); 5] = [
    ("few", "chairs-12.csv.gz"),
    ("chairs", "chairs-3601.csv.gz"),
    ("ratios", "chairs-ratios.csv"),
    ("pictures", "chairs-pictures.csv"),
    ("fish", "fish.csv.gz"),
];

/// Figures of all logs in a folder; those of logs that are not there are missing.
///
/// # Errors
/// A log that is damaged or of something else, with file and line.
pub(super) fn figures(folder: &Path) -> Result<Value, Box<dyn Error>> {
    let mut all = Map::new();
    let mut list = Vec::new();
    for (key, name) in LOGS {
        let path = folder.join(name);
        if !path.is_file() {
            eprintln!("{}: is not there; its figures are `?`", path.display());
            continue;
        }
        let log = LogFile::read(&path)?;
        let value = match key {
            "ratios" => ratios(&log),
            "pictures" => pictures(&log),
            _ => run(&log),
        };
        let wrong = |why| format!("{}: {why}", path.display());
        all.insert(key.to_string(), value.map_err(wrong)?);
        list.push(format!("* [{name}](logs/{name}): {}", about(&log)));
    }
    all.insert("list".to_string(), json!(list.join("\n")));
    let mut all = Value::Object(all);
    all["goals"] = json!(goals(&all));
    Ok(all)
}

/// The program and what it ran on.
fn about(log: &LogFile) -> String {
    let said = |key: &'static str| log.said(key).map(move |value| (key, value));
    let mut words: Vec<String> = (said("command").take(1).chain(said("program")).take(1))
        .map(|(_, value)| format!("`{value}`"))
        .collect();
    words.extend(log.said("part").map(str::to_string));
    let own = ["commit", "threads", "machine", "adapter", "size"];
    let own = own.into_iter().flat_map(said);
    words.extend(own.map(|(key, value)| format!("{key} {value}")));
    let load = log.said("load at begin and end");
    words.extend(load.map(|load| format!("load {load}")));
    words.join("; ")
}

/// A column that must be there.
fn column(log: &LogFile, name: &str) -> Result<Vec<f64>, String> {
    let found = log.column(name).filter(|column| !column.is_empty());
    found.ok_or_else(|| format!("has no rows with a column `{name}`"))
}

fn mean(all: &[f64]) -> f64 {
    all.iter().sum::<f64>() / all.len() as f64
}

fn most(all: &[f64]) -> f64 {
    all.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// A run of falling bodies.
fn run(log: &LogFile) -> Result<Value, String> {
    let said = |key: &str| -> Value {
        let json = log.said(key).next().map(serde_json::from_str);
        json.and_then(Result::ok).unwrap_or(Value::Null)
    };
    let mut columns = BTreeMap::new();
    for name in &log.columns {
        let all = column(log, name)?;
        columns.insert(
            name,
            json!({"sum": all.iter().sum::<f64>(), "mean": mean(&all), "median": median(&all), "most": most(&all)}),
        );
    }
    let sum = |name: &str| Ok::<f64, String>(column(log, name)?.iter().sum());
    let (seconds, events) = (sum("seconds")?, sum("events")?);
    let percent = |name: &str| {
        let all = column(log, name)?;
        Ok::<Value, String>(json!({"mean": 100.0 * mean(&all), "most": 100.0 * most(&all)}))
    };
    let updated = column(log, "nodes_updated")?;
    let still = updated.iter().filter(|nodes| **nodes == 0.0).count();
    let mut figures = json!({
        "columns": columns, "steps": log.rows.len(), "hours": seconds / 3600.0,
        "events_per_s": events / seconds, "events_millions": 1e-6 * events,
        "updated": percent("updated_share")?, "updated_to_level": percent("updated_share_to_level")?,
        "still": 100.0 * still as f64 / updated.len() as f64,
        "memory_mb": said("memory after the last step, bytes").as_f64().map(|bytes| 1e-6 * bytes),
        "settings": said("settings"), "spheres": said("spheres"), "pictures": said("pictures"),
    });
    if let (Ok(fish), Ok(triangles)) = (sum("fish_seconds"), sum("triangle_seconds")) {
        figures["triangle_share"] = json!(100.0 * triangles / (fish + triangles));
    }
    let pictures = &figures["pictures"];
    let number = |at: &str| pictures.pointer(at).and_then(Value::as_f64);
    let millions = ["/triangles", "/triangles_of_all"].map(|at| number(at).map(|n| 1e-6 * n));
    let left_out = number("/left_out_by_sphere").zip(number("/left_out_by_tree"));
    figures["drawn"] = json!({"millions": millions[0], "millions_of_all": millions[1],
        "left_out": left_out.map(|(sphere, tree)| sphere + tree)});
    Ok(figures)
}

/// Deformable chairs beside rigid ones: of each window the median of its repetitions, and all windows together.
fn ratios(log: &LogFile) -> Result<Value, String> {
    let windows = column(log, "step")?;
    let mut begins = windows.clone();
    begins.sort_by(f64::total_cmp);
    begins.dedup();
    let of_windows = |name: &str| -> Result<Vec<f64>, String> {
        let all = column(log, name)?;
        let window = |begin: &f64| {
            let own = windows.iter().zip(&all).filter(|(step, _)| *step == begin);
            median(&own.map(|(_, x)| *x).collect::<Vec<_>>())
        };
        Ok(begins.iter().map(window).collect())
    };
    let mut seconds = Vec::new();
    let mut events = Vec::new();
    for variant in VARIANTS {
        seconds.push(of_windows(&format!("{variant}_s"))?);
        events.push(of_windows(&format!("{variant}_events"))?);
    }
    let over = |a: &[f64], b: &[f64]| mean(a) / mean(b);
    let [deformable, rigid, redundant] = [0, 1, 2].map(|variant| &seconds[variant]);
    let per_step = over(deformable, rigid);
    let more = over(redundant, rigid);
    let each: Vec<f64> = deformable.iter().zip(rigid).map(|(a, b)| a / b).collect();
    let least = each.iter().copied().fold(f64::INFINITY, f64::min);
    let us = |variant: usize| 1e6 * over(&seconds[variant], &events[variant]);
    Ok(json!({
        "windows": begins.len(), "per_step": per_step, "per_event": us(0) / us(1),
        "least_per_step": least, "most_per_step": most(&each),
        "redundant": more, "redundant_percent": 100.0 * (more - 1.0),
        "ms": seconds.iter().map(|all| 1e3 * mean(all)).collect::<Vec<_>>(),
        "events": events.iter().map(|all| mean(all)).collect::<Vec<_>>(),
        "us_per_event": [us(0), us(1), us(2)],
    }))
}

/// Pictures of chairs.
fn pictures(log: &LogFile) -> Result<Value, String> {
    let mean_of = |name: &str| Ok::<f64, String>(mean(&column(log, name)?));
    let left_out = mean_of("left_out_by_sphere")? + mean_of("left_out_by_tree")?;
    Ok(json!({
        "pictures": log.rows.len(), "seconds": mean_of("seconds")?,
        "median_seconds": median(&column(log, "seconds")?), "bodies": mean_of("bodies")?,
        "left_out": left_out, "contacts": mean_of("contacts")?,
        "millions": 1e-6 * mean_of("triangles")?,
        "adapter": log.said("adapter").next(), "size": log.said("size").next(),
    }))
}

/// Of each goal whether it is reached.
fn goals(all: &Value) -> [String; 3] {
    let limits = [("per_step", 1.3), ("per_event", 1.2), ("redundant", 1.2)];
    limits.map(|(name, limit)| reached(all["ratios"][name].as_f64(), limit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::page::refreshed;

    fn log(about: &[(&str, &str)], columns: &[&str], rows: &[&[f64]]) -> LogFile {
        let mut log = LogFile {
            columns: columns.iter().map(|name| (*name).to_string()).collect(),
            rows: rows.iter().map(|row| row.to_vec()).collect(),
            ..LogFile::default()
        };
        for (key, value) in about {
            log.say(key, value);
        }
        log
    }

    const STEPS: [&str; 6] = [
        "step",
        "events",
        "nodes_updated",
        "updated_share",
        "updated_share_to_level",
        "seconds",
    ];

    /// A page that was written before there were logs.
    fn page() -> String {
        let text = include_str!("page.txt");
        text.replace('{', "old{") + "\n## `curtain`\n\nas before\n"
    }

    #[test]
    fn rows_are_filled_from_logs() {
        let folder = tempfile::tempdir().expect("a folder");
        let keep = |name: &str, log: &LogFile| {
            log.write(&folder.path().join(name)).expect("written");
        };
        let chairs = log(
            &[
                ("command", "chairs --bodies 3601"),
                ("part", "from step 1: commit abc"),
                ("memory after the last step, bytes", "250000000"),
                ("settings", r#"{"bodies": 3601}"#),
            ],
            &STEPS,
            &[
                &[1.0, 2e6, 8.0, 0.5, 0.5, 1800.0],
                &[2.0, 4e6, 0.0, 0.0, 0.0, 5400.0],
            ],
        );
        keep("chairs-3601.csv.gz", &chairs);
        let few = log(
            &[("command", "chairs --bodies 12")],
            &STEPS,
            &[&[1.0, 1.0, 2.0, 0.25, 0.75, 0.1]],
        );
        keep("chairs-12.csv.gz", &few);
        let pictures = r#"{"left_out_by_sphere": 7.0, "left_out_by_tree": 2.0, "triangles": 5e6,
            "triangles_of_all": 3e8, "pictures": 1}"#;
        let about = [
            ("settings", r#"{"bodies": 12000}"#),
            ("spheres", r#"{"count": 64}"#),
            ("pictures", pictures),
        ];
        let columns = [&STEPS[..], &["fish_seconds", "triangle_seconds"]].concat();
        let row = [1.0, 9.0, 2.0, 0.25, 0.75, 0.5, 0.2, 0.6];
        keep("fish.csv.gz", &log(&about, &columns, &[&row]));
        let columns = [
            "step",
            "deformable_s",
            "deformable_events",
            "rigid_s",
            "rigid_events",
            "redundant_s",
            "redundant_events",
        ];
        let rows: [&[f64]; 3] = [
            &[100.0, 0.2, 200.0, 0.1, 100.0, 0.15, 100.0],
            &[100.0, 0.4, 200.0, 0.1, 100.0, 0.15, 100.0],
            &[600.0, 0.3, 200.0, 0.2, 200.0, 0.3, 200.0],
        ];
        keep("chairs-ratios.csv", &log(&[], &columns, &rows));
        let figures = figures(folder.path()).expect("figures");
        let number = |at: &str| figures.pointer(at).and_then(Value::as_f64).expect(at);
        assert_eq!(number("/chairs/hours"), 2.0);
        assert_eq!(number("/chairs/events_millions"), 6.0);
        assert_eq!(number("/chairs/columns/seconds/mean"), 3600.0);
        assert_eq!(number("/chairs/still"), 50.0);
        assert_eq!(number("/chairs/memory_mb"), 250.0);
        assert_eq!(number("/chairs/settings/bodies"), 3601.0);
        // Medians 0.3 and 0.3 beside 0.1 and 0.2, of 200 events beside 150.
        assert!((number("/ratios/per_step") - 2.0).abs() < 1e-12);
        assert!((number("/ratios/per_event") - 1.5).abs() < 1e-12);
        assert!((number("/ratios/redundant_percent") - 50.0).abs() < 1e-12);
        assert!((number("/ratios/most_per_step") - 3.0).abs() < 1e-12);
        assert_eq!(figures["goals"][0], "**not reached**: 2.00");
        assert_eq!(figures["pictures"], Value::Null);

        let old = page();
        let page = refreshed(&old, &json!({"logs": figures})).expect("a page");
        let row = |id: &str| {
            let begin = format!("| {id} |");
            let line = page.lines().find(|line| line.starts_with(&begin));
            line.expect(id).to_string()
        };
        assert!(row("P43").contains(" 25.0 % "), "{}", row("P43"));
        assert!(
            row("P44").contains(" 2.00 h, 6.00 million events"),
            "{}",
            row("P44")
        );
        assert!(row("P45").contains("| 2.00 per step"), "{}", row("P45"));
        assert!(row("P46").contains("| 50.0 % "), "{}", row("P46"));
        let fish = row("P49");
        for text in [
            "| 12000 fish, 64 contact spheres each: 0.500 s a step",
            "0.600 s of fish with triangles of the bridge (75.0 %)",
            "Of 300 million triangles a picture 5.00 million are drawn: 9.00 fish",
        ] {
            assert!(fish.contains(text), "{fish}");
        }
        // What has no log, and what no log has.
        assert!(row("P48").contains('?'), "{}", row("P48"));
        assert!(row("P42").contains("ours old{"), "{}", row("P42"));
        assert!(page.contains(
            "](logs/chairs-3601.csv.gz): `chairs --bodies 3601`; from step 1: commit abc"
        ));
        assert!(page.ends_with("\n## `curtain`\n\nas before\n"));
        // Again, it is the same.
        let again = refreshed(&page, &json!({"logs": figures})).expect("a page");
        assert_eq!(again, page);
        let error = refreshed("# Something else\n", &json!({})).expect_err("no page");
        assert!(error.contains("results"), "{error}");
    }

    /// Whoever adds a log, or changes what the page says of it, writes the page again.
    #[test]
    fn the_page_is_that_of_the_logs() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/measured");
        let page = std::fs::read_to_string(folder.join("results.md")).expect("the page");
        let logs = figures(&folder.join("logs")).expect("logs");
        let figures = json!({"logs": logs, "built": crate::results::page::built()});
        let written = refreshed(&page, &figures).expect("a page");
        assert!(written == page, "run `results --logs`");
    }

    #[test]
    fn logs_of_something_else_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("chairs-3601.csv.gz");
        let other = log(&[], &["step", "events"], &[&[1.0, 2.0]]);
        other.write(&path).expect("written");
        let error = figures(folder.path()).expect_err("refused").to_string();
        let says = "has no rows with a column `seconds`";
        assert_eq!(error, format!("{}: {says}", path.display()));
        std::fs::write(&path, b"a,b\n").expect("written");
        let error = figures(folder.path()).expect_err("refused").to_string();
        assert!(
            error.starts_with(&format!("{}, line 1: ", path.display())),
            "{error}"
        );
    }
}
