//! Contact manifolds: the points of all triangles in contact, grouped by normal, with ids that last from step to step.

use std::ops::ControlFlow::Continue;

use bdtree_runtime::ContactManifold as Region;

use super::composite::{Nearness, PartPair, end_if, holds_mesh, part_pairs};
use super::dispatcher::MeshDispatcher;
use super::lasting::Both;
use super::parry::math::{Pose, Real, Vector};
use super::parry::query::details::NormalConstraints;
use super::parry::query::{
    ContactManifold, ContactManifoldsWorkspace, PersistentQueryDispatcher, TrackedContact,
    TypedWorkspaceData, Unsupported, WorkspaceData,
};
use super::parry::shape::{FeatureId, PackedFeatureId, Shape, SubShapeId};
use super::points::narrow;
use super::shape::DeformingMesh;
use super::triangles::{ConvexPair, ask_pair, convex_pairs, limit, meshes};
use super::voxels::Rows;

/// Points whose normals agree within about 8° are one manifold.
const SAME_NORMAL: Real = 0.99;

/// Most points of a manifold: those that hold best.
const POINTS: usize = 4;

/// A point that was there in the last step is taken before one that is this much better.
const LASTING: Real = 1.2;

/// A point of contact in the frames of the two whole shapes.
#[derive(Debug, Clone, Copy)]
struct Point {
    normal1: Vector,
    normal2: Vector,
    local_p1: Vector,
    local_p2: Vector,
    dist: Real,
    fid1: PackedFeatureId,
    fid2: PackedFeatureId,
    subshape1: SubShapeId,
    subshape2: SubShapeId,
}

/// Points with nearly the same normal: one manifold.
struct Group {
    normal1: Vector,
    normal2: Vector,
    points: Vec<Point>,
}

/// Tells the engine that a pair has several manifolds whose order may change. Holds nothing: what lasts is in the manifolds.
#[derive(Debug, Clone, Copy)]
struct Grouped;

impl WorkspaceData for Grouped {
    fn as_typed_workspace_data(&self) -> TypedWorkspaceData<'_> {
        TypedWorkspaceData::Custom
    }

    fn clone_dyn(&self) -> Box<dyn WorkspaceData> {
        Box::new(*self)
    }
}

impl<D, M, C> PersistentQueryDispatcher<M, C> for MeshDispatcher<D>
where
    D: PersistentQueryDispatcher<M, C>,
    M: Default + Clone + Send + Sync,
    C: Default + Copy + Send + Sync,
{
    fn contact_manifolds(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        prediction: Real,
        manifolds: &mut Vec<ContactManifold<M, C>>,
        workspace: &mut Option<ContactManifoldsWorkspace>,
    ) -> Result<(), Unsupported> {
        if !holds_mesh([shape1, shape2]) {
            return self
                .inner
                .contact_manifolds(pos12, shape1, shape2, prediction, manifolds, workspace);
        }
        let lasting = Both::of(shape1, shape2);
        if workspace
            .as_ref()
            .is_none_or(|is| is.0.downcast_ref::<Grouped>().is_none())
        {
            *workspace = Some(Grouped.into());
        }
        if let Some(both) = &lasting
            && both.follow(pos12, prediction, manifolds)
        {
            return Ok(());
        }
        let mut points = Vec::new();
        let mut failed = false;
        let near = Nearness::within(prediction);
        part_pairs(pos12, shape1, shape2, near, &mut |pair| {
            if let Some(both) = meshes(&pair.one, &pair.two) {
                regions(pair, both, prediction, &mut points);
                return Continue(());
            }
            let Some(rows) = Rows::of(pair) else {
                return Continue(());
            };
            let pair = &rows.instead(pair);
            let reach = |mesh: &DeformingMesh, other: &dyn Shape, pos: &Pose| {
                rows.reach(mesh, other, pos, prediction)
            };
            convex_pairs(pair, &reach, true, &mut |convex| {
                let mut manifold = ContactManifold::<M, C>::new();
                let found = self.inner.contact_manifold_convex_convex(
                    &pair.pos12,
                    convex.shape1,
                    convex.shape2,
                    convex.normals1,
                    convex.normals2,
                    prediction,
                    &mut manifold,
                );
                failed |= found.is_err();
                manifold
                    .points
                    .retain(|point| rows.hold([point.local_p1, point.local_p2]));
                collect(pair, convex, &manifold, prediction, &mut points);
                end_if(failed)
            });
            end_if(failed)
        });
        if failed {
            manifolds.clear();
            return Err(Unsupported);
        }
        let triangles = replace(manifolds, grouped(points), prediction);
        if let Some(both) = lasting {
            both.remember(pos12, prediction, manifolds, &triangles);
        }
        Ok(())
    }

    fn contact_manifold_convex_convex(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        normal_constraints1: Option<&dyn NormalConstraints>,
        normal_constraints2: Option<&dyn NormalConstraints>,
        prediction: Real,
        manifold: &mut ContactManifold<M, C>,
    ) -> Result<(), Unsupported> {
        self.inner.contact_manifold_convex_convex(
            pos12,
            shape1,
            shape2,
            normal_constraints1,
            normal_constraints2,
            prediction,
            manifold,
        )
    }
}

