//! Voxels among their neighbors: contacts push out of a `Voxels` through the faces that no neighbor covers.
//!
//! Taken alone, a voxel of a flat floor pushes sideways what sinks in near its edge, and what slides over the floor stops
//! there. So contacts are those of a box: the three rows of voxels through this one, as far as they go on. What is left are
//! the points within the voxel itself; other voxels have the others.

use super::composite::{Part, PartPair};
use super::near::{Reach, bounds};
use super::parry::bounding_volume::Aabb;
use super::parry::math::{Pose, Real, Vector};
use super::parry::shape::{AxisMask, Cuboid, Shape, VoxelData, Voxels};
use super::shape::DeformingMesh;

/// Along each axis, towards less and towards more.
const FACES: [[AxisMask; 2]; 3] = [
    [AxisMask::X_NEG, AxisMask::X_POS],
    [AxisMask::Y_NEG, AxisMask::Y_POS],
    [AxisMask::Z_NEG, AxisMask::Z_POS],
];

/// A voxel of a shape. Boxes and points are in its frame, whose origin is its center.
#[derive(Clone, Copy)]
pub(super) struct Voxel<'a> {
    pub(super) all: &'a Voxels,
    pub(super) own: VoxelData,
}

impl Voxel<'_> {
    fn half(&self) -> Vector {
        self.all.voxel_size() / 2.0
    }

    /// Whether neighbors cover all its faces.
    pub(super) fn is_covered(&self) -> bool {
        self.own.state.free_faces().is_empty()
    }

    /// How far rows go on from it along the axes. What ends beyond `around` has no end: nothing in there gets out on that side
    /// in a shorter way than on another.
    pub(super) fn rows(&self, around: Option<Aabb>) -> Aabb {
        let mut rows = Aabb::from_half_extents(Vector::ZERO, self.half());
        for (axis, faces) in FACES.into_iter().enumerate() {
            let size = self.all.voxel_size()[axis];
            let far = |limit: Aabb| limit.half_extents().max_element() * 4.0 + size;
            let [less, more] = faces.map(|face| {
                let is_more = face == faces[1];
                let limit = around.map(|box_| match is_more {
                    false => -box_.mins[axis],
                    true => box_.maxs[axis],
                });
                let mut at = self.own.grid_coords;
                let mut state = self.own.state;
                let mut end = size / 2.0;
                while !state.free_faces().contains(face) {
                    if limit.is_some_and(|limit| end > limit) {
                        break;
                    }
                    at[axis] += if is_more { 1 } else { -1 };
                    // A face may be covered by a voxel of another shape.
                    let Some(next) = self.all.voxel_state(at).filter(|next| !next.is_empty())
                    else {
                        break;
                    };
                    state = next;
                    end += size;
                }
                let has_end = state.free_faces().contains(face);
                match (around, limit) {
                    (Some(around), Some(limit)) if !has_end => end.max(limit) + far(around),
                    _ => end,
                }
            });
            rows.mins[axis] = -less;
            rows.maxs[axis] = more;
        }
        rows
    }

    /// It and the neighbors behind its open faces: what is there may be pushed out through them.
    pub(super) fn depths(&self) -> Aabb {
        let free = self.own.state.free_faces();
        let mut depths = Aabb::from_half_extents(Vector::ZERO, self.half());
        for (axis, [less, more]) in FACES.into_iter().enumerate() {
            let size = self.all.voxel_size()[axis];
            match (free.contains(less), free.contains(more)) {
                (true, false) => depths.maxs[axis] += size,
                (false, true) => depths.mins[axis] -= size,
                _ => {}
            }
        }
        depths
    }

    /// Whether a point of contact is its own, up to rounding.
    pub(super) fn holds(&self, point: Vector) -> bool {
        let half = self.half();
        let margin = 1e-4 * half + 64.0 * Real::EPSILON * self.own.center.abs();
        (half + margin - point.abs()).min_element() >= 0.0
    }
}

/// The boxes that stand for a voxel.
struct Boxes<'a> {
    voxel: Voxel<'a>,
    rows: Cuboid,
    /// The middle of the rows in the voxel's frame.
    center: Vector,
    depths: Aabb,
}

/// What the contacts of two parts are computed with in the place of voxels.
pub(super) struct Rows<'a> {
    sides: [Option<Boxes<'a>>; 2],
}

impl<'a> Rows<'a> {
    /// Of a pair of parts; `None` where neighbors cover all faces of a voxel: nothing is pushed out of it.
    pub(super) fn of(pair: &PartPair<'a>) -> Option<Self> {
        let PartPair { one, two, pos12 } = pair;
        let sides = [(one, two, *pos12), (two, one, pos12.inverse())];
        let mut boxes = [None, None];
        for (side, (part, other, pos)) in boxes.iter_mut().zip(sides) {
            let Some(voxel) = part.voxel else {
                continue;
            };
            if voxel.is_covered() {
                return None;
            }
            let around = bounds(other.shape).map(|aabb| aabb.transform_by(&pos));
            let rows = voxel.rows(around);
            *side = Some(Boxes {
                voxel,
                rows: Cuboid::new(rows.half_extents()),
                center: rows.center(),
                depths: voxel.depths(),
            });
        }
        Some(Self { sides: boxes })
    }

    /// The pair with rows in the place of voxels.
    pub(super) fn instead<'b>(&'b self, pair: &PartPair<'b>) -> PartPair<'b> {
        let [to1, to2] = [0, 1].map(|side| Pose::from_translation(self.center(side)));
        let part = |side: usize, part: Part<'b>, to: Pose| Part {
            shape: match &self.sides[side] {
                Some(boxes) => &boxes.rows,
                None => part.shape,
            },
            pose: part.pose * to,
            ..part
        };
        PartPair {
            one: part(0, pair.one, to1),
            two: part(1, pair.two, to2),
            pos12: to1.inverse() * pair.pos12 * to2,
        }
    }

    fn center(&self, side: usize) -> Vector {
        let boxes = self.sides[side].as_ref();
        boxes.map_or(Vector::ZERO, |boxes| boxes.center)
    }

    /// The triangles of a mesh that matter to the other part, which stands at `pos` in the mesh's frame.
    pub(super) fn reach(
        &self,
        mesh: &DeformingMesh,
        other: &dyn Shape,
        pos: &Pose,
        prediction: Real,
    ) -> Reach {
        let Some(boxes) = self.sides.iter().flatten().next() else {
            return mesh.reach_of(other, pos, prediction);
        };
        let at = Pose::from_translation(boxes.depths.center() - boxes.center);
        let depths = Cuboid::new(boxes.depths.half_extents());
        mesh.reach_of(&depths, &(*pos * at), prediction)
    }

    /// Whether a contact of parts that [`Rows::instead`] gives is of their voxels.
    pub(super) fn hold(&self, points: [Vector; 2]) -> bool {
        self.sides.iter().zip(points).all(|(side, point)| {
            side.as_ref()
                .is_none_or(|boxes| boxes.voxel.holds(point + boxes.center))
        })
    }
}
