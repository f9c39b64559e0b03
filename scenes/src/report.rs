//! What a program found: tables for the terminal, and JSON, CSV and pictures for a folder.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;

use bdtree_baselines::machine;
use serde_json::{Value, json};

/// A field of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// As it stands.
    Text(String),
    /// A number of things.
    Count(u64),
    /// Three digits in Markdown, all in CSV.
    Number(f64),
    /// Does not apply.
    None,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_string())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Count(count as u64)
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl Cell {
    fn markdown(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Count(count) => count.to_string(),
            Self::Number(number) => digits(*number),
            Self::None => "–".to_string(),
        }
    }

    fn csv(&self) -> String {
        match self {
            Self::Text(text) if text.contains([',', '"', '\n']) => {
                format!("\"{}\"", text.replace('"', "\"\""))
            }
            Self::Text(text) => text.clone(),
            Self::Count(count) => count.to_string(),
            Self::Number(number) => number.to_string(),
            Self::None => String::new(),
        }
    }
}

/// Three significant digits; numbers of a thousand and more to one.
pub fn digits(x: f64) -> String {
    if x == 0.0 {
        return "0".to_string();
    }
    if !x.is_finite() {
        return x.to_string();
    }
    let before = x.abs().log10().floor() as i32 + 1;
    // 9.996 has one digit before the point, 10.0 two.
    let rounded = 10.0_f64.powi(before) - x.abs() <= 0.5 * 10.0_f64.powi(before - 3);
    let after = (3 - before - i32::from(rounded)).max(0) as usize;
    format!("{x:.after$}")
}

/// A table.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// For the file's name; the first one of a report has none.
    pub key: &'static str,
    /// What it shows.
    pub title: String,
    /// Heads, units included.
    pub columns: Vec<String>,
    /// Rows of as many cells.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// Without rows.
    pub fn new(key: &'static str, title: impl Into<String>, columns: &[&str]) -> Self {
        Self {
            key,
            title: title.into(),
            columns: columns.iter().map(|c| (*c).to_string()).collect(),
            rows: Vec::new(),
        }
    }

    /// Title, empty line, table.
    pub fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let mut text = format!("{}\n\n", self.title);
        text += &line(self.columns.clone());
        text += &format!("|{}\n", "---|".repeat(self.columns.len()));
        for row in &self.rows {
            text += &line(row.iter().map(Cell::markdown).collect());
        }
        text
    }

    /// A line of heads, a line per row.
    pub fn csv(&self) -> String {
        let heads: Vec<Cell> = self.columns.iter().map(|c| c.as_str().into()).collect();
        let lines = std::iter::once(&heads).chain(&self.rows);
        lines
            .map(|row| row.iter().map(Cell::csv).collect::<Vec<_>>().join(",") + "\n")
            .collect()
    }
}

/// All that a program found.
#[derive(Debug, Clone)]
pub struct Report {
    /// The program's name, which its files begin with.
    pub name: &'static str,
    /// What was asked for, and every figure; times lie in objects called `times`, so that the rest is the
    /// same in every run.
    pub value: Value,
    /// For people.
    pub tables: Vec<Table>,
    /// Part of the file's name (empty: none), SVG text.
    pub pictures: Vec<(&'static str, String)>,
}

impl Report {
    /// All tables.
    pub fn markdown(&self) -> String {
        let tables: Vec<String> = self.tables.iter().map(Table::markdown).collect();
        tables.join("\n")
    }

    /// Figures, machine and commit.
    pub fn json(&self) -> Value {
        json!({"program": self.name, "machine": machine::processor(), "commit": commit(),
            "results": self.value})
    }

    /// Writes NAME.json, a CSV file per table and an SVG file per picture.
    ///
    /// # Errors
    /// A folder or file that cannot be written, with its path.
    pub fn write(&self, folder: &Path) -> Result<(), Box<dyn Error>> {
        let place = |key: &str, ending: &str| {
            let dash = if key.is_empty() { "" } else { "-" };
            folder.join(format!("{}{dash}{key}.{ending}", self.name))
        };
        let mut files = vec![(place("", "json"), format!("{:#}\n", self.json()))];
        files.extend(self.tables.iter().map(|t| (place(t.key, "csv"), t.csv())));
        let pictures = self.pictures.iter();
        files.extend(pictures.map(|(key, svg)| (place(key, "svg"), svg.clone())));
        for (path, text) in files {
            write(&path, &text)?;
        }
        Ok(())
    }

    /// Prints the tables, and writes the files if a folder is given: what every program does at its end.
    ///
    /// # Errors
    /// Those of [`Report::write`].
    pub fn show(&self, folder: Option<&Path>) -> Result<(), Box<dyn Error>> {
        println!("{}, commit {}\n", machine::processor(), commit());
        println!("{}", self.markdown());
        folder.map_or(Ok(()), |folder| self.write(folder))
    }
}

/// Writes a text, its folder too.
///
/// # Errors
/// A folder or file that cannot be written, with its path.
pub fn write(path: &Path, text: &str) -> Result<(), Box<dyn Error>> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let written = fs::create_dir_all(folder).and_then(|()| fs::write(path, text));
    Ok(written.map_err(|e| format!("{}: {e}", path.display()))?)
}

/// The commit that the sources are at, with `-dirty` if they differ; `unknown` without git.
pub fn commit() -> String {
    let git = Command::new("git")
        .args([
            "-C",
            env!("CARGO_MANIFEST_DIR"),
            "describe",
            "--always",
            "--dirty",
        ])
        .output();
    match git {
        Ok(output) if output.status.success() => {
            String::from_utf8_lossy(&output.stdout).trim().to_string()
        }
        _ => "unknown".to_string(),
    }
}

/// The same figures without the objects called `times`: what two runs must agree in.
pub fn without_times(value: &Value) -> Value {
    match value {
        Value::Object(fields) => fields
            .iter()
            .filter(|(name, _)| *name != "times")
            .map(|(name, value)| (name.clone(), without_times(value)))
            .collect(),
        Value::Array(values) => values.iter().map(without_times).collect(),
        other => other.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Cell, Table, digits, without_times};
    use serde_json::json;

    #[test]
    fn three_digits() {
        let texts = [0.0, 1234.5, 999.6, 99.96, 9.996, 1.0, 0.5, 0.012_345, -2.5].map(digits);
        assert_eq!(
            texts,
            [
                "0", "1234", "1000", "100", "10.0", "1.00", "0.500", "0.0123", "-2.50"
            ]
        );
    }

    #[test]
    fn tables_quote_and_align() {
        let mut table = Table::new("", "A title", &["a, b", "c"]);
        table.rows.push(vec![Cell::Count(3), Cell::Number(0.25)]);
        table.rows.push(vec!["x \"y\"".into(), Cell::None]);
        assert_eq!(table.csv(), "\"a, b\",c\n3,0.25\n\"x \"\"y\"\"\",\n");
        assert_eq!(
            table.markdown(),
            "A title\n\n| a, b | c |\n|---|---|\n| 3 | 0.250 |\n| x \"y\" | – |\n"
        );
    }

    #[test]
    fn times_are_left_out_at_any_depth() {
        let value = json!({"a": [{"times": 1, "b": 2}], "times": {"c": 3}});
        assert_eq!(without_times(&value), json!({"a": [{"b": 2}]}));
    }
}
