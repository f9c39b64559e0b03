//! Leaf lanes that touch exchange triangles until their balls are small.
//!
//! Cuts by planes leave patches with corners, and the ball around one is larger than around a rounder
//! patch of the same area. Starting from them, neighbouring leaves give each other triangles wherever
//! that lowers the expected visits of the two (docs/decisions/leaf-exchange.md). The nodes above stay
//! as they are and their balls hold what enters them; some leaves become empty.

mod balls;

use bdtree_format::LANES;

use self::balls::{Ball, Mesh};
use super::{Lane, LaneKind, Tree};
use crate::wrap::ball::{norm2, sub};

/// Nearest leaves that one deals with.
const NEIGHBOURS: usize = 8;

/// Nodes looked at to find them: enough unless the ball is that of a triangle with hundreds of smaller leaves in it,
/// or thousands of triangles lie in one place. Then some that are nearer may be missed.
const LOOKED_AT_MAX: usize = 256;

/// Larger leaves stay as they are cut: finding a trade takes the square of their size.
const LEAF_SIZE_MAX: usize = 16;

/// How often all leaves are gone through; a third time hardly changes anything.
const PASSES: usize = 2;

/// An exchange must lower the cost by this share: none for nothing.
const GAIN_MIN: f64 = 1e-6;

/// Share of its squared radius by which a point on a ball's surface may seem to lie inside.
const TOUCHING: f64 = 1e-6;

/// Lanes that a node keeps: leaves are emptied only in nodes that have more.
const LANES_MIN: u8 = 2;

/// The tree with rounder leaves of at most `leaf_size` triangles; `query` is the diameter of a
/// typical query. Deterministic, O(F log F + F `leaf_size`²).
pub(super) fn exchange(
    tree: &Tree,
    positions: &[[f32; 3]],
    corners: &[[u32; 3]],
    leaf_size: usize,
    query: f64,
) -> Tree {
    if leaf_size > LEAF_SIZE_MAX {
        return tree.clone();
    }
    let mut exchange = Exchange {
        mesh: Mesh {
            positions,
            corners,
            points: Vec::new(),
        },
        tree,
        leaf_size,
        query,
        balls: Vec::with_capacity(corners.len()),
        leaves: Vec::new(),
        nodes: Vec::with_capacity(tree.nodes.len()),
    };
    exchange.measure();
    for pass in 1..=PASSES {
        for leaf in 0..exchange.leaves.len() {
            exchange.deal(leaf, pass);
        }
    }
    with_leaves(tree, exchange.leaves.iter().map(|leaf| &leaf.triangles[..]))
}

/// Some triangles of a leaf: their ball, if there are any, and what it costs.
#[derive(Debug, Clone, Copy)]
struct Rest {
    ball: Option<Ball>,
    cost: f64,
}

/// A leaf lane.
#[derive(Debug)]
struct Leaf {
    triangles: Vec<u32>,
    ball: Ball,
    /// What is left without one of the triangles, in their order, and last without none; empty until
    /// asked for.
    rests: Vec<Rest>,
    /// The pass in which it changed last, counted from 1; 0 for none.
    changed: usize,
    /// Index of its node.
    node: usize,
}

/// A node as leaves see it.
#[derive(Debug)]
struct Node {
    /// Around all triangles below it at first; none from outside enters.
    ball: Ball,
    first_leaf: usize,
    /// Lanes that are not empty.
    lanes: u8,
    /// The node above; the root's is itself.
    above: usize,
}

/// What becomes of a leaf.
struct After {
    triangles: Vec<u32>,
    ball: Ball,
    cost: f64,
}

struct Exchange<'t> {
    mesh: Mesh<'t>,
    tree: &'t Tree,
    leaf_size: usize,
    query: f64,
    /// Of each triangle.
    balls: Vec<Ball>,
    leaves: Vec<Leaf>,
    nodes: Vec<Node>,
}

