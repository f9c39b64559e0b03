//! Brute force: parry's own queries for every deformed triangle and every element of the other shape.

use super::ours::DeformingMesh;
use super::parry::math::{Pose, Real, Vector};
use super::parry::query::details::NormalConstraints;
use super::parry::query::{
    ClosestPoints, ContactManifold, DefaultQueryDispatcher, NonlinearRigidMotion,
    PersistentQueryDispatcher, QueryDispatcher, ShapeCastOptions, Unsupported,
};
use super::parry::shape::{Cuboid, Shape, SharedShape, TriMesh, TriMeshFlags, Triangle, VoxelType};

pub(crate) type Answer<T> = Result<T, Unsupported>;

/// Where an element stands, and its shape.
pub(crate) type Element = (Pose, SharedShape);

/// The convex shapes that a shape consists of.
pub(crate) fn elements(shape: &SharedShape) -> Vec<Element> {
    let here = |shape: SharedShape| (Pose::IDENTITY, shape);
    if let Some(compound) = shape.as_compound() {
        compound.shapes().to_vec()
    } else if let Some(mesh) = shape.as_trimesh() {
        mesh.triangles()
            .map(|t| here(SharedShape::new(t)))
            .collect()
    } else if let Some(line) = shape.as_polyline() {
        line.segments().map(|s| here(SharedShape::new(s))).collect()
    } else if let Some(field) = shape.as_heightfield() {
        field
            .triangles()
            .map(|t| here(SharedShape::new(t)))
            .collect()
    } else if let Some(voxels) = shape.as_voxels() {
        let cuboid = SharedShape::new(Cuboid::new(voxels.voxel_size() / 2.0));
        voxels
            .voxels()
            .filter(|voxel| voxel.state.voxel_type() != VoxelType::Empty)
            .map(|voxel| (Pose::from_translation(voxel.center), cuboid.clone()))
            .collect()
    } else {
        vec![here(shape.clone())]
    }
}

/// All deformed triangles, and parry's mesh of them, which knows in which directions contacts may push.
pub(crate) struct Surface {
    pub(crate) triangles: Vec<Triangle>,
    mesh: TriMesh,
}

impl Surface {
    pub(crate) fn of(mesh: &DeformingMesh) -> Self {
        let pose = mesh.pose();
        let asset = pose.asset();
        let vertices = (0..asset.vertex_count() as u32).map(|v| {
            let x = pose
                .deformed(bdtree_runtime::VertexId(v))
                .expect("a vertex");
            Vector::from_array(x.map(|x| x as Real))
        });
        let vertices: Vec<Vector> = vertices.collect();
        let ids: Vec<[u32; 3]> = (0..asset.triangle_count() as u32)
            .map(|t| {
                asset
                    .triangle(bdtree_runtime::TriangleId(t))
                    .expect("a triangle")
            })
            .map(|corners| corners.map(|v| v.0))
            .collect();
        let corner = |v: u32| vertices[v as usize];
        let triangles = ids
            .iter()
            .map(|t| Triangle::new(corner(t[0]), corner(t[1]), corner(t[2])))
            .collect();
        let flags = TriMeshFlags::FIX_INTERNAL_EDGES;
        let mesh = TriMesh::with_flags(vertices.clone(), ids, flags).expect("parry's mesh");
        Self { triangles, mesh }
    }

    /// What is asked of every triangle and every element of the other shape, in the order that is tested.
    fn all<T>(
        &self,
        others: &[Element],
        pos: &Pose,
        is_swapped: bool,
        mut ask: impl FnMut(&Pose, &dyn Shape, &dyn Shape) -> Answer<T>,
    ) -> Answer<Vec<T>> {
        let mut answers = Vec::new();
        for (place, other) in others {
            let pos12 = *pos * *place;
            let pos21 = place.inverse() * pos.inverse();
            for triangle in &self.triangles {
                answers.push(match is_swapped {
                    false => ask(&pos12, triangle, &**other)?,
                    true => ask(&pos21, &**other, triangle)?,
                });
            }
        }
        Ok(answers)
    }

    pub(crate) fn intersects(
        &self,
        others: &[Element],
        pos: &Pose,
        is_swapped: bool,
    ) -> Answer<bool> {
        let all = self.all(others, pos, is_swapped, |pos12, a, b| {
            DefaultQueryDispatcher.intersection_test(pos12, a, b)
        })?;
        Ok(all.iter().any(|found| found.intersecting))
    }

    pub(crate) fn distance(
        &self,
        others: &[Element],
        pos: &Pose,
        is_swapped: bool,
    ) -> Answer<Real> {
        let all = self.all(others, pos, is_swapped, |pos12, a, b| {
            DefaultQueryDispatcher.distance(pos12, a, b)
        })?;
        Ok(all
            .iter()
            .map(|found| found.distance)
            .fold(Real::INFINITY, Real::min))
    }

