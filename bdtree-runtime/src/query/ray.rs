//! The first triangle that a ray meets, whether it meets one, and all that it meets.
//!
//! Triangles are two-sided; those of zero area are missed; at the same distance the lowest id wins. Rays
//! through edges and vertices do not slip between triangles that share them.

use bdtree_format::Row;
use core::ops::ControlFlow;

use super::line::Line;
use crate::bound::WideSpheres;
use crate::cache::Posed;
use crate::contact::{RayIntersection, Sink, TriangleId};
use crate::error::QueryError;
use crate::narrow::Triangle;
use crate::pose::Pose;
use crate::refined::Boxes;
use crate::shape::Ray;
use crate::simd::{Lanes, Quad};
use crate::traverse::{StackEntry, Visitor, Walk, one};

/// The first point where the ray meets a triangle, at a distance from 0 to its `max_distance`.
///
/// # Errors
/// An origin that is not finite or beyond 2^100, a direction that is zero or not finite, a
/// negative or NaN distance, a corrupt asset.
#[inline(always)] // a result that is as large is copied
pub(super) fn first(
    posed: Posed<'_>,
    ray: &Ray,
    stack: &mut [StackEntry],
) -> Result<(Option<RayIntersection>, Walk), QueryError> {
    let Some(line) = Line::new(posed.pose, ray, posed.has_boxes())? else {
        return Ok((None, Walk::default()));
    };
    let mut visitor = First::new(line);
    let walk = one(posed, stack, &mut visitor)?;
    Ok((visitor.best, walk))
}

/// Whether the ray meets any triangle: whether [`first`] finds one, in less time.
///
/// # Errors
/// As [`first`].
pub(super) fn any(
    posed: Posed<'_>,
    ray: &Ray,
    stack: &mut [StackEntry],
) -> Result<(bool, Walk), QueryError> {
    let Some(line) = Line::new(posed.pose, ray, posed.has_boxes())? else {
        return Ok((false, Walk::default()));
    };
    let mut visitor = First {
        any: true,
        ..First::new(line)
    };
    let walk = one(posed, stack, &mut visitor)?;
    Ok((visitor.is_met, walk))
}

/// Reports every triangle that the ray meets from distance 0 to `max_distance`, each once, in no
/// order that means anything.
///
/// # Errors
/// As [`first`].
pub(super) fn all(
    posed: Posed<'_>,
    ray: &Ray,
    stack: &mut [StackEntry],
    sink: &mut dyn Sink<RayIntersection>,
) -> Result<Walk, QueryError> {
    let Some(line) = Line::new(posed.pose, ray, posed.has_boxes())? else {
        return Ok(Walk::default());
    };
    let mut visitor = All { line, sink };
    one(posed, stack, &mut visitor)
}

/// Looks for the first hit, or for any.
#[derive(Default)]
pub(super) struct First {
    pub(super) line: Line,
    /// Parameter of the best hit, rounded up.
    pub(super) bound: f32,
    pub(super) best: Option<RayIntersection>,
    /// The first one found will do, and nothing but `is_met` is said of it.
    any: bool,
    is_met: bool,
}

impl First {
    /// Becomes that of a ray over a refined pose: for the first hit, or for whether there is any. False when it certainly misses
    /// the whole asset.
    ///
    /// # Errors
    /// As [`first`].
    #[inline(always)]
    pub(super) fn restart(
        &mut self,
        pose: &Pose<'_>,
        ray: &Ray,
        any: bool,
    ) -> Result<bool, QueryError> {
        let Some(line) = Line::new(pose, ray, true)? else {
            return Ok(false);
        };
        *self = Self {
            any,
            ..Self::new(line)
        };
        Ok(true)
    }

    /// Whether any hit was found, where any would do.
    pub(super) fn is_met(&self) -> bool {
        self.is_met
    }

    pub(super) fn new(line: Line) -> Self {
        Self {
            line,
            bound: f32::INFINITY,
            best: None,
            any: false,
            is_met: false,
        }
    }
}

impl Visitor for First {
    const ORDERED: bool = true;
    const HAS_BOXES: bool = true;
    const OF_SPHERES: u8 = 8;

    #[inline(always)]
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, keys: &mut Row) -> u8 {
        let met = self.line.lanes(&spheres, keys);
        if self.bound == f32::INFINITY {
            return met; // without waiting for the keys
        }
        met & !L::load(keys).above(L::splat(self.bound))
    }

    #[inline(always)]
    fn boxes<L: Lanes>(&self, boxes: &Boxes, keys: &mut Row) -> u8 {
        self.line.boxes::<L>(boxes, self.bound, keys)
    }

    #[inline(always)]
    fn bound(&self) -> f32 {
        self.bound
    }

    #[inline(always)]
    fn misses_four<Q: Quad>(&self, corners: &[[[f32; 4]; 3]; 3]) -> u8 {
        self.line.misses::<Q>(corners)
    }

    #[inline(always)]
    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()> {
        let Some(hit) = self.line.hit(corners) else {
            return ControlFlow::Continue(());
        };
        if self.any {
            self.is_met = true;
            return ControlFlow::Break(());
        }
        let better = match &self.best {
            None => true,
            Some(best) => (hit.t, id) < (best.distance, best.triangle),
        };
        if better {
            self.bound = self.line.shorten(hit.t);
            self.best = Some(self.line.intersection(id, corners, &hit));
        }
        ControlFlow::Continue(())
    }
}

struct All<'s> {
    line: Line,
    sink: &'s mut (dyn Sink<RayIntersection> + 's),
}

impl Visitor for All<'_> {
    const ORDERED: bool = false;
    const HAS_BOXES: bool = true;

    #[inline(always)]
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, keys: &mut Row) -> u8 {
        self.line.lanes(&spheres, keys)
    }

    #[inline(always)]
    fn boxes<L: Lanes>(&self, boxes: &Boxes, keys: &mut Row) -> u8 {
        self.line.boxes::<L>(boxes, f32::INFINITY, keys)
    }

    #[inline(always)]
    fn misses_four<Q: Quad>(&self, corners: &[[[f32; 4]; 3]; 3]) -> u8 {
        self.line.misses::<Q>(corners)
    }

    #[inline(never)]
    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()> {
        match self.line.hit(corners) {
            Some(hit) => self.sink.push(self.line.intersection(id, corners, &hit)),
            None => ControlFlow::Continue(()),
        }
    }
}
