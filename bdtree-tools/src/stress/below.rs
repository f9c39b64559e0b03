//! The vertices below every lane.

use bdtree_format::LANES;
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
                let mut list = match node.child(lane) {
                    Some(child) => lists[LANES * child as usize..][..LANES].concat(),
                    // Nothing where the lane is empty.
                    None => {
                        let triangles = asset.triangles().get(node.slots(lane)).unwrap_or_default();
                        triangles
                            .iter()
                            .flat_map(|triangle| triangle.corners)
                            .collect()
                    }
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