    pub(crate) fn contact(
        &self,
        others: &[Element],
        pos: &Pose,
        is_swapped: bool,
        prediction: Real,
    ) -> Answer<Option<Real>> {
        let all = self.all(others, pos, is_swapped, |pos12, a, b| {
            // With the half-space second parry 0.31 takes the pose for its inverse.
            if b.as_halfspace().is_some() {
                return DefaultQueryDispatcher.contact(&pos12.inverse(), b, a, prediction);
            }
            DefaultQueryDispatcher.contact(pos12, a, b, prediction)
        })?;
        Ok(all
            .iter()
            .flatten()
            .map(|found| found.dist)
            .min_by(Real::total_cmp))
    }

    /// 0 where they intersect.
    pub(crate) fn closest(
        &self,
        others: &[Element],
        pos: &Pose,
        is_swapped: bool,
        limit: Real,
    ) -> Answer<Option<Real>> {
        let all = self.all(others, pos, is_swapped, |pos12, a, b| {
            let found = DefaultQueryDispatcher.closest_points(pos12, a, b, limit)?;
            Ok(apart(found, pos12))
        })?;
        Ok(all
            .into_iter()
            .flatten()
            .filter(|d| *d <= limit)
            .min_by(Real::total_cmp))
    }

    pub(crate) fn cast(
        &self,
        others: &[Element],
        pos: &Pose,
        is_swapped: bool,
        velocity: Vector,
        options: ShapeCastOptions,
    ) -> Answer<Option<Real>> {
        let all = self.all(others, pos, is_swapped, |pos12, a, b| {
            DefaultQueryDispatcher.cast_shapes(pos12, velocity, a, b, options)
        })?;
        let times = all.iter().flatten().map(|hit| hit.time_of_impact);
        Ok(times.min_by(Real::total_cmp))
    }

    /// Of motions of the mesh and of the other shape.
    pub(crate) fn cast_nonlinear(
        &self,
        others: &[Element],
        [own, other]: [&NonlinearRigidMotion; 2],
        is_swapped: bool,
        end: Real,
    ) -> Answer<Option<Real>> {
        let mut first: Option<Real> = None;
        for (place, shape) in others {
            let moved = other.prepend(*place);
            for triangle in &self.triangles {
                let hit = if is_swapped {
                    DefaultQueryDispatcher
                        .cast_shapes_nonlinear(&moved, &**shape, own, triangle, 0.0, end, true)
                } else {
                    DefaultQueryDispatcher
                        .cast_shapes_nonlinear(own, triangle, &moved, &**shape, 0.0, end, true)
                };
                if let Some(hit) = hit? {
                    let time = hit.time_of_impact;
                    first = Some(first.map_or(time, |first| first.min(time)));
                }
            }
        }
        Ok(first)
    }

    /// All contact points within the prediction: the normal and points in the frames of mesh and other shape, distance.
    pub(crate) fn contacts(
        &self,
        others: &[Element],
        pos: &Pose,
        is_swapped: bool,
        prediction: Real,
    ) -> Answer<Vec<Found>> {
        let mut found = Vec::new();
        for (place, shape) in others {
            let normals = |k: usize| self.mesh.triangle_normal_constraints(k as u32);
            let pos12 = *pos * *place;
            for (k, triangle) in self.triangles.iter().enumerate() {
                let normals = normals(k);
                let normals = normals.as_ref().map(|n| n as &dyn NormalConstraints);
                let mut manifold = ContactManifold::<(), ()>::new();
                if is_swapped {
                    DefaultQueryDispatcher.contact_manifold_convex_convex(
                        &(place.inverse() * pos.inverse()),
                        &**shape,
                        triangle,
                        None,
                        normals,
                        prediction,
                        &mut manifold,
                    )?;
                } else {
                    DefaultQueryDispatcher.contact_manifold_convex_convex(
                        &pos12,
                        triangle,
                        &**shape,
                        normals,
                        None,
                        prediction,
                        &mut manifold,
                    )?;
                }
                found.extend(
                    manifold
                        .points
                        .iter()
                        .filter(|p| p.dist <= prediction)
                        .map(|p| {
                            let (normal, point) = match is_swapped {
                                false => (manifold.local_n1, p.local_p1),
                                true => (manifold.local_n2, p.local_p2),
                            };
                            Found {
                                normal,
                                point,
                                dist: p.dist,
                            }
                        }),
                );
            }
        }
        Ok(found)
    }
}

/// A contact point in the mesh's frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Found {
    pub(crate) normal: Vector,
    pub(crate) point: Vector,
    pub(crate) dist: Real,
}

/// The distance of closest points, 0 where shapes intersect.
pub(crate) fn apart(found: ClosestPoints, pos12: &Pose) -> Option<Real> {
    match found {
        ClosestPoints::Intersecting => Some(0.0),
        ClosestPoints::WithinMargin(a, b) => Some(a.distance(*pos12 * b)),
        ClosestPoints::Disjoint => None,
    }
}
