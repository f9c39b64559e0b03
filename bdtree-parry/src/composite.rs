//! Composite shapes taken apart: pairs of a deforming mesh or convex shape with another one.

use std::ops::ControlFlow;

use super::near::bounds;
use super::parry::bounding_volume::{Aabb, BoundingVolume};
use super::parry::math::{Pose, Real, Vector};
use super::parry::query::details::NormalConstraints;
use super::parry::shape::{Cuboid, Shape, SubShapeId, VoxelType};
use super::shape::DeformingMesh;
use super::voxels::Voxel;

/// A part of a shape, or a shape that has none.
#[derive(Clone, Copy)]
pub(super) struct Part<'a> {
    pub(super) shape: &'a dyn Shape,
    /// Where it stands in the whole's frame.
    pub(super) pose: Pose,
    /// What queries call it: 0 where there are no parts.
    pub(super) id: SubShapeId,
    /// Whether it is the whole.
    pub(super) is_whole: bool,
    /// In which directions its contacts may push.
    pub(super) normals: Option<&'a dyn NormalConstraints>,
    /// The voxel, if it is one.
    pub(super) voxel: Option<Voxel<'a>>,
}

impl<'a> Part<'a> {
    /// The deforming mesh, if it is one.
    pub(super) fn mesh(&self) -> Option<&'a DeformingMesh> {
        self.shape.as_shape()
    }

    /// The sub-shape of the whole that a triangle of the part belongs to: the triangle itself where the mesh is the whole.
    pub(super) fn subshape(&self, triangle: u32) -> SubShapeId {
        if self.is_whole { triangle } else { self.id }
    }
}

/// A part of each shape, and where the second's part stands in the frame of the first's.
#[derive(Clone, Copy)]
pub(super) struct PartPair<'a> {
    pub(super) one: Part<'a>,
    pub(super) two: Part<'a>,
    pub(super) pos12: Pose,
}

/// How near parts have to be to each other to matter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearness {
    /// At most this far apart; infinite for any distance.
    pub(super) distance: Real,
    /// At some time while the second moves by this, in the first's frame.
    pub(super) sweep: Vector,
}

impl Nearness {
    pub(super) fn within(distance: Real) -> Self {
        Self {
            distance,
            sweep: Vector::ZERO,
        }
    }
}

/// Whether any of these shapes is a deforming mesh or a `Compound` that holds one.
pub(super) fn holds_mesh(shapes: [&dyn Shape; 2]) -> bool {
    shapes.into_iter().any(|shape| match shape.as_compound() {
        Some(compound) => (compound.shapes().iter()).any(|(_, part)| is_mesh(&**part)),
        None => is_mesh(shape),
    })
}

/// Whether it is a deforming mesh itself: parts of a `Compound` are no `Compound`s.
fn is_mesh(shape: &dyn Shape) -> bool {
    shape.as_shape::<DeformingMesh>().is_some()
}

/// Ends a walk once something is so.
pub(super) fn end_if(is_so: bool) -> ControlFlow<()> {
    if is_so {
        ControlFlow::Break(())
    } else {
        ControlFlow::Continue(())
    }
}

/// Shows all pairs of parts that are near enough, until `visit` breaks.
pub(super) fn part_pairs(
    pos12: &Pose,
    shape1: &dyn Shape,
    shape2: &dyn Shape,
    near: Nearness,
    visit: &mut dyn FnMut(&PartPair<'_>) -> ControlFlow<()>,
) {
    let around1 = bounds(shape2).map(|aabb| swept(aabb.transform_by(pos12), near));
    parts(shape1, around1, &mut |one| {
        // The second's box seen by the part decides which of its own parts matter.
        let pos21 = pos12.inverse() * one.pose;
        let back = pos12.rotation.inverse() * -near.sweep;
        let seen = Nearness {
            sweep: back,
            ..near
        };
        let around2 = bounds(one.shape).map(|aabb| swept(aabb.transform_by(&pos21), seen));
        let mut flow = ControlFlow::Continue(());
        parts(shape2, around2, &mut |two| {
            let pos12 = one.pose.inverse() * *pos12 * two.pose;
            flow = visit(&PartPair {
                one: *one,
                two: *two,
                pos12,
            });
            flow
        });
        flow
    });
}

/// A box, wherever it comes, loosened.
fn swept(aabb: Aabb, near: Nearness) -> Aabb {
    let moved = Aabb::new(aabb.mins + near.sweep, aabb.maxs + near.sweep);
    let all = aabb.merged(&moved);
    let size = all
        .mins
        .abs()
        .max_element()
        .max(all.maxs.abs().max_element());
    let largest = Real::MAX / 16.0;
    let margin = (near.distance + 64.0 * Real::EPSILON * size).min(largest);
    all.loosened(margin)
}

/// Shows the parts of a shape that touch a box in its frame (all of them without one), until `visit` breaks.
fn parts(
    shape: &dyn Shape,
    within: Option<Aabb>,
    visit: &mut dyn FnMut(&Part<'_>) -> ControlFlow<()>,
) {
    let whole = shape.compute_local_aabb();
    let within = within.unwrap_or(whole);
    let mut flow = ControlFlow::Continue(());
    if let Some(composite) = shape.as_composite_shape() {
        for id in composite.bvh().intersect_aabb(&within) {
            composite.map_part_at(id, &mut |pose, part, normals| {
                flow = visit(&Part {
                    shape: part,
                    pose: pose.copied().unwrap_or(Pose::IDENTITY),
                    id,
                    is_whole: false,
                    normals,
                    voxel: None,
                });
            });
            if flow.is_break() {
                return;
            }
        }
    } else if let Some(field) = shape.as_heightfield() {
        // Its cells are counted in numbers that hold no box without end.
        let Some(within) = within.intersection(&whole.loosened(near_zero(&whole))) else {
            return;
        };
        field.map_elements_in_local_aabb(&within, &mut |id, triangle| {
            if flow.is_continue() {
                let normals = field.triangle_normal_constraints(id);
                flow = visit(&Part {
                    shape: triangle,
                    pose: Pose::IDENTITY,
                    id,
                    is_whole: false,
                    normals: super::shape::constraints(&normals),
                    voxel: None,
                });
            }
        });
    } else if let Some(voxels) = shape.as_voxels() {
        let Some(within) = within.intersection(&whole.loosened(near_zero(&whole))) else {
            return;
        };
        let cuboid = Cuboid::new(voxels.voxel_size() / 2.0);
        for voxel in voxels.voxels_intersecting_local_aabb(&within) {
            if voxel.state.voxel_type() == VoxelType::Empty {
                continue;
            }
            flow = visit(&Part {
                shape: &cuboid,
                pose: Pose::from_translation(voxel.center),
                id: voxel.linear_id.flat_id() as SubShapeId,
                is_whole: false,
                normals: None,
                voxel: Some(Voxel {
                    all: voxels,
                    own: voxel,
                }),
            });
            if flow.is_break() {
                return;
            }
        }
    } else {
        let _ = visit(&Part {
            shape,
            pose: Pose::IDENTITY,
            id: 0,
            is_whole: true,
            normals: None,
            voxel: None,
        });
    }
}

/// A margin for boxes that only touch.
fn near_zero(aabb: &Aabb) -> Real {
    16.0 * Real::EPSILON * (aabb.mins.abs().max_element() + aabb.maxs.abs().max_element())
}
