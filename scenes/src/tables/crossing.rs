//! Up to which deformation our spheres are smaller than the layered ones (figure 6), and what they are where the
//! paper's bound is as loose as in its figure.

use std::error::Error;

use serde::Serialize;

use super::ways::{Deformations, Way};
use crate::hierarchies::{ByKind, Hierarchies, Kind, Level};
use crate::report::{Cell, Table};

/// Figure 6, right: the mean ratio of the paper's bound on its bridge.
const PAPERS_MEAN: f64 = 1.25;

/// Halvings of an interval of amplitudes.
const STEPS: usize = 14;

/// Mean ratios of a level to the undeformed wrapped spheres at an amplitude.
#[derive(Serialize)]
struct Means {
    amplitude: f64,
    #[serde(flatten)]
    ratios: ByKind<f64>,
}

/// Of a mesh and a way to deform it.
#[derive(Serialize)]
pub(super) struct Crossing {
    #[serde(rename = "deformation")]
    way: Way,
    /// The largest that was asked for.
    largest_amplitude: f64,
    /// The least amplitude where they are; none up to the largest.
    ours_as_large_as_layered: Option<Means>,
    /// Where the paper's bound has its own figure's mean; none up to the largest amplitude.
    paper_as_in_its_figure: Option<Means>,
}

/// Of both ways, on one level of the binary tree; amplitudes are shares of the diagonal.
pub(super) fn measure(
    trees: &Hierarchies<'_>,
    deformations: &Deformations<'_, '_>,
    level: usize,
    largest: f64,
) -> Result<Vec<Crossing>, Box<dyn Error>> {
    if level >= trees.depth() {
        return Ok(Vec::new());
    }
    let nodes = trees.level(level)?;
    let both = [Way::Natural, Way::Even].map(|way| {
        let means =
            |amplitude: f64| means(trees, &nodes, &deformations.of(way, amplitude), amplitude);
        Ok(Crossing {
            way,
            largest_amplitude: largest,
            ours_as_large_as_layered: first(largest, &means, |r| r.ours >= r.layered)?,
            paper_as_in_its_figure: first(largest, &means, |r| r.paper >= PAPERS_MEAN)?,
        })
    });
    both.into_iter().collect()
}

fn means(
    trees: &Hierarchies<'_>,
    nodes: &Level<'_>,
    deformations: &[Vec<f32>],
    amplitude: f64,
) -> Result<Means, Box<dyn Error>> {
    let mut sums = [0.0; 3];
    for q in deformations {
        let mut posed = trees.posed(q)?;
        for (sum, kind) in sums.iter_mut().zip(Kind::ALL) {
            let found = nodes.spheres(kind, &mut posed);
            *sum += found.iter().map(|sphere| sphere.growth).sum::<f64>() / found.len() as f64;
        }
    }
    let ratios = sums.map(|sum| sum / deformations.len() as f64).into();
    Ok(Means { amplitude, ratios })
}

/// The least amplitude, up to the largest, from which `holds` is true, by bisection: ratios grow with the
/// amplitude.
fn first(
    largest: f64,
    means: &impl Fn(f64) -> Result<Means, Box<dyn Error>>,
    holds: impl Fn(&ByKind<f64>) -> bool,
) -> Result<Option<Means>, Box<dyn Error>> {
    let mut high = means(largest)?;
    if !holds(&high.ratios) {
        return Ok(None);
    }
    let mut low = 0.0;
    for _ in 0..STEPS {
        let middle = means(0.5 * (low + high.amplitude))?;
        if holds(&middle.ratios) {
            high = middle;
        } else {
            low = middle.amplitude;
        }
    }
    Ok(Some(high))
}

/// A row for each mesh and way.
pub(super) fn table(rows: &[(&str, &Crossing)]) -> Table {
    let title = "Up to where ours are smaller than the layered ones: in the mean of level 6, the amplitude at which both are \
                 as large; and the amplitude at which the paper's bound has the mean of its own figure 6, 1.25, with \
                 the others there. Ratios to the undeformed wrapped spheres, means over the same deformations made \
                 longer.";
    let share = |means: &Option<Means>, largest: f64| {
        Cell::Text(match means {
            Some(means) => format!("{:.1} %", 100.0 * means.amplitude),
            None => format!("above {:.1} %", 100.0 * largest),
        })
    };
    let ratio = |means: &Option<Means>, of: fn(&ByKind<f64>) -> f64| {
        let ratio = means.as_ref().map(|means| of(&means.ratios));
        ratio.map_or(Cell::None, |ratio| Cell::Text(format!("{ratio:.3}")))
    };
    Table::of(
        "crossings",
        title,
        rows,
        &[
            ("mesh", &|(mesh, _)| (*mesh).into()),
            ("deformation", &|(_, c)| c.way.name().into()),
            ("ours as large as layered at", &|(_, c)| {
                share(&c.ours_as_large_as_layered, c.largest_amplitude)
            }),
            ("ratio there", &|(_, c)| {
                ratio(&c.ours_as_large_as_layered, |r| r.ours)
            }),
            ("paper's bound 1.25 at", &|(_, c)| {
                share(&c.paper_as_in_its_figure, c.largest_amplitude)
            }),
            ("layered there", &|(_, c)| {
                ratio(&c.paper_as_in_its_figure, |r| r.layered)
            }),
            ("ours there", &|(_, c)| {
                ratio(&c.paper_as_in_its_figure, |r| r.ours)
            }),
        ],
    )
}