/// The points of two convex shapes.
fn collect<M, C>(
    pair: &PartPair<'_>,
    convex: &ConvexPair<'_>,
    manifold: &ContactManifold<M, C>,
    prediction: Real,
    out: &mut Vec<Point>,
) {
    let id = |fid, mesh: Option<&DeformingMesh>, triangle, subshape| match (mesh, triangle) {
        (Some(mesh), Some(triangle)) => mesh_feature(mesh, triangle, fid),
        _ => part_feature(subshape, fid),
    };
    for point in manifold
        .points
        .iter()
        .filter(|point| point.dist <= prediction)
    {
        out.push(Point {
            normal1: pair.one.pose.rotation * manifold.local_n1,
            normal2: pair.two.pose.rotation * manifold.local_n2,
            local_p1: pair.one.pose * point.local_p1,
            local_p2: pair.two.pose * point.local_p2,
            dist: point.dist,
            fid1: id(
                point.fid1,
                pair.one.mesh(),
                convex.triangle1,
                convex.subshape1,
            ),
            fid2: id(
                point.fid2,
                pair.two.mesh(),
                convex.triangle2,
                convex.subshape2,
            ),
            subshape1: convex.subshape1,
            subshape2: convex.subshape2,
        });
    }
}

/// The points of two meshes: those of their regions of contact, and where they do not touch the nearest point. Of a chair on
/// others 6400 pairs of triangles are within rapier's 2 cm, of which 90 touch; the nearest is found without the others. Regions with
/// what is within a sixteenth of the prediction took heaps of chairs a fifth more time, and these came to rest no sooner.
fn regions(
    pair: &PartPair<'_>,
    both: (&DeformingMesh, &DeformingMesh),
    prediction: Real,
    out: &mut Vec<Point>,
) {
    let mut found: Vec<Region> = Vec::new();
    let nearest = ask_pair(both, &pair.pos12, |query| {
        // Most pairs are not near; one walk finds that out.
        if !query.is_within(limit(prediction))? {
            return Ok(None);
        }
        query.contact_manifolds(0.0, &mut found)?;
        if found.is_empty() {
            query.closest_points(limit(prediction))
        } else {
            Ok(None)
        }
    });
    let back = pair.pos12.inverse();
    let feature = |triangle: u32| PackedFeatureId::face(triangle & 0x3fff_ffff);
    // In the frame of the first mesh.
    let mut push = |normals: [[f64; 3]; 2], points: [[f64; 3]; 2], triangles: [u32; 2], dist| {
        out.push(Point {
            normal1: pair.one.pose.rotation * narrow(normals[0]),
            normal2: pair.two.pose.rotation * (back.rotation * narrow(normals[1])),
            local_p1: pair.one.pose * narrow(points[0]),
            local_p2: pair.two.pose * (back * narrow(points[1])),
            dist,
            fid1: feature(triangles[0]),
            fid2: feature(triangles[1]),
            subshape1: pair.one.subshape(triangles[0]),
            subshape2: pair.two.subshape(triangles[1]),
        });
    };
    if let Some(near) = nearest.flatten() {
        let triangles = [near.triangle1.0, near.triangle2.0];
        let (normals, points) = ([near.normal1, near.normal2], [near.point1, near.point2]);
        push(normals, points, triangles, near.distance as Real);
    }
    for region in &found {
        for point in region.points() {
            let dist = point.distance as Real;
            // A region that overlaps elsewhere may have points far apart.
            if dist <= prediction {
                let triangles = [point.triangle1.0, point.triangle2.0];
                let (normals, points) = (
                    [region.normal1, region.normal2],
                    [point.point1, point.point2],
                );
                push(normals, points, triangles, dist);
            }
        }
    }
}

