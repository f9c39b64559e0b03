//! What an asset loses with the modes that it does without.
//!
//! Without the modes outside a set K a vertex is off by ‖Σ_{j ∉ K} U_ij q_j‖. Over which q that is taken depends
//! on what is known of them: see [`Over`].

use serde::Serialize;

use crate::basis::tally::Tally;
use crate::basis::{Basis, BasisError};
use crate::vec3::{norm, norm2};

/// Over which q an error is the largest, and against what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Over {
    /// Measured against the source of the fields, at all frames that it has: principal components.
    Source,
    /// Against the asset with all its modes, at all frames of its animation.
    Frames,
    /// Against the asset with all its modes, at every q with |q_j| ≤ `q_range`: a bound, the sum of what each
    /// mode can do, which is what `--modes` of given fields and morph targets states.
    Ranges,
}

/// The errors of the first k modes of an asset, k = 0 … M.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// What they are taken over.
    pub over: Over,
    /// One for each k; the last is that of all modes. Over the diagonal of the box around the rest positions.
    pub of_first: Vec<BasisError>,
    /// What all modes are off by from their source, where that is known and not part of `of_first`.
    pub own: Option<BasisError>,
}

impl Errors {
    /// Errors that were measured against the source: of the first 0, 1, … M modes.
    pub fn measured(of_first: Vec<BasisError>) -> Self {
        Self {
            over: Over::Source,
            of_first,
            own: None,
        }
    }

    /// Errors against all modes: at the frames of the basis's animation, or (`over` is [`Over::Ranges`], or there
    /// are no frames) within the ranges of the modes, which for modes without one are those that a bake gives them.
    /// `diagonal` is that of the box around the rest positions; M N T operations over the frames, M N over ranges.
    pub fn against_all(basis: &Basis, diagonal: f64, over: Over, own: Option<BasisError>) -> Self {
        let size = if diagonal > 0.0 { diagonal } else { 1.0 };
        let frames = basis.animation.as_ref().filter(|a| a.frame_count > 0);
        let (over, of_first) = match frames {
            Some(animation) if over != Over::Ranges => {
                (Over::Frames, at_frames(basis, &animation.q, size))
            }
            _ => (Over::Ranges, in_ranges(basis, size)),
        };
        Self {
            over,
            of_first,
            own,
        }
    }

    /// Whether the errors of `count` modes, and of one fewer, are bounds: less may be true. An error against a source
    /// that is no longer there is added to what is left out, and ranges add up what each of several modes can do (what
    /// one alone can do is exact).
    pub fn are_bounds(&self, count: usize) -> bool {
        let own = self.own.is_some_and(|own| own.max_rel > 0.0);
        match self.over {
            Over::Source => false,
            Over::Frames => own,
            Over::Ranges => own || count < self.mode_count(),
        }
    }

    /// Number of modes M.
    pub fn mode_count(&self) -> usize {
        self.of_first.len().saturating_sub(1)
    }

    /// The largest error of the first `count` modes against the source, over the diagonal: what they leave out and
    /// what all modes are off by, added (a vertex is nowhere farther off than both together). `None` when there
    /// are fewer modes.
    pub fn bound_rel(&self, count: usize) -> Option<f64> {
        let own = self.own.map_or(0.0, |own| own.max_rel);
        self.of_first.get(count).map(|error| error.max_rel + own)
    }

    /// The fewest first modes whose error is at most `max_error_rel`, none more than `most`; `None` when no such
    /// number is good enough.
    pub fn fewest(&self, max_error_rel: f64, most: usize) -> Option<usize> {
        // A bake of so few modes rounds anew: half a float's digit of room.
        const ROUNDING: f64 = 1.0 / (1 << 24) as f64;
        let fits = |count: &usize| {
            let bound = self.bound_rel(*count);
            bound.is_some_and(|bound| bound * (1.0 + ROUNDING) <= max_error_rel)
        };
        (0..=self.mode_count().min(most)).find(fits)
    }
}

/// `q[t * M + j]`; lengths over `size`. From the last mode to the first, so that one pass serves all numbers.
fn at_frames(basis: &Basis, q: &[f64], size: f64) -> Vec<BasisError> {
    let (n, m) = (basis.vertex_count, basis.mode_count());
    let mut tally = vec![Tally::default(); m + 1];
    let mut off = vec![[0.0; 3]; n];
    let frames = q.chunks_exact(m.max(1));
    let count = frames.len().max(1) * n.max(1);
    for (t, q) in frames.enumerate() {
        off.fill([0.0; 3]);
        for k in (0..m).rev() {
            for (off, u) in off.iter_mut().zip(basis.field(k)) {
                *off = [0, 1, 2].map(|axis| off[axis] + u[axis] * q[k]);
            }
            for (vertex, off) in off.iter().enumerate() {
                tally[k].add(norm2(*off), Some(t), vertex);
            }
        }
    }
    tally.iter().map(|tally| tally.error(count, size)).collect()
}

/// What modes can do within their ranges, vertex by vertex, added up.
fn in_ranges(basis: &Basis, size: f64) -> Vec<BasisError> {
    let (n, m) = (basis.vertex_count, basis.mode_count());
    let mut tally = vec![Tally::default(); m + 1];
    let mut off = vec![0.0; n];
    for k in (0..m).rev() {
        let range = basis.range(k, size);
        for (vertex, (off, u)) in off.iter_mut().zip(basis.field(k)).enumerate() {
            *off += range * norm(*u);
            tally[k].add(*off * *off, None, vertex);
        }
    }
    tally
        .iter()
        .map(|tally| tally.error(n.max(1), size))
        .collect()
}
