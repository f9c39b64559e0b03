//! One face: what its corners refer to, and whether its triangles have an area.

use std::ops::Range;

use super::notes::Notes;
use super::tokens;
use crate::input::degenerate::{Oddity, outside};

/// A corner's vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Corner {
    /// Position of the vertex among the `v` lines, from 0.
    pub(super) index: u32,
    /// The vertex has not been read yet; it may come later in the file, or not.
    pub(super) is_later: bool,
}

/// A face that can only be checked when all vertices are known.
pub(super) struct Deferred {
    pub(super) line: u64,
    pub(super) triangles: Range<usize>,
}

/// The vertex that a corner (`7`, `7/1`, `7//3`, `7/1/3`, `-1`) refers to, with `known` vertices
/// read so far. Texture and normal indices must be integers but are not followed.
pub(super) fn corner(token: &[u8], known: usize, limit: u32) -> Result<Corner, String> {
    let mut parts = token.split(|&b| b == b'/');
    let index = parts.next().unwrap_or_default();
    let index = tokens::integer(index).ok_or("is not a vertex index")?;
    for (i, part) in parts.enumerate() {
        if i > 1 {
            return Err("has more than three parts".into());
        }
        if !part.is_empty() && tokens::integer(part).is_none() {
            return Err("has a texture or normal index that is no integer".into());
        }
    }
    let known = known as u64;
    match index {
        0 => Err("index 0; the first vertex is 1".into()),
        i if i < 0 => match known.checked_sub(i.unsigned_abs()) {
            // No truncation: below `known`, which is limited to u32.
            Some(index) => Ok(Corner {
                index: index as u32,
                is_later: false,
            }),
            None => Err(format!(
                "relative index before the first vertex; {known} vertices so far"
            )),
        },
        i => match u32::try_from(i - 1) {
            Ok(index) if index < limit => Ok(Corner {
                index,
                is_later: u64::from(index) >= known,
            }),
            _ => Err("index beyond the greatest number of vertices".into()),
        },
    }
}

/// Notes the triangles of one face that repeat a corner, have no area or lie outside it; `first` is the id of the
/// first. All corners must be known.
pub(super) fn check_shape(
    triangles: &[[u32; 3]],
    first: usize,
    positions: &[[f64; 3]],
    line: u64,
    notes: &mut Notes<'_>,
) {
    for (id, &corners) in (first..).zip(triangles) {
        if let Some(oddity) = Oddity::of(corners, positions) {
            notes.oddity(oddity, line, id);
        }
    }
    if let Some(found) = outside(triangles, positions) {
        notes.oddity(Oddity::OutsidePolygon, line, first + found);
    }
}
