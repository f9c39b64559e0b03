//! Every query of two assets, and those over steps.

use bdtree_runtime::broad::{self, GridSlot};
use bdtree_runtime::query::{self, ManifoldSlot, PairFront};
use bdtree_runtime::{
    Asset, FrontSlot, Motion, PairContact, PairStackEntry, Pose, SearchEntry, StackEntry,
    Transform, TrianglePair,
};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::instance::{Instance, cache};
use super::{Answers, some_q};

/// Where the second one stands: about the first, so that most pairs touch.
fn beside(asset: &Asset<'_>, pose: &Pose<'_>, other: &Asset<'_>, rng: &mut Pcg64Mcg) -> Transform {
    let sphere = query::root_sphere(asset, pose).ok();
    let (center, radius) = sphere.map_or(([0.0; 3], 1.0), |s| (s.center, s.radius.min(1e20)));
    let gap = radius * [0.0, 0.3, 1.0, 5.0][rng.random_range(0..4)];
    let size = crate::poses::diagonal(other) * other.unit();
    let scale = if size > 0.0 && size.is_finite() {
        radius / size
    } else {
        1.0
    };
    Transform {
        translation: center.map(|c| (c + gap * rng.random_range(-1.0..1.0)).clamp(-1e20, 1e20)),
        scale: scale.clamp(1e-9, 1e9),
        ..Transform::IDENTITY
    }
}

