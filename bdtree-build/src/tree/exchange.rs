//! Leaf lanes that touch exchange triangles until their balls are small.
//!
//! Cuts by planes leave patches with corners, and the ball around one is larger than around a rounder
//! patch of the same area. Starting from them, neighbouring leaves give each other triangles wherever
//! that lowers the expected visits of the two (docs/design/decisions/leaf-exchange.md). The nodes above stay
//! as they are and their balls hold what enters them; some leaves become empty.

mod balls;
mod deal;
mod leaf;
mod order;

use std::sync::{Mutex, PoisonError};

use bdtree_format::LANES;

pub(super) use self::balls::Mesh;
use self::balls::{Ball, Vertices};
use self::deal::Dealer;
use self::leaf::{Leaf, Leaves};
use self::order::Task;
use super::{Lane, LaneKind, Tree, TreeNode};
use crate::parallel;
use crate::progress::Progress;

/// Larger leaves stay as they are cut: finding a trade takes the square of their size.
const LEAF_SIZE_MAX: usize = 16;

/// How often all leaves are gone through; a third time hardly changes anything.
const PASSES: usize = 2;

/// Triangles that a thread measures at a time.
const MEASURED: usize = 1024;

/// The tree with rounder leaves of at most `leaf_size` triangles; `query` is the diameter of a
/// typical query. The same for any number of threads, O(F log F + F `leaf_size`²).
pub(super) fn exchange(
    tree: &Tree,
    mesh: Mesh<'_>,
    leaf_size: usize,
    query: f64,
    threads: usize,
    progress: &dyn Progress,
) -> Tree {
    if leaf_size > LEAF_SIZE_MAX {
        return tree.clone();
    }
    let (scene, leaves) = measure(tree, mesh, leaf_size, query, threads);
    let leaves: Vec<Mutex<Leaves>> = leaves.into_iter().map(Mutex::new).collect();
    let held = |node: u32| {
        let leaves = leaves[node as usize].lock();
        leaves.unwrap_or_else(PoisonError::into_inner)
    };
    let waves = order::waves(&scene, threads);
    let mut dealers = parallel::states(threads, || Dealer::new(&scene));
    let tasks: usize = waves.iter().map(Vec::len).sum();
    progress.stage("leaves", Some((PASSES * tasks) as u64));
    for pass in 1..=PASSES {
        for wave in &waves {
            let deal = |dealer: &mut Dealer<'_>, task: &Task| {
                for &node in &*task.region {
                    dealer.leaves[node as usize] = std::mem::take(&mut *held(node));
                }
                for node in task.nodes.clone() {
                    dealer.deal_node(node, pass);
                }
                for &node in &*task.region {
                    *held(node) = std::mem::take(&mut dealer.leaves[node as usize]);
                }
            };
            parallel::for_each_told(wave.iter(), &mut dealers, deal, progress);
        }
    }
    let all = (0..leaves.len() as u32).flat_map(|node| std::mem::take(&mut *held(node)).list);
    with_leaves(tree, all)
}

/// What no trade changes.
#[derive(Debug)]
struct Scene<'t> {
    mesh: Mesh<'t>,
    tree: &'t Tree,
    leaf_size: usize,
    query: f64,
    /// Of each triangle.
    balls: Vec<Ball>,
    nodes: Vec<Node>,
}

/// A node as leaves see it.
#[derive(Debug, Clone, Copy, Default)]
struct Node {
    /// Around all triangles below it at first; none from outside enters.
    ball: Ball,
    /// The node above; the root's is itself.
    above: u32,
}

impl Scene<'_> {
    /// Expected visits of a leaf, up to a factor: as [`super::split::Splitter::visits`].
    fn cost(&self, square: f64) -> f64 {
        let reach = 2.0 * square.sqrt() + self.query;
        reach * reach
    }
}

/// Finds the balls of all triangles, leaves and nodes.
fn measure<'t>(
    tree: &'t Tree,
    mesh: Mesh<'t>,
    leaf_size: usize,
    query: f64,
    threads: usize,
) -> (Scene<'t>, Vec<Leaves>) {
    let mut balls = vec![Ball::EMPTY; mesh.corners.len()];
    let jobs = balls.chunks_mut(MEASURED).enumerate();
    let mut memory = parallel::states(threads, || (Vertices::default(), Vec::new()));
    parallel::for_each(jobs, &mut memory, |(vertices, _), (n, balls)| {
        for (triangle, ball) in ((n * MEASURED) as u32..).zip(balls) {
            *ball = mesh.ball(&[triangle], vertices);
        }
    });
    let mut nodes = vec![Node::default(); tree.nodes.len()];
    let mut leaves: Vec<Leaves> = tree.nodes.iter().map(|_| Leaves::default()).collect();
    // The first nodes hold the most.
    let jobs = tree.nodes.iter().zip(&mut nodes).zip(&mut leaves);
    parallel::for_each(
        jobs,
        &mut memory,
        |(vertices, below), ((record, node), leaves)| {
            below.clear();
            for lane in record.lanes {
                let triangles = tree.triangles_below(lane);
                below.extend_from_slice(triangles);
                leaves.lanes += u8::from(lane.kind != LaneKind::Empty);
                if lane.kind == LaneKind::Leaf {
                    let ball = mesh.ball(triangles, vertices);
                    leaves.list.push(Leaf::new(triangles, ball));
                }
            }
            node.ball = mesh.ball(below, vertices);
        },
    );
    for (node, record) in (0..).zip(&tree.nodes) {
        for child in children(record) {
            nodes[child as usize].above = node;
        }
    }
    let scene = Scene {
        mesh,
        tree,
        leaf_size,
        query,
        balls,
        nodes,
    };
    (scene, leaves)
}

/// A node's children.
fn children(node: &TreeNode) -> impl Iterator<Item = u32> {
    (node.first_child..).take(node.lanes_of(LaneKind::Inner).count())
}

/// The same nodes over other leaves, given in the order of nodes and lanes; empty lanes go.
fn with_leaves(tree: &Tree, leaves: impl Iterator<Item = Leaf>) -> Tree {
    let lanes = tree.nodes.iter().flat_map(|node| node.lanes);
    let starts = lanes
        .filter(|lane| lane.kind == LaneKind::Leaf)
        .map(|lane| lane.start);
    let mut runs: Vec<(u32, Vec<u32>)> = starts.zip(leaves.map(|leaf| leaf.triangles)).collect();
    // Depth first, as they were.
    runs.sort_unstable_by_key(|(start, _)| *start);
    let mut order = Vec::with_capacity(tree.order.len());
    // Where what began at a place begins now.
    let mut begins = vec![0; tree.order.len() + 1];
    for (start, triangles) in runs {
        begins[start as usize] = order.len() as u32;
        order.extend(triangles);
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
