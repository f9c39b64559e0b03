//! How the ball query grows with mesh, modes, displacement, contacts and questions, beside deforming and
//! refitting (P28, P41, P53).

mod size;
mod step;
mod sweep;

use std::error::Error;
use std::iter::once;
use std::path::PathBuf;

use clap::Parser;
use serde_json::json;

use crate::report::Report;
use bdtree_measure::plot::sheet;

/// Time and visits of the ball query over mesh size, modes, displacement, contacts and balls a step, beside
/// boxes (obvhs) that are refitted to all deformed vertices
#[derive(Debug, Clone, Parser)]
pub struct Arguments {
    /// Triangles of the cloths, about (8 and more each); two sizes or more, or none with `--triangles=`
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "12000,50000,200000,800000,2000000",
        value_parser = clap::value_parser!(u32).range(8..=20_000_000)
    )]
    pub triangles: Vec<u32>,
    /// Contacts of a ball on every cloth, within 5 % (above 0)
    #[arg(long, default_value_t = 60.0)]
    pub contacts: f64,
    /// Triangles of the body on which modes, displacement, contacts and balls vary, about (80 and more)
    #[arg(long, default_value_t = 35_280, value_parser = clap::value_parser!(u32).range(80..=20_000_000))]
    pub body_triangles: u32,
    /// How often everything is asked; medians count (1 and more)
    #[arg(long, default_value_t = 15, value_parser = clap::value_parser!(u16).range(1..))]
    pub repeat: u16,
    /// Folder for growth.json, growth.csv and its parts, growth.svg
    #[arg(long)]
    pub out: Option<PathBuf>,
}

/// Measures.
///
/// # Errors
/// Bodies that cannot be baked, contenders that do not find the same, no radius with so many contacts.
pub fn run(arguments: &Arguments) -> Result<Report, Box<dyn Error>> {
    if arguments.triangles.len() < 2 {
        return Err("--triangles: a growth needs two sizes or more".into());
    }
    if !(arguments.contacts > 0.0 && arguments.contacts.is_finite()) {
        return Err("--contacts: a number above 0".into());
    }
    let repeats = usize::from(arguments.repeat);
    let sizes = size::measure(&arguments.triangles, arguments.contacts, repeats)?;
    let sweeps = sweep::all(arguments.body_triangles, repeats)?;
    let tables = sweeps.iter().map(sweep::Sweep::table);
    let charts: Vec<_> = sweeps.iter().map(sweep::Sweep::chart).collect();
    let settings = json!({"triangles": arguments.triangles, "contacts": arguments.contacts,
        "body_triangles": arguments.body_triangles, "repeat": arguments.repeat});
    let of_sweeps: Vec<_> = sweeps.iter().map(sweep::Sweep::json).collect();
    Ok(Report {
        name: "growth",
        value: json!({"settings": settings, "size": sizes.json(), "sweeps": of_sweeps}),
        pictures: vec![("", sheet(&[sizes.chart()])?), ("sweeps", sheet(&charts)?)],
        tables: once(sizes.table()).chain(tables).collect(),
    })
}
