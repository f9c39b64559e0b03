//! Figures 4 and 6 in numbers: radii of three hierarchies over those of the undeformed wrapped spheres.

use std::error::Error;

use bdtree_fixtures::poses;
use bdtree_render::tightness::mean_and_max;
use bdtree_runtime::Asset;
use serde_json::{Value, json};

use super::ways::{Deformations, Way};
use crate::hierarchies::{Hierarchies, Kind};
use crate::report::{Cell, Table};
use bdtree_measure::plot::{Axis, Line, Plot};

/// Over the nodes of a level and all deformations of a case.
#[derive(Debug, Clone, Copy)]
struct Spread {
    mean: f64,
    max: f64,
    /// Radius of the largest sphere over the diagonal of the box.
    largest: f64,
}

/// How far a body is deformed, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Case {
    way: Way,
    /// Way of the farthest vertex over the diagonal.
    amplitude: f64,
}

/// By level, case (rest first) and kind.
pub(super) struct Ratios {
    cases: Vec<Case>,
    counts: Vec<usize>,
    levels: Vec<Vec<[Spread; 3]>>,
}

/// `amplitudes` are shares of the diagonal.
pub(super) fn measure(
    asset: &Asset<'_>,
    trees: &Hierarchies<'_>,
    deformations: &Deformations<'_, '_>,
    amplitudes: &[f64],
) -> Result<Ratios, Box<dyn Error>> {
    let diagonal = poses::diagonal(asset);
    let mut cases = vec![Case {
        way: Way::Rest,
        amplitude: 0.0,
    }];
    let mut posed = vec![vec![trees.posed(&vec![0.0; asset.mode_count()])?]];
    for way in [Way::Natural, Way::Even] {
        for amplitude in amplitudes.iter().copied() {
            let own = deformations.of(way, amplitude);
            cases.push(Case { way, amplitude });
            let own = own.iter().map(|q| trees.posed(q));
            posed.push(own.collect::<Result<Vec<_>, _>>()?);
        }
    }
    let mut levels = Vec::new();
    for level in 0..trees.depth() {
        let nodes = trees.level(level)?;
        let of_level = posed.iter_mut().map(|posed| {
            Kind::ALL.map(|kind| {
                let found = posed
                    .iter_mut()
                    .flat_map(|posed| nodes.spheres(kind, posed));
                let (mut growths, mut largest) = (Vec::new(), 0.0_f64);
                for sphere in found {
                    growths.push(sphere.growth);
                    largest = largest.max(sphere.radius);
                }
                let [mean, max] = mean_and_max(&growths).unwrap_or([f64::NAN; 2]);
                Spread {
                    mean,
                    max,
                    largest: largest / diagonal,
                }
            })
        });
        levels.push(of_level.collect());
    }
    Ok(Ratios {
        cases,
        counts: (0..trees.depth()).map(|level| trees.count(level)).collect(),
        levels,
    })
}

impl Ratios {
    /// All levels but the last, which has leaves only.
    fn inner(&self) -> impl Iterator<Item = &Vec<[Spread; 3]>> {
        self.levels.iter().take(self.levels.len().saturating_sub(1))
    }

    /// The least mean of layered over wrapped at rest of any inner level.
    fn least_layered(&self) -> f64 {
        self.inner()
            .map(|level| level[0][0].mean)
            .fold(f64::INFINITY, f64::min)
    }

    /// The largest quotient of the means, and of the largest ratios, of ours and layered on any inner level.
    fn ours_over_layered(&self, case: usize) -> [f64; 2] {
        let both = self.inner().map(|level| {
            let [layered, _, ours] = level[case];
            [ours.mean / layered.mean, ours.max / layered.max]
        });
        both.fold([0.0; 2], |[a, b], [c, d]| [f64::max(a, c), f64::max(b, d)])
    }

    /// Mean ratios over all spheres of the inner levels, by kind.
    fn means(&self, case: usize) -> [f64; 3] {
        let (mut sums, mut count) = ([0.0; 3], 0.0);
        for (level, spheres) in self.inner().zip(&self.counts) {
            for (sum, spread) in sums.iter_mut().zip(&level[case]) {
                *sum += spread.mean * *spheres as f64;
            }
            count += *spheres as f64;
        }
        sums.map(|sum| sum / count)
    }

