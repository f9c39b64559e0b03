//! Two trees against each other, in the frame of the first.
//!
//! A visit takes one node of each tree and tests eight lanes against eight. Where both lanes are
//! inner, both trees descend; the leaf lanes of one node stay together while the other descends.

use bdtree_format::{LANES, NodeRecord};
use core::ops::ControlFlow;

use super::byte_masks::{BYTES, any_row, columns, gather, lane_pair, lowest, rows};
use super::pair_leaves::run_leaves;
use super::pair_side::Side;
use super::pair_stack::{FrontSlot, LeafQueue, PairStack, QUEUE};
use super::separating_plane::{Found, SeparatingPlane};
use super::sphere_triangles::SphereTriangles;
use super::visitor::{PairVisitor, Walk};
use super::{PairStackEntry, lane_subtree};
use crate::bound::{Spheres, WideSpheres};
use crate::cache::Posed;
use crate::contact::LaneId;
use crate::depth::DepthLimit;
use crate::error::QueryError;
use crate::pair_frame::PairFrame;
use crate::pose::Pose;
use crate::refined::Bounds;
use crate::rounding::SKIP;
use crate::simd::{Lanes, Work};
use crate::view::Asset;

/// Nodes that a traversal keeps for itself where the caller grants fewer.
const NODES: usize = 16;

/// What a pair traversal walks.
pub(crate) struct Two<'s> {
    pub(crate) posed: [Posed<'s>; 2],
    pub(crate) frame: &'s PairFrame,
    /// Only these pairs of leaves are looked at, if there are any given, and no nodes.
    pub(crate) leaves: Option<&'s [FrontSlot]>,
}

impl<'s> Two<'s> {
    fn assets(&self) -> [&'s Asset<'s>; 2] {
        self.posed.each_ref().map(|posed| posed.pose.asset)
    }

    /// Visits all pairs of leaf triangles whose lanes' spheres meet, with the first asset's kernel.
    pub(crate) fn walk(
        self,
        stack: &mut [PairStackEntry],
        visitor: &mut dyn PairVisitor,
    ) -> Result<Walk, QueryError> {
        let [asset_a, asset_b] = self.assets();
        let needed = asset_a.pair_stack_len(asset_b);
        let found = stack.len();
        let Some(stack) = stack.get_mut(..needed) else {
            return Err(QueryError::Memory { needed, found });
        };
        let [mut posed_a, mut posed_b] = self.posed;
        let cuts = |posed: &Posed<'_>, asset: &Asset<'_>| {
            (posed.limit.as_ref()).is_some_and(|limit| limit.cuts(asset))
        };
        let is_limited = cuts(&posed_a, asset_a) || cuts(&posed_b, asset_b);
        if is_limited {
            // Spheres are the answer then.
            (posed_a.refined, posed_b.refined) = (Bounds::Unrefined, Bounds::Unrefined);
        }
        // Where one side is cut off, the other's sink takes the spheres that those meet.
        let limits = [posed_a.limit.take(), posed_b.limit.take()];
        let limits = is_limited.then_some(limits);
        let (mut nodes_a, mut nodes_b) = (None, None);
        let mut posed_a = posed_a.at_least::<NODES>(asset_a, &mut nodes_a);
        let mut posed_b = posed_b.at_least::<NODES>(asset_b, &mut nodes_b);
        let mut before = Found::default();
        // The search for a plane goes down to the triangles, which a limited walk does not.
        if self.leaves.is_none() && !is_limited {
            before = asset_a.kernel.run(SeparatingPlane {
                posed: [&mut posed_a, &mut posed_b],
                frame: self.frame,
                stack,
            })?;
        }
        let mut walk = Walk::default();
        if !before.apart {
            let two = Two {
                posed: [posed_a, posed_b],
                frame: self.frame,
                leaves: self.leaves,
            };
            walk = asset_a.kernel.run(TwoWalk {
                two,
                limits,
                stack,
                visitor,
            })?;
        }
        walk.nodes_visited += before.nodes_visited;
        walk.nodes_updated += before.nodes_updated;
        Ok(walk)
    }
}

/// A walk and who it is for.
struct TwoWalk<'w, 's, 'l> {
    two: Two<'s>,
    /// Those of the two sides, at least one of which ends before its leaves.
    limits: Option<[Option<DepthLimit<'l>>; 2]>,
    stack: &'w mut [PairStackEntry],
    visitor: &'w mut (dyn PairVisitor + 'w),
}