impl Exchange<'_> {
    /// Finds the balls of all triangles, leaves and nodes.
    fn measure(&mut self) {
        for triangle in 0..self.mesh.corners.len() as u32 {
            self.balls.push(self.mesh.ball(&[triangle]));
        }
        let mut below = Vec::new();
        for (node, record) in self.tree.nodes.iter().enumerate() {
            below.clear();
            let first_leaf = self.leaves.len();
            let mut lanes = 0;
            for lane in record.lanes {
                let triangles = self.tree.triangles_below(lane);
                below.extend_from_slice(triangles);
                lanes += u8::from(lane.kind != LaneKind::Empty);
                if lane.kind == LaneKind::Leaf {
                    self.leaves.push(Leaf {
                        triangles: triangles.to_vec(),
                        ball: self.mesh.ball(triangles),
                        rests: Vec::new(),
                        changed: 0,
                        node,
                    });
                }
            }
            self.nodes.push(Node {
                ball: self.mesh.ball(&below),
                first_leaf,
                lanes,
                above: 0,
            });
        }
        for (node, record) in self.tree.nodes.iter().enumerate() {
            let inner = record
                .lanes
                .iter()
                .filter(|lane| lane.kind == LaneKind::Inner);
            for child in (record.first_child as usize..).take(inner.count()) {
                self.nodes[child].above = node;
            }
        }
    }

    /// Expected visits of a leaf, up to a factor: as [`super::split::Splitter::visits`].
    fn cost(&self, square: f64) -> f64 {
        let reach = 2.0 * square.sqrt() + self.query;
        reach * reach
    }

    /// Lets a leaf trade with its neighbours.
    fn deal(&mut self, own: usize, pass: usize) {
        if self.leaves[own].triangles.is_empty() {
            return;
        }
        for other in self.near(own) {
            let [a, b] = [&self.leaves[own], &self.leaves[other]];
            let nothing_new = a.changed.max(b.changed) + 1 < pass;
            if own == other || nothing_new || a.triangles.is_empty() || b.triangles.is_empty() {
                continue;
            }
            let Some(trade) = self.best_trade(own, other) else {
                continue;
            };
            for (leaf, after) in [own, other].into_iter().zip(trade) {
                let leaf = &mut self.leaves[leaf];
                self.nodes[leaf.node].lanes -= u8::from(after.triangles.is_empty());
                leaf.triangles = after.triangles;
                leaf.ball = after.ball;
                leaf.rests.clear();
                leaf.changed = pass;
            }
        }
    }

    /// The leaves nearest to one, itself included, among those whose balls meet its.
    fn near(&self, leaf: usize) -> Vec<usize> {
        let ball = &self.leaves[leaf].ball;
        let mut found: Vec<(f64, usize)> = Vec::new();
        let mut stack = vec![0];
        let mut looked_at = 0;
        while let Some(node) = stack.pop() {
            let record = &self.tree.nodes[node];
            let mut child = record.first_child as usize;
            let mut leaf = self.nodes[node].first_leaf;
            for lane in record.lanes {
                match lane.kind {
                    LaneKind::Empty => {}
                    LaneKind::Inner => {
                        if ball.meets(&self.nodes[child].ball) {
                            stack.push(child);
                        }
                        child += 1;
                    }
                    LaneKind::Leaf => {
                        let other = &self.leaves[leaf];
                        if !other.triangles.is_empty() && ball.meets(&other.ball) {
                            let apart = norm2(sub(ball.centre, other.ball.centre));
                            found.push((apart, leaf));
                        }
                        leaf += 1;
                    }
                }
            }
            looked_at += 1;
            if looked_at == LOOKED_AT_MAX {
                break;
            }
        }
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let nearest = found.into_iter().take(1 + NEIGHBOURS);
        nearest.map(|(_, leaf)| leaf).collect()
    }

    /// The best of: one triangle from a to b, one from b to a, one for one; none if nothing gains.
    fn best_trade(&mut self, a: usize, b: usize) -> Option<[After; 2]> {
        self.find_rests(a);
        self.find_rests(b);
        let [none_a, none_b] = [a, b].map(|leaf| self.leaves[leaf].triangles.len());
        let before = self.leaves[a].rests[none_a].cost + self.leaves[b].rests[none_b].cost;
        let mut best = before * (1.0 - GAIN_MIN);
        let mut found = None;
        for i in 0..=none_a {
            for j in 0..=none_b {
                // A triangle that enters makes no ball smaller.
                let without = self.leaves[a].rests[i].cost + self.leaves[b].rests[j].cost;
                if without >= best || !self.may_change(a, i, b, j) || !self.may_change(b, j, a, i) {
                    continue;
                }
                if self.least_cost(a, i, b, j) + self.least_cost(b, j, a, i) >= best {
                    continue;
                }
                let after = [self.after(a, i, b, j), self.after(b, j, a, i)];
                let cost = after[0].cost + after[1].cost;
                if cost < best {
                    best = cost;
                    found = Some(after);
                }
            }
        }
        found
    }

    /// Whether a leaf may lose its triangle `out` and get `entering` of another; either number is that of
    /// the triangles where there is none.
    fn may_change(&self, leaf: usize, out: usize, other: usize, entering: usize) -> bool {
        let [own, other] = [&self.leaves[leaf], &self.leaves[other]];
        let loses = out < own.triangles.len();
        match other.triangles.get(entering) {
            Some(&triangle) => {
                let room = loses || own.triangles.len() < self.leaf_size;
                room && (own.node == other.node || self.hold(own.node, triangle))
            }
            None => !loses || own.triangles.len() > 1 || self.nodes[own.node].lanes > LANES_MIN,
        }
    }

    /// Whether a node and those above it hold a triangle in their balls.
    fn hold(&self, mut node: usize, triangle: u32) -> bool {
        let corners = self.mesh.corners(triangle);
        loop {
            let Node { ball, above, .. } = &self.nodes[node];
            if !corners.into_iter().all(|p| ball.holds(p)) {
                return false;
            }
            if node == 0 {
                return true;
            }
            node = *above;
        }
    }

    /// A lower bound of the cost of a leaf that changes so.
    fn least_cost(&self, leaf: usize, out: usize, other: usize, entering: usize) -> f64 {
        let rest = &self.leaves[leaf].rests[out];
        let new = self.leaves[other].triangles.get(entering);
        match (
            &rest.ball,
            new.map(|triangle| &self.balls[*triangle as usize]),
        ) {
            (Some(rest), Some(new)) => self.cost(rest.least_of_both(new)),
            (None, Some(new)) => self.cost(new.square),
            (_, None) => rest.cost,
        }
    }

    /// A leaf that changes so.
    fn after(&mut self, leaf: usize, out: usize, other: usize, entering: usize) -> After {
        let mut triangles = self.leaves[leaf].triangles.clone();
        if out < triangles.len() {
            triangles.remove(out);
        }
        triangles.extend(self.leaves[other].triangles.get(entering));
        let ball = self.mesh.ball(&triangles);
        let cost = if triangles.is_empty() {
            0.0
        } else {
            self.cost(ball.square)
        };
        After {
            triangles,
            ball,
            cost,
        }
    }

    fn find_rests(&mut self, leaf: usize) {
        if !self.leaves[leaf].rests.is_empty() {
            return;
        }
        let triangles = std::mem::take(&mut self.leaves[leaf].triangles);
        let ball = self.leaves[leaf].ball;
        let whole = Rest {
            ball: Some(ball),
            cost: self.cost(ball.square),
        };
        let mut rests = Vec::with_capacity(triangles.len() + 1);
        let inner = Ball {
            square: ball.square * (1.0 - TOUCHING),
            ..ball
        };
        for (out, &triangle) in triangles.iter().enumerate() {
            // The ball does not rest on a triangle that it holds inside.
            if self
                .mesh
                .corners(triangle)
                .into_iter()
                .all(|p| inner.holds(p))
            {
                rests.push(whole);
                continue;
            }
            let mut rest = triangles.clone();
            rest.remove(out);
            rests.push(if rest.is_empty() {
                Rest {
                    ball: None,
                    cost: 0.0,
                }
            } else {
                let ball = self.mesh.ball(&rest);
                Rest {
                    ball: Some(ball),
                    cost: self.cost(ball.square),
                }
            });
        }
        rests.push(whole);
        self.leaves[leaf].triangles = triangles;
        self.leaves[leaf].rests = rests;
    }
}