    pub(super) fn json(&self) -> Value {
        let spread = |s: &Spread| json!({"mean": s.mean, "max": s.max, "largest": s.largest});
        let level = |(level, of_level): (usize, &Vec<[Spread; 3]>)| -> Value {
            let all = self.cases.iter().zip(of_level);
            let all = all.map(|(case, [layered, paper, ours])| {
                json!({"deformation": case.way.name(), "amplitude": case.amplitude,
                    "layered": spread(layered), "paper": spread(paper), "ours": spread(ours)})
            });
            json!({"level": level, "spheres": self.counts[level],
                "ratios": all.collect::<Vec<Value>>()})
        };
        let cases = self.cases.iter().enumerate().map(|(k, case)| {
            let [mean, max] = self.ours_over_layered(k);
            let [layered, paper, ours] = self.means(k);
            json!({"deformation": case.way.name(), "amplitude": case.amplitude,
                "means_of_inner_levels": {"layered": layered, "paper": paper, "ours": ours},
                "most_ours_over_layered_of_inner_levels": {"mean": mean, "max": max}})
        });
        json!({
            "least_layered_over_wrapped_of_inner_levels": self.least_layered(),
            "cases": cases.collect::<Vec<Value>>(),
            "levels": self.levels.iter().enumerate().map(level).collect::<Vec<Value>>(),
        })
    }

    /// A row per case on one level.
    pub(super) fn figure_rows(&self, mesh: &str, level: usize) -> Vec<Vec<Cell>> {
        let Some(of_level) = self.levels.get(level) else {
            return Vec::new();
        };
        let rows = self.cases.iter().zip(of_level).enumerate();
        rows.map(|(k, (case, spreads))| {
            let share = format!("{} %", 100.0 * case.amplitude);
            let mut row = vec![mesh.into(), case.way.name().into(), share.into()];
            row.extend(spreads.iter().map(text));
            row.extend(spreads.iter().map(|s| Cell::Number(s.largest)));
            row.extend(self.means(k).map(Cell::Number));
            row.push(self.ours_over_layered(k)[0].into());
            row
        })
        .collect()
    }

    /// The natural case of the largest amplitude.
    fn last_natural(&self) -> usize {
        let natural = self.cases.iter().rposition(|case| case.way == Way::Natural);
        natural.unwrap_or(0)
    }

    /// A row per level: at rest and at the largest natural deformation.
    pub(super) fn level_rows(&self, mesh: &str) -> Vec<Vec<Cell>> {
        let last = self.last_natural();
        let rows = self.levels.iter().enumerate();
        rows.map(|(level, of_level)| {
            let mut row = vec![mesh.into(), level.into(), self.counts[level].into()];
            let [layered, _, ours] = &of_level[0];
            row.extend([text(layered), text(ours)]);
            row.extend(of_level[last].iter().map(text));
            row
        })
        .collect()
    }

    /// Means by level at rest and at the largest natural deformation.
    pub(super) fn chart(&self) -> Plot {
        let last = self.last_natural();
        let line = |name: String, case: usize, kind: usize| Line {
            name,
            points: (0..)
                .map(f64::from)
                .zip(self.levels.iter().map(|level| level[case][kind].mean))
                .collect(),
        };
        let share = 100.0 * self.cases[last].amplitude;
        let mut lines = vec![
            line("layered, at rest".to_string(), 0, 0),
            line("ours, at rest".to_string(), 0, 2),
        ];
        for (k, kind) in Kind::ALL.into_iter().enumerate() {
            lines.push(line(format!("{}, {share} %", kind.short()), last, k));
        }
        let level = Axis::linear("level of the binary tree");
        let title = "Chair: radius over the wrapped sphere's at rest";
        Plot::new(title, &level, &Axis::linear("mean ratio"), lines)
    }
}

/// Mean and largest.
fn text(spread: &Spread) -> Cell {
    Cell::Text(format!("{:.3} / {:.3}", spread.mean, spread.max))
}

pub(super) fn figure_table() -> Table {
    let title = "Figure 6: level 6, 64 spheres; radius over the undeformed wrapped sphere's, mean / largest, and the \
                 largest sphere over the diagonal. An amplitude is the way of the farthest vertex over the diagonal. \
                 Natural deformations: modes of about the same energy, or frames of the animation; even: all modes \
                 move about as far, which is rougher than bodies are. Then means over all spheres of the inner \
                 levels, and the largest quotient of ours and layered of any inner level's means. The paper's \
                 bridge: layered 1.31 / 1.77 at rest; deformed 1.31 / 1.79, BD-Tree 1.25 / 1.56.";
    let columns = [
        "mesh",
        "deformation",
        "amplitude",
        "layered",
        "paper's bound",
        "ours",
        "largest layered",
        "largest paper's",
        "largest ours",
        "layered, inner levels",
        "paper's, inner levels",
        "ours, inner levels",
        "ours over layered, most of any level",
    ];
    Table::new("figure-6", title, &columns)
}

pub(super) fn level_table() -> Table {
    let title = "The same on every level (figure 4): mean / largest at rest and at the largest natural amplitude.";
    let columns = [
        "mesh",
        "level",
        "spheres",
        "layered, at rest",
        "ours, at rest",
        "layered, deformed",
        "paper's bound, deformed",
        "ours, deformed",
    ];
    Table::new("levels", title, &columns)
}