impl Work for TwoWalk<'_, '_, '_> {
    type Output = Result<Walk, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        if let Some(kept) = self.two.leaves {
            return kept_leaves(self.two, kept, self.visitor);
        }
        walk_two::<L>(self)
    }
}

/// Most pairs of triangles that a walk may meet: each once.
fn tests_max(assets: [&Asset<'_>; 2]) -> u64 {
    assets[0].triangle_count() as u64 * assets[1].triangle_count() as u64
}

/// Most pairs of a lane of the first and a triangle of the second that a walk may meet: each once.
fn sphere_tests_max(assets: [&Asset<'_>; 2]) -> u64 {
    (LANES * assets[0].node_count()) as u64 * assets[1].triangle_count() as u64
}

/// Tests the triangles of given pairs of leaves; nodes are not visited.
#[inline(always)]
fn kept_leaves(
    two: Two<'_>,
    kept: &[FrontSlot],
    visitor: &mut dyn PairVisitor,
) -> Result<Walk, QueryError> {
    let mut tests_left = tests_max(two.assets());
    // One by one: each is large, and moving it out of an array or a pair is a copy.
    let [posed_a, posed_b] = two.posed;
    let mut a = Side::new(posed_a);
    let mut b = Side::new(posed_b);
    let mut walk = Walk::default();
    for pairs in kept.chunks(QUEUE) {
        for pair in pairs {
            a.announce_leaf(pair.a)?;
            b.announce_leaf(pair.b)?;
        }
        walk.stopped = run_leaves(&mut a, &mut b, pairs, &mut tests_left, visitor)?.is_break();
        if walk.stopped {
            break;
        }
    }
    Ok(walk)
}

#[inline(always)]
fn walk_two<L: Lanes>(work: TwoWalk<'_, '_, '_>) -> Result<Walk, QueryError> {
    let TwoWalk {
        two,
        mut limits,
        stack,
        visitor,
    } = work;
    let [asset_a, asset_b] = two.assets();
    let frame = two.frame;
    // In a sound pair of trees two nodes meet at most once with all lanes, and never again with
    // the ending lanes of one if they did.
    let nodes = |asset: &Asset<'_>| asset.node_count() as u64;
    let visits_max = nodes(asset_a)
        .saturating_mul(nodes(asset_b))
        .saturating_mul(3);
    let mut visits = 0;
    let mut nodes_visited = 0;
    // Spheres of the first against the second's own triangles.
    let to_triangles = matches!(&limits, Some([Some(limit), None]) if limit.leaves_too);
    let mut tests_left = if to_triangles {
        sphere_tests_max([asset_a, asset_b])
    } else {
        tests_max([asset_a, asset_b])
    };
    // One by one: each is large, and moving it out of an array or a pair is a copy.
    let [posed_a, posed_b] = two.posed;
    let mut a = Side::new(posed_a);
    let mut b = Side::new(posed_b);
    let mut queue = LeafQueue::EMPTY;
    let first = PairStackEntry {
        a: 0,
        b: 0,
        sphere: EVERYWHERE,
        lanes_a: u8::MAX,
        lanes_b: u8::MAX,
        unused: [0; 2],
    };
    let mut stack = PairStack::new(stack, asset_a, first)?;
    loop {
        if stack.is_empty() || !queue.has_room() {
            let pairs = queue.take();
            visitor.meet(pairs);
            let stopped = run_leaves(&mut a, &mut b, pairs, &mut tests_left, visitor)?.is_break();
            if stopped || stack.is_empty() {
                return Ok(Walk {
                    nodes_visited,
                    nodes_updated: a.updated + b.updated,
                    stopped,
                    ..Walk::default()
                });
            }
        }
        let entry = stack.pop();
        visits += 1;
        if visits > visits_max {
            return Err(asset_a.endless(visits_max).into());
        }
        nodes_visited += 1;
        let mut spheres_a = WideSpheres::<L>::empty();
        let node_a = a.node(entry.a, &mut spheres_a)?;
        let [x, y, z, radius] = entry.sphere;
        let lanes_a = entry.lanes_a & spheres_a.within([x, y, z], radius, SKIP);
        if lanes_a & (node_a.inner_mask | node_a.leaf_mask) == 0 {
            continue;
        }
        nodes_visited += 1;
        let mut own_b = WideSpheres::<L>::empty();
        let node_b = b.node(entry.b, &mut own_b)?;
        if node_a.leaf_mask & lanes_a != 0 && node_b.leaf_mask & entry.lanes_b != 0 {
            asset_a.prefetch_triangles(node_a);
            asset_b.prefetch_triangles(node_b);
        }
        let stored_a = spheres_a.store();
        let carried_b = frame.carry(own_b);
        let ends = match &limits {
            Some([a, b]) => [ends(a, node_a), ends(b, node_b)],
            None => [false; 2],
        };
        let (lanes_a, lanes_b) = (
            Split::new(node_a, lanes_a, ends[0]),
            Split::new(node_b, entry.lanes_b, ends[1]),
        );
        let visit = Visit {
            entry,
            nodes: [node_a, node_b],
            meets: meetings(&stored_a, lanes_a.all(), carried_b),
            ending: [lanes_a.ending, lanes_b.ending],
            inner: [lanes_a.inner, lanes_b.inner],
        };
        visit.descend_first(&mut stack)?;
        visit.descend_second(&mut stack)?;
        let both = visit.meets & rows(visit.inner[0]) & columns(visit.inner[1]);
        a.prefetch_children(node_a, gather(lowest(both)));
        b.prefetch_children(node_b, any_row(both));
        // What a limited walk reports is what lanes have met, whatever lies above them.
        let below = limits.is_none().then(|| carried_b.store());
        visit.descend_both(both, below.as_ref(), &mut stack)?;

        let mut ended = visit.meets & rows(visit.ending[0]) & columns(visit.ending[1]);
        if let Some(limits) = &mut limits {
            let mut leaves = ended & rows(node_a.leaf_mask) & columns(node_b.leaf_mask);
            if let [Some(limit), _] = limits
                && limit.leaves_too
            {
                leaves = 0;
                // Needs no margin beside `SKIP`: docs/design/guarantees.md, spheres of a level.
                let nearer = carried_b.grown(L::splat(-limit.nearer));
                ended &= meetings(&stored_a, lanes_a.ending, nearer);
            }
            let flow = if to_triangles {
                let work = SphereTriangles {
                    leaves: b.announce(node_b, any_row(ended))?,
                    a: &a,
                    b: &mut b,
                    node: entry.a,
                    spheres: &stored_a,
                    found: ended,
                    tests_left: &mut tests_left,
                    visitor,
                };
                asset_a.kernel.run(work)?
            } else {
                let poses = [a.posed.pose, b.posed.pose];
                let spheres = [&stored_a, &own_b.store()];
                let nodes = [entry.a, entry.b];
                report(ended & !leaves, poses, nodes, spheres, limits)
            };
            if flow.is_break() {
                return Ok(Walk {
                    nodes_visited,
                    nodes_updated: a.updated + b.updated,
                    stopped: true,
                    ..Walk::default()
                });
            }
            ended = leaves;
        }
        if ended != 0 {
            let leaves_a = a.announce(node_a, gather(lowest(ended)))?;
            let leaves_b = b.announce(node_b, any_row(ended))?;
            queue.add(ended, &leaves_a, &leaves_b);
        }
    }
}

/// A node's lanes that are looked at.
struct Split {
    /// Those below which there is no node to visit: leaves, and all where the walk ends.
    ending: u8,
    inner: u8,
}

impl Split {
    #[inline(always)]
    fn new(node: &NodeRecord, lanes: u8, ends: bool) -> Self {
        let leaves = node.leaf_mask & lanes;
        let inner = node.inner_mask & !node.leaf_mask & lanes;
        if ends {
            return Self {
                ending: leaves | inner,
                inner: 0,
            };
        }
        Self {
            ending: leaves,
            inner,
        }
    }

    #[inline(always)]
    fn all(&self) -> u8 {
        self.ending | self.inner
    }
}

/// Which lanes of a first node, of those in `lanes`, meet which of a second one in the frame of the first: byte i,
/// bit j for lane i of the first and lane j of the second.
#[inline(always)]
fn meetings<L: Lanes>(a: &Spheres, lanes: u8, b: WideSpheres<L>) -> u64 {
    let mut meets = 0_u64;
    let mut left = lanes;
    while left != 0 {
        let lane = left.trailing_zeros() as usize & (LANES - 1);
        left &= left - 1;
        let [x, y, z, radius] = lane_sphere(a, lane);
        let mask = b.within([x, y, z], radius, SKIP);
        meets |= u64::from(mask) << (8 * lane);
    }
    meets
}

/// Two nodes that were compared, first and second.
struct Visit<'a> {
    entry: PairStackEntry,
    nodes: [&'a NodeRecord; 2],
    /// As [`meetings`] returns it.
    meets: u64,
    ending: [u8; 2],
    inner: [u8; 2],
}

impl Visit<'_> {
    /// Inner lanes of the first against all ending lanes of the second together.
    #[inline(always)]
    fn descend_first(&self, stack: &mut PairStack<'_, '_>) -> Result<(), QueryError> {
        let mut found = lowest(self.meets & rows(self.inner[0]) & columns(self.ending[1]));
        while found != 0 {
            let lane = (found.trailing_zeros() as usize / 8) & (LANES - 1);
            found &= found - 1;
            stack.push(PairStackEntry {
                a: lane_subtree(self.nodes[0], lane).start,
                b: self.entry.b,
                sphere: EVERYWHERE,
                lanes_a: u8::MAX,
                lanes_b: (self.meets >> (8 * lane)) as u8 & self.ending[1],
                unused: [0; 2],
            })?;
        }
        Ok(())
    }

    /// All ending lanes of the first together against inner lanes of the second.
    #[inline(always)]
    fn descend_second(&self, stack: &mut PairStack<'_, '_>) -> Result<(), QueryError> {
        let mut found = self.meets & rows(self.ending[0]) & columns(self.inner[1]);
        while found != 0 {
            let lane = found.trailing_zeros() as usize & (LANES - 1);
            let column = BYTES << lane;
            let lanes_a = gather((found & column) >> lane);
            found &= !column;
            stack.push(PairStackEntry {
                a: self.entry.a,
                b: lane_subtree(self.nodes[1], lane).start,
                sphere: EVERYWHERE, // these lanes have been found to meet it
                lanes_a,
                lanes_b: u8::MAX,
                unused: [0; 2],
            })?;
        }
        Ok(())
    }

    /// The pairs `found` of inner lanes; `b` are the second's spheres in the frame of the first, if what lies below
    /// a lane of the first is to meet them.
    #[inline(always)]
    fn descend_both(
        &self,
        mut found: u64,
        b: Option<&Spheres>,
        stack: &mut PairStack<'_, '_>,
    ) -> Result<(), QueryError> {
        while found != 0 {
            let (lane_a, lane_b) = lane_pair(found);
            found &= found - 1;
            stack.push(PairStackEntry {
                a: lane_subtree(self.nodes[0], lane_a).start,
                b: lane_subtree(self.nodes[1], lane_b).start,
                sphere: match b {
                    Some(b) => lane_sphere(b, lane_b),
                    None => EVERYWHERE,
                },
                lanes_a: u8::MAX,
                lanes_b: u8::MAX,
                unused: [0; 2],
            })?;
        }
        Ok(())
    }
}

/// Whether nothing below a node's lanes is visited.
#[inline(always)]
fn ends(limit: &Option<DepthLimit<'_>>, node: &NodeRecord) -> bool {
    limit.as_ref().is_some_and(|limit| limit.ends(node))
}

/// Reports the spheres of pairs of lanes: both, so that those of the two sides correspond.
fn report(
    mut pairs: u64,
    poses: [&Pose<'_>; 2],
    nodes: [u32; 2],
    spheres: [&Spheres; 2],
    limits: &mut [Option<DepthLimit<'_>>; 2],
) -> ControlFlow<()> {
    while pairs != 0 {
        let (lane_a, lane_b) = lane_pair(pairs);
        pairs &= pairs - 1;
        for (side, lane) in [lane_a, lane_b].into_iter().enumerate() {
            if let Some(limit) = &mut limits[side] {
                let lane = LaneId {
                    node: nodes[side],
                    lane: lane as u8,
                };
                limit.report(poses[side], spheres[side], lane)?;
            }
        }
    }
    ControlFlow::Continue(())
}

/// A sphere that everything meets.
const EVERYWHERE: [f32; 4] = [0.0, 0.0, 0.0, f32::INFINITY];

/// One lane's center and radius.
#[inline(always)]
fn lane_sphere(spheres: &Spheres, lane: usize) -> [f32; 4] {
    let [x, y, z] = &spheres.center;
    [x[lane], y[lane], z[lane], spheres.radius[lane]]
}
