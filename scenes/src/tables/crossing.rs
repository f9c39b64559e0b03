//! Up to which deformation our spheres are smaller than the layered ones (figure 6), and what they are where the
//! paper's bound is as loose as in its figure.

use std::error::Error;

use serde_json::{Value, json};

use super::ways::{Deformations, Way};
use crate::hierarchies::{Hierarchies, Kind, Level};
use crate::report::{Cell, Table};

/// Figure 6, right: the mean ratio of the paper's bound on its bridge.
const PAPERS_MEAN: f64 = 1.25;

/// Halvings of an interval of amplitudes.
const STEPS: usize = 14;

/// Mean ratios of a level to the undeformed wrapped spheres at an amplitude.
struct Means {
    amplitude: f64,
    /// By [`Kind`].
    ratios: [f64; 3],
}

/// Of a mesh and a way to deform it.
pub(super) struct Crossing {
    way: Way,
    /// The largest amplitude that was asked for.
    largest: f64,
    /// Where ours get as large as the layered ones; none up to the largest amplitude.
    met: Option<Means>,
    /// Where the paper's bound has its own figure's mean; none up to the largest amplitude.
    as_paper: Option<Means>,
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
            largest,
            met: first(largest, &means, |[layered, _, ours]| ours >= layered)?,
            as_paper: first(largest, &means, |[_, paper, _]| paper >= PAPERS_MEAN)?,
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
    let (mut ratios, mut count) = ([0.0; 3], 0.0);
    for q in deformations {
        let mut posed = trees.posed(q)?;
        for (sum, kind) in ratios.iter_mut().zip(Kind::ALL) {
            let found = nodes.spheres(kind, &mut posed);
            *sum += found.iter().map(|sphere| sphere.growth).sum::<f64>() / found.len() as f64;
        }
        count += 1.0;
    }
    Ok(Means {
        amplitude,
        ratios: ratios.map(|sum| sum / count),
    })
}

/// The least amplitude, up to the largest, from which `holds` is true, by bisection: ratios grow with the
/// amplitude.
fn first(
    largest: f64,
    means: &impl Fn(f64) -> Result<Means, Box<dyn Error>>,
    holds: impl Fn([f64; 3]) -> bool,
) -> Result<Option<Means>, Box<dyn Error>> {
    let mut high = means(largest)?;
    if !holds(high.ratios) {
        return Ok(None);
    }
    let mut low = 0.0;
    for _ in 0..STEPS {
        let middle = means(0.5 * (low + high.amplitude))?;
        if holds(middle.ratios) {
            high = middle;
        } else {
            low = middle.amplitude;
        }
    }
    Ok(Some(high))
}

impl Crossing {
    pub(super) fn json(&self) -> Value {
        let of = |means: &Option<Means>| {
            means.as_ref().map(|means| {
                let [layered, paper, ours] = means.ratios;
                json!({"amplitude": means.amplitude, "layered": layered, "paper": paper, "ours": ours})
            })
        };
        json!({"deformation": self.way.name(), "largest_amplitude": self.largest,
            "ours_as_large_as_layered": of(&self.met), "paper_as_in_its_figure": of(&self.as_paper)})
    }

    pub(super) fn row(&self, mesh: &str) -> Vec<Cell> {
        let share = |means: &Option<Means>| {
            let found = means.as_ref().map(|means| 100.0 * means.amplitude);
            Cell::Text(match found {
                Some(share) => format!("{share:.1} %"),
                None => format!("above {:.1} %", 100.0 * self.largest),
            })
        };
        let of = |means: &Option<Means>, kind: usize| {
            let ratio = means.as_ref().map(|means| means.ratios[kind]);
            ratio.map_or(Cell::None, |ratio| Cell::Text(format!("{ratio:.3}")))
        };
        vec![
            mesh.into(),
            self.way.name().into(),
            share(&self.met),
            of(&self.met, 2),
            share(&self.as_paper),
            of(&self.as_paper, 0),
            of(&self.as_paper, 2),
        ]
    }
}

pub(super) fn table() -> Table {
    let title = "Up to where ours are smaller than the layered ones: in the mean of level 6, the amplitude at which both are \
                 as large; and the amplitude at which the paper's bound has the mean of its own figure 6, 1.25, with \
                 the others there. Ratios to the undeformed wrapped spheres, means over the same deformations made \
                 longer.";
    let columns = [
        "mesh",
        "deformation",
        "ours as large as layered at",
        "ratio there",
        "paper's bound 1.25 at",
        "layered there",
        "ours there",
    ];
    Table::new("crossings", title, &columns)
}
