//! Which modes act on which node and vertex: local fields cost only where they move something.

use std::collections::BTreeMap;

use bdtree_format::VertexModes;

use super::stored::StoredShape;
use crate::tree::{LaneKind, Tree};

/// Bytes of a displacement.
const ENTRY_BYTES: u64 = 12;

/// Mode lists, shared between nodes and vertices.
#[derive(Debug)]
pub(super) struct ModeLists {
    /// All lists, one behind the other, in descending order (SPEC 6.7).
    pub(super) modes: Vec<u16>,
    /// Start in `modes` and length, per node.
    pub(super) of_node: Vec<(u32, u16)>,
    /// The records of all vertices and a last one (SPEC 7.6); empty where the displacements of all
    /// modes are stored for all vertices.
    pub(super) of_vertex: Vec<VertexModes>,
}

/// The lists of all nodes, and of the vertices if that saves a quarter of the displacements' bytes
/// or more. A mode is left out of a node or vertex only if it moves no vertex below it, as stored.
pub(super) fn mode_lists(tree: &Tree, triangles: &[[u32; 3]], shape: &StoredShape) -> ModeLists {
    let words = shape.mode_count().div_ceil(64);
    let vertex_masks = vertex_masks(shape, words);
    let node_masks = node_masks(tree, triangles, &vertex_masks, words);
    // Where each list starts, by what it holds.
    let mut starts: BTreeMap<&[u64], u32> = BTreeMap::new();
    starts.extend(node_masks.chunks_exact(words.max(1)).map(|mask| (mask, 0)));
    let is_sparse = add_vertex_lists(&vertex_masks, shape, &mut starts);

    let mut lists: Vec<(Vec<u16>, &mut u32)> = starts
        .iter_mut()
        .map(|(mask, start)| (listed(mask).collect(), start))
        .collect();
    lists.sort_unstable_by(|(a, _), (b, _)| b.cmp(a));
    let mut modes = Vec::new();
    for (list, start) in lists {
        // An empty list, which is the last, stands at 0.
        *start = if list.is_empty() {
            0
        } else {
            modes.len() as u32
        };
        modes.extend(list);
    }

    let start = |mask: &[u64]| starts.get(mask).copied().unwrap_or(0);
    let of_node = (0..tree.nodes.len()).map(|i| {
        let mask = &node_masks[i * words..(i + 1) * words];
        (start(mask), count(mask) as u16)
    });
    let mut of_vertex = Vec::new();
    if is_sparse {
        let mut first_entry = 0;
        for mask in vertex_masks.chunks_exact(words) {
            of_vertex.push(VertexModes {
                first_entry,
                mode_list_start: start(mask),
            });
            first_entry += count(mask);
        }
        of_vertex.push(VertexModes {
            first_entry,
            mode_list_start: 0,
        });
    }
    ModeLists {
        of_node: of_node.collect(),
        modes,
        of_vertex,
    }
}

/// Adds the lists of vertices if displacements, records and these lists take at most three
/// quarters of the bytes of all displacements; whether it did.
fn add_vertex_lists<'m>(
    vertex_masks: &'m [u64],
    shape: &StoredShape,
    lists: &mut BTreeMap<&'m [u64], u32>,
) -> bool {
    let words = shape.mode_count().div_ceil(64);
    let all = ENTRY_BYTES * shape.displacements.len() as u64;
    let saves = |bytes: u64| 4 * bytes <= 3 * all;
    let entries: u64 = vertex_masks.iter().map(|w| u64::from(w.count_ones())).sum();
    let records = (size_of::<VertexModes>() * (shape.positions.len() + 1)) as u64;
    let mut bytes = ENTRY_BYTES * entries + records;
    // The usual case, decided without a look at the lists.
    if words == 0 || !saves(bytes) || u32::try_from(entries).is_err() {
        return false;
    }
    let mut added = lists.clone();
    added.extend(vertex_masks.chunks_exact(words).map(|mask| (mask, 0)));
    let length = |lists: &BTreeMap<&[u64], u32>| -> u64 {
        lists.keys().map(|mask| u64::from(count(mask))).sum()
    };
    let total = length(&added);
    bytes += 2 * (total - length(lists));
    if !saves(bytes) || u32::try_from(total).is_err() {
        return false;
    }
    *lists = added;
    true
}

/// The modes of a mask, ascending.
fn listed(mask: &[u64]) -> impl Iterator<Item = u16> {
    let bits = (0..64 * mask.len()).filter(|j| mask[j / 64] >> (j % 64) & 1 == 1);
    bits.map(|j| j as u16)
}

/// How many modes a mask has: at most 512.
fn count(mask: &[u64]) -> u32 {
    mask.iter().map(|word| word.count_ones()).sum()
}

/// Bit j of a node's words: mode j moves a vertex below it.
fn node_masks(tree: &Tree, triangles: &[[u32; 3]], vertex_masks: &[u64], words: usize) -> Vec<u64> {
    let mut node_masks = vec![0u64; tree.nodes.len() * words];
    let mut mask = vec![0u64; words];
    // Children stand behind their parents.
    for (i, node) in tree.nodes.iter().enumerate().rev() {
        mask.fill(0);
        let mut child = node.first_child as usize;
        for lane in node.lanes {
            match lane.kind {
                LaneKind::Empty => {}
                LaneKind::Inner => {
                    merge(&mut mask, &node_masks, child);
                    child += 1;
                }
                LaneKind::Leaf => {
                    for corner in tree.corners_below(lane, triangles) {
                        merge(&mut mask, vertex_masks, corner as usize);
                    }
                }
            }
        }
        node_masks[i * words..(i + 1) * words].copy_from_slice(&mask);
    }
    node_masks
}

/// Bit j of a vertex's words: mode j moves it.
fn vertex_masks(shape: &StoredShape, words: usize) -> Vec<u64> {
    let mode_count = shape.mode_count();
    let mut masks = vec![0u64; shape.positions.len() * words];
    if mode_count == 0 {
        return masks;
    }
    for (mask, row) in masks
        .chunks_exact_mut(words)
        .zip(shape.displacements.chunks_exact(mode_count))
    {
        for (j, u) in row.iter().enumerate() {
            if *u != [0.0; 3] {
                mask[j / 64] |= 1 << (j % 64);
            }
        }
    }
    masks
}

/// ORs entry `index` of `masks` into `mask`.
fn merge(mask: &mut [u64], masks: &[u64], index: usize) {
    let words = mask.len();
    for (word, other) in mask
        .iter_mut()
        .zip(&masks[index * words..(index + 1) * words])
    {
        *word |= other;
    }
}
