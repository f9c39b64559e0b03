//! Bounds of every lane around the vertices below it: the wrapped spheres of the paper (eqs. 2–7,
//! 11), centered on smallest balls, with the second-order terms of docs/design/guarantees.md.

pub mod ball;
pub mod bones;
mod check;
pub mod frames;
mod grid;
mod growth;
mod lane;
mod modes;
mod nested;
pub mod round;
pub mod stored;
mod units;

use bdtree_format::{
    LANES, ModePair, NodeRecord, ROW_CENTER_X, Row, VertexModes, pair_row, row_count,
};
use zerocopy::IntoBytes;

pub use bones::{WrappedBones, wrap_bones};
pub use nested::nest;
pub use stored::{ModeLimits, RANGE_DIAGONALS, StoredShape, store};

use crate::error::{BakeError, Place};
use crate::parallel;
use crate::progress::{Progress, Silent};
use crate::tree::{LaneKind, Met, Tree, TreeNode};
use lane::Scratch;
use round::vector_norm_up;
use units::power;

/// The least P + Σ W_j q_limit_j that readers take (SPEC 5.4); P may be any upper bound.
const REACH_MIN: f32 = 1.0 / (1u32 << 20) as f32;

/// Nodes, rows and mode lists as the file holds them.
#[derive(Debug, Clone, PartialEq)]
pub struct WrappedTree {
    /// Breadth first.
    pub nodes: Vec<NodeRecord>,
    /// Rows of all nodes, in node order.
    pub rows: Vec<Row>,
    /// The mode lists that nodes and vertices point into; each ascending, each stored once.
    pub mode_lists: Vec<u16>,
    /// Which modes each vertex has, and a last record (SPEC 7.6); empty where it has all.
    pub vertex_modes: Vec<VertexModes>,
    /// P: an upper bound of all ‖p_i‖ and ‖c‖ (stored units).
    pub position_norm_max: f32,
    /// W_j: upper bounds of all ‖U_ij‖ and ‖Ū_j‖ (stored units per unit of q).
    pub field_norms_max: Vec<f32>,
}

/// A node, its record and its rows.
type Job<'j> = (&'j TreeNode, &'j mut NodeRecord, &'j mut [Row]);

/// Bounds for `tree` over the triangles of `shape` (corner indices below its vertex count). The
/// result does not depend on `threads`. O(levels · N · M).
///
/// # Errors
/// More rows than a node can point to with 32 bits.
pub fn wrap(
    tree: &Tree,
    triangles: &[[u32; 3]],
    shape: &StoredShape,
    threads: usize,
) -> Result<WrappedTree, BakeError> {
    wrap_told(tree, triangles, shape, threads, &Silent)
}

/// [`wrap`] that advances `progress` by a step for each node.
pub(crate) fn wrap_told(
    tree: &Tree,
    triangles: &[[u32; 3]],
    shape: &StoredShape,
    threads: usize,
    progress: &dyn Progress,
) -> Result<WrappedTree, BakeError> {
    let lists = modes::mode_lists(tree, triangles, shape);
    let (mut nodes, row_total) = node_records(tree, &lists.of_node)?;
    let step_bounds = growth::step_bounds(shape, threads);
    let mut rows = vec![[0.0; LANES]; row_total];
    let mut rest = rows.as_mut_slice();
    let mut jobs = Vec::with_capacity(nodes.len());
    for (node, record) in tree.nodes.iter().zip(&mut nodes) {
        let (own, behind) = rest.split_at_mut(row_count(usize::from(record.mode_count)));
        rest = behind;
        jobs.push((node, record, own));
    }
    let mut memory = parallel::states(threads, <(Scratch, Met)>::default);
    // The root comes first, which has most vertices.
    let jobs = jobs.into_iter();
    let write = |(scratch, met): &mut (Scratch, Met), job: Job<'_>| {
        let (node, record, own) = job;
        for (lane, below) in node.lanes.iter().zip(&mut scratch.lanes) {
            let corners = tree.corners_below(*lane, triangles);
            below.vertices.clear();
            below
                .vertices
                .extend(met.once(shape.positions.len(), corners));
        }
        let modes = modes_of(&lists.modes, record);
        record.scale_exponents = lane::write_node(shape, modes, &step_bounds, scratch, own);
    };
    parallel::for_each_told(jobs, &mut memory, write, progress);
    let (mut position_norm_max, field_norms_max) = norms(shape, &nodes, &rows, &lists.modes);
    if position_norm_max == 0.0 && field_norms_max.iter().all(|&w| w == 0.0) {
        position_norm_max = REACH_MIN; // a single point that never moves
    }
    Ok(WrappedTree {
        nodes,
        rows,
        mode_lists: lists.modes,
        vertex_modes: lists.of_vertex,
        position_norm_max,
        field_norms_max,
    })
}

