//! Walking no deeper than a level: what lies below is answered with the spheres of that level.
//!
//! The paper's contact proxies (3.4). Node bounds and tests of them decide here what is reported, so tests are the
//! reference kernel's: multiply and add are rounded separately, the same bits on every processor, as bounds have
//! with every kernel.

use bdtree_format::{LANES, NodeRecord, Row, TriangleRecord};
use core::ops::ControlFlow;

use super::leaves::Leaves;
use super::two::EVERYWHERE;
use super::{PairStackEntry, PairVisitor, StackEntry, Visitor, Walk, lane_subtree, used_lanes};
use crate::bound::{Spheres, WideSpheres};
use crate::cache::Posed;
use crate::contact::{Proxy, TriangleId};
use crate::error::QueryError;
use crate::frame::PairFrame;
use crate::math::norm;
use crate::narrow::Triangle;
use crate::pose::Pose;
use crate::proxy::DepthLimit;
use crate::query::{MARGIN, SKIP};
use crate::simd::{Lanes, Reference, Work};
use crate::view::Asset;

/// [`super::one`] down to a level.
pub(super) fn one<'s, V: Visitor>(
    asset: &Asset<'_>,
    posed: Posed<'s>,
    limit: DepthLimit<'s>,
    stack: &mut [StackEntry],
    visitor: &mut V,
) -> Result<Walk, QueryError> {
    asset.kernel.run(OneWalk {
        asset,
        posed,
        limit,
        stack,
        visitor,
    })
}

struct OneWalk<'w, 's, 'a, V> {
    asset: &'w Asset<'a>,
    posed: Posed<'s>,
    limit: DepthLimit<'s>,
    stack: &'w mut [StackEntry],
    visitor: &'w mut V,
}

impl<V: Visitor> Work for OneWalk<'_, '_, '_, V> {
    type Output = Result<Walk, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        walk_one::<L, V>(self)
    }
}

#[inline(always)]
fn walk_one<L: Lanes, V: Visitor>(work: OneWalk<'_, '_, '_, V>) -> Result<Walk, QueryError> {
    let OneWalk {
        asset,
        mut posed,
        limit,
        stack,
        visitor,
    } = work;
    let pose = posed.pose;
    let (needed, found) = (asset.stack_len(), stack.len());
    let Some(stack) = stack.get_mut(..needed) else {
        return Err(QueryError::Memory { needed, found });
    };
    let mut walk = Walk {
        nodes_visited: 0,
        nodes_updated: 0,
        stopped: true,
    };
    let mut keys: Row = [0.0; LANES];
    let mut leaves = Leaves::new(asset);
    stack[0] = StackEntry {
        key: f32::NEG_INFINITY,
        ..StackEntry::default()
    };
    let mut len = 1;
    while len > 0 {
        len -= 1;
        let entry = stack[len];
        if V::ORDERED && !visitor.wanted(entry.key) {
            continue;
        }
        walk.nodes_visited += 1;
        if walk.nodes_visited > asset.node_count() as u64 {
            return Err(asset.endless(asset.node_count() as u64).into());
        }
        let node = asset.node(entry.at.start)?;
        let (spheres, evaluated) = posed.portable_spheres::<L>(asset, entry.at.start)?;
        walk.nodes_updated += u64::from(evaluated);
        let mask = visitor.lanes(WideSpheres::<Reference>::load(&spheres), &mut keys);
        let (order, count) = order(mask & used_lanes(node), &keys, V::ORDERED);
        // What ends here first, so that it is known before the nodes below are visited.
        for &lane in &order[..count] {
            if V::ORDERED && !visitor.wanted(keys[lane]) {
                continue;
            }
            if node.leaf_mask & (1 << lane) != 0 {
                let leaf = lane_subtree(node, lane);
                if leaves
                    .take::<L, V>(asset, &mut posed, leaf, visitor)?
                    .is_break()
                {
                    return Ok(walk);
                }
            } else if ends(node, limit.level)
                && limit.sink.push(proxy(pose, &spheres, lane)).is_break()
            {
                return Ok(walk);
            }
        }
        if ends(node, limit.level) {
            continue;
        }
        // Farthest first, so that the nearest is popped next.
        for &lane in order[..count].iter().rev() {
            if node.leaf_mask & (1 << lane) == 0 {
                let Some(slot) = stack.get_mut(len) else {
                    return Err(asset.too_deep().into());
                };
                *slot = StackEntry {
                    at: lane_subtree(node, lane),
                    key: keys[lane],
                };
                len += 1;
            }
        }
    }
    walk.stopped = leaves.finish::<L, V>(asset, pose, visitor)?.is_break();
    Ok(walk)
}

/// Whether nothing below this node's lanes is visited.
fn ends(node: &NodeRecord, level: usize) -> bool {
    usize::from(node.level) >= level
}

