//! A plane between two deformed meshes: most bodies that are near each other do not touch, and one
//! plane says so at a fraction of what all pairs of their nodes cost.
//!
//! Its normal is the line of the bodies' centers. All is in the frame of the first asset. What lies beyond the plane is
//! looked at down to its corners; without a plane nothing is lost but the time. More normals, those that the points found
//! farthest along it suggest (Chung and Wang, "Quick collision detection of polytopes in virtual environments", 1996), do not
//! pay: hardly more pairs are told apart (docs/measured/bevy.md, 1000 colliders).

use bdtree_format::{LANES, Row, TriangleRecord};

use super::{PairStackEntry, Subtree, lane_subtree, used_lanes};
use crate::bound::WideSpheres;
use crate::cache::{CHUNK, LeafChunk, Posed};
use crate::error::QueryError;
use crate::pair_frame::PairFrame;
use crate::rounding::NORMAL_LENGTH;
use crate::simd::{Lanes, Work};
use crate::view::Asset;

/// Nodes of one asset that may be looked at: bodies that face each other along their whole surfaces are better left to the walk
/// of both trees.
const NODES: u32 = 48;

/// The search for a plane.
pub(super) struct SeparatingPlane<'p, 's> {
    pub(super) posed: [&'p mut Posed<'s>; 2],
    pub(super) frame: &'p PairFrame,
    pub(super) stack: &'p mut [PairStackEntry],
}

/// What a search did.
#[derive(Default)]
pub(super) struct Found {
    /// The triangles are certainly farther apart than the pair's tolerance.
    pub(super) apart: bool,
    pub(super) nodes_visited: u64,
    pub(super) nodes_updated: u64,
}

impl Work for SeparatingPlane<'_, '_> {
    type Output = Result<Found, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let [posed_a, posed_b] = self.posed;
        let mut sides = [
            Side::new(posed_a, None),
            Side::new(posed_b, Some(self.frame)),
        ];
        let apart = search::<L>(&mut sides, self.frame, self.stack)?;
        let [a, b] = sides;
        Ok(Found {
            apart,
            nodes_visited: a.visited + b.visited,
            nodes_updated: a.updated + b.updated,
        })
    }
}

/// In loops over the two sides: what is done with one is long, and compiled once.
#[inline(always)]
fn search<L: Lanes>(
    sides: &mut [Side<'_, '_>; 2],
    frame: &PairFrame,
    stack: &mut [PairStackEntry],
) -> Result<bool, QueryError> {
    let mut middles = [[0.0; 3]; 2];
    for (side, middle) in sides.iter_mut().zip(&mut middles) {
        *middle = side.middle::<L>()?;
    }
    let Some(normal) = unit(minus(middles[1], middles[0])) else {
        return Ok(false);
    };
    let directions = [normal, normal.map(|x| -x)];
    let mut tops = [f32::NEG_INFINITY; 2];
    for k in 0..2 {
        tops[k] = sides[k].climb::<L>(directions[k])?;
    }
    let margin = frame.height_margin();
    let gap = -(tops[0] + tops[1]);
    if !(gap > 2.0 * margin) {
        return Ok(false); // NaN too
    }
    let mut plane = tops[0] + 0.5 * gap;
    let mut limit = -tops[1] - margin;
    for k in 0..2 {
        let Some(top) = sides[k].below::<L>(directions[k], plane, limit, stack)? else {
            return Ok(false);
        };
        // Of the other one all must stay on the plane's other side.
        plane = -top - margin;
        limit = plane;
    }
    Ok(true)
}

/// One asset in the frame of the first.
struct Side<'p, 's> {
    asset: &'p Asset<'p>,
    posed: &'p mut Posed<'s>,
    /// Carries there what is the second's.
    frame: Option<&'p PairFrame>,
    spare: LeafChunk,
    visited: u64,
    updated: u64,
}

impl<'p, 's> Side<'p, 's> {
    fn new(posed: &'p mut Posed<'s>, frame: Option<&'p PairFrame>) -> Self {
        Self {
            asset: posed.pose.asset,
            posed,
            frame,
            spare: LeafChunk::EMPTY,
            visited: 0,
            updated: 0,
        }
    }

    #[inline(always)]
    fn carried<L: Lanes>(&self, spheres: WideSpheres<L>) -> WideSpheres<L> {
        match self.frame {
            Some(frame) => frame.carry(spheres),
            None => spheres,
        }
    }

    /// Puts a node's spheres into `out`.
    #[inline(always)]
    fn spheres<L: Lanes>(
        &mut self,
        index: u32,
        out: &mut WideSpheres<L>,
    ) -> Result<(), QueryError> {
        let evaluated = self.posed.spheres(self.asset, index, out)?;
        self.visited += 1;
        self.updated += u64::from(evaluated);
        *out = self.carried(*out);
        Ok(())
    }

    /// The mean of the root's lane centers.
    #[inline(always)]
    fn middle<L: Lanes>(&mut self) -> Result<[f32; 3], QueryError> {
        let mut spheres = WideSpheres::<L>::empty();
        self.spheres(0, &mut spheres)?;
        let spheres = spheres.store();
        let lanes = used_lanes(self.asset.node(0)?);
        let mut sum = [0.0; 3];
        for lane in 0..LANES {
            if lanes & (1 << lane) != 0 {
                for axis in 0..3 {
                    sum[axis] += spheres.center[axis][lane];
                }
            }
        }
        let count = lanes.count_ones() as f32;
        Ok(sum.map(|x| x / count))
    }

