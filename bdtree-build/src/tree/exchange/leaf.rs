//! Leaves as trades change them.

use super::balls::Ball;

/// Which leaf lane of which node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    pub(super) node: u32,
    /// Among the node's leaf lanes.
    pub(super) leaf: u32,
}

/// The leaves of a node.
#[derive(Debug, Default)]
pub(super) struct Leaves {
    pub(super) list: Vec<Leaf>,
    /// Lanes of the node that are not empty, inner ones too.
    pub(super) lanes: u8,
}

/// A leaf lane.
#[derive(Debug, Default)]
pub(super) struct Leaf {
    pub(super) triangles: Vec<u32>,
    pub(super) ball: Ball,
    /// What is left without one of the triangles, in their order, and last without none; empty until
    /// asked for.
    pub(super) rests: Vec<Rest>,
    /// The pass in which it changed last, counted from 1; 0 for none.
    pub(super) changed: usize,
    /// How often it changed.
    pub(super) changes: u32,
    /// Leaves with which nothing is gained, with their `changes` when that was found, since this one changed.
    pub(super) refused: Vec<(Place, u32)>,
}

/// Some triangles of a leaf: their ball and what it costs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rest {
    pub(super) ball: Ball,
    pub(super) cost: f64,
}

impl Leaf {
    pub(super) fn new(triangles: &[u32], ball: Ball) -> Self {
        Self {
            triangles: triangles.to_vec(),
            ball,
            ..Self::default()
        }
    }

    /// Makes it what it becomes in a trade.
    pub(super) fn change(&mut self, triangles: Vec<u32>, ball: Ball, pass: usize) {
        self.triangles = triangles;
        self.ball = ball;
        self.rests.clear();
        self.refused.clear();
        self.changed = pass;
        self.changes += 1;
    }

    /// Puts the triangles without the one at `out`, if there is one there, and with one that enters into `after`.
    pub(super) fn put_after(&self, out: usize, entering: Option<&u32>, after: &mut Vec<u32>) {
        after.clear();
        after.extend_from_slice(&self.triangles);
        if out < after.len() {
            after.remove(out);
        }
        after.extend(entering);
    }

    pub(super) fn has_refused(&self, place: Place, other: &Self) -> bool {
        self.refused.contains(&(place, other.changes))
    }
}
