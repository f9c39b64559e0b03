//! Deforms all vertices, puts the corners of leaves side by side, and finds all boxes.
//!
//! The first two are done in parts, which may run at the same time.

use super::record::groups_in;
use super::sweep::{Inner, Leaves};
use super::vertices::{TOGETHER, Vertices};
use super::{RefinedLeaf, RefinedNode};
use crate::error::QueryError;
use crate::pose::Pose;

/// Most parts that preparing is split into: nodes without leaves may be one more.
const PARTS_MAX: usize = 32 + 1;

/// A part of preparing a pose, which any thread may run; [`RefinedPose::prepare_in_parts`](super::RefinedPose::prepare_in_parts)
/// hands them out.
#[derive(Debug, Default)]
pub struct PreparePart<'p> {
    work: PartWork<'p>,
    outcome: Option<Result<(), QueryError>>,
}

impl PreparePart<'_> {
    /// Does this part.
    pub fn run(&mut self) {
        // A kernel's work is moved into it.
        self.outcome = match core::mem::take(&mut self.work) {
            PartWork::Vertices(part) => Some(part.pose.asset.kernel.run(part)),
            PartWork::Leaves(part) => Some(part.asset.kernel.run(part)),
            PartWork::Done => self.outcome.take(),
        };
    }
}

#[derive(Debug, Default)]
enum PartWork<'p> {
    Vertices(Vertices<'p>),
    Leaves(Leaves<'p, &'p [[f32; 4]]>),
    #[default]
    Done,
}

/// What is to be filled.
pub(super) struct Slots<'p> {
    pub(super) nodes: &'p mut [RefinedNode],
    pub(super) leaves: &'p mut [RefinedLeaf],
    pub(super) vertices: &'p mut [[f32; 4]],
}

/// Fills all slots, in so many parts or fewer.
///
/// # Errors
/// A corrupt asset, a part that was not run.
pub(super) fn prepare(
    pose: &Pose<'_>,
    slots: Slots<'_>,
    parts: usize,
    run: &mut dyn FnMut(&mut [PreparePart<'_>]),
) -> Result<(), QueryError> {
    let Slots {
        nodes,
        leaves,
        vertices,
    } = slots;
    let parts = parts.clamp(1, PARTS_MAX - 1);
    {
        let each = vertices.len().div_ceil(parts).next_multiple_of(TOGETHER);
        let starts = (0..).step_by(each.max(1));
        let of = vertices.chunks_mut(each.max(1)).zip(starts);
        run_all(
            of.map(|(out, first)| PartWork::Vertices(Vertices { pose, first, out })),
            run,
        )?;
    }
    let vertices = &*vertices;
    let split = Split {
        pose,
        vertices,
        each: leaves.len().div_ceil(parts) as u32,
        nodes: &mut *nodes,
        leaves,
        first_node: 0,
        first_leaf: 0,
    };
    run_all(split, run)?;
    pose.asset.kernel.run(Inner {
        asset: pose.asset,
        nodes,
        first: 0,
    })
}

/// Has all run.
fn run_all<'p>(
    works: impl Iterator<Item = PartWork<'p>>,
    run: &mut dyn FnMut(&mut [PreparePart<'_>]),
) -> Result<(), QueryError> {
    let mut parts: [PreparePart<'_>; PARTS_MAX] = core::array::from_fn(|_| PreparePart::default());
    let mut count = 0;
    for (part, work) in parts.iter_mut().zip(works) {
        part.work = work;
        count += 1;
    }
    let parts = parts.get_mut(..count).unwrap_or_default();
    run(parts);
    for part in parts {
        let not_run = Err(QueryError::Argument("run: a part was not run"));
        part.outcome.take().unwrap_or(not_run)?;
    }
    Ok(())
}

/// Cuts nodes into parts of about as many leaves.
struct Split<'p> {
    pose: &'p Pose<'p>,
    vertices: &'p [[f32; 4]],
    /// Leaves of a part, from which on it ends.
    each: u32,
    nodes: &'p mut [RefinedNode],
    leaves: &'p mut [RefinedLeaf],
    first_node: u32,
    first_leaf: u32,
}

impl<'p> Iterator for Split<'p> {
    type Item = PartWork<'p>;

    fn next(&mut self) -> Option<PartWork<'p>> {
        if self.nodes.is_empty() {
            return None;
        }
        let from = self.pose.asset.nodes().get(self.first_node as usize..)?;
        let (mut node_count, mut leaf_count) = (0, 0);
        for node in from {
            node_count += 1;
            leaf_count += groups_in(&node.leaf_counts);
            if leaf_count >= self.each.max(1) {
                break;
            }
        }
        let nodes = core::mem::take(&mut self.nodes);
        let (nodes, rest) = nodes.split_at_mut(node_count.min(nodes.len()));
        self.nodes = rest;
        let leaves = core::mem::take(&mut self.leaves);
        let (leaves, rest) = leaves.split_at_mut((leaf_count as usize).min(leaves.len()));
        self.leaves = rest;
        let part = Leaves {
            asset: self.pose.asset,
            vertices: self.vertices,
            first_node: self.first_node,
            nodes,
            first_leaf: self.first_leaf,
            leaves,
            shift: 0,
        };
        self.first_node += node_count as u32;
        self.first_leaf += leaf_count;
        Some(PartWork::Leaves(part))
    }
}
