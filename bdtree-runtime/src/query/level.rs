//! Which spheres of a level meet: queries that look at no triangle (the paper's bounded depth, 3.4, with all its spheres
//! as proxies).

use core::cell::Cell;
use core::ops::ControlFlow;

use super::length;
use super::pair::tolerance;
use super::pairs::PairQuery;
use super::side::Side;
use super::single::{Query, shape_contacts};
use crate::bound::Spheres;
use crate::cache::Posed;
use crate::contact::{Contact, Coverage, LaneId, LaneTriangle, Sink, TriangleId};
use crate::depth::{DepthLimit, LevelSink};
use crate::error::QueryError;
use crate::narrow::Triangle;
use crate::pair_frame::{PairFrame, PairMap};
use crate::pose::Pose;
use crate::rounding::round_down;
use crate::shape::Shape;
use crate::traverse::{PairVisitor, Two, Walk};
use crate::workspace::Stats;

const LEVEL: &str = "max_level: level_spheres has a level of its own";
const TRIANGLES_LEVEL: &str = "max_level: level_triangles has a level of its own";
const REACH: &str = "reach: negative, not finite or beyond 2^100";

impl Query<'_, '_> {
    /// Reports the lanes of `level` (0 is the root's), and the leaf lanes above it, whose spheres
    /// ([`Pose::node_spheres`]) `shape` touches: each once, and the same ones with every [`Kernel`](crate::Kernel) and
    /// [`StepCache`](crate::StepCache). Triangles are not looked at. From level [`Asset::depth`](crate::Asset::depth) − 1 on
    /// all of them are of leaves. Where a sphere and the shape are apart by no more than a rounding error, its lane
    /// may be reported too.
    ///
    /// A sphere need not lie in those of its ancestors (unless the asset was baked with nested spheres), and a walk enters a
    /// node only if the shape touches the sphere of its lane. So a sphere is certainly reported if the shape touches it when
    /// it is made smaller by what it sticks out of its ancestors. Every triangle that the shape touches lies in a reported
    /// sphere. Spheres also reach where no vertex can be, farther from the asset's origin than P + Σ W_j |q_j| (SPEC 5.3;
    /// carried on by bones): a touch there alone may not count, or may be seen too early. Where a query follows an earlier
    /// pose ([`studies::follow`](crate::studies::follow)), the spheres are that pose's, grown.
    ///
    /// # Errors
    /// Those of [`Query::contacts`]; a level limit.
    pub fn level_spheres(
        &mut self,
        level: usize,
        shape: impl Into<Shape>,
        out: &mut impl Sink<LaneId>,
    ) -> Result<Coverage, QueryError> {
        let shape = shape.into();
        let mut found = Single { out };
        let posed = limited(
            &mut self.side,
            DepthLimit::of_spheres(level, &mut found),
            LEVEL,
        )?;
        let stack = self.workspace.memory.slots(posed.pose.asset.stack_len())?;
        let walk = shape_contacts(&shape, posed, stack, &mut NoTriangles)?;
        self.workspace.stats = Stats::of(&walk);
        Ok(Coverage::of(walk.stopped))
    }
}

