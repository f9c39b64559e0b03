//! Two trees against each other, in the frame of the first.

use bdtree_format::{LANES, NodeRecord, SectionKind, TriangleRecord};
use core::ops::ControlFlow;

use super::{PairStackEntry, Subtree, Walk, bits, lane_subtree, mask_of, used_lanes};
use crate::bound::Spheres;
use crate::contact::TriangleId;
use crate::error::QueryError;
use crate::frame::PairFrame;
use crate::narrow::Triangle;
use crate::pose::Pose;
use crate::view::Asset;

/// Relative error of a squared distance and a sum of two radii in f32 (docs/guarantees.md).
const SKIP: f32 = 1.0 - 1.0 / (1 << 20) as f32;

/// Triangles deformed at once on each side of a leaf pair.
const TILE: usize = 8;

/// A question about pairs of triangles of two deformed meshes.
pub(crate) trait PairVisitor {
    /// Takes two triangles' world corners; `Break` ends the traversal.
    fn triangles(
        &mut self,
        a: TriangleId,
        corners_a: &Triangle,
        b: TriangleId,
        corners_b: &Triangle,
    ) -> ControlFlow<()>;
}

/// One side of the traversal.
struct Side<'s, 'a> {
    asset: &'s Asset<'a>,
    pose: &'s Pose<'s>,
    /// The node evaluated last: siblings' pairs share it.
    cached: Option<(u32, Spheres)>,
    evaluations: u64,
}

impl<'a> Side<'_, 'a> {
    /// A node and its spheres, moved to the common frame by `to_common`.
    fn node(
        &mut self,
        index: u32,
        to_common: impl Fn(&mut Spheres),
    ) -> Result<(&'a NodeRecord, Spheres), QueryError> {
        let node = self.asset.node(index)?;
        if let Some((cached, spheres)) = self.cached
            && cached == index
        {
            return Ok((node, spheres));
        }
        let mut spheres = self.asset.spheres(self.pose, node)?;
        to_common(&mut spheres);
        self.evaluations += 1;
        self.cached = Some((index, spheres));
        Ok((node, spheres))
    }

    fn records(&self, leaf: Subtree) -> Result<&'a [TriangleRecord], QueryError> {
        let start = leaf.start as usize;
        let end = start.saturating_add(leaf.triangles as usize);
        self.asset.triangles.get(start..end).ok_or_else(|| {
            let len = self.asset.triangles.len();
            self.asset
                .out_of_range(SectionKind::TRIANGLES, end, len, 16)
                .into()
        })
    }

    /// Deforms up to [`TILE`] triangles.
    fn deform(
        &self,
        records: &[TriangleRecord],
        tile: &mut [Triangle; TILE],
    ) -> Result<(), QueryError> {
        for (record, corners) in records.iter().zip(tile) {
            *corners = self.asset.deformed_triangle(self.pose, record)?;
        }
        Ok(())
    }
}

