//! Many rays against one posed asset.

use core::iter::Enumerate;
use core::ops::{ControlFlow, Range};
use core::slice::Iter;

use super::ray::{self, First};
use crate::cache::Posed;
use crate::contact::{RayIntersection, Sink};
use crate::error::QueryError;
use crate::pose::Pose;
use crate::shape::Ray;
use crate::traverse::{Mixed, Questions, StackEntry, Walk, stream};

/// [`ray::first`] for some of `rays`: `hits[i]` becomes the first hit of ray i.
///
/// # Errors
/// As [`ray::first`] for any of the rays, and fewer hits than rays; what was written before stays.
pub(super) fn first(
    mut posed: Posed<'_>,
    rays: &[Ray],
    some: Range<usize>,
    stack: &mut [StackEntry],
    hits: &mut [Option<RayIntersection>],
) -> Result<Walk, QueryError> {
    let (rays, hits) = both(rays, hits, some)?;
    if let Some(tree) = Mixed::of(&mut posed) {
        return together(tree, rays, stack, hits, false, |first| first.best);
    }
    each(posed, rays, hits, |posed, r| ray::first(posed, r, stack))
}

/// [`ray::any`] for some of `rays`: `hits[i]` becomes whether ray i meets a triangle.
///
/// # Errors
/// As [`first`].
pub(super) fn any(
    mut posed: Posed<'_>,
    rays: &[Ray],
    some: Range<usize>,
    stack: &mut [StackEntry],
    hits: &mut [bool],
) -> Result<Walk, QueryError> {
    let (rays, hits) = both(rays, hits, some)?;
    if let Some(tree) = Mixed::of(&mut posed) {
        return together(tree, rays, stack, hits, true, First::is_met);
    }
    each(posed, rays, hits, |posed, r| ray::any(posed, r, stack))
}

/// Some of the rays and their hits.
fn both<'h, 'r, T>(
    rays: &'r [Ray],
    hits: &'h mut [T],
    some: Range<usize>,
) -> Result<(&'r [Ray], &'h mut [T]), QueryError> {
    let hits = hits
        .get_mut(..rays.len())
        .and_then(|hits| hits.get_mut(some.clone()));
    let both = rays.get(some).zip(hits);
    both.ok_or(QueryError::Argument("hits: fewer than rays"))
}

/// Casts rays in streams; the default is the answer of those that miss the whole asset.
#[inline(always)]
fn together<T: Default>(
    tree: Mixed<'_>,
    rays: &[Ray],
    stack: &mut [StackEntry],
    hits: &mut [T],
    is_any: bool,
    answer: impl Fn(&First) -> T,
) -> Result<Walk, QueryError> {
    let mut streamed = Streamed {
        pose: tree.pose(),
        rays: rays.iter().enumerate(),
        is_any,
        // Not a type of its own: streams are compiled once.
        put: &mut |number: usize, first: Option<&First>| {
            hits[number] = first.map(&answer).unwrap_or_default();
        },
    };
    stream(tree, stack, &mut streamed).map(unstopped)
}

/// One ray that has found its answer does not end the others.
fn unstopped(walk: Walk) -> Walk {
    Walk {
        stopped: false,
        ..walk
    }
}

/// Rays that are cast together.
struct Streamed<'r, 'p> {
    pose: &'r Pose<'r>,
    rays: Enumerate<Iter<'r, Ray>>,
    is_any: bool,
    put: &'p mut dyn FnMut(usize, Option<&First>),
}

impl Questions<First> for Streamed<'_, '_> {
    #[inline(always)]
    fn next(&mut self, first: &mut First) -> Result<Option<usize>, QueryError> {
        for (number, ray) in &mut self.rays {
            if first.restart(self.pose, ray, self.is_any)? {
                return Ok(Some(number));
            }
            (self.put)(number, None);
        }
        Ok(None)
    }

    #[inline(always)]
    fn answered(&mut self, number: usize, visitor: &First) {
        (self.put)(number, Some(visitor));
    }
}

fn each<T>(
    mut posed: Posed<'_>,
    rays: &[Ray],
    hits: &mut [T],
    mut cast: impl FnMut(Posed<'_>, &Ray) -> Result<(T, Walk), QueryError>,
) -> Result<Walk, QueryError> {
    let mut all = Walk::default();
    for (r, hit) in rays.iter().zip(hits) {
        let (found, walk) = cast(posed.again(), r)?;
        *hit = found;
        all.add(&walk);
    }
    Ok(unstopped(all))
}

/// [`ray::all`] for some of `rays`: every hit with the number of its ray, ray after ray. A full sink
/// ends it.
///
/// # Errors
/// As [`ray::first`] for any of the rays.
pub(super) fn all(
    mut posed: Posed<'_>,
    rays: &[Ray],
    some: Range<usize>,
    stack: &mut [StackEntry],
    sink: &mut dyn Sink<(usize, RayIntersection)>,
) -> Result<Walk, QueryError> {
    let mut all = Walk::default();
    let first = some.start;
    for (index, r) in (first..).zip(rays.get(some).unwrap_or_default()) {
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
