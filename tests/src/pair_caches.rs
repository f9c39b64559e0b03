//! Pair queries with and without caches beside each other.

use bdtree_runtime::{
    Asset, LeafSlot, NodeSlot, PairContact, PairStackEntry, Pose, StepCache, TrianglePair, query,
};

/// A cache of each size, for each side, to be used over many steps.
#[derive(Debug)]
pub struct PairCaches(Vec<(usize, [Cache; 2])>);

type Cache = StepCache<Vec<NodeSlot>, Vec<LeafSlot>>;

impl PairCaches {
    /// From one slot up to a slot for every node.
    pub fn new(asset: &Asset<'_>) -> Self {
        let all = (asset.node_count(), asset.triangle_count());
        let sizes = [(1, 1), (0, 5), (40, 0), (64, 64), all];
        Self(
            sizes
                .into_iter()
                .map(|(nodes, leaves)| {
                    let cache =
                        StepCache::new(vec![NodeSlot::EMPTY; nodes], vec![LeafSlot::EMPTY; leaves]);
                    (nodes, [cache.clone(), cache])
                })
                .collect(),
        )
    }

    /// The triangle pairs that all ways to ask find, ascending.
    ///
    /// # Panics
    /// When they differ, or a node is evaluated again although it was kept.
    pub fn pairs(
        &mut self,
        asset: &Asset<'_>,
        [a, b]: [&Pose<'_>; 2],
        tolerance: f64,
    ) -> Vec<(u32, u32)> {
        let mut stack = vec![PairStackEntry::default(); asset.pair_stack_len(asset)];
        let mut plain: Vec<PairContact> = Vec::new();
        let (one, two) = ((asset, a), (asset, b));
        let outcome = query::pair(one, two, tolerance, &mut stack, &mut plain).expect("pair");
        assert!(!outcome.truncated);
        assert!(outcome.nodes_updated <= outcome.nodes_visited);
        let mut ids: Vec<TrianglePair> = Vec::new();
        let again = query::touching(one, two, tolerance, &mut stack, &mut ids).expect("touching");
        assert_eq!(outcome, again);
        same(&plain, &ids);
        let most = 2 * asset.node_count() as u64;
        for (nodes, [cache_a, cache_b]) in &mut self.0 {
            let (mut a, mut b) = (cache_a.start(a), cache_b.start(b));
            let mut contacts: Vec<PairContact> = Vec::new();
            let (one, two) = ((asset, &mut a), (asset, &mut b));
            let first = query::pair(one, two, tolerance, &mut stack, &mut contacts).expect("pair");
            assert_eq!(contacts, plain);
            assert_eq!(first.nodes_visited, outcome.nodes_visited);
            ids.clear();
            let (one, two) = ((asset, &mut a), (asset, &mut b));
            let second =
                query::touching(one, two, tolerance, &mut stack, &mut ids).expect("touching");
            same(&plain, &ids);
            assert!(second.nodes_updated <= first.nodes_updated);
            if *nodes >= asset.node_count() {
                // Each node that is visited is evaluated once in the step.
                assert!(first.nodes_updated <= most.min(outcome.nodes_updated));
                assert_eq!(second.nodes_updated, 0);
            }
        }
        let mut pairs: Vec<(u32, u32)> = plain
            .iter()
            .map(|c| (c.triangle1.0, c.triangle2.0))
            .collect();
        pairs.sort_unstable();
        pairs
    }
}

fn same(contacts: &[PairContact], ids: &[TrianglePair]) {
    let of = |c: &PairContact| TrianglePair {
        triangle1: c.triangle1,
        triangle2: c.triangle2,
    };
    assert_eq!(contacts.iter().map(of).collect::<Vec<_>>(), ids);
}
