//! How ‖ΔR‖₂ falls from level to level (P21).

use std::error::Error;

use serde_json::{Value, json};

use super::Mesh;
use crate::hierarchies::Hierarchies;
use crate::report::{Cell, Table};
use bdtree_measure::plot::{Axis, Line, Plot};

/// The paper's chair (3.3): means of the levels over the root's.
pub(super) const PAPER: [f64; 19] = [
    1.000, 0.684, 0.575, 0.399, 0.252, 0.167, 0.110, 0.080, 0.057, 0.041, 0.030, 0.022, 0.017,
    0.016, 0.015, 0.013, 0.007, 0.004, 0.003,
];

/// The level that is compared.
const COMPARED: usize = 10;

/// Means of ‖ΔR‖₂ over the nodes of each level, the root's being 1.
pub(super) struct Decay {
    mesh: Mesh,
    paper: Vec<f64>,
    ours: Vec<f64>,
}

/// ‖ΔR‖₂ of the paper's nodes (Ū the mean) and of our spheres around the same triangles (Ū the center of the
/// smallest ball).
pub(super) fn measure(mesh: Mesh, trees: &Hierarchies<'_>) -> Result<Decay, Box<dyn Error>> {
    let mean = |norms: Vec<f64>| norms.iter().sum::<f64>() / norms.len() as f64;
    let (mut paper, mut ours) = (Vec::new(), Vec::new());
    for level in 0..trees.depth() {
        let of_level = trees.nodes.iter().enumerate();
        let of_level = of_level.filter(|(_, (of, _))| *of == level);
        let norms = of_level.map(|(node, _)| {
            let rows = trees.tree.numbers(node)[1..].iter();
            rows.map(|row| f64::from(row[3]).powi(2))
                .sum::<f64>()
                .sqrt()
        });
        paper.push(mean(norms.collect()));
        ours.push(mean(trees.level(level)?.growth_norms()));
    }
    let over_root = |means: Vec<f64>| means.iter().map(|mean| mean / means[0]).collect();
    Ok(Decay {
        mesh,
        paper: over_root(paper),
        ours: over_root(ours),
    })
}

/// Whether no level has more than the one above.
fn falls(means: &[f64]) -> bool {
    means.windows(2).all(|pair| pair[1] < pair[0])
}

impl Decay {
    pub(super) fn json(&self) -> Value {
        let of = |means: &[f64]| {
            json!({"by_level": means, "falls": falls(means),
                "level_10_over_the_papers": means.get(COMPARED).map(|mean| mean / PAPER[COMPARED])})
        };
        json!({"paper": of(&self.paper), "ours": of(&self.ours)})
    }
}

/// A row per level, two columns per mesh.
pub(super) fn table(decays: &[Decay]) -> Table {
    let columns: Vec<String> = decays
        .iter()
        .flat_map(|d| ["paper's nodes", "ours"].map(|who| format!("{}, {who}", d.mesh.name())))
        .collect();
    let heads: Vec<&str> = ["level", "paper's chair (2004)"]
        .into_iter()
        .chain(columns.iter().map(String::as_str))
        .collect();
    let title = "‖ΔR‖₂ by level of the binary tree: mean over the nodes, that of the root being 1";
    let mut table = Table::new("decay", title, &heads);
    let depth = decays.iter().map(|d| d.paper.len()).max().unwrap_or(0);
    let cell = |means: &[f64], level: usize| means.get(level).map_or(Cell::None, |x| (*x).into());
    for level in 0..depth.max(PAPER.len()) {
        let mut row = vec![level.into(), cell(&PAPER, level)];
        for decay in decays {
            row.extend([cell(&decay.paper, level), cell(&decay.ours, level)]);
        }
        table.rows.push(row);
    }
    table
}

pub(super) fn chart(decays: &[Decay]) -> Plot {
    let line = |name: &str, means: &[f64]| Line {
        name: name.to_string(),
        points: (0..).map(f64::from).zip(means.iter().copied()).collect(),
    };
    let own = decays.iter().map(|d| line(d.mesh.name(), &d.paper));
    let lines = own.chain([line("paper's chair (2004)", &PAPER)]).collect();
    let level = Axis::linear("level of the binary tree");
    let title = "Mean of ‖ΔR‖ by level (paper's bound)";
    Plot::new(title, &level, &Axis::log("over the root's"), lines)
}