impl PairQuery<'_, '_, '_> {
    /// Reports the pairs of lanes, one of each mesh, whose spheres ([`Pose::node_spheres`]) are at most `prediction` apart
    /// (world units): of levels `levels` (0 is the root's), and leaf lanes above them. Each pair is reported once, and the
    /// pairs and their order are the same with every [`Kernel`](crate::Kernel) and [`StepCache`](crate::StepCache). Triangles
    /// are not looked at. A pair that is farther apart by a rounding error, about 10⁻⁶ of the radii, `prediction`, `reach`
    /// and the distance of the bodies, may be among them.
    ///
    /// A sphere need not lie in those of its ancestors (unless the asset was baked with nested spheres), so a walk enters
    /// lanes whose spheres are up to `prediction + reach` apart. All pairs within `prediction` are reported if `reach` is at
    /// least what a sphere of the one and a sphere of the other together stick out of those above them. With `reach` 0 some
    /// may be missing, but all triangles that are at most `prediction` apart lie in a reported pair.
    ///
    /// # Errors
    /// A prediction or reach that is negative, not finite or beyond 2^100, a level limit or a front, too little memory, a
    /// corrupt asset.
    pub fn level_spheres(
        &mut self,
        levels: [usize; 2],
        prediction: f64,
        reach: f64,
        out: &mut impl Sink<[LaneId; 2]>,
    ) -> Result<Coverage, QueryError> {
        const FRONT: &str = "front: level_spheres keeps none";
        if self.front.is_some() {
            return Err(QueryError::Argument(FRONT));
        }
        let reach = length(reach, REACH)?;
        let mut near = Near(tolerance(prediction)? + reach);
        let [side1, side2] = &mut self.sides;
        let len = side1.pose.asset.pair_stack_len(side2.pose.asset);
        let stack = self.workspace.memory.slots(len)?;
        let first = Cell::new(LaneId::EMPTY);
        let (mut firsts, mut pairs) = (First { first: &first }, Second { first: &first, out });
        let mut limit1 = DepthLimit::of_spheres(levels[0], &mut firsts);
        let limit2 = DepthLimit::of_spheres(levels[1], &mut pairs);
        limit1.nearer = round_down(reach / side1.pose.placement.world_per_stored());
        let posed = [
            limited(side1, limit1, LEVEL)?,
            limited(side2, limit2, LEVEL)?,
        ]
        .map(Posed::shorter);
        let mut walk = Walk::default();
        if let Some(frame) = PairFrame::of_spheres(&posed[0], &posed[1], near.0) {
            let two = Two {
                posed,
                frame: &frame,
                leaves: None,
            };
            walk = two.walk(stack, &mut near)?;
        }
        self.workspace.stats = Stats::of(&walk);
        Ok(Coverage::of(walk.stopped))
    }

    /// Reports pairs of a lane of the first mesh and a triangle of the second: lanes of `level` (0 is the root's) and leaf
    /// lanes above it, and triangles that are at most `prediction` (world units) from the lane's sphere
    /// ([`Pose::node_spheres`]): deformed exactly as for any other query, they are measured from its center by
    /// [`narrow::closest_point`](crate::narrow::closest_point). Each pair is reported once, and the pairs and their order are
    /// the same with every [`Kernel`](crate::Kernel) and [`StepCache`](crate::StepCache). A triangle that is farther away by
    /// a rounding error of f64 (`StoredToWorld::error` of both, and 10⁻¹² of the radius and `prediction`) may be among them.
    ///
    /// `reach` is what the first's spheres may stick out of those above them, as for [`PairQuery::level_spheres`]; the
    /// second's triangles lie in all spheres above them. All pairs within `prediction` are reported if `reach` is at least
    /// that. With `reach` 0 some may be missing, but of any two triangles that are at most `prediction` apart, the second one
    /// is reported with the first one's lane.
    ///
    /// # Errors
    /// A prediction or reach that is negative, not finite or beyond 2^100, a level limit or a front, too little memory, a
    /// corrupt asset.
    pub fn level_triangles(
        &mut self,
        level: usize,
        prediction: f64,
        reach: f64,
        out: &mut impl Sink<LaneTriangle>,
    ) -> Result<Coverage, QueryError> {
        const FRONT: &str = "front: level_triangles keeps none";
        if self.front.is_some() {
            return Err(QueryError::Argument(FRONT));
        }
        let reach = length(reach, REACH)?;
        let mut near = NearSpheres {
            entered: tolerance(prediction)? + reach,
            reported: prediction,
            out,
        };
        let [side1, side2] = &mut self.sides;
        let len = side1.pose.asset.pair_stack_len(side2.pose.asset);
        let stack = self.workspace.memory.slots(len)?;
        let mut unused = NoSpheres;
        let mut limit = DepthLimit::of_spheres(level, &mut unused);
        limit.nearer = round_down(reach / side1.pose.placement.world_per_stored());
        let posed1 = limited(side1, limit, TRIANGLES_LEVEL)?.shorter();
        let posed2 = side2.posed_spheres(TRIANGLES_LEVEL)?.shorter();
        let mut walk = Walk::default();
        if let Some(frame) = PairFrame::of_spheres(&posed1, &posed2, near.entered) {
            let map = PairMap::new(&posed1, &posed2);
            near.reported += map.exact * map.unit_a;
            let two = Two {
                posed: [posed1, posed2],
                frame: &frame,
                leaves: None,
            };
            walk = two.walk(stack, &mut near)?;
        }
        self.workspace.stats = Stats::of(&walk);
        Ok(Coverage::of(walk.stopped))
    }
}

/// A side for one walk that ends at spheres.
///
/// # Errors
/// A level of its own; a stale cache.
pub(super) fn limited<'w>(
    side: &'w mut Side<'_>,
    limit: DepthLimit<'w>,
    what: &'static str,
) -> Result<Posed<'w>, QueryError> {
    let mut posed = side.posed_spheres(what)?;
    posed.limit = Some(limit);
    Ok(posed)
}

struct Single<'s> {
    out: &'s mut (dyn Sink<LaneId> + 's),
}

impl LevelSink for Single<'_> {
    fn take(&mut self, _: &Pose<'_>, _: &Spheres, lane: LaneId) -> ControlFlow<()> {
        self.out.push(lane)
    }
}

/// Keeps the first lane of a pair until the second one comes.
struct First<'s> {
    first: &'s Cell<LaneId>,
}

impl LevelSink for First<'_> {
    fn take(&mut self, _: &Pose<'_>, _: &Spheres, lane: LaneId) -> ControlFlow<()> {
        self.first.set(lane);
        ControlFlow::Continue(())
    }
}

struct Second<'s> {
    first: &'s Cell<LaneId>,
    out: &'s mut (dyn Sink<[LaneId; 2]> + 's),
}

impl LevelSink for Second<'_> {
    fn take(&mut self, _: &Pose<'_>, _: &Spheres, lane: LaneId) -> ControlFlow<()> {
        self.out.push([self.first.get(), lane])
    }
}

/// For walks that end before their triangles.
struct NoTriangles;

impl Sink<Contact> for NoTriangles {
    fn push(&mut self, _: Contact) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// For walks that end at triangles of the second.
struct NoSpheres;

impl LevelSink for NoSpheres {
    fn take(&mut self, _: &Pose<'_>, _: &Spheres, _: LaneId) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Two bodies up to a distance apart.
struct Near(f64);

impl PairVisitor for Near {
    fn tolerance(&self) -> f64 {
        self.0
    }

    fn triangles(&mut self, _: [TriangleId; 2], _: [&Triangle; 2]) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Spheres and triangles up to a distance apart.
struct NearSpheres<'s> {
    /// That of spheres and leaves that are looked into.
    entered: f64,
    reported: f64,
    out: &'s mut (dyn Sink<LaneTriangle> + 's),
}

impl PairVisitor for NearSpheres<'_> {
    fn tolerance(&self) -> f64 {
        self.entered
    }

    fn triangles(&mut self, _: [TriangleId; 2], _: [&Triangle; 2]) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn sphere_tolerance(&self) -> f64 {
        self.reported
    }

    fn lane_triangle(&mut self, lane: LaneId, triangle: TriangleId) -> ControlFlow<()> {
        self.out.push(LaneTriangle { lane, triangle })
    }
}
