//! A pose in each of the ways in which queries take one.

use bdtree_runtime::{Asset, CachedPose, LeafSlot, NodeSlot, Pose, Posed, Proxy, StepCache};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// A cache of a size that does not fit.
pub(super) type Cache = StepCache<[NodeSlot; 20], [LeafSlot; 4]>;

pub(super) fn cache() -> Cache {
    StepCache::new([NodeSlot::EMPTY; 20], [LeafSlot::EMPTY; 4])
}

/// A pose, perhaps with what a step keeps, perhaps not looked into below a level.
pub(super) struct Instance<'p> {
    pose: &'p Pose<'p>,
    cached: Option<CachedPose<'p>>,
    level: Option<usize>,
    proxies: Vec<Proxy>,
}

impl<'p> Instance<'p> {
    /// The pose alone.
    pub(super) fn plain(pose: &'p Pose<'p>) -> Self {
        Self {
            pose,
            cached: None,
            level: None,
            proxies: Vec::new(),
        }
    }

    /// The pose with a cache.
    pub(super) fn cached(cached: CachedPose<'p>) -> Self {
        Self {
            pose: cached.pose(),
            cached: Some(cached),
            level: None,
            proxies: Vec::new(),
        }
    }

    /// The same down to some level.
    pub(super) fn bounded(mut self, asset: &Asset<'_>, rng: &mut Pcg64Mcg) -> Self {
        self.level = Some(rng.random_range(0..=asset.depth()));
        self
    }

    /// For one query.
    pub(super) fn posed(&mut self) -> Posed<'_> {
        self.proxies.clear();
        let posed = match &mut self.cached {
            Some(cached) => Posed::from(cached),
            None => Posed::from(self.pose),
        };
        match self.level {
            Some(level) => posed.bounded(level, &mut self.proxies),
            None => posed,
        }
    }
}
