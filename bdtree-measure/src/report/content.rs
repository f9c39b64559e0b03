//! What a report says, as numbers: the page is made of these and of nothing else, and `--json` prints
//! them. Lengths are mesh units unless a name says otherwise; unknown values are null.

use std::collections::BTreeMap;

use crate::comparison::Comparison;
use serde::Serialize;

/// A report on one asset.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Content {
    /// The file's name.
    pub file: String,
    /// The day of the measurements, UTC, as 2026-01-31.
    pub date: String,
    /// What it was made of, and how.
    pub made: Made,
    /// The report in a few sentences.
    pub verdict: Vec<String>,
    /// What it holds.
    pub asset: Facts,
    /// What the times were measured with.
    pub machine: Machine,
    /// The poses that counts and times are of.
    pub samples: Samples,
    /// What cannot be said of this asset, and why.
    pub missing: Vec<String>,
    /// What to do, each with its figures.
    pub advice: Vec<Advice>,
    /// Fewer modes: error, bytes, time. Empty without modes.
    pub modes: Vec<ModesRow>,
    /// The q that the errors of `modes` are taken over, in words; null without modes.
    pub modes_over: Option<String>,
    /// The advised modes where they are not the first ones, as those of `modes` are; else null.
    pub modes_advised: Option<ModesAdvised>,
    /// The same ball queries without a level to stop at.
    pub depth_whole: WholeQuery,
    /// Queries stopped at a level, from the root's down.
    pub depth: Vec<DepthRow>,
    /// R'/R_opt per level, in the poses of the samples and, without a skin, per amplitude. Empty where nothing moves.
    pub tightness: Vec<TightnessRow>,
    /// How close a vertex came to leaving a sphere; null where nothing was tried.
    pub margin: Option<Margin>,
    /// Beside deforming all vertices, which with a skin includes carrying them by their bones, and refitting a tree; null
    /// for a rigid asset, which needs neither.
    pub refit: Option<Refit>,
    /// Bytes by section, in file order.
    pub sections: Vec<SectionRow>,
    /// What scenes that ask less never read.
    pub unneeded: Vec<Unneeded>,
    /// Seconds that each part of the report took.
    pub seconds: Vec<Seconds>,
}

/// What a file was made of, as its metadata say; null where they do not.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Made {
    /// The source's name.
    pub source: Option<String>,
    /// The program that baked it, with its version.
    pub builder: Option<String>,
    /// Where its modes come from: `elastic`, `pca`, `given`, …
    pub basis: Option<String>,
    /// Meters of a mesh unit.
    pub scale_m: Option<f64>,
    /// Options of `bdtree-build`, by name.
    pub settings: BTreeMap<String, String>,
    /// It was baked as `advice` says; null where modes were not measured.
    pub is_as_advised: Option<bool>,
    /// The command that bakes it anew as `advice` says; null where the source has no name or nothing is advised.
    pub command: Option<String>,
}

/// What a file holds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Facts {
    /// Number of vertices N.
    pub vertices: usize,
    /// Number of triangles F.
    pub triangles: usize,
    /// Number of modes M.
    pub modes: usize,
    /// Number of eight-wide nodes.
    pub nodes: usize,
    /// Number of node levels.
    pub depth: usize,
    /// Number of animation frames; null without an animation.
    pub frames: Option<usize>,
    /// What carries the vertices; null without a skin.
    pub skin: Option<Skin>,
    /// Length of the file.
    pub bytes: u64,
    /// Sides of the box of the triangles at rest; with a skin, of where its bones at rest carry them.
    pub size: [f64; 3],
    /// Its diagonal.
    pub diagonal: f64,
    /// Largest error of the basis against its source over the diagonal; null where there is no source.
    pub basis_error_rel: Option<f64>,
}

/// A skin.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Skin {
    /// Number of joints.
    pub joints: usize,
    /// Number of bones: distinct pairs of a joint and an inverse bind matrix.
    pub bones: usize,
    /// Number of clips.
    pub clips: usize,
    /// The most bones that carry one vertex.
    pub influences_max: usize,
}

