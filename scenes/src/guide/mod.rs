//! The plots and tables of docs/guide/settings.md, from what `bdtree report --json` and `bdtree-build --advise --json`
//! printed about several assets.

mod figures;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use serde_json::{Value, json};

use crate::report::Report;
use bdtree_measure::plot::sheet;

/// Plots and tables of docs/guide/settings.md, from reports and advice in JSON; an asset is called as its files are, up to the
/// first dot
#[derive(Debug, Clone, Parser)]
pub struct Arguments {
    /// What `bdtree report --json` printed
    #[arg(long = "report", value_name = "FILE", required = true, num_args = 1..)]
    pub reports: Vec<PathBuf>,
    /// What `bdtree-build --advise --json` printed
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub advice: Vec<PathBuf>,
    /// Folder for guide.json, guide.csv and its parts, guide-*.svg
    #[arg(long)]
    pub out: Option<PathBuf>,
}

/// An asset's file.
struct Source {
    name: String,
    path: PathBuf,
    value: Value,
}

impl Source {
    fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        let text = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let value = serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
        let name = path.file_name().map(|name| name.to_string_lossy());
        let name = name.as_deref().and_then(|name| name.split('.').next());
        Ok(Self {
            name: name.unwrap_or("?").to_string(),
            path: path.to_path_buf(),
            value,
        })
    }

    /// The objects of a list.
    fn list(&self, pointer: &str) -> Result<&[Value], Box<dyn Error>> {
        let list = self.value.pointer(pointer).and_then(Value::as_array);
        Ok(list.ok_or_else(|| format!("{}: no list at {pointer}", self.path.display()))?)
    }

    /// x and y of every object of a list that has both, as numbers.
    fn points(&self, list: &str, x: &str, y: &str) -> Result<Vec<(f64, f64)>, Box<dyn Error>> {
        let all = self.list(list)?.iter();
        let points =
            all.filter_map(|one| Some((one.pointer(x)?.as_f64()?, one.pointer(y)?.as_f64()?)));
        let points: Vec<_> = points.collect();
        if points.is_empty() {
            let path = self.path.display();
            return Err(format!("{path}: nothing at {list} has {x} and {y}").into());
        }
        Ok(points)
    }
}

/// Reads and draws.
///
/// # Errors
/// Files that cannot be read, that are no JSON, or that lack a figure: with the path and the place in it.
pub fn run(arguments: &Arguments) -> Result<Report, Box<dyn Error>> {
    let read = |paths: &[PathBuf]| {
        let all = paths.iter().map(|path| Source::read(path));
        all.collect::<Result<Vec<_>, _>>()
    };
    let (reports, advice) = (read(&arguments.reports)?, read(&arguments.advice)?);
    let drawn = [
        ("modes", figures::modes(&reports)?),
        ("leaves", figures::leaves(&advice)?),
        ("depth", figures::depth(&reports)?),
        ("refit", figures::refit(&reports)?),
    ];
    let mut pictures = Vec::new();
    let mut value = serde_json::Map::new();
    for (key, charts) in &drawn {
        pictures.push((*key, sheet(charts)?));
        let charts = charts.iter().map(|chart| {
            let curves = chart.lines.iter();
            let curves = curves.map(|curve| json!({"asset": curve.name, "points": curve.points}));
            json!({"title": chart.title, "x": chart.x.text, "y": chart.y.text,
                "curves": curves.collect::<Vec<Value>>()})
        });
        value.insert((*key).to_string(), charts.collect());
    }
    Ok(Report {
        name: "guide",
        // Everything here is a time or stands beside one.
        value: json!({ "times": value }),
        tables: vec![figures::break_even(&reports)?],
        pictures,
    })
}

#[cfg(test)]
mod tests;
