//! How deep a walk looks: to the triangles, or down to a level whose spheres stand for what lies below
//! them (the paper's contact proxies, 3.4). `Query::max_level` sets the level; `traverse/visit.rs` and `traverse/two.rs`
//! end there.

use bdtree_format::NodeRecord;
use core::fmt;
use core::ops::ControlFlow;

use crate::bound::Spheres;
use crate::contact::{LaneId, Proxy, Sink};
use crate::math::norm;
use crate::pose::Pose;
use crate::rounding::MARGIN;
use crate::view::Asset;

/// Down to a level, whose spheres a sink takes.
pub(crate) struct DepthLimit<'s> {
    pub(crate) level: usize,
    /// Whether leaves down to there are taken as spheres too, instead of looking at their triangles.
    pub(crate) leaves_too: bool,
    /// How much nearer spheres of a pair must be to be taken than to be entered (stored units of the first).
    pub(crate) nearer: f32,
    pub(crate) sink: &'s mut (dyn LevelSink + 's),
}

/// Takes the lanes below which a walk looks at nothing.
pub(crate) trait LevelSink {
    fn take(&mut self, pose: &Pose<'_>, spheres: &Spheres, lane: LaneId) -> ControlFlow<()>;
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
            leaves_too: false,
            nearer: 0.0,
            sink: self,
        }
    }
}

impl LevelSink for Proxies<'_> {
    fn take(&mut self, pose: &Pose<'_>, spheres: &Spheres, lane: LaneId) -> ControlFlow<()> {
        let flow = self.sink.push(proxy(pose, spheres, lane));
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
    /// Down to a level, and no triangles on the way.
    pub(crate) fn of_spheres(level: usize, sink: &'s mut (dyn LevelSink + 's)) -> Self {
        Self {
            level,
            leaves_too: true,
            nearer: 0.0,
            sink,
        }
    }

    /// The same for a shorter time; spelled out, since what borrows a sink is not shortened by itself.
    pub(crate) fn shorter<'t>(self) -> DepthLimit<'t>
    where
        's: 't,
    {
        DepthLimit {
            level: self.level,
            leaves_too: self.leaves_too,
            nearer: self.nearer,
            sink: self.sink,
        }
    }

    /// The same for one of several walks.
    pub(crate) fn again(&mut self) -> DepthLimit<'_> {
        DepthLimit {
            level: self.level,
            leaves_too: self.leaves_too,
            nearer: self.nearer,
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
        lane: LaneId,
    ) -> ControlFlow<()> {
        self.sink.take(pose, spheres, lane)
    }

    /// Whether a walk ends anywhere but at triangles.
    pub(crate) fn cuts(&self, asset: &Asset<'_>) -> bool {
        self.leaves_too || self.level < asset.depth().saturating_sub(1)
    }
}

impl fmt::Debug for DepthLimit<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut out = f.debug_struct("DepthLimit");
        out.field("level", &self.level).finish_non_exhaustive()
    }
}

/// The sphere of a lane in the world, which holds all that the leaf arithmetic puts below it.
pub(crate) fn proxy(pose: &Pose<'_>, spheres: &Spheres, lane: LaneId) -> Proxy {
    let at = usize::from(lane.lane);
    let center = [0, 1, 2].map(|axis| spheres.center[axis][at]);
    let center = pose.placement.world(center);
    let radius =
        f64::from(spheres.radius[at]) + pose.placement.error(norm(center), 2.0 * pose.reach);
    Proxy {
        lane,
        center,
        radius: radius * pose.placement.world_per_stored() * (1.0 + MARGIN),
    }
}