/// The nodes but for the exponents of their rows' units, and the number of all rows; `lists` are start and
/// length of each node's mode list.
fn node_records(tree: &Tree, lists: &[(u32, u16)]) -> Result<(Vec<NodeRecord>, usize), BakeError> {
    let mut nodes = Vec::with_capacity(tree.nodes.len());
    let mut row_total = 0usize;
    for (node, &(mode_list_start, mode_count)) in tree.nodes.iter().zip(lists) {
        let Ok(row_start) = u32::try_from(row_total) else {
            let message = "more than 2^32 rows: fewer modes or more triangles per leaf are needed";
            return Err(BakeError::one("wrap", Place::NOWHERE, message));
        };
        let mask = |kind: LaneKind| node.lanes_of(kind).fold(0, |mask, k| mask | 1 << k);
        nodes.push(NodeRecord {
            first_child: node.first_child,
            first_slot: node.first_slot,
            row_start,
            mode_list_start,
            mode_count,
            inner_mask: mask(LaneKind::Inner),
            leaf_mask: mask(LaneKind::Leaf),
            leaf_counts: node.lanes.map(|lane| match lane.kind {
                LaneKind::Leaf => lane.count as u8,
                LaneKind::Empty | LaneKind::Inner => 0,
            }),
            level: node.level,
            scale_exponents: [0; 3], // with the rows
        });
        row_total += row_count(usize::from(mode_count));
    }
    Ok((nodes, row_total))
}

/// The modes that act on a node.
pub(crate) fn modes_of<'l>(lists: &'l [u16], node: &NodeRecord) -> &'l [u16] {
    let start = node.mode_list_start as usize;
    &lists[start..start + usize::from(node.mode_count)]
}

/// The k-th pair of a node's active modes as `rows`, the node's, hold it.
pub(crate) fn mode_pair(rows: &[Row], k: usize) -> ModePair {
    let mut out = ModePair::default();
    out.as_mut_bytes()
        .copy_from_slice(rows[pair_row(k)..pair_row(k + 1)].as_bytes());
    out
}

/// Writes [`mode_pair`].
fn set_mode_pair(rows: &mut [Row], k: usize, pair: &ModePair) {
    rows[pair_row(k)..pair_row(k + 1)]
        .as_mut_bytes()
        .copy_from_slice(pair.as_bytes());
}

/// P and W_j over vertices and lanes.
fn norms(
    shape: &StoredShape,
    nodes: &[NodeRecord],
    rows: &[Row],
    lists: &[u16],
) -> (f32, Vec<f32>) {
    let (mut position, mut fields) = (shape.position_norm, shape.field_norms.clone());
    for node in nodes {
        let rows = &rows[node.row_start as usize..];
        for lane in 0..LANES {
            let center = [0, 1, 2].map(|axis| f64::from(rows[ROW_CENTER_X + axis][lane]));
            position = position.max(vector_norm_up(center));
        }
        let unit = power(i32::from(node.scale_exponents[0]));
        for (k, &mode) in modes_of(lists, node).iter().enumerate() {
            let mode = usize::from(mode);
            let per_q = unit / f64::from(shape.limits[mode].q_limit);
            let pair = mode_pair(rows, k / 2);
            for lane in 0..LANES {
                let [x, y, z, ..] = pair.numbers(k, lane);
                let center = [x, y, z].map(|n| f64::from(n) * per_q);
                fields[mode] = fields[mode].max(vector_norm_up(center));
            }
        }
    }
    (position, fields)
}
