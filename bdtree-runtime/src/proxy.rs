//! Bounded depth: queries that look no deeper than a level and report its spheres.

use crate::cache::Posed;
use crate::depth::DepthLimit;
use crate::view::Asset;

impl<'s> Posed<'s> {
    pub(crate) fn is_bounded(&self) -> bool {
        self.limit.is_some()
    }

    /// The limit of a query of `asset`, if it cuts anything off.
    pub(crate) fn take_limit(&mut self, asset: &Asset<'_>) -> Option<DepthLimit<'s>> {
        self.limit.take().filter(|limit| limit.cuts(asset))
    }
}

impl Asset<'_> {
    /// Number of nodes down to a level (0 is the root's).
    pub fn node_count_to(&self, level: usize) -> usize {
        // Breadth first: levels never fall.
        let is_above = |node: &bdtree_format::NodeRecord| usize::from(node.level) <= level;
        self.nodes.partition_point(is_above)
    }
}
