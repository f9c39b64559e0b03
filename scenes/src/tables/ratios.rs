//! Figures 4 and 6 in numbers: radii of three hierarchies over those of the undeformed wrapped spheres.

use std::error::Error;

use bdtree_fixtures::poses;
use bdtree_render::tightness::mean_and_max;
use bdtree_runtime::Asset;
use serde::Serialize;

use super::ways::{Deformations, Way};
use crate::hierarchies::{ByKind, Hierarchies, Kind};
use crate::report::{Cell, Table};
use bdtree_measure::plot::{Axis, Line, Plot};

/// How far a body is deformed, and how.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Case {
    #[serde(rename = "deformation")]
    way: Way,
    /// Way of the farthest vertex over the diagonal.
    amplitude: f64,
}

/// Over the nodes of a level and all deformations of a case.
#[derive(Debug, Clone, Copy, Serialize)]
struct Spread {
    mean: f64,
    max: f64,
    /// Radius of the largest sphere over the diagonal of the box.
    largest: f64,
}

/// A case on a level.
#[derive(Serialize)]
struct Ratio {
    #[serde(flatten)]
    case: Case,
    #[serde(flatten)]
    spreads: ByKind<Spread>,
}

/// All cases on a level, rest first.
#[derive(Serialize)]
struct Level {
    level: usize,
    /// How many.
    spheres: usize,
    ratios: Vec<Ratio>,
}

/// The largest quotient of the means, and of the largest ratios, of ours and layered on any level.
#[derive(Serialize)]
struct Quotients {
    mean: f64,
    max: f64,
}

/// A case on all levels but the last, which has leaves only.
#[derive(Serialize)]
struct Inner {
    #[serde(flatten)]
    case: Case,
    /// Mean ratios over all spheres.
    means_of_inner_levels: ByKind<f64>,
    most_ours_over_layered_of_inner_levels: Quotients,
}

/// Of one asset.
#[derive(Serialize)]
pub(super) struct Ratios {
    /// The least mean of layered over wrapped at rest of any.
    least_layered_over_wrapped_of_inner_levels: f64,
    cases: Vec<Inner>,
    levels: Vec<Level>,
}

/// `amplitudes` are shares of the diagonal.
pub(super) fn measure(
    asset: &Asset<'_>,
    trees: &Hierarchies<'_>,
    deformations: &Deformations<'_, '_>,
    amplitudes: &[f64],
) -> Result<Ratios, Box<dyn Error>> {
    let diagonal = poses::diagonal(asset);
    let rest = Case {
        way: Way::Rest,
        amplitude: 0.0,
    };
    let mut posed = vec![(rest, vec![trees.posed(&vec![0.0; asset.mode_count()])?])];
    for way in [Way::Natural, Way::Even] {
        for amplitude in amplitudes.iter().copied() {
            let own = deformations.of(way, amplitude);
            let own = own.iter().map(|q| trees.posed(q));
            posed.push((Case { way, amplitude }, own.collect::<Result<_, _>>()?));
        }
    }
    let mut levels = Vec::new();
    for level in 0..trees.depth() {
        let nodes = trees.level(level)?;
        let ratios = posed.iter_mut().map(|(case, posed)| {
            let spread = |kind| {
                let found = posed.iter_mut().flat_map(|p| nodes.spheres(kind, p));
                let both = found.map(|sphere| (sphere.growth, sphere.radius));
                let (growths, radii): (Vec<f64>, Vec<f64>) = both.unzip();
                let [mean, max] = mean_and_max(&growths).unwrap_or([f64::NAN; 2]);
                let largest = radii.into_iter().fold(0.0, f64::max) / diagonal;
                Spread { mean, max, largest }
            };
            Ratio {
                case: *case,
                spreads: Kind::ALL.map(spread).into(),
            }
        });
        levels.push(Level {
            level,
            ratios: ratios.collect(),
            spheres: trees.count(level),
        });
    }
    let inner = &levels[..levels.len().saturating_sub(1)];
    let least = inner
        .iter()
        .map(|level| level.ratios[0].spreads.layered.mean);
    Ok(Ratios {
        least_layered_over_wrapped_of_inner_levels: least.fold(f64::INFINITY, f64::min),
        cases: (0..posed.len())
            .map(|k| Inner::new(posed[k].0, inner, k))
            .collect(),
        levels,
    })
}

impl Inner {
    fn new(case: Case, levels: &[Level], k: usize) -> Self {
        let (mut sums, mut count) = ([0.0; 3], 0.0);
        let mut most = Quotients {
            mean: 0.0,
            max: 0.0,
        };
        for level in levels {
            let ByKind {
                layered,
                paper,
                ours,
            } = level.ratios[k].spreads;
            for (sum, spread) in sums.iter_mut().zip([layered, paper, ours]) {
                *sum += spread.mean * level.spheres as f64;
            }
            count += level.spheres as f64;
            most.mean = most.mean.max(ours.mean / layered.mean);
            most.max = most.max.max(ours.max / layered.max);
        }
        Self {
            case,
            means_of_inner_levels: sums.map(|sum| sum / count).into(),
            most_ours_over_layered_of_inner_levels: most,
        }
    }
}

