//! What was made: sizes, stage times, errors, tightness. Serialises to the fields of `--json`.

pub(crate) mod random;
pub(crate) mod visits;

use std::collections::BTreeMap;

use bdtree_format::ROW_RADIUS;
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

use crate::basis::elastic::ElasticReport;
use crate::basis::volume::VolumeReport;
use crate::basis::{Basis, BasisError};
use crate::mass::MassProperties;
use crate::tree::{LaneKind, Met, Tree};
use crate::wrap::ball::smallest_ball;
use crate::wrap::{StoredShape, WrappedTree, mode_pair, modes_of};
use random::Random;
pub use visits::Visits;

/// Lanes per level that tightness is measured on.
const SAMPLES_MAX: usize = 1000;

/// Lanes whose deformed vertices fit a ball of this share of the whole's diagonal are points:
/// their ratio is rounding.
const POINT_SIZE_REL: f64 = 1e-6;

/// The least and the largest coordinates of a box.
pub type Bounds = [[f64; 3]; 2];

/// A finished bake.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BakeReport {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of modes.
    pub modes: usize,
    /// Number of joints, if there is a skin.
    pub joints: Option<usize>,
    /// Number of bones, each a joint with an inverse bind matrix, if there is a skin.
    pub bones: Option<usize>,
    /// Most bones of a vertex, if there is a skin.
    pub influences_max: Option<usize>,
    /// Number of clips, if there is a skin.
    pub clips: Option<usize>,
    /// Number of frames of the animation, if there is one.
    pub frames: Option<usize>,
    /// How long the animation lasts (s), if its frames have times.
    pub duration_s: Option<f64>,
    /// Number of eight-wide nodes.
    pub nodes: usize,
    /// Number of levels.
    pub depth: usize,
    /// Length of the file.
    pub bytes: usize,
    /// Least and largest coordinates of the rest positions (mesh units).
    #[serde(serialize_with = "min_and_max")]
    pub bounds: Bounds,
    /// The same with the bones at rest, for a file with a skin: of the stored numbers.
    #[serde(serialize_with = "min_and_max_if_any")]
    pub bounds_at_rest: Option<Bounds>,
    /// What was odd but kept.
    pub warnings: Vec<String>,
    /// Seconds per stage.
    pub stages: BTreeMap<String, f64>,
    /// Frequencies of all modes (Hz), when every mode has one.
    pub frequencies_hz: Option<Vec<f64>>,
    /// Error of the basis over the diagonal of the box.
    pub basis_error_rel: Option<BasisError>,
    /// Per level, the root's lanes being level 0.
    pub tightness: Vec<LevelTightness>,
    /// Nodes that small queries visit.
    pub visits: Visits,
    /// Mass, center of mass and inertia of the body at rest, if it is known.
    pub mass: Option<MassProperties>,
    /// Meters per mesh unit, where masses and frequencies depend on it.
    pub scale_m: Option<f64>,
    /// How elastic modes were found, if those are the fields.
    pub elastic: Option<ElasticReport>,
    /// How the modes of a volume were found, if those are the fields.
    pub volume: Option<VolumeReport>,
}

/// A box as `bdtree info` has it.
fn min_and_max<S: Serializer>([min, max]: &Bounds, to: S) -> Result<S::Ok, S::Error> {
    let mut object = to.serialize_struct("Bounds", 2)?;
    object.serialize_field("min", min)?;
    object.serialize_field("max", max)?;
    object.end()
}

fn min_and_max_if_any<S: Serializer>(bounds: &Option<Bounds>, to: S) -> Result<S::Ok, S::Error> {
    match bounds {
        Some(bounds) => min_and_max(bounds, to),
        None => to.serialize_none(),
    }
}

/// R'/R_opt of the lanes of one level at q = q_range; R_opt is the radius of the smallest ball
/// of the deformed vertices. Of a file with a skin both are those of the bind space, before bones carry them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LevelTightness {
    /// Level of the nodes.
    pub level: usize,
    /// Mean ratio.
    pub mean: f64,
    /// Largest ratio.
    pub max: f64,
}

/// ω_j / 2π of all modes, if every mode has a frequency and there is one.
pub(crate) fn frequencies_hz(basis: &Basis) -> Option<Vec<f64>> {
    if basis.modes.is_empty() {
        return None;
    }
    let hertz = |omega: f64| omega / std::f64::consts::TAU;
    basis
        .modes
        .iter()
        .map(|mode| mode.omega_rad_s.map(hertz))
        .collect()
}

/// Tightness per level, on at most 1000 lanes each, the same ones in every run. Lanes that
/// deform to a point are skipped, and so are levels without others.
pub(crate) fn tightness(
    tree: &Tree,
    triangles: &[[u32; 3]],
    shape: &StoredShape,
    wrapped: &WrappedTree,
) -> Vec<LevelTightness> {
    let q: Vec<f64> = shape
        .limits
        .iter()
        .map(|limits| f64::from(limits.q_range))
        .collect();
    let deformed = shape.deform(&q);
    let diagonal = f64::from(wrapped.position_norm_max);
    let mut met = Met::default();
    let mut points = Vec::new();
    let mut levels = Vec::new();
    for level in 0..tree.depth {
        let mut lanes: Vec<(usize, usize)> = tree
            .nodes
            .iter()
            .enumerate()
            .filter(|(_, node)| usize::from(node.level) == level)
            .flat_map(|(i, node)| {
                (0..node.lanes.len())
                    .filter(|&k| node.lanes[k].kind != LaneKind::Empty)
                    .map(move |k| (i, k))
            })
            .collect();
        Random::new().keep(SAMPLES_MAX, &mut lanes);
        let (mut sum, mut max, mut count) = (0.0, 0.0f64, 0usize);
        for (i, k) in lanes {
            let corners = tree.corners_below(tree.nodes[i].lanes[k], triangles);
            let vertices = met.once(deformed.len(), corners);
            points.clear();
            points.extend(vertices.map(|vertex| deformed[vertex as usize]));
            let best = smallest_ball(&points).radius;
            let ratio = radius_at(wrapped, shape, i, k, &q) / best;
            if best > POINT_SIZE_REL * diagonal && ratio.is_finite() {
                sum += ratio;
                max = max.max(ratio);
                count += 1;
            }
        }
        if count > 0 {
            let mean = sum / count as f64;
            levels.push(LevelTightness { level, mean, max });
        }
    }
    levels
}

/// R'(q) of one lane in f64, for q ≥ 0 (docs/design/guarantees.md).
fn radius_at(
    wrapped: &WrappedTree,
    shape: &StoredShape,
    node: usize,
    lane: usize,
    q: &[f64],
) -> f64 {
    let node = &wrapped.nodes[node];
    let rows = &wrapped.rows[node.row_start as usize..];
    let [_, growth_unit, cross_unit] = node.scale_exponents.map(|e| 2.0_f64.powi(e.into()));
    let modes = modes_of(&wrapped.mode_lists, node);
    let (mut cross, mut growth) = (0.0, 0.0);
    for (k, &mode) in modes.iter().enumerate() {
        let mode = usize::from(mode);
        let share = q[mode] / f64::from(shape.limits[mode].q_limit);
        let [_, _, _, own_growth, plus, _] = mode_pair(rows, k / 2).numbers(k, lane);
        growth += growth_unit * f64::from(own_growth) * share;
        cross += cross_unit * f64::from(plus) * share;
    }
    let radius = f64::from(rows[ROW_RADIUS][lane]);
    (radius * radius + 2.0 * cross + growth * growth)
        .max(0.0)
        .sqrt()
}
