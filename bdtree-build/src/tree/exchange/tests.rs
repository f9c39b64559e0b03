//! Trades keep the tree whole and make leaves rounder.

use crate::progress::Silent;

use super::super::{Split, TreeNode, TreeSettings, cut};
use super::deal::LANES_MIN;
use super::*;

const LEAF_SIZE: usize = 4;

/// A wavy sheet of 2 n² triangles.
fn sheet(n: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let positions = (0..(n + 1) * (n + 1)).map(|i| {
        let (x, y) = ((i % (n + 1)) as f32 * 0.1, (i / (n + 1)) as f32 * 0.1);
        [
            x + 0.03 * (7.0 * y).sin(),
            y,
            (1.3 * x).sin() * (0.9 * y).cos(),
        ]
    });
    let triangles = (0..n * n).flat_map(|i| {
        let a = i / n * (n + 1) + i % n;
        let (b, c, d) = (a + 1, a + n + 1, a + n + 2);
        [[a, b, d], [a, d, c]]
    });
    (positions.collect(), triangles.collect())
}

fn both(positions: &[[f32; 3]], triangles: &[[u32; 3]], leaf_size: usize) -> [Tree; 2] {
    let settings = TreeSettings {
        split: Split::Cost,
        leaf_size,
        threads: 1,
    };
    let (tree, query) = cut(positions, triangles, &settings, leaf_size);
    let mesh = Mesh {
        positions,
        corners: triangles,
    };
    let [after, in_parallel] =
        [1, 3].map(|threads| exchange(&tree, mesh, leaf_size, query, threads, &Silent));
    assert!(after == in_parallel);
    [tree, after]
}

fn leaf_count(tree: &Tree) -> usize {
    let lanes = tree.nodes.iter().flat_map(|node| node.lanes);
    lanes.filter(|lane| lane.kind == LaneKind::Leaf).count()
}

/// That a tree is one over so many triangles, with lanes in at least two places of every node that had
/// them there `before`.
fn is_whole_as(before: &Tree, tree: &Tree, triangles: usize, leaf_size: usize) {
    is_whole(tree, triangles, leaf_size);
    for (old, new) in before.nodes.iter().zip(&tree.nodes) {
        let full = |node: &TreeNode| node.lanes.iter().filter(|l| l.count > 0).count();
        assert!(full(new) >= full(old).min(usize::from(LANES_MIN)));
    }
}

fn is_whole(tree: &Tree, triangles: usize, leaf_size: usize) {
    let mut ids: Vec<u32> = tree.leaf_order().collect();
    ids.sort_unstable();
    assert!(ids.into_iter().eq(0..triangles as u32));
    let mut slots = 0;
    for node in &tree.nodes {
        assert_eq!(node.first_slot, slots);
        let mut child = node.first_child as usize;
        for lane in node.lanes {
            let mut below = tree.triangles_below(lane).to_vec();
            assert_eq!(below.len(), lane.count as usize);
            match lane.kind {
                LaneKind::Empty => assert_eq!(lane, Lane::default()),
                LaneKind::Leaf => {
                    assert!((1..=leaf_size).contains(&below.len()));
                    slots += lane.count;
                }
                LaneKind::Inner => {
                    let lanes = tree.nodes[child].lanes;
                    let mut held: Vec<u32> = lanes
                        .iter()
                        .flat_map(|lane| tree.triangles_below(*lane).iter().copied())
                        .collect();
                    held.sort_unstable();
                    below.sort_unstable();
                    assert_eq!(held, below);
                    child += 1;
                }
            }
        }
        let empty = |lane: &&Lane| lane.kind == LaneKind::Empty;
        let trailing = node.lanes.iter().rev().take_while(empty).count();
        assert_eq!(trailing, node.lanes.iter().filter(empty).count());
        assert!(trailing < LANES);
    }
}

#[test]
fn leaves_get_rounder_and_nodes_no_larger() {
    let (positions, triangles) = sheet(60);
    let mesh = Mesh {
        positions: &positions,
        corners: &triangles,
    };
    let mut vertices = Vertices::default();
    let [before, after] = both(&positions, &triangles, LEAF_SIZE);
    is_whole(&before, triangles.len(), LEAF_SIZE);
    is_whole_as(&before, &after, triangles.len(), LEAF_SIZE);
    let mut leaf_squares = |tree: &Tree| {
        let lanes = tree.nodes.iter().flat_map(|node| node.lanes);
        let leaves = lanes.filter(|lane| lane.kind == LaneKind::Leaf);
        leaves
            .map(|lane| mesh.ball(tree.triangles_below(lane), &mut vertices).square)
            .sum::<f64>()
    };
    let (sum_before, sum_after) = (leaf_squares(&before), leaf_squares(&after));
    assert!(sum_after < 0.97 * sum_before, "{sum_after} of {sum_before}");
    assert_eq!(before.nodes.len(), after.nodes.len());
    for (old, new) in before.nodes.iter().zip(&after.nodes) {
        let below = |tree: &Tree, lanes: [Lane; LANES]| {
            let ids = lanes.iter().flat_map(|lane| tree.triangles_below(*lane));
            ids.copied().collect::<Vec<u32>>()
        };
        let ball = mesh.ball(&below(&before, old.lanes), &mut vertices);
        let room = Ball {
            square: ball.square * (1.0 + 1e-9),
            ..ball
        };
        for triangle in below(&after, new.lanes) {
            assert!(mesh.corners(triangle).into_iter().all(|p| room.holds(p)));
        }
    }
}

/// Cuts leave many leaves that are not full; some of them give away what they have.
#[test]
fn leaves_become_fewer() {
    let (positions, triangles) = sheet(60);
    // The rows of the sheet as a soup in which every third triangle is missing.
    let holes: Vec<[u32; 3]> = (0..)
        .zip(triangles)
        .filter(|(i, _)| i % 3 > 0)
        .map(|t| t.1)
        .collect();
    let [before, after] = both(&positions, &holes, LEAF_SIZE);
    is_whole_as(&before, &after, holes.len(), LEAF_SIZE);
    assert!(leaf_count(&after) < leaf_count(&before));
}

#[test]
fn thousands_of_triangles_in_one_place_are_no_trouble() {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    for corners in [[0, 1, 2], [0, 0, 0]] {
        let triangles = vec![corners; 20_000];
        let [before, after] = both(&positions, &triangles, LEAF_SIZE);
        is_whole_as(&before, &after, triangles.len(), LEAF_SIZE);
    }
}

#[test]
fn any_count_and_leaf_size() {
    let (positions, triangles) = sheet(4);
    let [_, nothing] = both(&positions, &[], LEAF_SIZE);
    assert_eq!((nothing.nodes.len(), nothing.order.len()), (1, 0));
    for leaf_size in [1, 2, 3, 5, 8, LEAF_SIZE_MAX, 255] {
        for count in 1..=triangles.len() {
            let triangles = &triangles[..count];
            let [before, after] = both(&positions, triangles, leaf_size);
            is_whole_as(&before, &after, count, leaf_size);
            assert!(leaf_size <= LEAF_SIZE_MAX || before == after);
        }
    }
}
