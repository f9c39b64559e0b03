//! The paper's tables over the fixtures: Table 1, how ‖ΔR‖ decays, figures 4 and 6 in numbers, and the
//! inequality of Appendix A (P04, P05, P08–P10, P21–P23, P50).

mod crossing;
mod decay;
mod lipschitz;
mod ratios;
mod subjects;
mod ways;

use std::error::Error;
use std::path::PathBuf;

use bdtree_measure::Body;
use bdtree_runtime::{Asset, Model};
use clap::Parser;
use serde_json::{Value, json};

use crate::hierarchies::Hierarchies;
use crate::report::{Cell, Report, Table};
use bdtree_measure::plot::sheet;

use ratios::Ratios;
use ways::Deformations;

pub use subjects::Mesh;

/// Table 1, the decay of ‖ΔR‖, figure 6 in numbers and Appendix A's inequality of the paper, over the fixtures
#[derive(Debug, Clone, Parser)]
pub struct Arguments {
    /// Fixtures, small to large: fish (M = 3), chair (10), curtain (12), bridge (10)
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "chair,bridge,fish,curtain"
    )]
    pub meshes: Vec<Mesh>,
    /// Other .bdt files to make figure 6 of, too
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub files: Vec<PathBuf>,
    /// Deformations of figure 6: way of the farthest vertex over the diagonal of the box (above 0, up to 1)
    #[arg(long, value_delimiter = ',', default_value = "0.01,0.05,0.1,0.2", value_parser = share)]
    pub amplitudes: Vec<f64>,
    /// Random deformations of each amplitude (1 to 1000)
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub poses: u16,
    /// Appendix A on nodes of at most so many vertices: it compares all pairs (2 to 20000)
    #[arg(long, default_value_t = 2048, value_parser = clap::value_parser!(u16).range(2..=20_000))]
    pub pair_vertices: u16,
    /// Seed of the deformations
    #[arg(long, default_value_t = 2004)]
    pub seed: u64,
    /// Folder for tables.json, tables.csv and its parts, tables.svg
    #[arg(long)]
    pub out: Option<PathBuf>,
}

impl Arguments {
    /// The largest amplitude.
    fn largest(&self) -> f64 {
        self.amplitudes.iter().copied().fold(0.0, f64::max)
    }
}

/// A share on the command line.
fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if share > 0.0 && share <= 1.0 => Ok(share),
        _ => Err("an amplitude is a number above 0, up to 1".to_string()),
    }
}

/// The level of the paper's figure 6: 64 spheres.
const FIGURE_LEVEL: usize = 6;

/// What is shown of figure 6, of meshes and of files alike.
struct Figure {
    level: Table,
    crossings: Table,
}

impl Figure {
    fn new() -> Self {
        Self {
            level: ratios::figure_table(),
            crossings: crossing::table(),
        }
    }

    /// Measures an asset and adds its rows: the ratios, and the figures of both as JSON.
    fn add(
        &mut self,
        name: &str,
        asset: &Asset<'_>,
        trees: &Hierarchies<'_>,
        arguments: &Arguments,
    ) -> Result<(Ratios, Value), Box<dyn Error>> {
        let body = Body::of_asset(asset)?;
        let deformations = Deformations::new(asset, &body, arguments.poses, arguments.seed);
        let ratios = ratios::measure(asset, trees, &deformations, &arguments.amplitudes)?;
        let met = crossing::measure(trees, &deformations, FIGURE_LEVEL, arguments.largest())?;
        self.level
            .rows
            .extend(ratios.figure_rows(name, FIGURE_LEVEL));
        self.crossings
            .rows
            .extend(met.iter().map(|one| one.row(name)));
        let value = json!({"triangles": asset.triangle_count(), "modes": asset.mode_count(),
            "ratios": ratios.json(),
            "crossings": met.iter().map(|one| one.json()).collect::<Vec<Value>>()});
        Ok((ratios, value))
    }
}

