//! What was tried, and how close it came.

use bdtree_format::SectionKind;
use bdtree_runtime::{Asset, Datum, FormatError};
use serde::Serialize;

use super::{Options, kernels};
use crate::info::section_start;

/// Most violations that are kept.
pub(super) const VIOLATIONS_MAX: usize = 1000;

/// A vertex close to the surface of a sphere above it, or beyond. Lengths in stored units; as `verify` prints
/// it in mesh units.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tight {
    /// How far the vertex is inside, over the pose's slack; negative when it is outside.
    pub margin_slacks: f64,
    /// The kernel that evaluated the sphere.
    pub kernel: String,
    /// Node index.
    pub node: u32,
    /// Lane of the node, 0 to 7.
    pub lane: usize,
    /// Vertex id, one below the lane.
    pub vertex: u32,
    /// The sphere's radius.
    pub radius: f64,
    /// From the sphere's center to the vertex.
    pub distance: f64,
    /// What the pose adds to every radius for rounding.
    pub slack: f64,
    /// The reduced coordinates.
    pub q: Vec<f32>,
}

/// What a stress run did and found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
    /// Nodes at a q.
    pub cases: u64,
    /// q tried.
    pub poses: u64,
    /// Vertices held against a sphere.
    pub vertices: u64,
    /// Spheres without a radius (NaN): queries visit those, sound files have none.
    pub unbounded: u64,
    /// Vertices outside a sphere above them, at most 1000.
    pub violations: Vec<Tight>,
    /// The vertex that came closest to a surface, in slacks; `None` when no vertex was tried.
    pub tightest: Option<Tight>,
}

impl Report {
    /// Notes a margin in slacks.
    #[inline]
    pub(super) fn margin(&mut self, margin_slacks: f64, tight: impl FnOnce() -> Tight) {
        let looser = |t: &Tight| margin_slacks >= t.margin_slacks;
        if !self.tightest.as_ref().is_some_and(looser) {
            self.tightest = Some(tight());
        }
    }

    /// Notes a vertex that is outside.
    pub(super) fn violation(&mut self, tight: Tight) {
        if self.violations.len() < VIOLATIONS_MAX {
            self.violations.push(tight);
        }
    }

    /// Adds what came after this in the order of the cases.
    pub(super) fn add(&mut self, later: Self) {
        self.cases += later.cases;
        self.poses += later.poses;
        self.vertices += later.vertices;
        self.unbounded += later.unbounded;
        later.violations.into_iter().for_each(|v| self.violation(v));
        if let Some(tight) = later.tightest {
            self.margin(tight.margin_slacks, || tight);
        }
    }

    /// What was found as errors of the file, at the rows of nodes: one for each vertex outside a sphere, at most
    /// 1000.
    pub(crate) fn errors(&self, asset: &Asset<'_>) -> Vec<FormatError> {
        let error = |row: u64, rule, expected, found| FormatError {
            section: SectionKind::ROWS,
            byte: section_start(asset, SectionKind::ROWS) + 32 * row,
            rule,
            expected,
            found,
        };
        let outside = |tight: &Tight| {
            let node = asset.nodes().get(tight.node as usize);
            let row = node.map_or(0, |node| u64::from(node.row_start));
            let rule = "guarantees: a sphere holds every deformed vertex below it";
            let (expected, found) = (Datum::AtLeast(tight.distance), Datum::Real(tight.radius));
            error(row, rule, expected, found)
        };
        let mut errors: Vec<FormatError> = self.violations.iter().map(outside).collect();
        if self.unbounded > 0 {
            let rule = "guarantees: the radicand of a radius is not negative";
            let found = Datum::Integer(self.unbounded);
            errors.push(error(0, rule, Datum::Integer(0), found));
        }
        errors
    }

    /// As figures.
    pub(crate) fn summary(
        self,
        asset: &Asset<'_>,
        options: Options,
        rounding_slack_rel: f64,
    ) -> Summary {
        let unit = asset.unit();
        let in_mesh_units = |tight: Tight| Tight {
            radius: tight.radius * unit,
            distance: tight.distance * unit,
            slack: tight.slack * unit,
            ..tight
        };
        Summary {
            cases: self.cases,
            seed: options.seed,
            poses: self.poses,
            vertices: self.vertices,
            kernels: kernels().iter().map(|k| format!("{k:?}")).collect(),
            violations: self.violations.len(),
            unbounded: self.unbounded,
            tightest: self.tightest.map(in_mesh_units),
            rounding_slack_rel,
        }
    }
}

/// What `verify --stress --json` prints under `stress`.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// Nodes at a q.
    pub cases: u64,
    /// What the cases were made from.
    pub seed: u64,
    /// q tried.
    pub poses: u64,
    /// Vertices held against a sphere.
    pub vertices: u64,
    /// The kernels that took turns.
    pub kernels: Vec<String>,
    /// Vertices outside a sphere above them, at most 1000.
    pub violations: usize,
    /// Spheres without a radius, which queries visit.
    pub unbounded: u64,
    /// The closest call, in mesh units.
    pub tightest: Option<Tight>,
    /// What rounding adds to the mean radius at q within ± `q_range`, as a share of it.
    pub rounding_slack_rel: f64,
}

/// The name that the processor's makers gave the instructions of a kernel.
fn instructions(kernel: &str) -> String {
    match kernel {
        "Scalar" => "scalar".to_string(),
        name => name.to_uppercase(),
    }
}

impl std::fmt::Display for Summary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            cases,
            poses,
            vertices,
            violations,
            unbounded,
            ..
        } = self;
        match violations {
            0 => writeln!(f, "{vertices} vertex checks passed, none failed")?,
            n => writeln!(f, "{n} of {vertices} vertex checks failed")?,
        }
        if *unbounded > 0 {
            writeln!(f, "{unbounded} spheres have no radius")?;
        }
        writeln!(f, "{cases} cases: a node in one of {poses} poses")?;
        if let Some(t) = &self.tightest {
            writeln!(
                f,
                "smallest margin: {:.1} % of the rounding allowance of {:.2e} mesh units (sphere {} of node \
                 {}, vertex {}, {} code)",
                100.0 * t.margin_slacks,
                t.slack,
                t.lane,
                t.node,
                t.vertex,
                instructions(&t.kernel)
            )?;
        }
        let percent = 100.0 * self.rounding_slack_rel;
        write!(
            f,
            "rounding adds {percent:.2e} % to the mean radius at q_range"
        )
    }
}
