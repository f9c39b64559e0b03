//! The vertices below every lane.

use bdtree_format::{LANES, NodeRecord};
use bdtree_runtime::Asset;

/// The vertices of the triangles below each lane, each once, ascending.
pub(super) struct Below {
    /// Where those of lane k of node i begin: entry 8 i + k, and one more.
    starts: Vec<usize>,
    vertices: Vec<u32>,
}

impl Below {
    /// Of a tree that broke no rule of [`Asset::verify`].
    pub(super) fn of(asset: &Asset<'_>) -> Self {
        let nodes = asset.nodes();
        // Children stand behind their node, so their lists are made first.
        let mut lists = vec![Vec::new(); LANES * nodes.len()];
        for (i, node) in nodes.iter().enumerate().rev() {
            for lane in 0..LANES {
                let mut list = if node.leaf_mask & (1 << lane) != 0 {
                    let leaf = leaf_triangles(node, lane);
                    asset.triangles()[leaf]
                        .iter()
                        .flat_map(|triangle| triangle.corners)
                        .collect()
                } else if let Some(child) = child(node, lane) {
                    lists[LANES * child..LANES * (child + 1)].concat()
                } else {
                    Vec::new()
                };
                list.sort_unstable();
                list.dedup();
                lists[LANES * i + lane] = list;
            }
        }
        let mut starts = vec![0];
        let mut vertices = Vec::with_capacity(lists.iter().map(Vec::len).sum());
        for list in lists {
            vertices.extend(list);
            starts.push(vertices.len());
        }
        Self { starts, vertices }
    }

    /// Those below a lane; none where the lane is empty.
    #[inline]
    pub(super) fn lane(&self, node: usize, lane: usize) -> &[u32] {
        let at = LANES * node + lane;
        &self.vertices[self.starts[at]..self.starts[at + 1]]
    }
}

/// The triangle slots of a leaf lane.
fn leaf_triangles(node: &NodeRecord, lane: usize) -> std::ops::Range<usize> {
    let counts = node.leaf_counts.map(usize::from);
    let start = node.first_slot as usize + counts[..lane].iter().sum::<usize>();
    start..start + counts[lane]
}

/// The node that an inner lane leads to.
fn child(node: &NodeRecord, lane: usize) -> Option<usize> {
    let bit = 1_u8 << lane;
    let before = (node.inner_mask & (bit - 1)).count_ones();
    (node.inner_mask & bit != 0).then_some((node.first_child + before) as usize)
}
