//! Which modes act on which node: local fields cost only where they move something.

use std::collections::HashMap;

use super::stored::StoredShape;
use crate::tree::{LaneKind, Tree};

/// Mode lists, shared between nodes.
#[derive(Debug)]
pub(super) struct ModeLists {
    /// All lists, one behind the other, in the order in which nodes first need them.
    pub(super) modes: Vec<u16>,
    /// Start in `modes` and length, per node.
    pub(super) of_node: Vec<(u32, u16)>,
}

/// The lists of all nodes. A mode is left out of a node only if it moves no vertex below it, as
/// stored.
pub(super) fn mode_lists(tree: &Tree, triangles: &[[u32; 3]], shape: &StoredShape) -> ModeLists {
    let mode_count = shape.mode_count();
    let words = mode_count.div_ceil(64);
    let vertex_masks = vertex_masks(shape, words);
    let mut node_masks = vec![0u64; tree.nodes.len() * words];
    // Children stand behind their parents.
    for (i, node) in tree.nodes.iter().enumerate().rev() {
        let mut mask = vec![0u64; words];
        let mut child = node.first_child as usize;
        for lane in node.lanes {
            match lane.kind {
                LaneKind::Empty => {}
                LaneKind::Inner => {
                    merge(&mut mask, &node_masks, child);
                    child += 1;
                }
                LaneKind::Leaf => {
                    for &triangle in tree.triangles_below(lane) {
                        for corner in triangles[triangle as usize] {
                            merge(&mut mask, &vertex_masks, corner as usize);
                        }
                    }
                }
            }
        }
        node_masks[i * words..(i + 1) * words].copy_from_slice(&mask);
    }

    let mut lists = ModeLists {
        modes: Vec::new(),
        of_node: Vec::with_capacity(tree.nodes.len()),
    };
    let mut known: HashMap<&[u64], (u32, u16)> = HashMap::new();
    for i in 0..tree.nodes.len() {
        let mask = &node_masks[i * words..(i + 1) * words];
        let place = *known.entry(mask).or_insert_with(|| {
            let start = lists.modes.len();
            let active = (0..mode_count).filter(|j| mask[j / 64] >> (j % 64) & 1 == 1);
            lists.modes.extend(active.map(|j| j as u16));
            let count = lists.modes.len() - start;
            // An empty list stands at 0, wherever it was first needed.
            (if count == 0 { 0 } else { start as u32 }, count as u16)
        });
        lists.of_node.push(place);
    }
    lists
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
