//! A stress run in words and as JSON.

use std::fmt;

use bdtree_format::SectionKind;
use bdtree_runtime::{Asset, Datum, FormatError};
use serde::Serialize;

use super::report::{Report, Tight};
use super::{Options, kernels};

/// A stress run as it is told: as errors of the file, and as figures.
pub(crate) struct Stressed {
    /// One for each vertex outside a sphere, at most 1000.
    pub(crate) errors: Vec<FormatError>,
    pub(crate) summary: Summary,
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
    /// The closest call.
    pub tightest: Option<Tightest>,
    /// What certainty adds to the mean radius at q within ± `q_range`, as a share of it.
    pub certainty_rel: f64,
}

/// The vertex closest to the surface of a sphere above it, or farthest outside. Lengths in mesh units.
#[derive(Debug, Serialize)]
pub struct Tightest {
    /// How far it is inside, over what the pose adds to every radius for rounding.
    pub margin_slacks: f64,
    /// The kernel that evaluated the sphere.
    pub kernel: String,
    /// Node index.
    pub node: u32,
    /// Lane of the node.
    pub lane: usize,
    /// Vertex id.
    pub vertex: u32,
    /// The sphere's radius.
    pub radius: f64,
    /// From the sphere's center to the vertex.
    pub distance: f64,
    /// What the pose adds to every radius.
    pub slack: f64,
    /// The reduced coordinates.
    pub q: Vec<f32>,
}

impl Tightest {
    fn of(tight: &Tight, unit: f64) -> Self {
        Self {
            margin_slacks: tight.margin(),
            kernel: format!("{:?}", tight.kernel),
            node: tight.node,
            lane: tight.lane,
            vertex: tight.vertex,
            radius: tight.radius * unit,
            distance: tight.distance * unit,
            slack: tight.slack * unit,
            q: tight.q.clone(),
        }
    }
}

impl Stressed {
    pub(crate) fn of(asset: &Asset<'_>, options: Options, report: &Report, certainty: f64) -> Self {
        let error = |tight: &Tight| outside(asset, tight);
        let summary = Summary {
            cases: report.cases,
            seed: options.seed,
            poses: report.poses,
            vertices: report.vertices,
            kernels: kernels().iter().map(|k| format!("{k:?}")).collect(),
            violations: report.violations.len(),
            unbounded: report.unbounded,
            tightest: report
                .tightest
                .as_ref()
                .map(|tight| Tightest::of(tight, asset.unit())),
            certainty_rel: certainty,
        };
        let mut errors: Vec<FormatError> = report.violations.iter().map(error).collect();
        errors.extend((report.unbounded > 0).then(|| without_radius(asset, report.unbounded)));
        Self { errors, summary }
    }
}

/// The error for a vertex outside a sphere: at the rows of the sphere's node.
fn outside(asset: &Asset<'_>, tight: &Tight) -> FormatError {
    let node = asset.nodes().get(tight.node as usize);
    let row = node.map_or(0, |node| u64::from(node.row_start));
    FormatError {
        section: SectionKind::ROWS,
        byte: rows_offset(asset) + 32 * row,
        rule: "guarantees: a sphere holds every deformed vertex below it",
        expected: Datum::Real(tight.distance),
        found: Datum::Real(tight.radius),
    }
}

/// The error for spheres whose radius is not a number.
fn without_radius(asset: &Asset<'_>, count: u64) -> FormatError {
    FormatError {
        section: SectionKind::ROWS,
        byte: rows_offset(asset),
        rule: "guarantees: the radicand of a radius is not negative",
        expected: Datum::Integer(0),
        found: Datum::Integer(count),
    }
}

fn rows_offset(asset: &Asset<'_>) -> u64 {
    let mut sections = asset.sections().iter();
    let rows = sections.find(|s| s.kind == SectionKind::ROWS);
    rows.map_or(0, |s| s.offset.get())
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            cases,
            poses,
            vertices,
            violations,
            unbounded,
            certainty_rel,
            ..
        } = self;
        write!(
            f,
            "{cases} cases (nodes at one of {poses} q), {vertices} vertices held against spheres \
             above them, {violations} outside; "
        )?;
        if *unbounded > 0 {
            write!(f, "{unbounded} spheres without a radius; ")?;
        }
        if let Some(t) = &self.tightest {
            write!(
                f,
                "tightest: {:.3} of the {:.2e} mesh units that rounding is given are left (node {}, \
                 lane {}, vertex {}, {}); ",
                t.margin_slacks, t.slack, t.node, t.lane, t.vertex, t.kernel
            )?;
        }
        let percent = 100.0 * certainty_rel;
        write!(
            f,
            "certainty costs {percent:.2e} % of the mean radius at q_range"
        )
    }
}
