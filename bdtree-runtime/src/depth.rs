//! How deep a walk looks: to the triangles, or down to a level whose spheres stand for what lies below
//! them (the paper's contact proxies, 3.4). `Query::max_level` sets the level; `traverse/visit.rs` and `traverse/two.rs`
//! end there.

use bdtree_format::NodeRecord;
use core::fmt;
use core::ops::ControlFlow;

use crate::bound::Spheres;
use crate::contact::{Proxy, Sink};
use crate::math::norm;
use crate::pose::Pose;
use crate::rounding::MARGIN;
use crate::view::Asset;

/// Down to a level, whose spheres a sink takes.
pub(crate) struct DepthLimit<'s> {
    pub(crate) level: usize,
    pub(crate) sink: &'s mut (dyn Sink<Proxy> + 's),
}

/// A level, and the caller's sink for its spheres.
pub(crate) struct Proxies<'s> {
    level: usize,
    sink: &'s mut (dyn Sink<Proxy> + 's),
    /// Whether it had no room for one since the last walk began: then a walk that found nothing has proved nothing.
    pub(crate) is_full: bool,
}

impl<'s> Proxies<'s> {
    pub(crate) fn new(level: usize, sink: &'s mut (dyn Sink<Proxy> + 's)) -> Self {
        let is_full = false;
        Self {
            level,
            sink,
            is_full,
        }
    }

    /// For one walk.
    pub(crate) fn limit(&mut self) -> DepthLimit<'_> {
        self.is_full = false;
        DepthLimit {
            level: self.level,
            sink: self,
        }
    }
}

impl Sink<Proxy> for Proxies<'_> {
    fn push(&mut self, proxy: Proxy) -> ControlFlow<()> {
        let flow = self.sink.push(proxy);
        self.is_full |= flow.is_break();
        flow
    }
}

impl fmt::Debug for Proxies<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut out = f.debug_struct("Proxies");
        out.field("level", &self.level).finish_non_exhaustive()
    }
}

impl<'s> DepthLimit<'s> {
    /// The same for a shorter time; spelled out, since what borrows a sink is not shortened by itself.
    pub(crate) fn shorter<'t>(self) -> DepthLimit<'t>
    where
        's: 't,
    {
        DepthLimit {
            level: self.level,
            sink: self.sink,
        }
    }

    /// The same for one of several walks.
    pub(crate) fn again(&mut self) -> DepthLimit<'_> {
        DepthLimit {
            level: self.level,
            sink: &mut *self.sink,
        }
    }

    /// Whether nothing below this node's lanes is visited.
    #[inline(always)]
    pub(crate) fn ends(&self, node: &NodeRecord) -> bool {
        usize::from(node.level) >= self.level
    }

    /// Reports the sphere of a lane below which nothing is visited.
    pub(crate) fn report(
        &mut self,
        pose: &Pose<'_>,
        spheres: &Spheres,
        lane: usize,
    ) -> ControlFlow<()> {
        self.sink.push(proxy(pose, spheres, lane))
    }

    /// Whether there is anything below the level.
    pub(crate) fn cuts(&self, asset: &Asset<'_>) -> bool {
        self.level < asset.depth().saturating_sub(1)
    }
}

impl fmt::Debug for DepthLimit<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut out = f.debug_struct("DepthLimit");
        out.field("level", &self.level).finish_non_exhaustive()
    }
}

/// The sphere of a lane in the world, which holds all that the leaf arithmetic puts below it.
pub(crate) fn proxy(pose: &Pose<'_>, spheres: &Spheres, lane: usize) -> Proxy {
    let center = [0, 1, 2].map(|axis| spheres.center[axis][lane]);
    let center = pose.placement.world(center);
    let radius =
        f64::from(spheres.radius[lane]) + pose.placement.error(norm(center), 2.0 * pose.reach);
    Proxy {
        center,
        radius: radius * pose.placement.world_per_stored() * (1.0 + MARGIN),
    }
}