/// The same nodes over other leaves, given in the order of nodes and lanes; empty lanes go.
fn with_leaves<'l>(tree: &Tree, leaves: impl Iterator<Item = &'l [u32]>) -> Tree {
    let lanes = tree.nodes.iter().flat_map(|node| node.lanes);
    let starts = lanes
        .filter(|lane| lane.kind == LaneKind::Leaf)
        .map(|lane| lane.start);
    let mut runs: Vec<(u32, &[u32])> = starts.zip(leaves).collect();
    // Depth first, as they were.
    runs.sort_unstable_by_key(|(start, _)| *start);
    let mut order = Vec::with_capacity(tree.order.len());
    // Where what began at a place begins now.
    let mut begins = vec![0; tree.order.len() + 1];
    for (start, triangles) in runs {
        begins[start as usize] = order.len() as u32;
        order.extend_from_slice(triangles);
    }
    begins[tree.order.len()] = order.len() as u32;
    let mut nodes = tree.nodes.clone();
    let mut next_slot = 0;
    for node in &mut nodes {
        node.first_slot = next_slot;
        let moved = node.lanes.map(|lane| {
            let start = begins[lane.start as usize];
            let end = begins[(lane.start + lane.count) as usize];
            Lane {
                start,
                count: end - start,
                ..lane
            }
        });
        node.lanes = [Lane::default(); LANES];
        let full = moved.into_iter().filter(|lane| lane.count > 0);
        for (place, lane) in node.lanes.iter_mut().zip(full) {
            *place = lane;
            if lane.kind == LaneKind::Leaf {
                next_slot += lane.count;
            }
        }
    }
    Tree {
        nodes,
        order,
        depth: tree.depth,
    }
}

#[cfg(test)]
mod tests;
