//! Bounded depth: queries that look no deeper than a level and report its spheres.

use crate::cache::Posed;
use crate::contact::{Proxy, Sink};
use crate::depth::DepthLimit;
use crate::view::Asset;

impl<'s> Posed<'s> {
    /// The same, not looked into below `level` (0 is the root's): a query tests the triangles that
    /// hang on nodes down to there exactly, as always, and gives `proxies` the spheres of what else its
    /// tests do not rule out. So every triangle of the full answer is reported or lies in a reported
    /// sphere. From level [`Asset::depth`](crate::Asset::depth) − 1 on the answer is the full one.
    ///
    /// Which spheres: those that the traversal reaches. They need not lie in their ancestors' (unless
    /// the asset was baked with nested spheres), so the set depends on the tree; it is the same on every
    /// processor and with every [`Kernel`](crate::Kernel).
    ///
    /// In a pair query each side has its own bound. Where either side ends at its level, the k-th
    /// sphere of one side and the k-th of the other meet (within the tolerance); a side that ends in
    /// triangles there gives the sphere around them. Between what lies in such two, no two
    /// points are farther apart than 2 R₁ + 2 R₂ plus the tolerance.
    ///
    /// Queries for the nearest thing prune by what they have found so far; the frustum's state and
    /// the root sphere take no bound.
    pub fn bounded<'t>(self, level: usize, proxies: &'t mut (dyn Sink<Proxy> + 't)) -> Posed<'t>
    where
        's: 't,
    {
        self.limited(DepthLimit {
            level,
            sink: proxies,
        })
    }

    pub(crate) fn is_bounded(&self) -> bool {
        self.limit.is_some()
    }

    /// The limit of a query of `asset`, if it cuts anything off.
    pub(crate) fn take_limit(&mut self, asset: &Asset<'_>) -> Option<DepthLimit<'s>> {
        self.limit.take().filter(|limit| limit.cuts(asset))
    }
}

impl Asset<'_> {
    /// Number of nodes down to a level: node slots of a [`StepCache`](crate::StepCache) that keep every
    /// node a query visits which is [bounded](Posed::bounded) there. What an instance needs is then a
    /// [`Pose`](crate::Pose) with [`Asset::pose_len`] numbers and this many
    /// [`NodeSlot`](crate::NodeSlot)s, whatever the mesh's size.
    pub fn node_count_to(&self, level: usize) -> usize {
        // Breadth first: levels never fall.
        let is_above = |node: &bdtree_format::NodeRecord| usize::from(node.level) <= level;
        self.nodes.partition_point(is_above)
    }
}
