//! What lies above branches: boxes around spheres, cut down to what is known below.

use bdtree_format::LANES;

use super::record::{Boxes, RefinedNode};
use crate::bound::WideSpheres;
use crate::cache::{Kept, Posed};
use crate::error::QueryError;
use crate::pose::Pose;
use crate::simd::{Lanes, Work};
use crate::traverse::{UNREFINED, lane_subtree, there_is, used_lanes};
use crate::view::Asset;

/// What evaluating a node and boxes around its spheres costs, in the unit of [`Walk::gain`](crate::traverse::Walk::gain).
pub(super) const TOP_COST: u64 = 12;

/// Gives nodes boxes around the spheres of their lanes.
pub(super) struct Tops<'p> {
    pub(super) pose: &'p Pose<'p>,
    pub(super) nodes: &'p mut [RefinedNode],
}

impl Work for Tops<'_> {
    type Output = Result<(), QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self { pose, nodes } = self;
        let asset = pose.asset;
        let tops = nodes.len() as u32;
        let mut posed = Posed::new(pose, None, Kept::nothing(), None);
        for (index, slot) in (0..).zip(&mut *nodes) {
            let node = asset.node(index)?;
            let mut spheres = WideSpheres::<L>::empty();
            posed.spheres(asset, index, &mut spheres)?;
            let used = used_lanes(node);
            let mut starts = [0; LANES];
            let mut triangles = [0; LANES];
            for lane in (0..LANES).filter(|lane| used >> lane & 1 != 0) {
                let at = lane_subtree(node, lane);
                there_is(asset, at)?;
                triangles[lane] = at.triangles as u8;
                let is_here = at.triangles == 0 && at.start < tops;
                starts[lane] = if is_here {
                    at.start
                } else {
                    at.start | UNREFINED
                };
            }
            *slot = RefinedNode {
                boxes: Boxes::around(&spheres),
                starts,
                triangles,
                used,
                inner_mask: used & !node.leaf_mask,
                unused: [0; 6],
            };
        }
        // Spheres that hold less are tighter.
        for index in (0..nodes.len()).rev() {
            let (front, behind) = nodes.split_at_mut(index + 1);
            let Some(slot) = front.last_mut() else {
                break;
            };
            for lane in 0..LANES {
                let child = slot.starts[lane] as usize;
                let is_here = slot.inner_mask >> lane & 1 != 0 && child < tops as usize;
                if let Some(child) = behind.get(child.wrapping_sub(index + 1))
                    && is_here
                {
                    cut(slot, lane, child);
                }
            }
        }
        Ok(())
    }
}

/// Makes the boxes above a branch smaller, now that its own are exact.
pub(super) fn tighten(
    asset: &Asset<'_>,
    tops: &mut [RefinedNode],
    root: usize,
    refined: &RefinedNode,
) {
    let (mut child, mut tight) = (root, *refined);
    while child > 0 {
        // The last node whose children do not begin behind this one.
        let above = asset.nodes().get(..child.min(tops.len()));
        let behind = above
            .unwrap_or_default()
            .partition_point(|node| node.first_child as usize <= child);
        let Some(parent) = behind.checked_sub(1) else {
            return;
        };
        let Some((slot, lane)) = tops
            .get_mut(parent)
            .and_then(|slot| lane_of(slot, child).map(|lane| (slot, lane)))
        else {
            return;
        };
        cut(slot, lane, &tight);
        (child, tight) = (parent, *slot);
    }
}

/// Cuts the box of a lane down to what the boxes of the node hold that it leads to.
///
/// A bound that is NaN is unknown: then nothing is cut.
fn cut(slot: &mut RefinedNode, lane: usize, child: &RefinedNode) {
    let used = |of: &usize| child.used >> of & 1 != 0;
    let boxes = &child.boxes;
    let is_unknown =
        |of: usize| (0..3).any(|k| boxes.low[k][of].is_nan() || boxes.high[k][of].is_nan());
    if (0..LANES).filter(used).any(is_unknown) {
        return;
    }
    for axis in 0..3 {
        let [mut low, mut high] = [f32::INFINITY, f32::NEG_INFINITY];
        for of in (0..LANES).filter(used) {
            low = low.min(child.boxes.low[axis][of]);
            high = high.max(child.boxes.high[axis][of]);
        }
        let boxes = &mut slot.boxes;
        let (of_low, of_high) = (&mut boxes.low[axis][lane], &mut boxes.high[axis][lane]);
        (*of_low, *of_high) = (of_low.max(low), of_high.min(high));
    }
}

/// The lane that leads to a node of the asset.
fn lane_of(slot: &RefinedNode, child: usize) -> Option<usize> {
    (0..LANES).find(|lane| {
        let is_inner = slot.inner_mask >> lane & 1 != 0;
        is_inner && (slot.starts[*lane] & !UNREFINED) as usize == child
    })
}
