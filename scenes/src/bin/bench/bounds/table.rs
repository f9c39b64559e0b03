//! Figures as text and as JSON.

use std::fmt;

use serde_json::{Map, Value, json};

/// Named rows of numbers.
pub(super) struct Table {
    title: String,
    columns: Vec<&'static str>,
    rows: Vec<(String, Vec<f64>)>,
}

impl Table {
    pub(super) fn new(title: &str, columns: &[&'static str]) -> Self {
        Self {
            title: title.to_string(),
            columns: columns.to_vec(),
            rows: Vec::new(),
        }
    }

    /// Adds a row: a number for each column.
    pub(super) fn push(&mut self, name: impl Into<String>, values: Vec<f64>) {
        self.rows.push((name.into(), values));
    }

    pub(super) fn to_json(&self) -> Value {
        let rows = self.rows.iter().map(|(name, values)| {
            let values = self.columns.iter().zip(values);
            let mut row: Map<_, _> = values.map(|(c, v)| (c.to_string(), json!(v))).collect();
            row.insert("name".into(), json!(name));
            Value::Object(row)
        });
        json!({ "title": self.title, "rows": rows.collect::<Vec<_>>() })
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "| {} | {} |", self.title, self.columns.join(" | "))?;
        writeln!(f, "|---{}|", "|---".repeat(self.columns.len()))?;
        for (name, values) in &self.rows {
            write!(f, "| {name} |")?;
            for value in values {
                let digits = usize::from(value.fract() != 0.0 && value.abs() < 100.0);
                write!(f, " {value:.digits$} |")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}