/// Measures.
///
/// # Errors
/// Fixtures that cannot be made or baked, files that cannot be read.
pub fn run(arguments: &Arguments) -> Result<Report, Box<dyn Error>> {
    let mut sizes = sizes_table();
    let mut decays = Vec::new();
    let mut figure = Figure::new();
    let mut levels = ratios::level_table();
    let mut lipschitz = lipschitz::table(arguments.pair_vertices);
    let (mut results, mut charts) = (Vec::new(), Vec::new());
    for mesh in &arguments.meshes {
        let model = subjects::baked(*mesh)?;
        let asset = model.asset();
        let trees = Hierarchies::new(*asset);
        let name = mesh.name();
        sizes.rows.push(sizes_row(*mesh, asset, &trees));
        let decay = decay::measure(*mesh, &trees)?;
        let (ratios, mut value) = figure.add(name, asset, &trees, arguments)?;
        levels.rows.extend(ratios.level_rows(name));
        let pairs = lipschitz::measure(asset, &trees, usize::from(arguments.pair_vertices))?;
        lipschitz.rows.extend(pairs.iter().map(|p| p.row(name)));
        if *mesh == Mesh::Chair {
            charts.push(ratios.chart());
        }
        for (key, own) in [
            ("mesh", json!(name)),
            ("vertices", json!(asset.vertex_count())),
            ("bytes", json!(asset.bytes().len())),
            ("spheres", json!(trees.tree().node_count())),
            ("levels", json!(trees.depth())),
            ("our_nodes", json!(asset.node_count())),
            ("our_levels", json!(asset.depth())),
            ("decay", decay.json()),
            ("appendix_a", pairs.iter().map(|p| p.json()).collect()),
        ] {
            value[key] = own;
        }
        results.push(value);
        decays.push(decay);
    }
    let mut of_files = Vec::new();
    for path in &arguments.files {
        let model = Model::read(path)?;
        let (asset, name) = (model.asset(), path.file_stem().unwrap_or(path.as_os_str()));
        let (name, trees) = (name.to_string_lossy(), Hierarchies::new(*asset));
        let added = figure.add(&name, asset, &trees, arguments);
        let (_, mut value) = added.map_err(|error| format!("{}: {error}", path.display()))?;
        value["file"] = json!(name);
        of_files.push(value);
    }
    charts.insert(0, decay::chart(&decays));
    let picture = sheet(&charts)?;
    Ok(Report {
        name: "tables",
        value: json!({"settings": {"amplitudes": arguments.amplitudes, "poses": arguments.poses,
            "pair_vertices": arguments.pair_vertices, "seed": arguments.seed}, "meshes": results, "files": of_files}),
        tables: vec![
            sizes,
            decay::table(&decays),
            figure.level,
            figure.crossings,
            levels,
            lipschitz,
        ],
        pictures: vec![("", picture)],
    })
}

/// The chair with its ten modes.
///
/// # Errors
/// A fixture that cannot be made or baked.
pub fn chair() -> Result<Model, Box<dyn Error>> {
    subjects::baked(Mesh::Chair)
}

fn sizes_table() -> Table {
    Table::new(
        "",
        "Table 1: our fixtures, the paper's numbers in brackets. Spheres and levels are those of the paper's \
         binary tree (2 F − 1); nodes of eight spheres are ours.",
        &[
            "mesh",
            "vertices",
            "faces",
            "M",
            "spheres",
            "levels",
            "our nodes",
            "their levels",
            "bytes",
        ],
    )
}

fn sizes_row(mesh: Mesh, asset: &Asset<'_>, trees: &Hierarchies<'_>) -> Vec<Cell> {
    let theirs = mesh.of_the_paper();
    let own = [
        asset.vertex_count(),
        asset.triangle_count(),
        asset.mode_count(),
        trees.tree().node_count(),
        trees.depth(),
    ];
    let both = own
        .iter()
        .zip(theirs)
        .map(|(own, paper)| format!("{own} ({paper})").into());
    let mut row: Vec<Cell> = std::iter::once(mesh.name().into()).chain(both).collect();
    row.extend([asset.node_count(), asset.depth(), asset.bytes().len()].map(Cell::from));
    row
}