    /// The height along a direction of the highest corner of one leaf: descends into the lane that reaches farthest, counting half
    /// of its radius.
    #[inline(always)]
    fn climb<L: Lanes>(&mut self, direction: [f32; 3]) -> Result<f32, QueryError> {
        let mut top = f32::NEG_INFINITY;
        let mut at = Subtree::default();
        for _ in 0..=self.asset.depth() {
            if at.triangles > 0 {
                let records = self.asset.leaf(at)?;
                let first = records.get(..CHUNK).unwrap_or(records);
                let mut corners = [WideSpheres::<L>::empty(); 2];
                self.corners(at.start, first, &mut corners)?;
                for corner in corners {
                    for height in corner.heights(direction, 0.0).store() {
                        top = top.max(height);
                    }
                }
                break;
            }
            let mut spheres = WideSpheres::<L>::empty();
            self.spheres(at.start, &mut spheres)?;
            let heights = spheres.heights(direction, 0.5).store();
            let node = self.asset.node(at.start)?;
            let mut left = used_lanes(node);
            let mut highest = None;
            while left != 0 {
                let lane = left.trailing_zeros() as usize & (LANES - 1);
                left &= left - 1;
                if highest.is_none_or(|best: usize| heights[lane] > heights[best]) {
                    highest = Some(lane);
                }
            }
            let Some(lane) = highest else {
                break; // a corrupt file's
            };
            at = lane_subtree(node, lane);
        }
        Ok(top)
    }

    /// The first four of `records`, the triangles from `start` on: their corners, some twice, are put into
    /// `out`, as spheres that hold the tolerance and what rounding takes.
    #[inline(always)]
    fn corners<L: Lanes>(
        &mut self,
        start: u32,
        records: &[TriangleRecord],
        out: &mut [WideSpheres<L>; 2],
    ) -> Result<(), QueryError> {
        let chunk = self
            .posed
            .leaf(self.asset, start, records, &mut self.spare)?;
        let [a, b, c] = &chunk.corners;
        let (first, second) = (points(a, b), points(b, c));
        *out = [self.carried(first), self.carried(second)];
        Ok(())
    }

    /// A height along `direction`, at least `plane` and at most `limit`, that nothing exceeds by more than
    /// rounding; `None` where there is none, or it takes too long to say.
    #[inline(always)]
    fn below<L: Lanes>(
        &mut self,
        direction: [f32; 3],
        plane: f32,
        limit: f32,
        stack: &mut [PairStackEntry],
    ) -> Result<Option<f32>, QueryError> {
        let mut top = plane;
        let mut visits = 0;
        let mut len = 0;
        let mut next = Some(0);
        while let Some(index) = next {
            visits += 1;
            if visits > NODES {
                return Ok(None);
            }
            let node = self.asset.node(index)?;
            let mut spheres = WideSpheres::<L>::empty();
            self.spheres(index, &mut spheres)?;
            let heights = spheres.heights(direction, 1.0);
            let beyond = !L::splat(top).above(heights) & used_lanes(node);
            let mut inner = beyond & !node.leaf_mask;
            while inner != 0 {
                let lane = inner.trailing_zeros() as usize & (LANES - 1);
                inner &= inner - 1;
                let child = lane_subtree(node, lane).start;
                self.posed.prefetch_node(self.asset, child);
                let Some(slot) = stack.get_mut(len) else {
                    return Ok(None);
                };
                slot.a = child;
                len += 1;
            }
            let mut left = beyond & node.leaf_mask;
            while left != 0 {
                let lane = left.trailing_zeros() as usize & (LANES - 1);
                left &= left - 1;
                let leaf = lane_subtree(node, lane);
                let mut start = leaf.start;
                for records in self.asset.leaf(leaf)?.chunks(CHUNK) {
                    let mut corners = [WideSpheres::<L>::empty(); 2];
                    self.corners(start, records, &mut corners)?;
                    for corners in corners {
                        let heights = corners.heights(direction, 1.0).store();
                        for height in heights {
                            // NaN is not below.
                            if !(height <= limit) {
                                return Ok(None);
                            }
                            if height > top {
                                top = height;
                            }
                        }
                    }
                    start = start.saturating_add(CHUNK as u32);
                }
            }
            next = None;
            if len > 0 {
                len -= 1;
                next = stack.get(len).map(|entry| entry.a);
            }
        }
        Ok(Some(top))
    }
}

/// Two groups of four points side by side.
#[inline(always)]
fn points<L: Lanes>(p: &[[f32; 4]; 3], q: &[[f32; 4]; 3]) -> WideSpheres<L> {
    WideSpheres {
        center: [
            L::load(&row(&p[0], &q[0])),
            L::load(&row(&p[1], &q[1])),
            L::load(&row(&p[2], &q[2])),
        ],
        radius: L::splat(0.0),
    }
}

#[inline(always)]
fn row(p: &[f32; 4], q: &[f32; 4]) -> Row {
    [p[0], p[1], p[2], p[3], q[0], q[1], q[2], q[3]]
}

#[inline(always)]
fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A vector of this direction that is not longer than 1.
#[inline(always)]
fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let squared = dot(v, v);
    let scale = NORMAL_LENGTH / crate::math::sqrt_f32(squared);
    // Far above what may be flushed to 0 in the squares.
    (squared > 1e-30 && scale > 0.0).then(|| v.map(|x| x * scale))
}
