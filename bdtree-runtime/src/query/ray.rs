//! The first triangle that a ray meets, whether it meets one, and all that it meets.

use bdtree_format::Row;
use core::ops::ControlFlow;

use super::line::Line;
use super::{AnyHit, Nearest, Outcome};
use crate::bound::WideSpheres;
use crate::cache::Posed;
use crate::contact::{RayHit, Sink, TriangleId};
use crate::error::QueryError;
use crate::narrow::Triangle;
use crate::simd::{Lanes, Quad};
use crate::traverse::{StackEntry, Visitor, one};
use crate::view::Asset;

/// The first point where the ray from `origin` along `direction` (normalised first) meets a
/// triangle, at a distance from 0 to `max_distance` (which may be infinite). Triangles are
/// two-sided; those of zero area are missed; at the same distance the lowest id wins. Rays
/// through edges and vertices do not slip between triangles that share them.
///
/// # Errors
/// An origin that is not finite or beyond 2^100, a direction that is zero or not finite, a
/// negative or NaN distance, a pose of another asset, too short a stack, a corrupt asset.
pub fn ray<'p>(
    asset: &Asset<'_>,
    pose: impl Into<Posed<'p>>,
    origin: [f64; 3],
    direction: [f64; 3],
    max_distance: f64,
    stack: &mut [StackEntry],
) -> Result<Nearest<RayHit>, QueryError> {
    ray_posed(asset, pose.into(), origin, direction, max_distance, stack)
}

/// [`ray`], compiled here for all callers.
fn ray_posed(
    asset: &Asset<'_>,
    posed: Posed<'_>,
    origin: [f64; 3],
    direction: [f64; 3],
    max_distance: f64,
    stack: &mut [StackEntry],
) -> Result<Nearest<RayHit>, QueryError> {
    let Some(line) = Line::new(posed.pose, origin, direction, max_distance)? else {
        return Ok(Nearest {
            hit: None,
            nodes_visited: 0,
            nodes_updated: 0,
        });
    };
    let mut visitor = First::<false>::new(line);
    let walk = one(asset, posed, stack, &mut visitor)?;
    Ok(Nearest {
        hit: visitor.best,
        nodes_visited: walk.nodes_visited,
        nodes_updated: walk.nodes_updated,
    })
}

/// Whether the ray meets any triangle: whether [`ray()`] finds one, in less time.
///
/// # Errors
/// As [`ray()`].
pub fn ray_any<'p>(
    asset: &Asset<'_>,
    pose: impl Into<Posed<'p>>,
    origin: [f64; 3],
    direction: [f64; 3],
    max_distance: f64,
    stack: &mut [StackEntry],
) -> Result<AnyHit, QueryError> {
    ray_any_posed(asset, pose.into(), origin, direction, max_distance, stack)
}

/// [`ray_any`], compiled here for all callers.
fn ray_any_posed(
    asset: &Asset<'_>,
    posed: Posed<'_>,
    origin: [f64; 3],
    direction: [f64; 3],
    max_distance: f64,
    stack: &mut [StackEntry],
) -> Result<AnyHit, QueryError> {
    let Some(line) = Line::new(posed.pose, origin, direction, max_distance)? else {
        return Ok(AnyHit {
            hit: false,
            nodes_visited: 0,
            nodes_updated: 0,
        });
    };
    let mut visitor = First::<true>::new(line);
    let walk = one(asset, posed, stack, &mut visitor)?;
    Ok(AnyHit {
        hit: visitor.best.is_some(),
        nodes_visited: walk.nodes_visited,
        nodes_updated: walk.nodes_updated,
    })
}

/// Reports every triangle that the ray meets from distance 0 to `max_distance`, each once, in no
/// order that means anything.
///
/// # Errors
/// As [`ray()`].
pub fn ray_all<'p>(
    asset: &Asset<'_>,
    pose: impl Into<Posed<'p>>,
    origin: [f64; 3],
    direction: [f64; 3],
    max_distance: f64,
    stack: &mut [StackEntry],
    sink: &mut impl Sink<RayHit>,
) -> Result<Outcome, QueryError> {
    ray_all_posed(
        asset,
        pose.into(),
        origin,
        direction,
        max_distance,
        stack,
        sink,
    )
}

/// [`ray_all`], compiled here for all callers.
fn ray_all_posed(
    asset: &Asset<'_>,
    posed: Posed<'_>,
    origin: [f64; 3],
    direction: [f64; 3],
    max_distance: f64,
    stack: &mut [StackEntry],
    sink: &mut dyn Sink<RayHit>,
) -> Result<Outcome, QueryError> {
    let Some(line) = Line::new(posed.pose, origin, direction, max_distance)? else {
        return Ok(Outcome {
            nodes_visited: 0,
            nodes_updated: 0,
            truncated: false,
        });
    };
    let mut visitor = All { line, sink };
    let walk = one(asset, posed, stack, &mut visitor)?;
    Ok(Outcome {
        nodes_visited: walk.nodes_visited,
        nodes_updated: walk.nodes_updated,
        truncated: walk.stopped,
    })
}

/// Looks for the first hit; with `ANY` for one that need not be the first.
pub(super) struct First<const ANY: bool> {
    pub(super) line: Line,
    /// Parameter of the best hit, rounded up.
    pub(super) bound: f32,
    pub(super) best: Option<RayHit>,
}

impl<const ANY: bool> First<ANY> {
    pub(super) fn new(line: Line) -> Self {
        Self {
            line,
            bound: f32::INFINITY,
            best: None,
        }
    }
}

impl<const ANY: bool> Visitor for First<ANY> {
    const ORDERED: bool = true;

    #[inline(always)]
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, keys: &mut Row) -> u8 {
        let met = self.line.lanes(&spheres, keys);
        if self.bound == f32::INFINITY {
            return met; // without waiting for the keys
        }
        met & !L::load(keys).above(L::splat(self.bound))
    }

    #[inline(always)]
    fn wanted(&self, key: f32) -> bool {
        let beyond = key > self.bound;
        !beyond
    }

    #[inline(always)]
    fn misses_four<Q: Quad>(&self, corners: &[[[f32; 4]; 3]; 3]) -> u8 {
        self.line.misses::<Q>(corners)
    }

    #[inline(never)]
    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()> {
        let Some(hit) = self.line.hit(id, corners) else {
            return ControlFlow::Continue(());
        };
        let better = match &self.best {
            None => true,
            Some(best) => (hit.distance, id) < (best.distance, best.triangle),
        };
        if better {
            self.bound = self.line.shorten(hit.distance);
            self.best = Some(hit);
        }
        if ANY {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

struct All<'s> {
    line: Line,
    sink: &'s mut (dyn Sink<RayHit> + 's),
}

impl Visitor for All<'_> {
    const ORDERED: bool = false;

    #[inline(always)]
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, keys: &mut Row) -> u8 {
        self.line.lanes(&spheres, keys)
    }

    #[inline(always)]
    fn wanted(&self, _key: f32) -> bool {
        true
    }

    #[inline(always)]
    fn misses_four<Q: Quad>(&self, corners: &[[[f32; 4]; 3]; 3]) -> u8 {
        self.line.misses::<Q>(corners)
    }

    #[inline(never)]
    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()> {
        match self.line.hit(id, corners) {
            Some(hit) => self.sink.push(hit),
            None => ControlFlow::Continue(()),
        }
    }
}
