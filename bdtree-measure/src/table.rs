//! Tables as Markdown and CSV.

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

/// The head of a column, and what a row has there.
pub type Column<'a, R> = (&'a str, &'a dyn Fn(&R) -> Cell);

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

    /// A row for each of `rows`, a column for each head and what stands below it.
    pub fn of<R>(
        key: &'static str,
        title: impl Into<String>,
        rows: &[R],
        columns: &[Column<'_, R>],
    ) -> Self {
        let heads: Vec<&str> = columns.iter().map(|(head, _)| *head).collect();
        let row = |row: &R| columns.iter().map(|(_, cell)| cell(row)).collect();
        Self {
            rows: rows.iter().map(row).collect(),
            ..Self::new(key, title, &heads)
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

#[cfg(test)]
mod tests {
    use super::{Cell, Table, digits};

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
}