/// What measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Machine {
    /// Its processor.
    pub processor: String,
    /// The node kernel in use.
    pub kernel: String,
    /// Repetitions of which times are medians, where they are: those of `modes` are the least of some rounds, and
    /// steps of `refit` that take long are repeated less often.
    pub repetitions: usize,
}

/// Where the sample poses come from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Samples {
    /// How many.
    pub count: usize,
    /// In words.
    pub source: String,
    /// The farthest that any of them moves a vertex, over the diagonal.
    pub displacement_max_rel: f64,
    /// How many of them each part looks at.
    pub of_parts: Parts,
    /// Radii of balls over the diagonal.
    pub balls: Balls,
}

impl Samples {
    /// So many of them, in words.
    pub(super) fn some(&self, count: usize) -> String {
        match count == self.count {
            true => self.source.clone(),
            false => format!("{count} of {}", self.source),
        }
    }
}

/// Samples of a part; 0 where the part is left out.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Parts {
    /// Of `modes`.
    pub modes: usize,
    /// Of `depth`.
    pub depth: usize,
    /// Of `tightness`.
    pub tightness: usize,
    /// Of `refit`.
    pub refit: usize,
}

/// Radii over the diagonal.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Balls {
    /// Of `modes` and `depth`.
    pub large_rel: f64,
    /// Of `refit`.
    pub small_rel: f64,
}

/// A sentence of advice.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Advice {
    /// What it is about: `modes`, `leaf size`, `depth`, `refit`, `sections`.
    pub topic: String,
    /// What to do and what it brings.
    pub text: String,
}

/// The first modes kept.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModesRow {
    /// How many.
    pub modes: usize,
    /// Largest distance of a vertex from where all modes put it, over `modes_over` and vertices.
    pub error_max: f64,
    /// Root mean square of those distances; over ranges that of the vertices' largest.
    pub error_rms: f64,
    /// The largest over the diagonal.
    pub error_max_rel: f64,
    /// The root mean square over the diagonal.
    pub error_rms_rel: f64,
    /// Length of a file baked with so many modes, without what the source said besides the mesh and its modes.
    pub bytes: u64,
    /// Nodes that a ball of 5 % of the diagonal visits, mean.
    pub ball_visits: f64,
    /// Those of a ray.
    pub ray_visits: f64,
    /// Those of the asset against itself beside it.
    pub pair_visits: f64,
    /// Time of a ball, µs.
    pub ball_micros: f64,
    /// Time of a ray, one of a batch of 16, µs.
    pub ray_micros: f64,
    /// Time of a pair, µs.
    pub pair_micros: f64,
    /// Time over that with all modes in the same run, geometric mean over the three; 1 for all modes.
    pub time_rel: f64,
}

/// Advised modes that are not the first ones.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModesAdvised {
    /// Their numbers, ascending.
    pub modes: Vec<usize>,
    /// The largest error that they leave at most, over the diagonal.
    pub error_max_rel: f64,
}

/// Ball queries without a level limit.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct WholeQuery {
    /// Time of one, µs.
    pub ball_micros: f64,
    /// Nodes that it visits, mean.
    pub ball_visits: f64,
    /// Samples where the ball touches nothing, over all samples.
    pub apart_rel: f64,
}

/// Queries stopped at a level (`Posed::bounded`).
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct DepthRow {
    /// The level; 0 is the root's.
    pub level: usize,
    /// Time of a ball query, µs.
    pub ball_micros: f64,
    /// That over the time of `depth_whole`.
    pub time_rel: f64,
    /// Nodes that it visits, mean.
    pub ball_visits: f64,
    /// Area of touched triangles that is in no answer and no reported sphere, over the area touched. It
    /// is 0: spheres are reported for whatever was not looked into.
    pub missed_area_rel: f64,
    /// Area of triangles in reported spheres that the ball does not touch, over the area touched.
    pub extra_area_rel: f64,
    /// Largest difference between the penetration that spheres and triangles report and the true one,
    /// over the diagonal.
    pub penetration_error_rel: f64,
    /// Samples whose answer has spheres though nothing touches, over all samples.
    pub false_rel: f64,
}

