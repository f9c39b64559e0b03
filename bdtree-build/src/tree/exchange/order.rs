//! Which leaves may deal at the same time, so that what comes out is what it is one after the other.
//!
//! A leaf reads and changes leaves of its region only: the nodes near its own. So nodes whose regions have nothing
//! in common may deal in any order, and the others keep theirs. The tree's order rises along all axes, which
//! makes a front that many may deal along.

use std::ops::Range;
use std::sync::Arc;

use super::balls::Ball;
use super::{LaneKind, Scene, children};
use crate::parallel;

/// Nodes that deal one after the other.
const NODES: usize = 16;

/// Nodes looked at to find a region. Above it the region is everything, as that of a triangle among thousands
/// of smaller ones.
const LOOKED_AT_MAX: usize = 16_384;

/// How much farther, by the square, the balls of a node's leaves reach than its own. The points of a smallest ball
/// (c, r) need a square of r² + ‖z − c‖² about z, so if R² is enough there, ‖z − c‖ + r ≤ √2 R; the
/// rest is for rounding.
const REACH_SQUARE: f64 = 2.25;

/// Nodes whose leaves deal, one after the other.
#[derive(Debug)]
pub(super) struct Task {
    pub(super) nodes: Range<u32>,
    /// Nodes whose leaves are read or changed.
    pub(super) region: Arc<[u32]>,
}

/// All nodes in tasks, in groups that come one after the other; within a group no two regions meet.
pub(super) fn waves(scene: &Scene<'_>, threads: usize) -> Vec<Vec<Task>> {
    let count = scene.nodes.len();
    let everything: Arc<[u32]> = (0..count as u32).collect();
    if threads <= 1 {
        let (nodes, region) = (0..count as u32, everything);
        return vec![vec![Task { nodes, region }]];
    }
    let mut regions: Vec<Option<Arc<[u32]>>> = vec![None; count.div_ceil(NODES)];
    let jobs = regions.iter_mut().enumerate();
    let mut seen = parallel::states(threads, || vec![0; count]);
    parallel::for_each(jobs, &mut seen, |seen, (n, region)| {
        let nodes = n * NODES..((n + 1) * NODES).min(count);
        *region = find_region(scene, nodes, n as u32 + 1, seen).map(Arc::from);
    });
    let mut waves: Vec<Vec<Task>> = Vec::new();
    // Per node, the first wave that may have it.
    let mut free = vec![0; count];
    let mut rest = (0u32..).step_by(NODES).zip(regions).peekable();
    while let Some((first, region)) = rest.next() {
        let mut end = first as usize + NODES;
        if region.is_none() {
            while rest.next_if(|(_, next)| next.is_none()).is_some() {
                end += NODES;
            }
        }
        let region = region.unwrap_or_else(|| Arc::clone(&everything));
        let wave = region.iter().map(|&n| free[n as usize]).max().unwrap_or(0);
        for &node in &*region {
            free[node as usize] = wave + 1;
        }
        if wave == waves.len() {
            waves.push(Vec::new());
        }
        let nodes = first..end.min(count) as u32;
        waves[wave].push(Task { nodes, region });
    }
    waves
}

/// The nodes that `nodes` may have to do with; none if these are very many. `seen` holds what was seen with other
/// `mark`s.
fn find_region(
    scene: &Scene<'_>,
    nodes: Range<usize>,
    mark: u32,
    seen: &mut [u32],
) -> Option<Vec<u32>> {
    let mut region = Vec::new();
    let mut stack = Vec::new();
    let mut looked_at = 0;
    let has_leaves = |node: usize| {
        let record = &scene.tree.nodes[node];
        record.lanes_of(LaneKind::Leaf).next().is_some()
    };
    for node in nodes.filter(|&node| has_leaves(node)) {
        let own = scene.nodes[node].ball;
        let reach = Ball {
            square: own.square * REACH_SQUARE,
            ..own
        };
        stack.push(0);
        while let Some(node) = stack.pop() {
            looked_at += 1;
            if looked_at > LOOKED_AT_MAX {
                return None;
            }
            let record = &scene.tree.nodes[node as usize];
            if has_leaves(node as usize) && seen[node as usize] != mark {
                seen[node as usize] = mark;
                region.push(node);
            }
            for child in children(record) {
                if reach.meets(&scene.nodes[child as usize].ball) {
                    stack.push(child);
                }
            }
        }
    }
    Some(region)
}
