//! Bounded depth: queries that look no deeper than a level and report its spheres.

use core::fmt;

use crate::cache::Posed;
use crate::contact::{Proxy, Sink};
use crate::view::Asset;

/// How deep a query looks, and where the spheres go at which it stops.
pub(crate) struct DepthLimit<'s> {
    pub(crate) level: usize,
    pub(crate) sink: &'s mut (dyn Sink<Proxy> + 's),
}

impl fmt::Debug for DepthLimit<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut out = f.debug_struct("DepthLimit");
        out.field("level", &self.level).finish_non_exhaustive()
    }
}

impl DepthLimit<'_> {
    /// The same for a shorter time.
    pub(crate) fn again(&mut self) -> DepthLimit<'_> {
        DepthLimit {
            level: self.level,
            sink: &mut *self.sink,
        }
    }
}

impl<'s> Posed<'s> {
    pub(crate) fn is_bounded(&self) -> bool {
        self.limit.is_some()
    }

    pub(crate) fn take_limit(&mut self) -> Option<DepthLimit<'s>> {
        self.limit.take()
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
