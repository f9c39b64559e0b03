//! What was tried, and how close it came.

use bdtree_runtime::Kernel;

/// Most violations that are kept.
pub(super) const VIOLATIONS_MAX: usize = 1000;

/// A vertex close to the surface of a sphere above it, or beyond. Lengths in stored units.
#[derive(Debug, Clone, PartialEq)]
pub struct Tight {
    /// What evaluated the sphere.
    pub kernel: Kernel,
    /// Node index.
    pub node: u32,
    /// Lane of the node, 0 to 7.
    pub lane: usize,
    /// Vertex id, one below the lane.
    pub vertex: u32,
    /// The reduced coordinates.
    pub q: Vec<f32>,
    /// The sphere's radius.
    pub radius: f64,
    /// From the sphere's center to the vertex.
    pub distance: f64,
    /// What the pose adds to every radius for rounding.
    pub slack: f64,
}

impl Tight {
    /// How far the vertex is inside, over the pose's slack; negative when it is outside.
    pub fn margin(&self) -> f64 {
        let margin = (self.radius - self.distance) / self.slack;
        // What is not a number is as bad as can be.
        if margin.is_nan() {
            f64::NEG_INFINITY
        } else {
            margin
        }
    }
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
    pub(super) fn margin(&mut self, margin: f64, tight: impl FnOnce() -> Tight) {
        let looser = |t: &Tight| !margin.is_nan() && margin >= t.margin();
        let looser = self.tightest.as_ref().is_some_and(looser);
        if !looser {
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
            self.margin(tight.margin(), || tight);
        }
    }
}
