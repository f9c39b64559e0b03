//! Many rays against one posed asset.

use core::ops::ControlFlow;

use super::{Outcome, Ray, ray, ray_all, ray_any};
use crate::cache::Posed;
use crate::contact::{RayHit, Sink};
use crate::error::QueryError;
use crate::traverse::StackEntry;
use crate::view::Asset;

/// [`ray()`] for each of `rays`: `hits[i]` becomes the first hit of ray i.
///
/// # Errors
/// As [`ray()`] for any of the rays, and fewer hits than rays; what was written before stays.
pub fn rays<'p>(
    asset: &Asset<'_>,
    pose: impl Into<Posed<'p>>,
    rays: &[Ray],
    stack: &mut [StackEntry],
    hits: &mut [Option<RayHit>],
) -> Result<Outcome, QueryError> {
    rays_posed(asset, pose.into(), rays, stack, hits)
}

/// [`rays`], compiled here for all callers.
fn rays_posed(
    asset: &Asset<'_>,
    mut posed: Posed<'_>,
    rays: &[Ray],
    stack: &mut [StackEntry],
    hits: &mut [Option<RayHit>],
) -> Result<Outcome, QueryError> {
    let mut outcome = nothing_done(rays.len(), hits.len())?;
    for (r, hit) in rays.iter().zip(hits) {
        let posed = posed.again();
        let found = ray(asset, posed, r.origin, r.direction, r.max_distance, stack)?;
        *hit = found.hit;
        outcome.nodes_visited += found.nodes_visited;
        outcome.nodes_updated += found.nodes_updated;
    }
    Ok(outcome)
}

/// [`ray_any`] for each of `rays`: `hits[i]` becomes whether ray i meets a triangle.
///
/// # Errors
/// As [`rays()`].
pub fn rays_any<'p>(
    asset: &Asset<'_>,
    pose: impl Into<Posed<'p>>,
    rays: &[Ray],
    stack: &mut [StackEntry],
    hits: &mut [bool],
) -> Result<Outcome, QueryError> {
    rays_any_posed(asset, pose.into(), rays, stack, hits)
}

/// [`rays_any`], compiled here for all callers.
fn rays_any_posed(
    asset: &Asset<'_>,
    mut posed: Posed<'_>,
    rays: &[Ray],
    stack: &mut [StackEntry],
    hits: &mut [bool],
) -> Result<Outcome, QueryError> {
    let mut outcome = nothing_done(rays.len(), hits.len())?;
    for (r, hit) in rays.iter().zip(hits) {
        let posed = posed.again();
        let found = ray_any(asset, posed, r.origin, r.direction, r.max_distance, stack)?;
        *hit = found.hit;
        outcome.nodes_visited += found.nodes_visited;
        outcome.nodes_updated += found.nodes_updated;
    }
    Ok(outcome)
}

/// [`ray_all`] for each of `rays`: every hit with the number of its ray, ray after ray. A full sink
/// ends it, `truncated`.
///
/// # Errors
/// As [`ray()`] for any of the rays.
pub fn rays_all<'p>(
    asset: &Asset<'_>,
    pose: impl Into<Posed<'p>>,
    rays: &[Ray],
    stack: &mut [StackEntry],
    sink: &mut impl Sink<(usize, RayHit)>,
) -> Result<Outcome, QueryError> {
    rays_all_posed(asset, pose.into(), rays, stack, sink)
}

/// [`rays_all`], compiled here for all callers.
fn rays_all_posed(
    asset: &Asset<'_>,
    mut posed: Posed<'_>,
    rays: &[Ray],
    stack: &mut [StackEntry],
    sink: &mut dyn Sink<(usize, RayHit)>,
) -> Result<Outcome, QueryError> {
    let mut outcome = nothing_done(0, 0)?;
    for (index, r) in rays.iter().enumerate() {
        let mut sink = Numbered {
            index,
            sink: &mut *sink,
        };
        let (posed, sink) = (posed.again(), &mut sink);
        let found = ray_all(
            asset,
            posed,
            r.origin,
            r.direction,
            r.max_distance,
            stack,
            sink,
        )?;
        outcome.nodes_visited += found.nodes_visited;
        outcome.nodes_updated += found.nodes_updated;
        if found.truncated {
            outcome.truncated = true;
            break;
        }
    }
    Ok(outcome)
}

/// Adds the number of its ray to each hit.
struct Numbered<'s> {
    index: usize,
    sink: &'s mut (dyn Sink<(usize, RayHit)> + 's),
}

impl Sink<RayHit> for Numbered<'_> {
    fn push(&mut self, hit: RayHit) -> ControlFlow<()> {
        self.sink.push((self.index, hit))
    }
}

fn nothing_done(rays: usize, hits: usize) -> Result<Outcome, QueryError> {
    if hits < rays {
        return Err(QueryError::Argument("hits: fewer than rays"));
    }
    Ok(Outcome {
        nodes_visited: 0,
        nodes_updated: 0,
        truncated: false,
    })
}