/// The sphere of a lane in the world, which holds all that the leaf arithmetic puts below it.
pub(crate) fn proxy(pose: &Pose<'_>, spheres: &Spheres, lane: usize) -> Proxy {
    let center = [0, 1, 2].map(|axis| spheres.centre[axis][lane]);
    let center = pose.frame.world(center);
    let radius = f64::from(spheres.radius[lane]) + pose.frame.error(norm(center), 2.0 * pose.reach);
    Proxy {
        center,
        radius: radius * pose.frame.world_per_stored() * (1.0 + MARGIN),
    }
}

/// One side of a pair.
struct Side<'r, 's, 'a> {
    asset: &'r Asset<'a>,
    posed: Posed<'s>,
    limit: Option<DepthLimit<'s>>,
    /// The node asked for last, and its spheres in its own frame.
    last: Option<(u32, Spheres)>,
}

impl<'r, 's, 'a> Side<'r, 's, 'a> {
    fn new((asset, mut posed): (&'r Asset<'a>, Posed<'s>)) -> Self {
        let limit = posed.take_limit();
        Self {
            asset,
            posed,
            limit,
            last: None,
        }
    }

    /// A node, its spheres, and those of its lanes `lanes` that lead somewhere.
    #[inline(always)]
    fn visit<L: Lanes>(
        &mut self,
        index: u32,
        lanes: u8,
        walk: &mut Walk,
    ) -> Result<(&'a NodeRecord, Spheres, u8), QueryError> {
        let node = self.asset.node(index)?;
        let spheres = match self.last {
            Some((last, spheres)) if last == index => spheres,
            _ => {
                let (spheres, evaluated) = self.posed.portable_spheres::<L>(self.asset, index)?;
                walk.nodes_visited += 1;
                walk.nodes_updated += u64::from(evaluated);
                self.last = Some((index, spheres));
                spheres
            }
        };
        Ok((node, spheres, used_lanes(node) & lanes))
    }

    /// Whether a lane is not looked into: it holds triangles or lies at the last level.
    fn is_end(&self, node: &NodeRecord, lane: usize) -> bool {
        node.leaf_mask & (1 << lane) != 0
            || self.limit.as_ref().is_some_and(|l| ends(node, l.level))
    }

    /// Node and lanes where to go on from a lane of node `at`: itself, where nothing below it is looked at.
    fn below(&self, at: u32, node: &NodeRecord, lane: usize) -> (u32, u8) {
        if self.is_end(node, lane) {
            (at, 1 << lane)
        } else {
            (lane_subtree(node, lane).start, u8::MAX)
        }
    }

    fn report(&mut self, spheres: &Spheres, lane: usize) -> ControlFlow<()> {
        match &mut self.limit {
            Some(limit) => limit.sink.push(proxy(self.posed.pose, spheres, lane)),
            None => ControlFlow::Continue(()),
        }
    }
}

/// The walk of two trees with one side or both bounded. A stack entry has all lanes of a node, or one lane
/// at which its side ends.
pub(super) fn two<'r, 's>(
    a: (&'r Asset<'_>, Posed<'s>),
    b: (&'r Asset<'_>, Posed<'s>),
    frame: &PairFrame,
    stack: &mut [PairStackEntry],
    visitor: &mut dyn PairVisitor,
) -> Result<Walk, QueryError> {
    a.0.kernel.run(TwoWalk {
        sides: (Side::new(a), Side::new(b)),
        frame,
        stack,
        visitor,
    })
}

struct TwoWalk<'w, 'r, 's, 'a, 'b> {
    sides: (Side<'r, 's, 'a>, Side<'r, 's, 'b>),
    frame: &'w PairFrame,
    stack: &'w mut [PairStackEntry],
    visitor: &'w mut dyn PairVisitor,
}

impl Work for TwoWalk<'_, '_, '_, '_, '_> {
    type Output = Result<Walk, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        walk_two::<L>(self)
    }
}

