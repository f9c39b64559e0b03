//! Queries of two meshes.

use bdtree_format::LANES;

use super::budget::{Budget, Budgeted, queue_len};
use super::distance::closest_points;
use super::front::PairFront;
use super::manifold::{ContactManifold, ManifoldSlot, manifolds};
use super::pair::{Contacts, Ids, tolerance, walk};
use super::side::Side;
use super::single::{BUDGET_AND_LEVEL, First, Query};
use core::ops::ControlFlow;

use crate::cache::{Posed, StepCache};
use crate::contact::{Coverage, PairContact, Proxy, Sink, SliceSink, TrianglePair};
use crate::depth::Proxies;
use crate::error::QueryError;
use crate::pose::Pose;
use crate::traverse::{PairStackEntry, PairVisitor, SearchEntry, StackEntry, Walk};
use crate::workspace::{Stats, Workspace};

/// Most entries that a budgeted query of two meshes keeps in a workspace that grows: 13 MB.
const QUEUE_MAX: usize = 1 << 18;

/// Pairs of triangles for which a workspace that grows has room at first.
const PAIRS: usize = 256;

/// Questions about two posed meshes; made by [`Pose::against`] or
/// [`Instance::against`](crate::Instance::against).
///
/// Meshes are surfaces, not solids: a body wholly inside a closed mesh touches nothing. Sinks append: clear them
/// yourself.
#[derive(Debug)]
pub struct PairQuery<'q, 'm, 'f> {
    pub(super) sides: [Side<'q>; 2],
    pub(super) front: Option<&'q mut PairFront<'f>>,
    pub(super) workspace: &'q mut Workspace<'m>,
}

impl Pose<'_> {
    /// Questions about this mesh and another, in the memory of a workspace. They are of different instances;
    /// their asset may be the same.
    #[inline]
    pub fn against<'q, 'm, 'f>(
        &'q self,
        other: &'q Pose<'_>,
        workspace: &'q mut Workspace<'m>,
    ) -> PairQuery<'q, 'm, 'f> {
        PairQuery {
            sides: [Side::new(*self), Side::new(*other)],
            front: None,
            workspace,
        }
    }
}

impl<'q, 'm> Query<'q, 'm> {
    /// Questions about this mesh and another, with the cache and the level of each: those of this query and
    /// those of `other`, whose workspace is left alone.
    pub fn against<'f>(self, other: Query<'q, '_>) -> PairQuery<'q, 'm, 'f> {
        PairQuery {
            sides: [self.side, other.side],
            front: None,
            workspace: self.workspace,
        }
    }
}