impl DeformingMesh {
    /// A triangle that a feature of a point of contact belongs to, where manifolds of [`MeshDispatcher`] name one of this mesh and
    /// the mesh is no part of a `Compound`.
    pub fn triangle_of(&self, feature: PackedFeatureId) -> Option<u32> {
        let triangle = match feature.unpack() {
            FeatureId::Vertex(vertex) => self.model().triangle_at(vertex)?,
            FeatureId::Edge(edge) => edge / 4,
            FeatureId::Face(triangle) => triangle,
            FeatureId::Unknown => return None,
        };
        (triangle < self.triangle_count()).then_some(triangle)
    }
}

/// What a feature of a triangle is called in its mesh: a vertex by its id in the file, so that all triangles around it agree.
fn mesh_feature(mesh: &DeformingMesh, triangle: u32, fid: PackedFeatureId) -> PackedFeatureId {
    const CODES: u32 = 0x3fff_ffff;
    match fid.unpack() {
        FeatureId::Vertex(corner) => match mesh.corners(triangle) {
            Some(corners) => PackedFeatureId::vertex(corners[corner as usize % 3] & CODES),
            None => fid,
        },
        FeatureId::Edge(edge) => PackedFeatureId::edge((triangle * 4 + edge % 4) & CODES),
        FeatureId::Face(_) | FeatureId::Unknown => PackedFeatureId::face(triangle & CODES),
    }
}

/// What a feature of a part is called in the whole.
fn part_feature(part: SubShapeId, fid: PackedFeatureId) -> PackedFeatureId {
    let mixed = part.wrapping_mul(0x9e37_79b1) & 0x3fff_ffff;
    // The kind of feature stands in the upper two bits.
    PackedFeatureId(fid.0 ^ mixed)
}

/// Points by their normals, the deepest first.
fn grouped(mut points: Vec<Point>) -> Vec<Group> {
    points.sort_by(|a, b| {
        let ids = |p: &Point| (p.fid1.0, p.fid2.0);
        a.dist.total_cmp(&b.dist).then(ids(a).cmp(&ids(b)))
    });
    let mut groups: Vec<Group> = Vec::new();
    for point in points {
        let is_same = |group: &&mut Group| group.normal1.dot(point.normal1) >= SAME_NORMAL;
        match groups.iter_mut().find(is_same) {
            Some(group) => group.points.push(point),
            None => groups.push(Group {
                normal1: point.normal1,
                normal2: point.normal2,
                points: vec![point],
            }),
        }
    }
    groups
}

