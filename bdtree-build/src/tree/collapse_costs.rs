//! Which binary nodes become wide nodes and which dissolve into their parents.
//!
//! Chosen for the least expected visits by dynamic programming (H. Ylitie, T. Karras, S. Laine, "Efficient
//! incoherent ray traversal on GPUs through compressed wide BVHs", HPG 2017, section 3.1).

use bdtree_format::LANES;

/// The cheapest ways to put a binary subtree into lanes of a node above it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CollapseCosts {
    /// Expected visits of all wide nodes below, when the subtree gets at most i + 1 lanes.
    cost: [f64; LANES],
    /// Lanes of the left child then; 0: the whole subtree is one lane.
    pub(super) left_lanes: [u8; LANES],
    /// Lanes of the left child in the subtree's own wide node.
    pub(super) own_left_lanes: u8,
}

impl CollapseCosts {
    /// The costs of an inner node whose wide node would be visited `visits` times.
    pub(super) fn of_inner(visits: f64, left: &Self, right: &Self) -> Self {
        // The cheapest way to share `lanes` between the children.
        let share = |lanes: usize| {
            (1..lanes)
                .map(|l| (left.cost[l - 1] + right.cost[lanes - l - 1], l as u8))
                .fold(
                    (f64::INFINITY, 0),
                    |best, new| if new.0 < best.0 { new } else { best },
                )
        };
        let (below, own_left_lanes) = share(LANES);
        let own = (visits + below, 0);
        let mut costs = Self {
            own_left_lanes,
            ..Self::default()
        };
        for i in 0..LANES {
            let opened = share(i + 1);
            (costs.cost[i], costs.left_lanes[i]) = if opened.0 < own.0 { opened } else { own };
        }
        costs
    }
}
