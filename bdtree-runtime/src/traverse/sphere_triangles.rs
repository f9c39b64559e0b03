//! Spheres at which a walk of the first tree ends, against the triangles of the second's leaves.

use bdtree_format::LANES;
use core::ops::ControlFlow;

use super::Subtree;
use super::byte_masks::{BYTES, any_row, gather};
use super::pair_side::Side;
use super::visitor::PairVisitor;
use crate::bound::Spheres;
use crate::cache::CHUNK;
use crate::contact::{LaneId, TriangleId};
use crate::error::QueryError;
use crate::rounding::MARGIN;
use crate::simd::{Lanes, Work};

/// What a visit has found: pairs of a lane of the first and a leaf lane of the second.
pub(super) struct SphereTriangles<'l, 's> {
    pub(super) a: &'l Side<'s>,
    pub(super) b: &'l mut Side<'s>,
    /// The first's node, and its spheres (stored units).
    pub(super) node: u32,
    pub(super) spheres: &'l Spheres,
    /// The second's leaves.
    pub(super) leaves: [Subtree; LANES],
    /// Byte i, bit j: lane i of the first, leaf j of the second.
    pub(super) found: u64,
    /// Fewer by every pair of a sphere and a triangle.
    pub(super) tests_left: &'l mut u64,
    pub(super) visitor: &'l mut (dyn PairVisitor + 'l),
}

/// A sphere in the world, with all that a triangle may be away from it.
#[derive(Clone, Copy, Default)]
struct WorldSphere {
    center: [f64; 3],
    reach: f64,
}

impl Work for SphereTriangles<'_, '_> {
    type Output = Result<ControlFlow<()>, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let spheres = self.world();
        let mut leaves = any_row(self.found);
        while leaves != 0 {
            let at = leaves.trailing_zeros() as usize & (LANES - 1);
            leaves &= leaves - 1;
            let lanes = gather((self.found & (BYTES << at)) >> at);
            let leaf = self.leaves[at];
            let tests = u64::from(leaf.triangles) * u64::from(lanes.count_ones());
            let Some(fewer) = self.tests_left.checked_sub(tests) else {
                return Err(self.b.asset.endless(*self.tests_left).into());
            };
            *self.tests_left = fewer;
            let mut start = leaf.start as usize;
            let mut rest = self.b.asset.leaf(leaf)?;
            while !rest.is_empty() {
                let four = self.b.four::<L>(start, rest)?;
                let mut left = lanes;
                while left != 0 {
                    let lane = left.trailing_zeros() as usize & (LANES - 1);
                    left &= left - 1;
                    let sphere = &spheres[lane];
                    let near = four.world.within::<L::Quad>(sphere.center, sphere.reach);
                    let mut near = near & !(u8::MAX << four.len);
                    while near != 0 {
                        let k = near.trailing_zeros() as usize & (CHUNK - 1);
                        near &= near - 1;
                        let lane = LaneId {
                            node: self.node,
                            lane: lane as u8,
                        };
                        let triangle = TriangleId(four.ids[k]);
                        if self.visitor.lane_triangle(lane, triangle).is_break() {
                            return Ok(ControlFlow::Break(()));
                        }
                    }
                }
                start += CHUNK;
                rest = rest.get(CHUNK..).unwrap_or_default();
            }
        }
        Ok(ControlFlow::Continue(()))
    }
}

impl SphereTriangles<'_, '_> {
    /// The first's spheres in the world: as [`Pose::stored_to_world`](crate::Pose::stored_to_world) has them, and larger by
    /// what the visitor allows.
    #[inline(always)]
    fn world(&self) -> [WorldSphere; LANES] {
        let placement = &self.a.posed.pose.placement;
        let mut spheres = [WorldSphere::default(); LANES];
        let [x, y, z] = &self.spheres.center;
        for lane in 0..LANES {
            let radius = f64::from(self.spheres.radius[lane]) * placement.world_per_stored();
            spheres[lane] = WorldSphere {
                center: placement.world([x[lane], y[lane], z[lane]]),
                reach: (radius + self.visitor.sphere_tolerance()) * (1.0 + MARGIN),
            };
        }
        spheres
    }
}
