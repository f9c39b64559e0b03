//! How triangles are split and ordered: a binary tree built from the top (Quinlan 1994, or by
//! cost), collapsed into the file's eight-wide nodes.
//!
//! The tree depends on the positions that it is given and on nothing else. Those are the rest positions as stored, so
//! that assets of one mesh with different bases share their structure; with a skin they are
//! [`tree_positions`](crate::skin::tree_positions). It is the same for any number of threads.

mod binary;
mod collapse;
mod collapse_costs;
mod exchange;
mod split;

use bdtree_format::{DEPTH_MAX, LANES, LEAF_TRIANGLES_MAX};

use crate::progress::{Progress, Silent};
use crate::words::words;

/// How a set of triangles is divided in two.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Split {
    /// At the middle of the longest axis of the box around the triangles (S. Quinlan, "Efficient
    /// distance computation between non-convex objects", ICRA 1994).
    Quinlan,
    /// Where the two parts together promise the fewest visits: box size times number of leaves,
    /// over planes on all three axes (a surface-area heuristic), cut so that leaves and the
    /// nodes above them are full. Then leaves that touch exchange triangles until their balls are small.
    #[default]
    Cost,
}

words!(
    Split,
    "is neither cost nor quinlan",
    Quinlan = "quinlan",
    Cost = "cost"
);

/// How a tree is built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TreeSettings {
    /// How sets are divided.
    pub split: Split,
    /// Most triangles in a leaf lane; taken into `1..=255`.
    pub leaf_size: usize,
    /// Threads to build with; the tree does not depend on it.
    pub threads: usize,
}

/// What one lane of a node holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LaneKind {
    /// Nothing.
    #[default]
    Empty,
    /// A child node.
    Inner,
    /// Triangles.
    Leaf,
}

/// One of the eight lanes of a node: a run of [`Tree::order`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Lane {
    /// What it holds.
    pub kind: LaneKind,
    /// First place in [`Tree::order`] of the triangles below the lane.
    pub start: u32,
    /// Number of triangles below the lane.
    pub count: u32,
}

/// An eight-wide node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TreeNode {
    /// The lanes; empty ones stand last.
    pub lanes: [Lane; LANES],
    /// Index of the first inner lane's child; the others follow.
    pub first_child: u32,
    /// Number of triangles in leaf lanes of all nodes before this one.
    pub first_slot: u32,
    /// Distance from the root.
    pub level: u8,
}

impl TreeNode {
    /// Its lanes of a kind, ascending.
    pub(crate) fn lanes_of(&self, kind: LaneKind) -> impl Iterator<Item = usize> {
        (0..LANES).filter(move |&k| self.lanes[k].kind == kind)
    }
}

/// Nodes breadth first, and the triangles they hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tree {
    /// The nodes; the root is the first.
    pub nodes: Vec<TreeNode>,
    /// Triangle ids such that every lane's triangles are a run (depth first, lane after lane).
    pub order: Vec<u32>,
    /// Number of levels.
    pub depth: usize,
}

impl Tree {
    /// The triangles below a lane: ids, ascending within a leaf lane.
    pub fn triangles_below(&self, lane: Lane) -> &[u32] {
        let start = lane.start as usize;
        self.order
            .get(start..start + lane.count as usize)
            .unwrap_or_default()
    }

    /// The corners of the triangles below a lane, `corners` being those of all.
    pub(crate) fn corners_below(
        &self,
        lane: Lane,
        corners: &[[u32; 3]],
    ) -> impl Iterator<Item = u32> {
        let below = self.triangles_below(lane).iter();
        below.flat_map(|&triangle| corners[triangle as usize])
    }

    /// Triangle ids in the file's order: leaf lanes in node order.
    pub fn leaf_order(&self) -> impl Iterator<Item = u32> + '_ {
        self.nodes
            .iter()
            .flat_map(|node| node.lanes)
            .filter(|lane| lane.kind == LaneKind::Leaf)
            .flat_map(|lane| self.triangles_below(lane).iter().copied())
    }
}

/// The tree over `triangles` (corner indices below `positions.len()`) at the stored rest
/// positions. At most [`DEPTH_MAX`] levels for any input of fewer than 2³² triangles; a mesh
/// without triangles gives one empty node. O(F log² F).
pub fn build(positions: &[[f32; 3]], triangles: &[[u32; 3]], settings: &TreeSettings) -> Tree {
    build_told(positions, triangles, settings, &Silent)
}

/// [`build`] that tells `progress` how far the leaves are, which take longest.
pub(crate) fn build_told(
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    settings: &TreeSettings,
    progress: &dyn Progress,
) -> Tree {
    let leaf_size = settings.leaf_size.clamp(1, LEAF_TRIANGLES_MAX);
    let (mut tree, query) = cut(positions, triangles, settings, leaf_size);
    debug_assert!(tree.depth <= DEPTH_MAX);
    if settings.split == Split::Cost {
        let threads = settings.threads.max(1);
        let mesh = exchange::Mesh {
            positions,
            corners: triangles,
        };
        tree = exchange::exchange(&tree, mesh, leaf_size, query, threads, progress);
    }
    sort_leaves(&mut tree);
    tree
}

/// The tree as cut from the top and collapsed, and the diameter of a typical query.
fn cut(
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    settings: &TreeSettings,
    leaf_size: usize,
) -> (Tree, f64) {
    let mut items = split::items(positions, triangles);
    let splitter = split::Splitter {
        split: settings.split,
        leaf_size,
        diagonal: split::bounds_of(&items).cost().sqrt(),
    };
    let root = binary::build(&mut items, &splitter, settings.threads.max(1));
    let order = items.iter().map(|item| item.id).collect();
    (collapse::collapse(&root, order), splitter.query())
}

/// Puts the triangles of each leaf lane in ascending order of ids.
fn sort_leaves(tree: &mut Tree) {
    for lane in tree.nodes.iter().flat_map(|node| node.lanes) {
        if lane.kind == LaneKind::Leaf {
            let start = lane.start as usize;
            tree.order[start..start + lane.count as usize].sort_unstable();
        }
    }
}

/// Which vertices of a mesh have been met among those of a set, for one set after the other.
#[derive(Debug, Default)]
pub(crate) struct Met {
    /// Per vertex, the last set that it was met in.
    sets: Vec<u32>,
    set: u32,
}

impl Met {
    /// The vertices of a set, each once, in the order of first use; all are below `vertex_count`.
    pub(crate) fn once(
        &mut self,
        vertex_count: usize,
        vertices: impl Iterator<Item = u32>,
    ) -> impl Iterator<Item = u32> {
        self.sets.resize(vertex_count, 0);
        self.set += 1;
        let Self { sets, set } = self;
        vertices.filter(|&vertex| std::mem::replace(&mut sets[vertex as usize], *set) != *set)
    }
}
