//! Which nodes a budgeted query visits first, and what their keys certify.

use bdtree_format::Row;
use core::ops::ControlFlow;

use super::super::ball::Ball;
use super::super::project::Closest;
use crate::bound::WideSpheres;
use crate::contact::TriangleId;
use crate::narrow::Triangle;
use crate::rounding::MARGIN;
use crate::simd::Lanes;
use crate::traverse::Visitor;

impl Closest {
    /// What everything at a key is not nearer than (world).
    pub(super) fn distance(&self, key: f32) -> f64 {
        (f64::from(key) / self.stored_per_world * (1.0 - MARGIN)).max(0.0)
    }
}

/// A ball whose nearest nodes come first.
pub(super) struct Deepest<'s> {
    /// Guides, and compares nothing.
    pub(super) near: Closest,
    pub(super) ball: Ball<'s>,
}

impl Visitor for Deepest<'_> {
    const ORDERED: bool = true;

    #[inline(always)]
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, keys: &mut Row) -> u8 {
        self.near.lanes(spheres, keys)
    }

    fn bound(&self) -> f32 {
        self.near.bound
    }

    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()> {
        self.ball.triangle(id, corners)
    }
}
