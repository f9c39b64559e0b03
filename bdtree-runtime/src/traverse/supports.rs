//! How far leaves reach along a direction, so that most pairs of them are never compared.
//!
//! Between bodies that are some way apart the gap points the same way nearly everywhere; along the
//! direction of a good answer most leaves are seen to be farther apart than it.

use bdtree_format::TriangleRecord;

use super::leaf_side::LeafSide;
use crate::error::FormatError;
use crate::math::{dot, norm, scale, sub};
use crate::rounding::MARGIN;

/// A direction to look along.
#[derive(Clone, Copy)]
pub(super) struct View {
    from: [f64; 3],
    direction: [f64; 3],
    length: f64,
    version: u32,
}

impl View {
    /// Looks from the first to the second of two nearest points from now on, if they are clearly nearer
    /// than those before; not at all where they are one.
    pub(super) fn improve(view: &mut Option<Self>, point1: [f64; 3], point2: [f64; 3]) {
        /// Worth looking at all leaves anew.
        const NEARER: f64 = 0.98;
        let direction = sub(point2, point1);
        let length = norm(direction);
        let (before, version) = view.map_or((f64::INFINITY, 0), |v| (v.length, v.version));
        if length > 0.0 && length < NEARER * before {
            *view = Some(Self {
                from: point1,
                direction,
                length,
                version: version.wrapping_add(1),
            });
        }
    }

    /// The other way.
    pub(super) fn back(&self) -> Self {
        Self {
            direction: scale(self.direction, -1.0),
            ..*self
        }
    }

    /// What supports that are farther apart than this along the direction say: farther than `distance`.
    pub(super) fn reach(&self, distance: f64) -> f64 {
        distance * self.length * (1.0 + MARGIN)
    }
}

/// Slots of [`Supports`].
const SLOTS: usize = 512;

/// The supports of one side's leaves: a direct-mapped table, the newest of a slot stays.
pub(crate) struct Supports {
    /// First triangle slot, version of the view (0: none), support.
    slots: [(u32, u32, f64); SLOTS],
}

impl Supports {
    pub(super) fn new() -> Self {
        Self {
            slots: [(0, 0, 0.0); SLOTS],
        }
    }

    /// The largest coordinate along the view's direction of the triangles from slot `start` on, rounding
    /// included.
    pub(super) fn of(
        &mut self,
        view: &View,
        side: &mut LeafSide<'_>,
        start: u32,
        records: &[TriangleRecord],
    ) -> Result<f64, FormatError> {
        // Fibonacci hashing (Knuth, vol. 3, 6.4): the top bits of the product.
        let at = (start.wrapping_mul(0x9e37_79b9) >> (32 - SLOTS.trailing_zeros())) as usize;
        let slot = &mut self.slots[at];
        if (slot.0, slot.1) == (start, view.version) {
            return Ok(slot.2);
        }
        side.fill(start, records)?;
        let mut support = f64::NEG_INFINITY;
        for triangle in &side.corners {
            for corner in triangle {
                let x = sub(*corner, view.from);
                support = support.max(dot(x, view.direction) + MARGIN * norm(x) * view.length);
            }
        }
        *slot = (start, view.version, support);
        Ok(support)
    }
}
