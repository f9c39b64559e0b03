//! Nearest pairs of two trees, in the frame of the first: branch and bound.

use bdtree_format::LANES;

use super::frontier::{Frontier, SearchEntry, insert};
use super::gap::Gap;
use super::leaf_pairs::LeafPairs;
use super::leaf_side::LeafSide;
use super::visitor::Walk;
use super::{lane_subtree, used_lanes};
use crate::bound::WideSpheres;
use crate::cache::Posed;
use crate::error::QueryError;
use crate::simd::{Lanes, Work};
use crate::view::Asset;

/// Visits pairs of subtrees as `frontier` orders them, as long as they may hold a pair of triangles
/// as near as the best so far.
pub(crate) struct NearestTwo<'n, F> {
    pub(crate) posed: [Posed<'n>; 2],
    pub(crate) gap: &'n Gap,
    pub(crate) frontier: &'n mut F,
    pub(crate) pairs: &'n mut LeafPairs,
}

impl<F: Frontier> Work for NearestTwo<'_, F> {
    type Output = Result<Walk, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self {
            posed,
            gap,
            frontier,
            pairs,
        } = self;
        let [posed_a, posed_b] = posed;
        let mut a = LeafSide::new(posed_a);
        let mut b = LeafSide::new(posed_b);
        // A sound pair of trees has at most one entry for each pair of a node or leaf lane of one
        // and a node or leaf lane of the other, and a node has eight lanes.
        let subtrees = |asset: &Asset<'_>| (1 + LANES as u64) * asset.node_count() as u64;
        let visits_max = subtrees(a.asset).saturating_mul(subtrees(b.asset));
        let tests_max =
            (a.asset.triangle_count() as u64).saturating_mul(b.asset.triangle_count() as u64);
        let mut walk = Walk::default();
        let mut found = [SearchEntry::default(); LANES];
        frontier.put(&[gap.root]);
        while let Some(entry) = frontier.next(gap.bound(pairs.limit())) {
            walk.nodes_visited += 1;
            if walk.nodes_visited > visits_max {
                return Err(a.asset.endless(visits_max).into());
            }
            // The larger one is opened; leaves are not.
            let of_a = entry.a.triangles == 0
                && (entry.b.triangles != 0 || entry.sphere_a[3] >= entry.sphere_b[3]);
            let (side, index, other) = if of_a {
                (&mut a, entry.a.start, entry.sphere_b)
            } else {
                (&mut b, entry.b.start, entry.sphere_a)
            };
            let node = side.asset.node(index)?;
            let mut spheres = WideSpheres::<L>::empty();
            let evaluated = side.posed.spheres(side.asset, index, &mut spheres)?;
            walk.nodes_updated += u64::from(evaluated);
            let spheres = if of_a {
                spheres
            } else {
                gap.frame.carry(spheres)
            };
            let keys = gap.keys(spheres, other, of_a);
            let [x, y, z] = spheres.store().center;
            let radius = spheres.store().radius;
            let bound = gap.bound(pairs.limit());
            let mut count = 0;
            let mut left = used_lanes(node);
            while left != 0 {
                let lane = (left.trailing_zeros() & 7) as usize;
                left &= left - 1;
                let mut child = entry.below(keys[lane]);
                if child.key > bound {
                    continue;
                }
                let sub = lane_subtree(node, lane);
                let sphere = [x[lane], y[lane], z[lane], radius[lane]];
                if of_a {
                    (child.a, child.sphere_a) = (sub, sphere);
                } else {
                    (child.b, child.sphere_b) = (sub, sphere);
                }
                insert(&mut found, &mut count, child);
            }
            // Two leaves are compared where they are found.
            let mut kept = 0;
            for k in 0..count {
                let child = found[k];
                if child.a.triangles == 0 || child.b.triangles == 0 {
                    found[kept] = child;
                    kept += 1;
                } else if child.key <= gap.bound(pairs.limit()) {
                    pairs.compare(&mut a, child.a, &mut b, child.b)?;
                    if pairs.tests > tests_max {
                        return Err(a.asset.endless(tests_max).into());
                    }
                }
            }
            if !frontier.put(&found[..kept]) {
                return Err(a.asset.too_deep().into());
            }
        }
        Ok(walk)
    }
}
