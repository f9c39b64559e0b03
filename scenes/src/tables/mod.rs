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

use crossing::Crossing;
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
    name: String,
    ratios: Ratios,
    crossings: Vec<Crossing>,
}

impl Figure {
    fn new(
        name: &str,
        asset: &Asset<'_>,
        trees: &Hierarchies<'_>,
        arguments: &Arguments,
    ) -> Result<Self, Box<dyn Error>> {
        let body = Body::of_asset(asset)?;
        let deformations = Deformations::new(asset, &body, arguments.poses, arguments.seed);
        let largest = arguments.amplitudes.iter().copied().fold(0.0, f64::max);
        Ok(Self {
            name: name.to_string(),
            ratios: ratios::measure(asset, trees, &deformations, &arguments.amplitudes)?,
            crossings: crossing::measure(trees, &deformations, FIGURE_LEVEL, largest)?,
        })
    }

    /// The figures of its asset, and what else is known of that.
    fn json(&self, asset: &Asset<'_>, mut more: Value) -> Value {
        more["triangles"] = json!(asset.triangle_count());
        more["modes"] = json!(asset.mode_count());
        more["ratios"] = json!(self.ratios);
        more["crossings"] = json!(self.crossings);
        more
    }
}

/// By name.
fn ratios(figures: &[Figure]) -> Vec<(&str, &Ratios)> {
    let all = figures.iter().map(|f| (f.name.as_str(), &f.ratios));
    all.collect()
}

/// Measures.
///
/// # Errors
/// Fixtures that cannot be made or baked, files that cannot be read.
pub fn run(arguments: &Arguments) -> Result<Report, Box<dyn Error>> {
    let (mut sizes, mut decays, mut pairs) = (Vec::new(), Vec::new(), Vec::new());
    let (mut figures, mut results, mut charts) = (Vec::new(), Vec::new(), Vec::new());
    for mesh in &arguments.meshes {
        let model = subjects::baked(*mesh)?;
        let asset = model.asset();
        let trees = Hierarchies::new(*asset);
        let name = mesh.name();
        let size = Size::new(*mesh, asset, &trees);
        let decay = decay::measure(*mesh, &trees)?;
        let figure = Figure::new(name, asset, &trees, arguments)?;
        let own = lipschitz::measure(asset, &trees, usize::from(arguments.pair_vertices))?;
        if *mesh == Mesh::Chair {
            charts.push(figure.ratios.chart());
        }
        let [vertices, _, _, spheres, levels] = size.own;
        let more = json!({"mesh": name, "vertices": vertices, "bytes": size.bytes, "spheres": spheres,
            "levels": levels, "our_nodes": size.nodes, "our_levels": size.depth, "decay": decay.json(),
            "appendix_a": own});
        results.push(figure.json(asset, more));
        pairs.extend(own.map(|pairs| (name, pairs)));
        sizes.push(size);
        decays.push(decay);
        figures.push(figure);
    }
    let mut of_files = Vec::new();
    for path in &arguments.files {
        let model = Model::read(path)?;
        let (asset, name) = (model.asset(), path.file_stem().unwrap_or(path.as_os_str()));
        let (name, trees) = (name.to_string_lossy(), Hierarchies::new(*asset));
        let figure = Figure::new(&name, asset, &trees, arguments);
        let figure = figure.map_err(|error| format!("{}: {error}", path.display()))?;
        of_files.push(figure.json(asset, json!({"file": name})));
        figures.push(figure);
    }
    charts.insert(0, decay::chart(&decays));
    let crossings = figures.iter();
    let crossings = crossings.flat_map(|f| f.crossings.iter().map(|c| (f.name.as_str(), c)));
    let pairs: Vec<_> = pairs.iter().map(|(name, pairs)| (*name, pairs)).collect();
    Ok(Report {
        name: "tables",
        value: json!({"settings": {"amplitudes": arguments.amplitudes, "poses": arguments.poses,
            "pair_vertices": arguments.pair_vertices, "seed": arguments.seed}, "meshes": results, "files": of_files}),
        tables: vec![
            sizes_table(&sizes),
            decay::table(&decays),
            ratios::figure_table(&ratios(&figures), FIGURE_LEVEL),
            crossing::table(&crossings.collect::<Vec<_>>()),
            ratios::level_table(&ratios(&figures[..results.len()])),
            lipschitz::table(arguments.pair_vertices, &pairs),
        ],
        pictures: vec![("", sheet(&charts)?)],
    })
}

/// The chair with its ten modes.
///
/// # Errors
/// A fixture that cannot be made or baked.
pub fn chair() -> Result<Model, Box<dyn Error>> {
    subjects::baked(Mesh::Chair)
}

/// A row of Table 1.
struct Size {
    mesh: Mesh,
    /// Vertices, faces, M, spheres and levels of the paper's tree.
    own: [usize; 5],
    nodes: usize,
    depth: usize,
    bytes: usize,
}

impl Size {
    fn new(mesh: Mesh, asset: &Asset<'_>, trees: &Hierarchies<'_>) -> Self {
        Self {
            mesh,
            own: [
                asset.vertex_count(),
                asset.triangle_count(),
                asset.mode_count(),
                trees.tree.node_count(),
                trees.depth(),
            ],
            nodes: asset.node_count(),
            depth: asset.depth(),
            bytes: asset.bytes().len(),
        }
    }

    /// A number, and the paper's.
    fn both(&self, k: usize) -> Cell {
        format!("{} ({})", self.own[k], self.mesh.of_the_paper()[k]).into()
    }
}

fn sizes_table(rows: &[Size]) -> Table {
    let title = "Table 1: our fixtures, the paper's numbers in brackets. Spheres and levels are those of the paper's \
                 binary tree (2 F − 1); nodes of eight spheres are ours.";
    Table::of(
        "",
        title,
        rows,
        &[
            ("mesh", &|size| size.mesh.name().into()),
            ("vertices", &|size| size.both(0)),
            ("faces", &|size| size.both(1)),
            ("M", &|size| size.both(2)),
            ("spheres", &|size| size.both(3)),
            ("levels", &|size| size.both(4)),
            ("our nodes", &|size| size.nodes.into()),
            ("their levels", &|size| size.depth.into()),
            ("bytes", &|size| size.bytes.into()),
        ],
    )
}
