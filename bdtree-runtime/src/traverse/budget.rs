//! Searches that stop after a number of visits, the most promising first, and say what they left.

use bdtree_format::{LANES, Row};

use super::frontier::{Frontier, SearchEntry, insert};
use super::leaf_side::LeafSide;
use super::shared::Shared;
use super::visitor::{Visitor, Walk};
use super::{lane_subtree, used_lanes};
use crate::bound::WideSpheres;
use crate::cache::{CHUNK, Posed};
use crate::contact::TriangleId;
use crate::error::QueryError;
use crate::simd::{Lanes, Work};

/// A binary heap (Knuth, vol. 3, 5.2.3) in the caller's memory, the least key first, that gives out
/// a limited number of entries. What finds no room is left out and remembered by its key.
pub(crate) struct Queue<'s> {
    entries: &'s mut [SearchEntry],
    len: usize,
    visits_left: u64,
    /// The least key that found no room.
    left_out: f32,
    overflowed: bool,
}

impl<'s> Queue<'s> {
    pub(crate) fn new(entries: &'s mut [SearchEntry], max_visits: u64) -> Self {
        Self {
            entries,
            len: 0,
            visits_left: max_visits,
            left_out: f32::INFINITY,
            overflowed: false,
        }
    }

    /// Nothing that was not visited has a lower key.
    pub(crate) fn rest(&self) -> f32 {
        match self.entries.first() {
            Some(first) if self.len > 0 => first.key.min(self.left_out),
            _ => self.left_out,
        }
    }

    /// Whether nothing is left with a key up to `bound`.
    pub(crate) fn is_done(&self, bound: f32) -> bool {
        (self.len == 0 && !self.overflowed) || self.rest() > bound
    }

    /// Notes that not all below this key was looked at.
    pub(crate) fn leave_out(&mut self, key: f32) {
        self.left_out = self.left_out.min(key);
        self.overflowed = true;
    }
}

impl Frontier for Queue<'_> {
    fn next(&mut self, bound: f32) -> Option<SearchEntry> {
        let entries = self.entries.get_mut(..self.len)?;
        let first = *entries.first()?;
        if first.key > bound || self.visits_left == 0 {
            return None;
        }
        self.visits_left -= 1;
        self.len -= 1;
        // The last one sinks from the top.
        let last = entries[self.len];
        let mut at = 0;
        loop {
            let mut child = 2 * at + 1;
            if child >= self.len {
                break;
            }
            if child + 1 < self.len && entries[child + 1].key < entries[child].key {
                child += 1;
            }
            if entries[child].key >= last.key {
                break;
            }
            entries[at] = entries[child];
            at = child;
        }
        entries[at] = last;
        Some(first)
    }

    fn put(&mut self, found: &[SearchEntry]) -> bool {
        for entry in found {
            let mut at = self.len;
            if at >= self.entries.len() {
                self.leave_out(entry.key);
                continue;
            }
            while at > 0 && self.entries[(at - 1) / 2].key > entry.key {
                self.entries[at] = self.entries[(at - 1) / 2];
                at = (at - 1) / 2;
            }
            self.entries[at] = *entry;
            self.len += 1;
        }
        true
    }
}

/// Visits the nodes of one tree as `queue` gives them out, by the visitor's keys.
pub(crate) struct BudgetedOne<'n, 'q, V> {
    pub(crate) posed: Posed<'n>,
    pub(crate) queue: &'n mut Queue<'q>,
    pub(crate) visitor: &'n mut V,
    /// Triangles that were tested, or lie in leaves that were ruled out.
    pub(crate) settled: &'n mut u64,
}

impl<V: Visitor> Work for BudgetedOne<'_, '_, V> {
    type Output = Result<Walk, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self {
            posed,
            queue,
            visitor,
            settled,
        } = self;
        if L::IS_COMPACT && !V::IS_SHARED {
            return L::apart(BudgetedOne {
                posed: posed.shorter(),
                queue,
                visitor: &mut Shared::<true>(visitor),
                settled,
            });
        }
        let asset = posed.pose.asset;
        let mut side = LeafSide::new(posed);
        let mut walk = Walk::default();
        let visits_max = asset.node_count() as u64;
        let mut triangles_left = asset.triangle_count() as u64;
        let mut keys: Row = [0.0; LANES];
        let mut found = [SearchEntry::default(); LANES];
        queue.put(&[SearchEntry::node(0, f32::NEG_INFINITY)]);
        while let Some(entry) = queue.next(visitor.bound()) {
            walk.nodes_visited += 1;
            if walk.nodes_visited > visits_max {
                return Err(asset.endless(visits_max).into());
            }
            let node = asset.node(entry.a.start)?;
            let mut spheres = WideSpheres::<L>::empty();
            let at = entry.a.start;
            let evaluated = side.posed.spheres(asset, at, &mut spheres)?;
            walk.nodes_updated += u64::from(evaluated);
            let wanted = visitor.lanes(spheres, &mut keys);
            let mut count = 0;
            let mut left = used_lanes(node);
            while left != 0 {
                let lane = (left.trailing_zeros() & 7) as usize;
                left &= left - 1;
                let sub = lane_subtree(node, lane);
                if wanted & (1 << lane) == 0 {
                    *settled += u64::from(sub.triangles);
                    continue;
                }
                let mut child = entry.below(keys[lane]);
                child.a = sub;
                insert(&mut found, &mut count, child);
            }
            let mut kept = 0;
            for k in 0..count {
                let child = found[k];
                if child.a.triangles == 0 {
                    found[kept] = child;
                    kept += 1;
                    continue;
                }
                triangles_left = asset.fewer_triangles(triangles_left, child.a)?;
                *settled += u64::from(child.a.triangles);
                if child.key > visitor.bound() {
                    continue;
                }
                for (i, records) in asset.leaf(child.a)?.chunks(CHUNK).enumerate() {
                    side.fill(child.a.start + (CHUNK * i) as u32, records)?;
                    for k in 0..records.len() {
                        let id = TriangleId(side.ids[k]);
                        if visitor.triangle(id, &side.corners[k]).is_break() {
                            walk.stopped = true;
                            queue.leave_out(entry.key);
                            return Ok(walk);
                        }
                    }
                }
            }
            queue.put(&found[..kept]);
        }
        Ok(walk)
    }
}
