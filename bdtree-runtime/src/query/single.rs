//! Queries of one mesh.

use core::ops::{ControlFlow, Range};

use super::budget::{Budget, Budgeted, BudgetedContacts, queue_len};
use super::side::Side;
use super::{ball, capsule, cuboid, frustum, half_space, project, ray, rays};
use crate::cache::{Posed, StepCache};
use crate::contact::{Contact, Coverage, PointProjection, Proxy, RayIntersection, Sink};
use crate::depth::Proxies;
use crate::error::QueryError;
use crate::pose::Pose;
use crate::refined::RefinedPose;
use crate::shape::{Ball, Frustum, FrustumState, Ray, Shape};
use crate::traverse::{STREAM, SearchEntry, StackEntry, Walk};
use crate::vector::Vec3;
use crate::workspace::{Stats, Workspace};

/// Questions about one posed mesh; made by [`Pose::query`] or [`Instance::query`](crate::Instance::query).
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # use bdtree_runtime::{Asset, Ball, Contact, Ray, Transform, Workspace, include_bdt};
/// # let asset = Asset::open(include_bdt!("../../../fixtures/golden/sphere.bdt"))?;
/// # let (q, mut memory) = (vec![0.0; asset.mode_count()], vec![0.0; asset.pose_len()]);
/// # let pose = asset.pose(&q, Transform::IDENTITY, &mut memory)?;
/// let mut workspace = Workspace::new();
/// let mut query = pose.query(&mut workspace);
/// let mut contacts: Vec<Contact> = Vec::new();
/// query.contacts(Ball::new([0.0, 0.1, 0.0], 0.3), &mut contacts)?;
/// let hit = query.cast_ray(&Ray::new([0.0, 5.0, 0.0], [0.0, -1.0, 0.0]))?;
/// # let _ = hit;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Query<'q, 'm> {
    pub(crate) side: Side<'q>,
    pub(super) workspace: &'q mut Workspace<'m>,
}

impl Pose<'_> {
    /// Questions about this mesh, in the memory of a workspace.
    #[inline]
    pub fn query<'q, 'm>(&'q self, workspace: &'q mut Workspace<'m>) -> Query<'q, 'm> {
        Query {
            side: Side::new(*self),
            workspace,
        }
    }
}

impl<'q, 'm> Query<'q, 'm> {
    /// Of a pose with the cache that was started with it.
    #[cfg(feature = "alloc")]
    #[inline]
    pub(crate) fn with_cache(
        pose: Pose<'q>,
        cache: &'q mut StepCache<'_>,
        workspace: &'q mut Workspace<'m>,
    ) -> Self {
        let mut side = Side::new(pose);
        side.keep(cache);
        Self { side, workspace }
    }

    /// Uses a step cache: answers stay the same, and nodes and triangles that an earlier query of the step has
    /// computed are not computed again. If the cache was not started with this pose, queries return
    /// [`QueryError::Cache`].
    #[inline]
    pub fn cached(mut self, cache: &'q mut StepCache<'_>) -> Self {
        self.side.keep(cache);
        self
    }

    /// Uses exact bounds of the whole pose: answers stay the same, and take less time. Queries that end at a level and those
    /// within a budget do without, and so do instances that follow a reference. If it was prepared for another pose, queries return
    /// [`QueryError::Cache`].
    #[inline]
    pub fn refined(mut self, refined: &'q RefinedPose<'_>) -> Self {
        self.side.refine(refined);
        self
    }

    /// Stops descending at `level` (0 is the root's). Triangles of leaves down to there are tested exactly, as always.
    /// For every subtree below `level` that its test cannot rule out, the query pushes one bounding sphere into
    /// `proxies`. So every triangle of the full answer is reported or lies in a reported sphere. From level
    /// [`Asset::depth`](crate::Asset::depth) − 1 on the answer is the full one.
    ///
    /// A sphere need not lie in those of its ancestors (unless the asset was baked with nested spheres), so which
    /// spheres the traversal reaches depends on the tree. It is the same on every processor and with every
    /// [`Kernel`](crate::Kernel).
    ///
    /// If `proxies` is full, the query stops: it returns [`Coverage::Truncated`], or [`QueryError::Proxies`] if it has
    /// no [`Coverage`] to return, unless what it has found already decides the answer.
    ///
    /// Queries for a nearest point or first hit leave out subtrees behind the best result found so far.
    /// [`Query::frustum_state`] and [`Query::max_visits`] refuse a level.
    pub fn max_level(mut self, level: usize, proxies: &'q mut dyn Sink<Proxy>) -> Self {
        self.side.limit = Some(Proxies::new(level, proxies));
        self
    }