#[inline(always)]
fn walk_two<L: Lanes>(work: TwoWalk<'_, '_, '_, '_, '_>) -> Result<Walk, QueryError> {
    let TwoWalk {
        sides: (mut a, mut b),
        frame,
        stack,
        visitor,
    } = work;
    let (needed, found) = (a.asset.pair_stack_len(b.asset), stack.len());
    let Some(stack) = stack.get_mut(..needed) else {
        return Err(QueryError::Memory { needed, found });
    };
    // As in the walk to the leaves: what a sound pair of trees can take.
    let subtrees = |asset: &Asset<'_>| (1 + LANES as u64) * asset.node_count() as u64;
    let visits_max = subtrees(a.asset).saturating_mul(subtrees(b.asset));
    let mut tests_left = a.asset.triangle_count() as u64 * b.asset.triangle_count() as u64;
    let mut visits = 0;
    let mut walk = Walk {
        nodes_visited: 0,
        nodes_updated: 0,
        stopped: true,
    };
    stack[0] = PairStackEntry {
        a: 0,
        b: 0,
        sphere: EVERYWHERE,
        lanes_a: u8::MAX,
        lanes_b: u8::MAX,
        unused: [0; 2],
    };
    let mut len = 1;
    while len > 0 {
        len -= 1;
        let entry = stack[len];
        visits += 1;
        if visits > visits_max {
            return Err(a.asset.endless(visits_max).into());
        }
        let (node_a, spheres_a, mask_a) = a.visit::<L>(entry.a, entry.lanes_a, &mut walk)?;
        let (node_b, spheres_b, mask_b) = b.visit::<L>(entry.b, entry.lanes_b, &mut walk)?;
        let carried = frame
            .carry(WideSpheres::<Reference>::load(&spheres_b))
            .store();
        for lane_a in bits(mask_a) {
            for lane_b in bits(mask_b) {
                if apart(&spheres_a, lane_a, &carried, lane_b) {
                    continue;
                }
                if !a.is_end(node_a, lane_a) || !b.is_end(node_b, lane_b) {
                    let Some(slot) = stack.get_mut(len) else {
                        return Err(a.asset.too_deep().into());
                    };
                    let (next_a, lanes_a) = a.below(entry.a, node_a, lane_a);
                    let (next_b, lanes_b) = b.below(entry.b, node_b, lane_b);
                    *slot = PairStackEntry {
                        a: next_a,
                        b: next_b,
                        sphere: EVERYWHERE,
                        lanes_a,
                        lanes_b,
                        unused: [0; 2],
                    };
                    len += 1;
                    continue;
                }
                let are_leaves =
                    node_a.leaf_mask & (1 << lane_a) != 0 && node_b.leaf_mask & (1 << lane_b) != 0;
                let done = if are_leaves {
                    let leaf_a = a.asset.leaf(lane_subtree(node_a, lane_a))?;
                    let leaf_b = b.asset.leaf(lane_subtree(node_b, lane_b))?;
                    let tests = leaf_a.len() as u64 * leaf_b.len() as u64;
                    let Some(left) = tests_left.checked_sub(tests) else {
                        return Err(a.asset.endless(tests_left).into());
                    };
                    tests_left = left;
                    triangles(&a, leaf_a, &b, leaf_b, visitor)?
                } else {
                    match a.report(&spheres_a, lane_a) {
                        ControlFlow::Continue(()) => b.report(&spheres_b, lane_b),
                        full => full,
                    }
                };
                if done.is_break() {
                    return Ok(walk);
                }
            }
        }
    }
    walk.stopped = false;
    Ok(walk)
}

/// Whether two lanes' spheres in one frame certainly do not meet.
fn apart(a: &Spheres, lane_a: usize, b: &Spheres, lane_b: usize) -> bool {
    let mut square = 0.0;
    for axis in 0..3 {
        let d = a.centre[axis][lane_a] - b.centre[axis][lane_b];
        square += d * d;
    }
    let reach = a.radius[lane_a] + b.radius[lane_b];
    square * SKIP > reach * reach
}

/// Triangles of the second lane that are deformed together: most leaves have no more.
const TOGETHER: usize = 16;

/// Tests all pairs of triangles of two leaf lanes.
fn triangles(
    a: &Side<'_, '_, '_>,
    records_a: &[TriangleRecord],
    b: &Side<'_, '_, '_>,
    records_b: &[TriangleRecord],
    visitor: &mut dyn PairVisitor,
) -> Result<ControlFlow<()>, QueryError> {
    for records_b in records_b.chunks(TOGETHER) {
        let mut corners_b: [Triangle; TOGETHER] = Default::default();
        for (corners, record) in corners_b.iter_mut().zip(records_b) {
            *corners = b.asset.deformed_triangle(b.posed.pose, record)?;
        }
        for record_a in records_a {
            let corners_a = a.asset.deformed_triangle(a.posed.pose, record_a)?;
            for (record_b, corners_b) in records_b.iter().zip(&corners_b) {
                let (id_a, id_b) = (TriangleId(record_a.id), TriangleId(record_b.id));
                let done = visitor.triangles(id_a, &corners_a, id_b, corners_b);
                if done.is_break() {
                    return Ok(done);
                }
            }
        }
    }
    Ok(ControlFlow::Continue(()))
}

/// The set lanes, ascending.
fn bits(mut mask: u8) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        (mask != 0).then(|| {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            lane
        })
    })
}

/// The set lanes, by key (stable) if `ordered`, else ascending; and how many there are.
fn order(mask: u8, keys: &Row, ordered: bool) -> ([usize; LANES], usize) {
    let mut lanes = [0; LANES];
    let mut count = 0;
    for lane in bits(mask) {
        let mut at = count;
        if ordered {
            while at > 0 && keys[lanes[at - 1]] > keys[lane] {
                lanes[at] = lanes[at - 1];
                at -= 1;
            }
        }
        lanes[at] = lane;
        count += 1;
    }
    (lanes, count)
}