impl<'q, 'm, 'f> PairQuery<'q, 'm, 'f> {
    /// Of two poses, each with the cache that was started with it.
    #[cfg(feature = "alloc")]
    #[inline]
    pub(crate) fn with_caches(
        of: [(Pose<'q>, &'q mut StepCache<'static>); 2],
        workspace: &'q mut Workspace<'m>,
    ) -> Self {
        Self {
            sides: of.map(|(pose, cache)| {
                let mut side = Side::new(pose);
                side.keep(cache);
                side
            }),
            front: None,
            workspace,
        }
    }

    /// Uses a step cache for each mesh, as [`Query::cached`] does. Where a cache was started with another pose, queries
    /// return [`QueryError::Cache`].
    #[inline]
    pub fn cached(mut self, first: &'q mut StepCache<'_>, second: &'q mut StepCache<'_>) -> Self {
        let [side1, side2] = &mut self.sides;
        side1.keep(first);
        side2.keep(second);
        self
    }

    /// Stops descending the first mesh at `level`, as [`Query::max_level`].
    ///
    /// Proxies come in pairs: push k of one sink and push k of the other are spheres at most `prediction` apart. They
    /// are pushed where either side ends at its level; a side that has reached triangles there pushes the sphere around
    /// them. No point inside one of the two spheres is farther from a point inside the other than 2 R₁ + 2 R₂ +
    /// `prediction`.
    pub fn max_level1(mut self, level: usize, proxies: &'q mut dyn Sink<Proxy>) -> Self {
        self.sides[0].limit = Some(Proxies::new(level, proxies));
        self
    }

    /// Stops descending the second mesh at `level`, as [`PairQuery::max_level1`].
    pub fn max_level2(mut self, level: usize, proxies: &'q mut dyn Sink<Proxy>) -> Self {
        self.sides[1].limit = Some(Proxies::new(level, proxies));
        self
    }

    /// Starts from the pairs of leaves that earlier steps found near each other: [`PairQuery::contacts`],
    /// [`PairQuery::triangle_pairs`], [`PairQuery::intersects`], [`PairQuery::is_within`] and
    /// [`PairQuery::contact_manifolds`] give the same answers and visit no node until the two have moved by a margin.
    /// `intersects` and `is_within` of two meshes that touch end early and keep no front; use `triangle_pairs` there.
    ///
    /// Both poses need a [`Motion`](crate::Motion): [`Instance`](crate::Instance) has one, other poses get theirs by
    /// [`Pose::moving`]. Without it these queries return [`QueryError::Motion`].
    pub fn front(mut self, front: &'q mut PairFront<'f>) -> Self {
        self.front = Some(front);
        self
    }

    /// Within a number of node visits, the most promising first: the answer says what it may have missed.
    pub fn max_visits(self, max_visits: u64) -> BudgetedPairQuery<'q, 'm, 'f> {
        BudgetedPairQuery {
            query: self,
            max_visits,
        }
    }

    /// What the last question visited.
    pub fn stats(&self) -> Stats {
        self.workspace.stats
    }

    /// Reports every pair of triangles, one of each mesh, whose distance is at most `prediction`, with points and
    /// normals. At 0 those that share a point: exact, coplanar overlap and touching count. The trees are walked
    /// in the frame of the first. The sink is appended to.
    ///
    /// # Errors
    /// A prediction that is negative, not finite or beyond 2^100, too little memory, a corrupt asset.
    #[inline]
    pub fn contacts(
        &mut self,
        prediction: f64,
        out: &mut impl Sink<PairContact>,
    ) -> Result<Coverage, QueryError> {
        let tolerance = tolerance(prediction)?;
        self.walk(&mut Contacts {
            tolerance,
            is_complete: true,
            sink: out,
        })
    }

    /// Reports which pairs of triangles [`PairQuery::contacts`] would report, without their points: several
    /// times faster where many touch.
    ///
    /// # Errors
    /// Those of [`PairQuery::contacts`].
    #[inline]
    pub fn triangle_pairs(
        &mut self,
        prediction: f64,
        out: &mut impl Sink<TrianglePair>,
    ) -> Result<Coverage, QueryError> {
        let tolerance = tolerance(prediction)?;
        self.walk(&mut Ids {
            tolerance,
            sink: out,
        })
    }

    /// Whether any two triangles share a point: [`PairQuery::is_within`] 0.
    ///
    /// # Errors
    /// Those of [`PairQuery::contacts`].
    pub fn intersects(&mut self) -> Result<bool, QueryError> {
        self.is_within(0.0)
    }

    /// Whether any two triangles, one of each mesh, are at most `prediction` apart (world units, inclusive), so that
    /// [`PairQuery::contacts`] would report them: ends with the first pair that is found.
    ///
    /// # Errors
    /// Those of [`PairQuery::contacts`]: a prediction has to be finite. [`QueryError::Proxies`] if nothing was found and a sink of
    /// proxies is full.
    pub fn is_within(&mut self, prediction: f64) -> Result<bool, QueryError> {
        let mut first = First::default();
        self.triangle_pairs(prediction, &mut first)?;
        if !first.is_found && self.sides.iter().any(Side::is_cut) {
            return Err(QueryError::Proxies);
        }
        Ok(first.is_found)
    }

    /// The nearest two triangles, one of each mesh, and where they are nearest, if that is within `max_distance`
    /// (which may be infinite); `point1 = point2` at distance 0 when they share a point. Of several pairs at the
    /// same distance: the lowest ids, those of the first mesh before those of the second.
    ///
    /// # Errors
    /// A negative or NaN distance, a level limit, too little memory, a corrupt asset.
    pub fn closest_points(&mut self, max_distance: f64) -> Result<Option<PairContact>, QueryError> {
        const LEVEL: &str = "max_level: distances need all levels";
        let len = self.distance_stack_len();
        let [side1, side2] = &mut self.sides;
        let posed = [side1.posed_whole(LEVEL)?, side2.posed_whole(LEVEL)?];
        let stack = self.workspace.memory.slots::<SearchEntry>(len)?;
        let (best, walk) = closest_points(posed, max_distance, stack)?;
        self.workspace.stats = Stats::of(&walk);
        Ok(best)
    }

    /// The distance of the two meshes, if it is within `max_distance`: that of
    /// [`PairQuery::closest_points`].
    ///
    /// # Errors
    /// Its errors.
    pub fn distance(&mut self, max_distance: f64) -> Result<Option<f64>, QueryError> {
        let best = self.closest_points(max_distance)?;
        Ok(best.map(|best| best.distance))
    }

    /// Reports one manifold per connected region of contact, in the order of its lowest triangle pair:
    /// [`PairQuery::contacts`], condensed to a few points with normals, depths and areas. Both surfaces must list their
    /// corners counterclockwise as seen from outside, or both clockwise.
    ///
    /// With `prediction` 0 only triangles that touch form regions. Above 0, pairs up to `prediction` apart form and
    /// connect regions too. A region where nothing touches is one point, at its nearest pair, with depth 0 and a positive
    /// distance. Where the surfaces cross in closed curves, pairs that do not touch may join regions, but add nothing to
    /// points, depth and area.
    ///
    /// A region that such a curve bounds has four points, each on a line along the normal: `point1` is where the line
    /// leaves the first body, `point2` where, followed backwards, it leaves the second. Where it leaves only one of them
    /// or none, the nearest points of both stand for them. `distance` is always `(point2 − point1) · normal1`, so a point
    /// where the two do not overlap has a positive one. A thin body that passes right through the other counts up to its
    /// far end: its depth is how far it has to move back, which is more than what the two share. Where the curve's
    /// projection along the normal overlaps itself so that it has no inside, the region is one point, as where a surface
    /// ends.
    ///
    /// Where the contour is far from flat, normal and area are those of its projection. On smooth surfaces the errors
    /// of depth, normal and area are of second order in the edges' length.
    ///
    /// # Errors
    /// Those of [`PairQuery::contacts`]; a level limit.
    pub fn contact_manifolds(
        &mut self,
        prediction: f64,
        out: &mut impl Sink<ContactManifold>,
    ) -> Result<Coverage, QueryError> {
        const LEVEL: &str = "max_level: contact manifolds need all levels";
        if self.sides.iter().any(|side| side.limit.is_some()) {
            return Err(QueryError::Argument(LEVEL));
        }
        let tolerance = tolerance(prediction)?;
        let count = self.collect(tolerance)?;
        let [side1, side2] = &mut self.sides;
        let posed = [side1.posed()?, side2.posed()?];
        let lens = [count, ManifoldSlot::count(count), stack_len(&posed)];
        // Room for all three was made before the pairs were collected.
        let (pairs, slots, stack) = self.workspace.memory.three_slots(lens)?;
        manifolds(posed, pairs, slots, stack, out)
    }

    /// [`PairQuery::contact_manifolds`] of pairs that [`PairQuery::contacts`] has reported. Pass all of them, in any order:
    /// the slice is sorted in place by ids, and a pair that is there twice counts once. A level limit is ignored.
    ///
    /// # Errors
    /// Triangle ids that the meshes do not have, too little memory, a damaged asset.
    pub fn condense(
        &mut self,
        pairs: &mut [PairContact],
        out: &mut impl Sink<ContactManifold>,
    ) -> Result<Coverage, QueryError> {
        const IDS: &str = "pairs: a triangle id that the mesh does not have";
        let [side1, side2] = &mut self.sides;
        let counts = [&side1, &side2].map(|side| side.pose.asset.triangle_count());
        let is_known = |p: &PairContact| {
            (p.triangle1.0 as usize) < counts[0] && (p.triangle2.0 as usize) < counts[1]
        };
        if !pairs.iter().all(is_known) {
            return Err(QueryError::Argument(IDS));
        }
        let mut posed = [side1.posed()?, side2.posed()?];
        // Depths are found by rays, which look everywhere.
        for posed in &mut posed {
            posed.limit = None;
        }
        let lens = [ManifoldSlot::count(pairs.len()), stack_len(&posed)];
        let (slots, stack) = self.workspace.memory.two_slots(lens)?;
        manifolds(posed, pairs, slots, stack, out)
    }

    /// Puts all pairs of triangles at the beginning of the workspace, which has room behind them to condense
    /// them; how many there are.
    fn collect(&mut self, tolerance: f64) -> Result<usize, QueryError> {
        let [side1, side2] = &self.sides;
        let (asset1, asset2) = (side1.pose.asset, side2.pose.asset);
        let stack = asset1.pair_stack_len(asset2);
        let single = asset1.stack_len().max(asset2.stack_len());
        let behind = (size_of::<PairStackEntry>() * stack).max(size_of::<StackEntry>() * single);
        let each = size_of::<PairContact>() + size_of::<ManifoldSlot>() * ManifoldSlot::count(1);
        let grows = self.workspace.memory.grows();
        let mut room = self.workspace.memory.len().saturating_sub(behind) / each;
        if grows {
            room = room.max(PAIRS);
        }
        loop {
            // All of it, so that what is collected stays where it is.
            let needed = each * room + behind;
            let found = self.workspace.memory.slots::<u8>(needed)?.len();
            let (pairs, stack) = self.workspace.memory.two_slots([room, stack])?;
            let mut sink = SliceSink::new(pairs);
            let mut visitor = Contacts {
                tolerance,
                is_complete: false,
                sink: &mut sink,
            };
            let walk = walk_sides(&mut self.sides, &mut self.front, stack, &mut visitor)?;
            self.workspace.stats = Stats::of(&walk);
            if !walk.stopped {
                return Ok(sink.items().len());
            }
            if !grows {
                let mut count = Counted(0);
                let mut visitor = Contacts {
                    tolerance,
                    is_complete: false,
                    sink: &mut count,
                };
                walk_sides(&mut self.sides, &mut self.front, stack, &mut visitor)?;
                let needed = each * count.0 + behind;
                return Err(QueryError::Memory { needed, found });
            }
            room *= 2;
        }
    }

    /// One walk and its counts.
    fn walk(&mut self, visitor: &mut dyn PairVisitor) -> Result<Coverage, QueryError> {
        let [side1, side2] = &self.sides;
        let len = side1.pose.asset.pair_stack_len(side2.pose.asset);
        let stack = self.workspace.memory.slots(len)?;
        let walk = walk_sides(&mut self.sides, &mut self.front, stack, visitor)?;
        self.workspace.stats = Stats::of(&walk);
        Ok(Coverage::of(walk.stopped))
    }

    fn distance_stack_len(&self) -> usize {
        let [side1, side2] = &self.sides;
        side1.pose.asset.distance_stack_len(side2.pose.asset)
    }
}

/// A sink that counts.
struct Counted(usize);

impl Sink<PairContact> for Counted {
    fn push(&mut self, _: PairContact) -> ControlFlow<()> {
        self.0 += 1;
        ControlFlow::Continue(())
    }
}

fn walk_sides(
    [side1, side2]: &mut [Side<'_>; 2],
    front: &mut Option<&mut PairFront<'_>>,
    stack: &mut [PairStackEntry],
    visitor: &mut dyn PairVisitor,
) -> Result<Walk, QueryError> {
    let posed = [side1.posed()?, side2.posed()?];
    let walk = match front {
        Some(front) => front.walk(posed, stack, visitor),
        None => walk(posed, stack, visitor),
    }?;
    // On refined poses leaves need not be deformed: on either side that saves about a unit for each node that is visited
    // (docs/measured/benchmarks.md, refined poses).
    let gain = walk.nodes_visited;
    for side in [side1, side2] {
        side.note(&Walk { gain, ..walk }, 1);
    }
    Ok(walk)
}

/// The longer of the two that single queries need.
fn stack_len([posed1, posed2]: &[Posed<'_>; 2]) -> usize {
    let [len1, len2] = [posed1, posed2].map(|posed| posed.pose.asset.stack_len());
    len1.max(len2)
}

/// Questions about two posed meshes within a number of node visits; made by [`PairQuery::max_visits`].
#[derive(Debug)]
pub struct BudgetedPairQuery<'q, 'm, 'f> {
    query: PairQuery<'q, 'm, 'f>,
    max_visits: u64,
}

impl BudgetedPairQuery<'_, '_, '_> {
    /// [`PairQuery::closest_points`] within the budget.
    ///
    /// # Errors
    /// Its errors.
    pub fn closest_points(
        &mut self,
        max_distance: f64,
    ) -> Result<Budgeted<Option<PairContact>>, QueryError> {
        let [side1, side2] = &mut self.query.sides;
        let posed = [
            side1.posed_spheres(BUDGET_AND_LEVEL)?,
            side2.posed_spheres(BUDGET_AND_LEVEL)?,
        ];
        let [nodes1, nodes2] = posed.each_ref().map(|posed| posed.pose.asset.node_count());
        // Never more than there are pairs of a node or leaf of one and a node or leaf of the other.
        let parts = |nodes: usize| (1 + LANES) * nodes;
        let len = queue_len(self.max_visits)
            .min(parts(nodes1).saturating_mul(parts(nodes2)))
            .min(QUEUE_MAX);
        let workspace = &mut *self.query.workspace;
        let mut budget = Budget {
            max_visits: self.max_visits,
            queue: workspace.memory.up_to::<SearchEntry>(len),
        };
        let (best, walk) = budget.closest_points(posed, max_distance)?;
        workspace.stats = Stats::of(&walk);
        Ok(best)
    }
}