/// Visits all pairs of leaf triangles whose lanes' spheres meet.
pub(crate) fn two<V: PairVisitor>(
    (asset_a, pose_a): (&Asset<'_>, &Pose<'_>),
    (asset_b, pose_b): (&Asset<'_>, &Pose<'_>),
    frame: &PairFrame,
    stack: &mut [PairStackEntry],
    visitor: &mut V,
) -> Result<Walk, QueryError> {
    let needed = asset_a.pair_stack_len(asset_b);
    let found = stack.len();
    let Some(stack) = stack.get_mut(..needed) else {
        return Err(QueryError::Memory { needed, found });
    };
    // A sound pair of trees has at most one entry for each pair of a node or leaf lane of one
    // and a node or leaf lane of the other, and a node has eight lanes.
    let subtrees = |asset: &Asset<'_>| (1 + LANES as u64) * asset.node_count() as u64;
    let visits_max = subtrees(asset_a).saturating_mul(subtrees(asset_b));
    let mut visits = 0;
    // A sound pair of trees meets each pair of triangles once.
    let mut tests_left = asset_a.triangle_count() as u64 * asset_b.triangle_count() as u64;

    let mut a = Side {
        asset: asset_a,
        pose: pose_a,
        cached: None,
        evaluations: 0,
    };
    let mut b = Side {
        asset: asset_b,
        pose: pose_b,
        cached: None,
        evaluations: 0,
    };
    let mut walk = Walk {
        nodes_visited: 0,
        stopped: false,
    };
    stack[0] = PairStackEntry::default();
    let mut len = 1;
    while len > 0 {
        len -= 1;
        let entry = stack[len];
        visits += 1;
        if visits > visits_max {
            return Err(asset_a.endless(visits_max).into());
        }
        let mut push = |a: Subtree, b: Subtree, leaf_sphere: [f32; 4]| {
            let Some(slot) = stack.get_mut(len) else {
                return Err(QueryError::from(asset_a.too_deep()));
            };
            *slot = PairStackEntry { a, b, leaf_sphere };
            len += 1;
            Ok(())
        };
        match (entry.a.triangles, entry.b.triangles) {
            (0, 0) => {
                let (node_a, spheres_a) = a.node(entry.a.start, |_| ())?;
                let (node_b, spheres_b) = b.node(entry.b.start, |s| frame.carry(s))?;
                let mask_b = used_lanes(node_b);
                for lane_a in bits(used_lanes(node_a)) {
                    let sphere_a = lane_sphere(&spheres_a, lane_a);
                    let sub_a = lane_subtree(node_a, lane_a);
                    for lane_b in bits(meeting(&spheres_b, sphere_a) & mask_b) {
                        let sub_b = lane_subtree(node_b, lane_b);
                        match (sub_a.triangles, sub_b.triangles) {
                            (0, 0) => push(sub_a, sub_b, [0.0; 4])?,
                            (0, _) => push(sub_a, sub_b, lane_sphere(&spheres_b, lane_b))?,
                            (_, 0) => push(sub_a, sub_b, sphere_a)?,
                            _ => {
                                if leaves(&a, sub_a, &b, sub_b, &mut tests_left, visitor)?
                                    .is_break()
                                {
                                    walk.stopped = true;
                                }
                            }
                        }
                        if walk.stopped {
                            walk.nodes_visited = a.evaluations + b.evaluations;
                            return Ok(walk);
                        }
                    }
                }
            }
            (0, _) | (_, 0) => {
                let a_is_node = entry.a.triangles == 0;
                let (node, spheres) = if a_is_node {
                    a.node(entry.a.start, |_| ())?
                } else {
                    b.node(entry.b.start, |s| frame.carry(s))?
                };
                let mask = used_lanes(node);
                for lane in bits(meeting(&spheres, entry.leaf_sphere) & mask) {
                    let sub = lane_subtree(node, lane);
                    let (sub_a, sub_b) = if a_is_node {
                        (sub, entry.b)
                    } else {
                        (entry.a, sub)
                    };
                    if sub.triangles == 0 {
                        push(sub_a, sub_b, entry.leaf_sphere)?;
                    } else if leaves(&a, sub_a, &b, sub_b, &mut tests_left, visitor)?.is_break() {
                        walk.stopped = true;
                        walk.nodes_visited = a.evaluations + b.evaluations;
                        return Ok(walk);
                    }
                }
            }
            // Two leaf lanes are tested where they are found, never pushed.
            _ => {
                if leaves(&a, entry.a, &b, entry.b, &mut tests_left, visitor)?.is_break() {
                    walk.stopped = true;
                    break;
                }
            }
        }
    }
    walk.nodes_visited = a.evaluations + b.evaluations;
    Ok(walk)
}

/// One lane's centre and radius.
fn lane_sphere(spheres: &Spheres, lane: usize) -> [f32; 4] {
    let [x, y, z] = &spheres.centre;
    [x[lane], y[lane], z[lane], spheres.radius[lane]]
}

/// The lanes whose spheres may meet a sphere; NaN meets.
#[inline(always)]
fn meeting(spheres: &Spheres, [x, y, z, r]: [f32; 4]) -> u8 {
    mask_of(|k| {
        let dx = spheres.centre[0][k] - x;
        let dy = spheres.centre[1][k] - y;
        let dz = spheres.centre[2][k] - z;
        let reach = spheres.radius[k] + r;
        let apart = (dx * dx + dy * dy + dz * dz) * SKIP > reach * reach;
        !apart
    })
}

/// All triangle pairs of two leaf lanes, tile by tile, as long as `tests_left` lasts.
fn leaves<V: PairVisitor>(
    a: &Side<'_, '_>,
    leaf_a: Subtree,
    b: &Side<'_, '_>,
    leaf_b: Subtree,
    tests_left: &mut u64,
    visitor: &mut V,
) -> Result<ControlFlow<()>, QueryError> {
    let tests = u64::from(leaf_a.triangles) * u64::from(leaf_b.triangles);
    let Some(left) = tests_left.checked_sub(tests) else {
        return Err(a.asset.endless(*tests_left).into());
    };
    *tests_left = left;
    let mut tile_a = [[[0.0; 3]; 3]; TILE];
    let mut tile_b = [[[0.0; 3]; 3]; TILE];
    for records_a in a.records(leaf_a)?.chunks(TILE) {
        a.deform(records_a, &mut tile_a)?;
        for records_b in b.records(leaf_b)?.chunks(TILE) {
            b.deform(records_b, &mut tile_b)?;
            for (record_a, corners_a) in records_a.iter().zip(&tile_a) {
                for (record_b, corners_b) in records_b.iter().zip(&tile_b) {
                    let (id_a, id_b) = (TriangleId(record_a.id), TriangleId(record_b.id));
                    if visitor
                        .triangles(id_a, corners_a, id_b, corners_b)
                        .is_break()
                    {
                        return Ok(ControlFlow::Break(()));
                    }
                }
            }
        }
    }
    Ok(ControlFlow::Continue(()))
}