/// Puts groups in the place of the last step's manifolds, whose data go to those with the nearest normals and whose points'
/// data go to points of the same features, or else of nearly the same place. Gives the sub-shapes of each manifold's points.
fn replace<M: Default + Clone, C: Default + Copy>(
    manifolds: &mut Vec<ContactManifold<M, C>>,
    groups: Vec<Group>,
    prediction: Real,
) -> Vec<Vec<[SubShapeId; 2]>> {
    let mut old = std::mem::take(manifolds);
    let old_points: Vec<(Vector, TrackedContact<C>)> = old
        .iter()
        .flat_map(|manifold| {
            manifold
                .points
                .iter()
                .map(|point| (manifold.local_n1, *point))
        })
        .collect();
    let mut used = vec![false; old_points.len()];
    let mut subshapes = Vec::with_capacity(groups.len());
    for group in groups {
        let chosen = chosen(&group, &old_points, prediction);
        let (id1, id2) = (group.points[0].subshape1, group.points[0].subshape2);
        let nearest = (0..old.len())
            .map(|k| (k, old[k].local_n1.dot(group.normal1)))
            .filter(|(_, cos)| *cos >= SAME_NORMAL)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let mut manifold = match nearest {
            Some((k, _)) => old.swap_remove(k),
            None => ContactManifold::with_data(id1, id2, M::default()),
        };
        manifold.subshape1 = id1;
        manifold.subshape2 = id2;
        manifold.local_n1 = group.normal1;
        manifold.local_n2 = group.normal2;
        manifold.points.clear();
        subshapes.push(chosen.iter().map(|p| [p.subshape1, p.subshape2]).collect());
        for point in chosen {
            let mut tracked = TrackedContact::new(
                point.local_p1,
                point.local_p2,
                point.fid1,
                point.fid2,
                point.dist,
            );
            if let Some(k) = matching(&point, &group, &old_points, &used, prediction) {
                used[k] = true;
                tracked.data = old_points[k].1.data;
            }
            manifold.points.push(tracked);
        }
        manifolds.push(manifold);
    }
    subshapes
}

/// The last step's point that this one continues, none that another one continues already.
fn matching<C>(
    point: &Point,
    group: &Group,
    old: &[(Vector, TrackedContact<C>)],
    used: &[bool],
    prediction: Real,
) -> Option<usize> {
    let mut best: Option<(usize, Real)> = None;
    for (k, (normal, was)) in old.iter().enumerate() {
        if used[k] || normal.dot(group.normal1) < SAME_NORMAL {
            continue;
        }
        let apart = was.local_p1.distance(point.local_p1);
        if was.fid1 == point.fid1 && was.fid2 == point.fid2 && apart < 4.0 * prediction {
            return Some(k);
        }
        if apart < prediction && best.is_none_or(|best| apart < best.1) {
            best = Some((k, apart));
        }
    }
    best.map(|best| best.0)
}

/// Up to four points of a group: the deepest, the one farthest from it, and the farthest on either side of the line between
/// them. Points of the last step come before slightly better ones, so that resting contacts keep theirs.
fn chosen<C>(group: &Group, old: &[(Vector, TrackedContact<C>)], prediction: Real) -> Vec<Point> {
    if group.points.len() <= POINTS {
        return group.points.clone();
    }
    let lasting: Vec<Real> = group
        .points
        .iter()
        .map(|point| {
            let is_old = old.iter().any(|(_, was)| {
                was.fid1 == point.fid1
                    && was.fid2 == point.fid2
                    && was.local_p1.distance(point.local_p1) < prediction
            });
            if is_old { LASTING } else { 1.0 }
        })
        .collect();
    let points = &group.points;
    let best_of = |score: &dyn Fn(&Point) -> Real| {
        (0..points.len())
            .map(|k| {
                let score = score(&points[k]);
                (
                    k,
                    if score > 0.0 {
                        score * lasting[k]
                    } else {
                        score
                    },
                )
            })
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
            .filter(|(_, score)| *score > 0.0)
            .map(|(k, _)| k)
    };
    // The deepest is the first; an older one of nearly its depth takes its place.
    let deepest = (0..points.len())
        .find(|k| lasting[*k] > 1.0 && points[*k].dist <= points[0].dist + 0.05 * prediction)
        .unwrap_or(0);
    let first = points[deepest].local_p1;
    let mut kept = vec![deepest];
    if let Some(far) = best_of(&|p| p.local_p1.distance_squared(first)) {
        let across = group.normal1.cross(points[far].local_p1 - first);
        kept.push(far);
        kept.extend(best_of(&|p| (p.local_p1 - first).dot(across)));
        kept.extend(best_of(&|p| -(p.local_p1 - first).dot(across)));
    }
    kept.into_iter().map(|k| points[k]).collect()
}
