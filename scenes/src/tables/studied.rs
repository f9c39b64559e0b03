//! The other bounds of docs/node-bounds.md on the fixtures: what a sphere about the same vertices could be.

use bdtree_baselines as baselines;
use bdtree_build::tree::{LaneKind, Split};
use bdtree_format::LANES;
use nalgebra::Vector3;
use serde_json::{Value, json};

use super::ways::{Deformations, Way};
use crate::bounds::affine::{Affine, Stretch};
use crate::bounds::body::Body;
use crate::bounds::bound::{Bound, Wrapped};
use crate::bounds::sphere::{Growth, enclosing};
use crate::report::{Cell, Table};

const SHARED: Affine = Affine {
    shared: true,
    tangent: false,
    bent: false,
    placed: false,
    stretch: Stretch::Norm,
};

const PARTS: Affine = Affine {
    stretch: Stretch::Parts,
    ..SHARED
};

/// What is compared, with its heading.
const BOUNDS: [(&str, Bound); 6] = [
    ("ball b±", Bound::Ball(Growth::SecondOrder)),
    ("affine, shared", Bound::Affine(SHARED)),
    ("affine by parts, shared", Bound::Affine(PARTS)),
    ("b± or affine by parts, by node", Bound::BestOf(&[PARTS])),
    ("ball wrapped at c'", Bound::Wrapped),
    ("smallest ball", Bound::Smallest),
];

/// Lanes of a level that are measured, at most: evenly spread.
const LANES_MAX: usize = 2048;

/// The mean radii of a level's lanes over those at rest.
pub(super) struct Studied {
    way: Way,
    amplitude: f64,
    level: usize,
    lanes: usize,
    /// By [`BOUNDS`].
    ratios: [f64; BOUNDS.len()],
}

/// Of both ways and all amplitudes (shares of the diagonal), on every level of the product's tree.
pub(super) fn measure(
    body: &baselines::Body,
    deformations: &Deformations<'_, '_>,
    amplitudes: &[f64],
) -> Vec<Studied> {
    let count = body.positions.len();
    let fields = body.fields.chunks(count.max(1)).map(|field| {
        let wide = field.iter().map(|u| Vector3::from(u.map(f64::from)));
        wide.collect::<Vec<_>>()
    });
    let triangles = body.triangles.clone();
    let own = Body::new(&body.positions, fields.collect(), triangles, Split::Cost, 4);
    let bounds = BOUNDS.map(|(_, bound)| Wrapped::new(&own, bound));
    let levels = lanes_by_level(&own);
    let mut studied = Vec::new();
    for way in [Way::Natural, Way::Even] {
        for amplitude in amplitudes.iter().copied() {
            let all = deformations.of(way, amplitude);
            let mut sums = vec![[0.0; BOUNDS.len()]; levels.len()];
            for q in &all {
                let q: Vec<f64> = q.iter().map(|q| f64::from(*q)).collect();
                let deformed = own.deformed(&q);
                for (lanes, sums) in levels.iter().zip(&mut sums) {
                    for (lane, rest) in lanes {
                        for (sum, bound) in sums.iter_mut().zip(&bounds) {
                            let ball = bound.at(&own, *lane, &q, &deformed).ball;
                            *sum += ball.map_or(f64::NAN, |ball| ball.radius) / rest;
                        }
                    }
                }
            }
            let of_levels = levels.iter().zip(sums).enumerate();
            studied.extend(of_levels.map(|(level, (lanes, sums))| Studied {
                way,
                amplitude,
                level,
                lanes: lanes.len(),
                ratios: sums.map(|sum| sum / (lanes.len() * all.len()) as f64),
            }));
        }
    }
    studied
}

/// Lanes and their radii at rest, by level; those of a single point are left out.
fn lanes_by_level(body: &Body) -> Vec<Vec<(usize, f64)>> {
    let mut level = vec![0; body.tree.nodes.len()];
    let mut levels: Vec<Vec<usize>> = Vec::new();
    for lane in 0..body.lane_count() {
        let own = level[lane / LANES];
        levels.resize(levels.len().max(own + 1), Vec::new());
        match body.kind(lane) {
            LaneKind::Empty => continue,
            LaneKind::Inner => level[body.child(lane)] = own + 1,
            LaneKind::Leaf => {}
        }
        levels[own].push(lane);
    }
    let measured = levels.into_iter().map(|lanes| {
        let step = lanes.len().div_ceil(LANES_MAX).max(1);
        let lanes = lanes.into_iter().step_by(step);
        let radii = lanes.map(|lane| (lane, enclosing(&body.rest(lane)).radius));
        radii.filter(|(_, radius)| *radius > 0.0).collect()
    });
    measured.collect()
}

impl Studied {
    pub(super) fn json(&self) -> Value {
        let ratios = BOUNDS.iter().zip(self.ratios);
        let ratios: serde_json::Map<String, Value> = ratios
            .map(|((name, _), ratio)| (name.to_string(), ratio.into()))
            .collect();
        json!({"deformation": self.way.name(), "amplitude": self.amplitude, "level": self.level,
            "lanes": self.lanes, "ratios": ratios})
    }

    pub(super) fn row(&self, mesh: &str) -> Vec<Cell> {
        let share = format!("{} %", 100.0 * self.amplitude);
        let mut row = vec![mesh.into(), self.way.name().into(), share.into()];
        row.extend([self.level, self.lanes].map(Cell::from));
        row.extend(self.ratios.map(|ratio| Cell::Text(format!("{ratio:.3}"))));
        row
    }
}

pub(super) fn table() -> Table {
    let title = "Other bounds on the product's tree: mean radius over the smallest ball's at rest, by level of \
                 nodes of eight (level 1 has 64 spheres), at most 2048 spheres of a level";
    let columns: Vec<&str> = ["mesh", "deformation", "amplitude", "level", "spheres"]
        .into_iter()
        .chain(BOUNDS.iter().map(|(name, _)| *name))
        .collect();
    Table::new("bounds", title, &columns)
}