    /// Limits the number of node visits, the most promising first: answers say what they may have missed.
    pub fn max_visits(self, max_visits: u64) -> BudgetedQuery<'q, 'm> {
        BudgetedQuery {
            query: self,
            max_visits,
        }
    }

    /// The pose.
    pub fn pose(&self) -> &Pose<'q> {
        &self.side.pose
    }

    /// What the last question visited.
    pub fn stats(&self) -> Stats {
        self.workspace.stats
    }

    /// Reports every triangle that the shape touches. Meshes are surfaces, not solids: a ball wholly inside a closed mesh
    /// touches nothing. Sinks append: clear them yourself.
    ///
    /// | shape | triangles within | `point` | `normal` | `distance` |
    /// |---|---|---|---|---|
    /// | [`Ball`] | the radius of the center | nearest to the center | from there to the center | to the center, less the radius |
    /// | [`Capsule`](crate::Capsule) | the radius of the segment | nearest to the segment | from there to the segment | to the segment, less the radius |
    /// | [`Cuboid`](crate::Cuboid) | the box | deepest in the box: farthest from the nearest face | from that face into the box | the depth, negative |
    /// | [`HalfSpace`](crate::HalfSpace) | the half-space: a vertex is on or below the plane | the deepest vertex, the first of equals | into the half-space: the plane's, negated | height above the plane |
    ///
    /// Where a triangle reaches the center or the segment, `normal` is the triangle's own. [`Contact::distance`] says how
    /// to separate the two.
    ///
    /// # Errors
    /// [`QueryError::Argument`] names the shape's field that is not finite, beyond 2^100, negative or zero where
    /// it must not be; too little memory, a corrupt asset.
    #[inline]
    pub fn contacts(
        &mut self,
        shape: impl Into<Shape>,
        out: &mut impl Sink<Contact>,
    ) -> Result<Coverage, QueryError> {
        self.walk_shape(&shape.into(), out)
    }

    /// [`Query::contacts`], compiled here for all callers.
    fn walk_shape(
        &mut self,
        shape: &Shape,
        out: &mut dyn Sink<Contact>,
    ) -> Result<Coverage, QueryError> {
        self.walk(|posed, stack| {
            let walk = shape_contacts(shape, posed, stack, out)?;
            Ok((Coverage::of(walk.stopped), walk))
        })
    }

    /// Whether the shape touches any triangle: ends with the first one that is found.
    ///
    /// # Errors
    /// Those of [`Query::contacts`].
    pub fn intersects(&mut self, shape: impl Into<Shape>) -> Result<bool, QueryError> {
        let mut first = First::default();
        self.walk_shape(&shape.into(), &mut first)?;
        self.settled(first.is_found, first.is_found)
    }

    /// The point of the mesh nearest to `point`, if it is within `max_distance` (which may be infinite).
    ///
    /// # Errors
    /// A point that is not finite or beyond 2^100, a negative or NaN distance, too little memory, a corrupt asset.
    #[inline]
    pub fn project_point(
        &mut self,
        point: impl Into<Vec3>,
        max_distance: f64,
    ) -> Result<Option<PointProjection>, QueryError> {
        let Vec3(point) = point.into();
        let found =
            self.walk(|posed, stack| project::project(posed, point, max_distance, stack))?;
        self.settled(found, false)
    }

    /// Where the ray first meets the mesh. Triangles of zero area are missed; rays through edges and vertices
    /// do not slip between triangles that share them.
    ///
    /// # Errors
    /// An origin that is not finite or beyond 2^100, a direction that is zero or not finite, a negative or NaN
    /// distance, too little memory, a corrupt asset.
    pub fn cast_ray(&mut self, ray: &Ray) -> Result<Option<RayIntersection>, QueryError> {
        let hit = self.walk(|posed, stack| ray::first(posed, ray, stack))?;
        self.settled(hit, false)
    }

    /// Whether [`Query::cast_ray`] finds anything, in less time.
    ///
    /// # Errors
    /// Those of [`Query::cast_ray`].
    pub fn intersects_ray(&mut self, ray: &Ray) -> Result<bool, QueryError> {
        let is_met = self.walk(|posed, stack| ray::any(posed, ray, stack))?;
        self.settled(is_met, is_met)
    }

    /// Reports every triangle that the ray meets, unsorted.
    ///
    /// # Errors
    /// Those of [`Query::cast_ray`].
    pub fn cast_ray_all(
        &mut self,
        ray: &Ray,
        out: &mut impl Sink<RayIntersection>,
    ) -> Result<Coverage, QueryError> {
        self.walk(|posed, stack| {
            let walk = ray::all(posed, ray, stack, out)?;
            Ok((Coverage::of(walk.stopped), walk))
        })
    }

    /// [`Query::cast_ray`] for each of `rays`: `hits[i]` becomes that of ray i.
    ///
    /// # Errors
    /// Those of [`Query::cast_ray`] for any of the rays, and fewer hits than rays; what was written before stays.
    pub fn cast_rays(
        &mut self,
        rays: &[Ray],
        hits: &mut [Option<RayIntersection>],
    ) -> Result<(), QueryError> {
        self.walk_for(rays.len(), |some, posed, stack| {
            rays::first(posed, rays, some, stack, hits)
        })?;
        self.settled((), false)
    }

    /// [`Query::intersects_ray`] for each of `rays`: `hits[i]` becomes that of ray i.
    ///
    /// # Errors
    /// Those of [`Query::cast_rays`].
    pub fn intersects_rays(&mut self, rays: &[Ray], hits: &mut [bool]) -> Result<(), QueryError> {
        self.walk_for(rays.len(), |some, posed, stack| {
            rays::any(posed, rays, some, stack, hits)
        })?;
        self.settled((), false)
    }

    /// [`Query::cast_ray_all`] for each of `rays`: every hit with the number of its ray, ray after ray.
    ///
    /// # Errors
    /// Those of [`Query::cast_ray`] for any of the rays.
    pub fn cast_rays_all(
        &mut self,
        rays: &[Ray],
        out: &mut impl Sink<(usize, RayIntersection)>,
    ) -> Result<Coverage, QueryError> {
        let stopped = self.walk_for(rays.len(), |some, posed, stack| {
            rays::all(posed, rays, some, stack, out)
        })?;
        Ok(Coverage::of(stopped))
    }

    /// Whether the mesh is in a frustum: `Inside` if all of it is, `Outside` if [`Frustum::triangle`] says so of every
    /// triangle, else `Intersects`. Within rounding, a mesh outside may be called `Intersects`; a visible one is never
    /// called `Outside`. [`BoundingSphere::state`](crate::BoundingSphere::state) tests one sphere instead.
    ///
    /// # Errors
    /// A level limit, too little memory, a corrupt asset.
    pub fn frustum_state(&mut self, frustum: &Frustum) -> Result<FrustumState, QueryError> {
        const LEVEL: &str = "max_level: a frustum's state needs all levels";
        if self.side.limit.is_some() {
            return Err(QueryError::Argument(LEVEL));
        }
        self.walk(|posed, stack| frustum::state(posed, frustum, stack))
    }

    /// An answer that does not tell its coverage: an error where proxies without room cut it short, unless it is
    /// right all the same.
    #[inline(always)]
    fn settled<T>(&self, answer: T, is_right: bool) -> Result<T, QueryError> {
        if self.side.is_cut() && !is_right {
            return Err(QueryError::Proxies);
        }
        Ok(answer)
    }

    /// One walk and its counts.
    #[inline(always)]
    fn walk<T>(
        &mut self,
        ask: impl FnOnce(Posed<'_>, &mut [StackEntry]) -> Result<(T, Walk), QueryError>,
    ) -> Result<T, QueryError> {
        let posed = self.side.posed()?;
        let needed = posed.pose.asset.stack_len();
        let (answer, walk) = ask(posed, self.workspace.memory.slots(needed)?)?;
        self.workspace.stats = Stats::of(&walk);
        self.side.note(&walk, 1);
        Ok(answer)
    }

    /// Several walks, some at a time: `ask` is told which. Whether one broke off, which ends them.
    #[inline(always)]
    fn walk_for(
        &mut self,
        walks: usize,
        mut ask: impl FnMut(Range<usize>, Posed<'_>, &mut [StackEntry]) -> Result<Walk, QueryError>,
    ) -> Result<bool, QueryError> {
        let mut all = Walk::default();
        let mut start = 0;
        loop {
            let left = walks - start;
            let some = self.side.batch(left).min(left);
            let posed = self.side.posed_for(left)?;
            let needed = posed.pose.asset.stack_len();
            let memory = &mut self.workspace.memory;
            let stack = match (some, posed.has_boxes()) {
                // As many as go on together, or as there is room for.
                (2.., true) => memory.up_to(needed.saturating_mul(STREAM.min(some))),
                _ => memory.slots(needed)?,
            };
            let walk = ask(start..start + some, posed, stack)?;
            self.side.note(&walk, some);
            all.add(&walk);
            start += some;
            if start >= walks || walk.stopped {
                break;
            }
        }
        self.workspace.stats = Stats::of(&all);
        Ok(all.stopped)
    }
}

/// The walk of [`Query::contacts`].
pub(super) fn shape_contacts(
    shape: &Shape,
    posed: Posed<'_>,
    stack: &mut [StackEntry],
    out: &mut dyn Sink<Contact>,
) -> Result<Walk, QueryError> {
    match shape {
        Shape::Ball(ball) => ball::contacts(posed, ball, stack, out),
        Shape::Capsule(capsule) => capsule::contacts(posed, capsule, stack, out),
        Shape::Cuboid(cuboid) => cuboid::contacts(posed, cuboid, stack, out),
        Shape::HalfSpace(half_space) => half_space::contacts(posed, half_space, stack, out),
    }
}

/// A sink that has no room: the query ends with the first thing that it finds.
#[derive(Default)]
pub(super) struct First {
    pub(super) is_found: bool,
}

impl<T> Sink<T> for First {
    fn push(&mut self, _item: T) -> ControlFlow<()> {
        self.is_found = true;
        ControlFlow::Break(())
    }
}

/// Questions about one posed mesh within a number of node visits; made by [`Query::max_visits`].
///
/// With each further visit the answer can only get better and its bound can only rise. Visits without end
/// return what the plain question returns. What is still to be visited is kept in the workspace; what finds no
/// room there is left out and counts in the bound.
#[derive(Debug)]
pub struct BudgetedQuery<'q, 'm> {
    query: Query<'q, 'm>,
    max_visits: u64,
}

impl BudgetedQuery<'_, '_> {
    /// [`Query::contacts`] of a ball, the nearest nodes first.
    ///
    /// # Errors
    /// Its errors; a level limit.
    pub fn contacts(
        &mut self,
        ball: Ball,
        out: &mut impl Sink<Contact>,
    ) -> Result<BudgetedContacts, QueryError> {
        self.walk(|budget, posed| budget.ball(posed, &ball, out))
    }

    /// [`Query::project_point`] within the budget.
    ///
    /// # Errors
    /// Its errors; a level limit.
    pub fn project_point(
        &mut self,
        point: impl Into<Vec3>,
        max_distance: f64,
    ) -> Result<Budgeted<Option<PointProjection>>, QueryError> {
        let Vec3(point) = point.into();
        self.walk(|budget, posed| budget.project(posed, point, max_distance))
    }

    /// [`Query::cast_ray`] within the budget.
    ///
    /// # Errors
    /// Its errors; a level limit.
    pub fn cast_ray(&mut self, ray: &Ray) -> Result<Budgeted<Option<RayIntersection>>, QueryError> {
        self.walk(|budget, posed| budget.ray(posed, ray))
    }

    fn walk<T>(
        &mut self,
        ask: impl FnOnce(&mut Budget<'_>, Posed<'_>) -> Result<(T, Walk), QueryError>,
    ) -> Result<T, QueryError> {
        let workspace = &mut *self.query.workspace;
        let posed = self.query.side.posed_spheres(BUDGET_AND_LEVEL)?;
        let len = queue_len(self.max_visits).min(posed.pose.asset.node_count());
        let mut budget = Budget {
            max_visits: self.max_visits,
            queue: workspace.memory.up_to::<SearchEntry>(len),
        };
        let (answer, walk) = ask(&mut budget, posed)?;
        workspace.stats = Stats::of(&walk);
        Ok(answer)
    }
}

pub(super) const BUDGET_AND_LEVEL: &str = "max_level: not together with max_visits";