/// Asks of the first asset against the second, in either order.
pub(super) fn ask(
    [asset, partner]: [&Asset<'_>; 2],
    pose: &Pose<'_>,
    rng: &mut Pcg64Mcg,
    answers: &mut Answers,
) {
    let place = beside(asset, pose, partner, rng);
    let (q, mut memory) = (some_q(partner, rng), vec![0.0; partner.pose_len()]);
    let other = Pose::new(partner, &q, place, &mut memory).expect("a pose");
    let (mut a, mut b) = ((asset, pose), (partner, &other));
    if rng.random_bool(0.5) {
        (a, b) = (b, a);
    }
    let size = query::root_sphere(partner, &other).map_or(1.0, |s| s.radius);
    let tolerance = [0.0, 0.02 * size.min(1e28)][rng.random_range(0..2)];
    let mut asker = Asker {
        assets: [a.0, b.0],
        poses: [a.1, b.1],
        tolerance,
        stack: vec![PairStackEntry::default(); a.0.pair_stack_len(b.0)],
        rng,
        answers,
    };
    let pairs = asker.pairs();
    asker.bounded();
    asker.distances();
    asker.manifold(pairs);
    asker.steps();
    asker.broad();
}

struct Asker<'k, 'a> {
    assets: [&'k Asset<'a>; 2],
    poses: [&'k Pose<'k>; 2],
    tolerance: f64,
    stack: Vec<PairStackEntry>,
    rng: &'k mut Pcg64Mcg,
    answers: &'k mut Answers,
}

impl Asker<'_, '_> {
    /// SPEC 6.8, and what the search for a plane between two assets may look at.
    fn visits(&self, visited: u64) {
        let [n, m] = self.assets.map(|asset| asset.node_count() as u64);
        let most = 2 * 81 * n * m + 400;
        assert!(visited <= most, "{visited} visits, {most} at most");
    }

    /// Most pairs of triangles that can be reported.
    fn pairs_max(&self) -> usize {
        let [n, m] = self.assets.map(Asset::triangle_count);
        n * m
    }

    /// Plain and with caches, which must not matter.
    fn pairs(&mut self) -> Vec<PairContact> {
        let ([a, b], [pose_a, pose_b]) = (self.assets, self.poses);
        let mut pairs: Vec<PairContact> = Vec::new();
        let (one, two) = ((a, pose_a), (b, pose_b));
        let found = query::pair(one, two, self.tolerance, &mut self.stack, &mut pairs);
        assert!(pairs.len() <= self.pairs_max());
        let plain = self.answers.take(found);
        self.visits(plain.map_or(0, |o| o.nodes_visited));

        let (mut cache_a, mut cache_b) = (cache(), cache());
        let (mut kept_a, mut kept_b) = (cache_a.start(pose_a), cache_b.start(pose_b));
        let mut ids: Vec<TrianglePair> = Vec::new();
        let (one, two) = ((a, &mut kept_a), (b, &mut kept_b));
        let found = query::touching(one, two, self.tolerance, &mut self.stack, &mut ids);
        let cached = self.answers.take(found);
        let visits = [cached, plain].map(|o| o.map(|o| o.nodes_visited));
        assert_eq!(visits[0], visits[1]);
        assert!(plain.is_none() || ids.len() == pairs.len());
        pairs
    }

    /// One side or both down to a level.
    fn bounded(&mut self) {
        let ([a, b], [pose_a, pose_b]) = (self.assets, self.poses);
        let mut first = Instance::plain(pose_a).bounded(a, self.rng);
        let mut second = Instance::plain(pose_b);
        if self.rng.random_bool(0.5) {
            second = second.bounded(b, self.rng);
        }
        let mut pairs: Vec<PairContact> = Vec::new();
        let (one, two) = ((a, first.posed()), (b, second.posed()));
        let found = query::pair(one, two, self.tolerance, &mut self.stack, &mut pairs);
        assert!(pairs.len() <= self.pairs_max());
        if let Some(outcome) = self.answers.take(found) {
            self.visits(outcome.nodes_visited);
        }
    }

    fn distances(&mut self) {
        let ([a, b], [pose_a, pose_b]) = (self.assets, self.poses);
        let mut search = vec![SearchEntry::default(); a.distance_stack_len(b)];
        let found = query::distance((a, pose_a), (b, pose_b), f64::INFINITY, &mut search);
        if let Some(near) = self.answers.take(found) {
            self.visits(near.nodes_visited);
        }
        let visits = [3, 30, u64::MAX][self.rng.random_range(0..3)];
        let mut budget = query::Budget::new(visits, &mut search);
        let found = budget.distance((a, pose_a), (b, pose_b), f64::INFINITY);
        if let Some(near) = self.answers.take(found) {
            assert!(near.nodes_visited <= visits && !near.at_least.is_nan());
            self.visits(near.nodes_visited);
        }
    }

    /// Of what was found, or of any ids.
    fn manifold(&mut self, mut pairs: Vec<PairContact>) {
        let ([a, b], [pose_a, pose_b]) = (self.assets, self.poses);
        pairs.truncate(40);
        if pairs.is_empty() {
            pairs = vec![PairContact::EMPTY; 2];
            for pair in &mut pairs {
                pair.triangle1.0 = self.rng.random_range(0..a.triangle_count() as u32);
                pair.triangle2.0 = self.rng.random_range(0..b.triangle_count() as u32);
            }
        }
        let mut slots = vec![ManifoldSlot::default(); ManifoldSlot::count(pairs.len())];
        let mut stack = vec![StackEntry::default(); a.stack_len().max(b.stack_len())];
        let mut regions: Vec<query::ContactRegion> = Vec::new();
        let (one, two) = ((a, pose_a), (b, pose_b));
        let memory = &mut slots;
        let found = query::manifold(one, two, &mut pairs, memory, &mut stack, &mut regions);
        self.answers.take(found);
        for region in &regions {
            assert!(matches!(region.points().len(), 1 | 4));
        }
    }

    /// Steps with motions and a front; every other one asks for ids only.
    fn steps(&mut self) {
        let ([a, b], [pose_a, pose_b]) = (self.assets, self.poses);
        let slots = [0, 3, 100][self.rng.random_range(0..3)];
        let mut front = PairFront::new(vec![FrontSlot::EMPTY; slots]);
        let mut motion_a = Motion::new(pose_a);
        let mut motion_b = Motion::new(pose_b);
        let mut memories = [0; 5].map(|_| vec![0.0; a.pose_len()]);
        let speed = [0.0, 1e-6, 1e-2][self.rng.random_range(0..3)];
        let mut before = *pose_a;
        for (step, memory) in memories.iter_mut().enumerate() {
            let q: Vec<f32> = pose_a
                .q()
                .iter()
                .map(|q| q * (1.0 - speed * step as f32))
                .collect();
            let now = Pose::new(a, &q, Transform::IDENTITY, memory).expect("a pose");
            let moved = motion_a.advance(a, &before, &now);
            if self.answers.take(moved).is_none() {
                return;
            }
            assert!(motion_a.total() >= 0.0);
            before = now;
            let still = motion_b.advance(b, pose_b, pose_b);
            if self.answers.take(still).is_none() {
                return;
            }
            let (one, two) = ((a, &now, &motion_a), (b, pose_b, &motion_b));
            let found = if step % 2 == 0 {
                let mut pairs: Vec<PairContact> = Vec::new();
                front.pair(one, two, self.tolerance, &mut self.stack, &mut pairs)
            } else {
                let mut ids: Vec<TrianglePair> = Vec::new();
                front.touching(one, two, self.tolerance, &mut self.stack, &mut ids)
            };
            if let Some(outcome) = self.answers.take(found) {
                self.visits(outcome.nodes_visited);
            }
        }
    }

    fn broad(&mut self) {
        let mut spheres = Vec::new();
        for k in 0..2 {
            let sphere = query::root_sphere(self.assets[k], self.poses[k]);
            spheres.extend(self.answers.take(sphere));
        }
        // Beyond 2^100 nothing is a sphere any more.
        let fits = |s: &query::BoundingSphere| {
            s.radius <= 1e30 && s.center.iter().all(|x| x.abs() <= 1e30)
        };
        spheres.retain(fits);
        let mut slots = vec![GridSlot::EMPTY; broad::grid_slots(spheres.len())];
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        let found = broad::pairs(&spheres, self.tolerance, &mut slots, &mut pairs);
        self.answers.take(found);
        assert!(pairs.len() <= 1);
    }
}
