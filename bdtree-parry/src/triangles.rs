//! A pair of parts as pairs of convex shapes: each mesh by those of its triangles that can matter.

use std::ops::ControlFlow;

use bdtree_runtime::{PairQuery, QueryError};

use super::composite::{Part, PartPair};
use super::near::{Reach, transform};
use super::parry::math::{Pose, Real, Vector};
use super::parry::query::details::NormalConstraints;
use super::parry::shape::{Shape, SubShapeId, Triangle};
use super::points::with_workspace;
use super::shape::{DeformingMesh, constraints};

/// Two convex shapes in the frames of the parts that they belong to.
#[derive(Clone, Copy)]
pub(super) struct ConvexPair<'a> {
    pub(super) shape1: &'a dyn Shape,
    pub(super) shape2: &'a dyn Shape,
    /// Directions that contacts may push in; asked for contacts alone.
    pub(super) normals1: Option<&'a dyn NormalConstraints>,
    pub(super) normals2: Option<&'a dyn NormalConstraints>,
    pub(super) subshape1: SubShapeId,
    pub(super) subshape2: SubShapeId,
    /// The triangle, where the part is a mesh.
    pub(super) triangle1: Option<u32>,
    pub(super) triangle2: Option<u32>,
}

/// Shows the pairs of triangles of a mesh, where `reach` says, with the other part; a mesh of the other part is shown whole.
pub(super) fn convex_pairs(
    pair: &PartPair<'_>,
    reach: &dyn Fn(&DeformingMesh, &dyn Shape, &Pose) -> Reach,
    has_normals: bool,
    visit: &mut dyn FnMut(&ConvexPair<'_>) -> ControlFlow<()>,
) {
    let PartPair { one, two, pos12 } = pair;
    if let Some(mesh) = one.mesh() {
        let ids = mesh.triangles_in(&reach(mesh, two.shape, pos12));
        each_triangle(mesh, &ids, has_normals, &mut |id, triangle, normals| {
            visit(&ConvexPair {
                shape1: triangle,
                shape2: two.shape,
                normals1: normals,
                normals2: two.normals,
                subshape1: one.subshape(id),
                subshape2: two.id,
                triangle1: Some(id),
                triangle2: None,
            })
        });
    } else if let Some(mesh) = two.mesh() {
        let ids = mesh.triangles_in(&reach(mesh, one.shape, &pos12.inverse()));
        each_triangle(mesh, &ids, has_normals, &mut |id, triangle, normals| {
            visit(&ConvexPair {
                shape1: one.shape,
                shape2: triangle,
                normals1: one.normals,
                normals2: normals,
                subshape1: one.id,
                subshape2: two.subshape(id),
                triangle1: None,
                triangle2: Some(id),
            })
        });
    } else {
        let _ = visit(&ConvexPair {
            shape1: one.shape,
            shape2: two.shape,
            normals1: one.normals,
            normals2: two.normals,
            subshape1: one.id,
            subshape2: two.id,
            triangle1: None,
            triangle2: None,
        });
    }
}

/// Takes a triangle's id, the triangle, and in which directions its contacts may push.
type VisitTriangle<'v> =
    dyn FnMut(u32, &dyn Shape, Option<&dyn NormalConstraints>) -> ControlFlow<()> + 'v;

/// Shows the triangles of these ids, which must be sorted.
fn each_triangle(
    mesh: &DeformingMesh,
    ids: &[u32],
    has_normals: bool,
    visit: &mut VisitTriangle<'_>,
) {
    if !has_normals {
        let mut triangles = ids.iter().filter_map(|&id| Some((id, mesh.triangle(id)?)));
        let _ = triangles.try_for_each(|(id, triangle)| visit(id, &triangle, None));
        return;
    }
    // The normal of each is asked for by its neighbors, too.
    let all: Vec<Option<(Triangle, Option<Vector>)>> = (ids.iter())
        .map(|id| mesh.triangle(*id).map(|of| (of, of.normal())))
        .collect();
    let normal = |id: u32| match ids.binary_search(&id) {
        Ok(k) => all[k].map(|(_, normal)| normal),
        Err(_) => Some(mesh.triangle(id)?.normal()),
    };
    for (&id, of) in ids.iter().zip(&all) {
        let Some((triangle, _)) = of else {
            continue;
        };
        let normals = mesh.constraints_by(id, &normal);
        if visit(id, triangle, constraints(&normals)).is_break() {
            return;
        }
    }
}

/// Both parts, where both are meshes.
pub(super) fn meshes<'a>(
    one: &Part<'a>,
    two: &Part<'a>,
) -> Option<(&'a DeformingMesh, &'a DeformingMesh)> {
    Some((one.mesh()?, two.mesh()?))
}

/// Asks two meshes exactly, in the frame of the first; `None` at a pose that is none, and of a damaged file.
pub(super) fn ask_pair<T>(
    (mesh1, mesh2): (&DeformingMesh, &DeformingMesh),
    pos12: &Pose,
    ask: impl FnOnce(&mut PairQuery<'_, '_, '_>) -> Result<T, QueryError>,
) -> Option<T> {
    let pose1 = mesh1.pose();
    let pose2 = mesh2.pose();
    let pose2 = pose2.placed(transform(pos12, mesh2.model().scale())).ok()?;
    with_workspace(|workspace| ask(&mut pose1.against(&pose2, workspace))).ok()
}

/// A distance that `bdtree-runtime` takes: not negative.
pub(super) fn limit(distance: Real) -> f64 {
    f64::from(distance).max(0.0)
}
