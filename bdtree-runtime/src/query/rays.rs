//! Many rays against one posed asset.

use core::ops::ControlFlow;

use super::ray;
use crate::cache::Posed;
use crate::contact::{RayIntersection, Sink};
use crate::error::QueryError;
use crate::shape::Ray;
use crate::traverse::{StackEntry, Walk};

/// [`ray::first`] for each of `rays`: `hits[i]` becomes the first hit of ray i.
///
/// # Errors
/// As [`ray::first`] for any of the rays, and fewer hits than rays; what was written before stays.
pub(super) fn first(
    posed: Posed<'_>,
    rays: &[Ray],
    stack: &mut [StackEntry],
    hits: &mut [Option<RayIntersection>],
) -> Result<Walk, QueryError> {
    each(posed, rays, hits, |posed, r| ray::first(posed, r, stack))
}

/// [`ray::any`] for each of `rays`: `hits[i]` becomes whether ray i meets a triangle.
///
/// # Errors
/// As [`first`].
pub(super) fn any(
    posed: Posed<'_>,
    rays: &[Ray],
    stack: &mut [StackEntry],
    hits: &mut [bool],
) -> Result<Walk, QueryError> {
    each(posed, rays, hits, |posed, r| ray::any(posed, r, stack))
}

fn each<T>(
    mut posed: Posed<'_>,
    rays: &[Ray],
    hits: &mut [T],
    mut cast: impl FnMut(Posed<'_>, &Ray) -> Result<(T, Walk), QueryError>,
) -> Result<Walk, QueryError> {
    if hits.len() < rays.len() {
        return Err(QueryError::Argument("hits: fewer than rays"));
    }
    let mut all = Walk::default();
    for (r, hit) in rays.iter().zip(hits) {
        let (found, walk) = cast(posed.again(), r)?;
        *hit = found;
        all.add(&walk);
    }
    Ok(all)
}

/// [`ray::all`] for each of `rays`: every hit with the number of its ray, ray after ray. A full sink
/// ends it.
///
/// # Errors
/// As [`ray::first`] for any of the rays.
pub(super) fn all(
    mut posed: Posed<'_>,
    rays: &[Ray],
    stack: &mut [StackEntry],
    sink: &mut dyn Sink<(usize, RayIntersection)>,
) -> Result<Walk, QueryError> {
    let mut all = Walk::default();
    for (index, r) in rays.iter().enumerate() {
        let mut numbered = Numbered { index, sink };
        let walk = ray::all(posed.again(), r, stack, &mut numbered)?;
        all.add(&walk);
        if walk.stopped {
            break;
        }
    }
    Ok(all)
}

/// Adds the number of its ray to each hit.
struct Numbered<'n, 's> {
    index: usize,
    sink: &'n mut (dyn Sink<(usize, RayIntersection)> + 's),
}

impl Sink<RayIntersection> for Numbered<'_, '_> {
    fn push(&mut self, hit: RayIntersection) -> ControlFlow<()> {
        self.sink.push((self.index, hit))
    }
}
