//! What a program found: tables for the terminal, and JSON, CSV and pictures for a folder.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

use bdtree_measure::machine;
pub use bdtree_measure::table::{Cell, Column, Table, digits};
use serde_json::{Value, json};

/// A row of a table with the names of its columns: of these one description text and JSON are made.
pub type Row = Vec<(String, Cell)>;

/// A [`Row`], written as `json!` has it: a column's name and what becomes its [`Cell`].
#[macro_export]
macro_rules! row {
    ($($column:expr => $cell:expr),* $(,)?) => {
        vec![$((String::from($column), $crate::report::Cell::from($cell))),*]
    };
}

/// A table of rows. Its columns are those of all rows, in the order in which they first occur.
pub fn table(key: &'static str, title: impl Into<String>, rows: &[Row]) -> Table {
    let mut columns: Vec<String> = Vec::new();
    for (column, _) in rows.iter().flatten() {
        if !columns.contains(column) {
            columns.push(column.clone());
        }
    }
    let cell = |row: &Row, column: &String| {
        let own = row.iter().find(|(name, _)| name == column);
        own.map_or(Cell::None, |(_, cell)| cell.clone())
    };
    let cells = |row: &Row| columns.iter().map(|column| cell(row, column)).collect();
    let title = title.into();
    Table {
        key,
        title,
        rows: rows.iter().map(cells).collect(),
        columns,
    }
}

/// A table as JSON: an object per row, whose fields are the columns.
fn objects(table: &Table) -> Value {
    let value = |cell: &Cell| match cell {
        Cell::Text(text) => json!(text),
        Cell::Count(count) => json!(count),
        Cell::Number(number) => json!(number),
        Cell::None => Value::Null,
    };
    let object = |row: &Vec<Cell>| {
        let fields = table.columns.iter().cloned().zip(row.iter().map(value));
        Value::Object(fields.collect())
    };
    table.rows.iter().map(object).collect()
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
    /// Of tables that hold every figure.
    pub fn of_tables(name: &'static str, tables: Vec<Table>) -> Self {
        let objects = |table: &Table| (table.key.to_string(), objects(table));
        Self {
            name,
            value: Value::Object(tables.iter().map(objects).collect()),
            tables,
            pictures: Vec::new(),
        }
    }

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

/// The commit that the sources were at when this was asked first, with `-dirty` if they differed; `unknown` without git.
///
/// A program that runs for long asks at its beginning, since sources may change meanwhile.
pub fn commit() -> String {
    static COMMIT: OnceLock<String> = OnceLock::new();
    let ask = || {
        let git = Command::new("git")
            .args(["describe", "--always", "--dirty"])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output();
        match git {
            Ok(output) if output.status.success() => {
                String::from_utf8_lossy(&output.stdout).trim().to_string()
            }
            _ => "unknown".to_string(),
        }
    };
    COMMIT.get_or_init(ask).clone()
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
    use serde_json::json;

    use super::{Report, table, without_times};

    #[test]
    fn rows_make_text_and_json() {
        let rows = [
            row! {"who" => "a", "n" => 2_usize},
            row! {"who" => "b", "s" => 0.5},
        ];
        let report = Report::of_tables("program", vec![table("key", "Title", &rows)]);
        let text = "Title\n\n| who | n | s |\n|---|---|---|\n| a | 2 | – |\n| b | – | 0.500 |\n";
        assert_eq!(report.markdown(), text);
        let [a, b] = [
            json!({"who": "a", "n": 2, "s": null}),
            json!({"who": "b", "n": null, "s": 0.5}),
        ];
        assert_eq!(report.value, json!({"key": [a, b]}));
    }

    #[test]
    fn times_are_left_out_at_any_depth() {
        let value = json!({"a": [{"times": 1, "b": 2}], "times": {"c": 3}});
        assert_eq!(without_times(&value), json!({"a": [{"b": 2}]}));
    }
}
