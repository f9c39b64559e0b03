//! The nearest pair of triangles among pairs of leaves.

use super::Subtree;
use super::leaf_side::LeafSide;
use super::supports::{Supports, View};
use crate::cache::CHUNK;
use crate::contact::{PairContact, TriangleId};
use crate::error::QueryError;
use crate::math::{dot, sqrt, sub};
use crate::narrow::{Triangle, triangle_distance, triangles_intersect};
use crate::rounding::MARGIN;

/// The nearest pair so far.
pub(crate) struct LeafPairs {
    /// Pairs farther apart are no answer.
    max_distance: f64,
    pub(crate) best: Option<PairContact>,
    /// Pairs of triangles that were met.
    pub(super) tests: u64,
    /// The direction of a good answer: most leaves are apart along it.
    view: Option<View>,
    supports: [Supports; 2],
}

impl LeafPairs {
    pub(crate) fn new(max_distance: f64) -> Self {
        Self {
            max_distance,
            best: None,
            tests: 0,
            view: None,
            supports: [Supports::new(), Supports::new()],
        }
    }

    /// Pairs farther apart than this are no answer (world).
    #[inline(always)]
    pub(crate) fn limit(&self) -> f64 {
        match &self.best {
            Some(best) => best.distance,
            None => self.max_distance,
        }
    }

    /// Compares all triangles of two leaves.
    #[inline(never)]
    pub(super) fn compare(
        &mut self,
        a: &mut LeafSide<'_>,
        leaf_a: Subtree,
        b: &mut LeafSide<'_>,
        leaf_b: Subtree,
    ) -> Result<(), QueryError> {
        let (records_a, records_b) = (a.asset.leaf(leaf_a)?, b.asset.leaf(leaf_b)?);
        self.tests = self
            .tests
            .saturating_add(records_a.len() as u64 * records_b.len() as u64);
        for (i, chunk_a) in records_a.chunks(CHUNK).enumerate() {
            let start_a = leaf_a.start + (CHUNK * i) as u32;
            for (j, chunk_b) in records_b.chunks(CHUNK).enumerate() {
                let start_b = leaf_b.start + (CHUNK * j) as u32;
                if let Some(view) = &self.view {
                    let [supports_a, supports_b] = &mut self.supports;
                    let high = supports_a.of(view, a, start_a, chunk_a)?;
                    let low = -supports_b.of(&view.back(), b, start_b, chunk_b)?;
                    if low - high > view.reach(self.limit()) {
                        continue;
                    }
                }
                a.fill(start_a, chunk_a)?;
                b.fill(start_b, chunk_b)?;
                self.chunks(a, chunk_a.len(), b, chunk_b.len());
            }
        }
        Ok(())
    }

    /// Up to four triangles against four, those with the nearest boxes first.
    fn chunks(&mut self, a: &LeafSide<'_>, len_a: usize, b: &LeafSide<'_>, len_b: usize) {
        let limit = self.limit();
        let mut near = [(0.0, 0, 0); CHUNK * CHUNK];
        let mut count = 0;
        for i in 0..len_a {
            for j in 0..len_b {
                let (mut squared, mut span) = (0.0, 0.0_f64);
                for k in 0..3 {
                    let gap = (b.low[j][k] - a.high[i][k])
                        .max(a.low[i][k] - b.high[j][k])
                        .max(0.0);
                    squared += gap * gap;
                    span = span.max(a.high[i][k].max(b.high[j][k]) - a.low[i][k].min(b.low[j][k]));
                }
                let gap = sqrt(squared) * (1.0 - MARGIN) - MARGIN * span;
                if gap > limit {
                    continue;
                }
                let mut at = count;
                while at > 0 && near[at - 1].0 > gap {
                    near[at] = near[at - 1];
                    at -= 1;
                }
                near[at] = (gap, i, j);
                count += 1;
            }
        }
        for &(gap, i, j) in &near[..count] {
            if gap > self.limit() {
                return;
            }
            let ids = (TriangleId(a.ids[i]), TriangleId(b.ids[j]));
            self.pair(ids, &a.corners[i], &b.corners[j]);
        }
    }

    fn pair(&mut self, (id_a, id_b): (TriangleId, TriangleId), a: &Triangle, b: &Triangle) {
        if let Some(best) = &self.best {
            let lower = (id_a, id_b) < (best.triangle1, best.triangle2);
            if best.distance == 0.0 {
                // Only another touching pair with lower ids would be better.
                if !lower || !triangles_intersect(a, b) {
                    return;
                }
            } else if apart(a, b, sub(best.point2, best.point1), best.distance)
                || apart(a, b, sub(center(b), center(a)), best.distance)
            {
                return;
            }
        }
        let nearest = triangle_distance(a, b);
        let better = match &self.best {
            None => nearest.distance <= self.max_distance,
            Some(best) => {
                (nearest.distance, id_a, id_b) < (best.distance, best.triangle1, best.triangle2)
            }
        };
        if better {
            self.best = Some(PairContact {
                triangle1: id_a,
                triangle2: id_b,
                point1: nearest.point1,
                point2: nearest.point2,
                // See `query::distance`.
                normal1: [0.0; 3],
                normal2: [0.0; 3],
                distance: nearest.distance,
                barycentric1: nearest.barycentric1,
                barycentric2: nearest.barycentric2,
            });
            View::improve(&mut self.view, nearest.point1, nearest.point2);
        }
    }
}

/// Three times the centroid.
fn center([p, q, r]: &Triangle) -> [f64; 3] {
    [0, 1, 2].map(|k| p[k] + q[k] + r[k])
}

/// Whether the gap along `direction` shows that b is farther than `distance` from a. Not if NaN.
fn apart(a: &Triangle, b: &Triangle, direction: [f64; 3], distance: f64) -> bool {
    let (mut high, mut low, mut size) = (0.0_f64, f64::INFINITY, 0.0_f64);
    for k in 0..3 {
        let (x, y) = (sub(a[k], a[0]), sub(b[k], a[0]));
        high = high.max(dot(x, direction));
        low = low.min(dot(y, direction));
        size = size.max(dot(x, x)).max(dot(y, y));
    }
    let length = sqrt(dot(direction, direction));
    low - high > (distance * (1.0 + MARGIN) + MARGIN * sqrt(size)) * length
}