/// R'/R_opt of a level; R_opt is the radius of the smallest ball of the deformed vertices.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TightnessRow {
    /// How far the vertex that moves most is moved, over the diagonal; null where samples are taken as they are.
    pub displacement_rel: Option<f64>,
    /// The level; 0 is the root's.
    pub level: usize,
    /// Spheres that were measured.
    pub spheres: usize,
    /// The paper's bound: R + Σ ΔR_j |q_j|, Ū_j the mean (eqs. 4 to 7); null with a skin, since it knows no bones.
    pub paper: Option<Ratio>,
    /// The same with Ū_j the center of the smallest ball of the displacements.
    pub smallest_ball: Option<Ratio>,
    /// The file's.
    pub bdtree: Ratio,
}

/// Mean and largest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ratio {
    /// Mean.
    pub mean: f64,
    /// Largest.
    pub max: f64,
}

/// The tightest that a search in exact arithmetic found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Margin {
    /// Nodes at a q that were tried.
    pub cases: u64,
    /// Vertices outside a sphere: 0.
    pub violations: usize,
    /// The least distance of a vertex from the inside of a sphere, over what the pose adds to radii for
    /// rounding: above 0 it is inside, 1 where that addition was not touched.
    pub least: Option<f64>,
    /// What rounding adds to radii, over the mean radius at ± `q_range`; null where that says nothing.
    pub rounding_slack_rel: Option<f64>,
}

/// Times beside deform + refit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Refit {
    /// What was refitted.
    pub library: String,
    /// Deforming all vertices, and carrying them by their bones, µs.
    pub deform_micros: f64,
    /// Refitting, µs.
    pub refit_micros: f64,
    /// Preparing a pose instead, µs.
    pub pose_micros: f64,
    /// Memory that a refined pose takes, which ours uses where a step asks so much that it pays.
    pub refined_bytes: u64,
    /// Questions of one kind, by how many are asked per step.
    pub curves: Vec<Curve>,
}

/// Times over the number of questions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// `ball`, `ray` or `pair`.
    pub question: String,
    /// What `amount` counts: balls, rays, touching pairs of triangles.
    pub unit: String,
    /// Points, by rising amount, each with another one.
    pub points: Vec<CurvePoint>,
    /// Who is safely ahead, and where: `ahead`, `below`, `above`, `from`, `to`, `break_even`.
    #[serde(flatten)]
    pub comparison: Comparison,
}

/// One number of questions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CurvePoint {
    /// How many are asked, or how many pairs of triangles touch in the mean, per step. Where several places of the second
    /// instance touch nothing (0) times are geometric means, visits means.
    pub amount: f64,
    /// Ours, µs per step.
    pub bdtree_micros: f64,
    /// Deform, refit and ask, µs per step.
    pub refit_micros: f64,
    /// The second over the first; from 0.9 to 1.1 neither is safely ahead.
    pub ratio: f64,
    /// Nodes visited over all nodes; above 1 where several questions visit the same.
    pub visited_rel: f64,
    /// Share of the steps in which ours refined the pose.
    pub refined_rel: f64,
}

/// A section of the file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SectionRow {
    /// Its four letters.
    pub kind: String,
    /// What it is for.
    pub purpose: String,
    /// Its length.
    pub bytes: u64,
    /// Over the file's.
    pub share: f64,
}

/// What a scene that asks less never reads.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Unneeded {
    /// How the file is used.
    pub scene: String,
    /// What is never read then.
    pub without: String,
    /// Bytes of that.
    pub bytes: u64,
}

/// Time of a part of the report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Seconds {
    /// The part.
    pub part: String,
    /// Seconds.
    pub seconds: f64,
}