impl Level {
    /// At the largest natural amplitude.
    fn deformed(&self) -> &Ratio {
        let natural = |ratio: &&Ratio| ratio.case.way == Way::Natural;
        let last = self.ratios.iter().rfind(natural);
        last.unwrap_or(&self.ratios[0])
    }
}

/// Mean and largest.
fn text(spread: &Spread) -> Cell {
    Cell::Text(format!("{:.3} / {:.3}", spread.mean, spread.max))
}

/// A row per mesh and case on one level.
pub(super) fn figure_table(all: &[(&str, &Ratios)], level: usize) -> Table {
    let title = "Figure 6: level 6, 64 spheres; radius over the undeformed wrapped sphere's, mean / largest, and the \
                 largest sphere over the diagonal. An amplitude is the way of the farthest vertex over the diagonal. \
                 Natural deformations: modes of about the same energy, or frames of the animation; even: all modes \
                 move about as far, which is rougher than bodies are. Then means over all spheres of the inner \
                 levels, and the largest quotient of ours and layered of any inner level's means. The paper's \
                 bridge: layered 1.31 / 1.77 at rest; deformed 1.31 / 1.79, BD-Tree 1.25 / 1.56.";
    let rows = all.iter().flat_map(|(mesh, all)| {
        let of_level = all.levels.get(level).into_iter();
        let spreads = of_level.flat_map(|level| &level.ratios);
        let rows = all.cases.iter().zip(spreads);
        rows.map(move |(case, ratio)| (*mesh, case, &ratio.spreads))
    });
    Table::of(
        "figure-6",
        title,
        &rows.collect::<Vec<_>>(),
        &[
            ("mesh", &|(mesh, ..)| (*mesh).into()),
            ("deformation", &|(_, inner, _)| inner.case.way.name().into()),
            ("amplitude", &|(_, inner, _)| {
                format!("{} %", 100.0 * inner.case.amplitude).into()
            }),
            ("layered", &|(.., s)| text(&s.layered)),
            ("paper's bound", &|(.., s)| text(&s.paper)),
            ("ours", &|(.., s)| text(&s.ours)),
            ("largest layered", &|(.., s)| s.layered.largest.into()),
            ("largest paper's", &|(.., s)| s.paper.largest.into()),
            ("largest ours", &|(.., s)| s.ours.largest.into()),
            ("layered, inner levels", &|(_, inner, _)| {
                inner.means_of_inner_levels.layered.into()
            }),
            ("paper's, inner levels", &|(_, inner, _)| {
                inner.means_of_inner_levels.paper.into()
            }),
            ("ours, inner levels", &|(_, inner, _)| {
                inner.means_of_inner_levels.ours.into()
            }),
            ("ours over layered, most of any level", &|(_, inner, _)| {
                inner.most_ours_over_layered_of_inner_levels.mean.into()
            }),
        ],
    )
}

/// A row per mesh and level.
pub(super) fn level_table(all: &[(&str, &Ratios)]) -> Table {
    let title = "The same on every level (figure 4): mean / largest at rest and at the largest natural amplitude.";
    let rows = all.iter();
    let rows = rows.flat_map(|(mesh, all)| all.levels.iter().map(|level| (*mesh, level)));
    let rest = |level: &Level| level.ratios[0].spreads;
    let deformed = |level: &Level| level.deformed().spreads;
    Table::of(
        "levels",
        title,
        &rows.collect::<Vec<_>>(),
        &[
            ("mesh", &|(mesh, _)| (*mesh).into()),
            ("level", &|(_, level)| level.level.into()),
            ("spheres", &|(_, level)| level.spheres.into()),
            ("layered, at rest", &|(_, level)| text(&rest(level).layered)),
            ("ours, at rest", &|(_, level)| text(&rest(level).ours)),
            ("layered, deformed", &|(_, level)| {
                text(&deformed(level).layered)
            }),
            ("paper's bound, deformed", &|(_, level)| {
                text(&deformed(level).paper)
            }),
            ("ours, deformed", &|(_, level)| text(&deformed(level).ours)),
        ],
    )
}

impl Ratios {
    /// Means by level at rest and at the largest natural deformation.
    pub(super) fn chart(&self) -> Plot {
        let line = |name: String, mean: &dyn Fn(&Level) -> f64| Line {
            name,
            points: (0..)
                .map(f64::from)
                .zip(self.levels.iter().map(mean))
                .collect(),
        };
        let share = 100.0 * self.levels[0].deformed().case.amplitude;
        let rest = |level: &Level| level.ratios[0].spreads;
        let deformed = |level: &Level| level.deformed().spreads;
        let lines = vec![
            line("layered, at rest".to_string(), &|l| rest(l).layered.mean),
            line("ours, at rest".to_string(), &|l| rest(l).ours.mean),
            line(format!("layered, {share} %"), &|l| deformed(l).layered.mean),
            line(format!("paper, {share} %"), &|l| deformed(l).paper.mean),
            line(format!("ours, {share} %"), &|l| deformed(l).ours.mean),
        ];
        let level = Axis::linear("level of the binary tree");
        let title = "Chair: radius over the wrapped sphere's at rest";
        Plot::new(title, &level, &Axis::linear("mean ratio"), lines)
    }
}
