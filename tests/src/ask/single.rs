//! Every query of one asset.

use bdtree_runtime::narrow::Frustum;
use bdtree_runtime::{
    Asset, Contact, Pose, Posed, Proxy, RayHit, SearchEntry, SliceSink, StackEntry, Transform,
    query,
};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::instance::{Instance, cache};
use super::{Answers, some_q};

/// Asks with the pose alone, and then once more in some other way.
pub(super) fn ask(asset: &Asset<'_>, pose: &Pose<'_>, rng: &mut Pcg64Mcg, answers: &mut Answers) {
    let mut asker = Asker::new(asset, pose, rng, answers);
    asker.everything(Instance::plain(pose));
    let bounded = asker.rng.random_bool(0.4);
    let mut cache = cache();
    if asker.rng.random_bool(0.4) {
        let mut instance = Instance::plain(pose);
        if !bounded {
            instance = Instance::cached(cache.start(pose));
            asker.everything_twice(instance);
        } else {
            instance = instance.bounded(asset, asker.rng);
            asker.everything(instance);
        }
    } else {
        // Steps from another pose: its spheres, grown.
        let (start, mut memory) = (some_q(asset, asker.rng), vec![0.0; asset.pose_len()]);
        let start = Pose::new(asset, &start, Transform::IDENTITY, &mut memory).expect("a pose");
        cache.start(&start);
        let cached = cache.follow(asset, &start, pose).expect("its own pose");
        if let Some(growth) = asker.answers.read(cached.growth(asset)) {
            assert!(!(growth < 0.0), "growth {growth}");
        }
        let mut instance = Instance::cached(cached);
        if bounded {
            instance = instance.bounded(asset, asker.rng);
        }
        asker.everything(instance);
    }
    asker.budgets();
}

/// Arguments and memory for the queries of one file.
struct Asker<'k, 'a> {
    asset: &'k Asset<'a>,
    pose: &'k Pose<'k>,
    rng: &'k mut Pcg64Mcg,
    answers: &'k mut Answers,
    stack: Vec<StackEntry>,
    point: [f64; 3],
    direction: [f64; 3],
    size: f64,
}

impl<'k, 'a> Asker<'k, 'a> {
    fn new(
        asset: &'k Asset<'a>,
        pose: &'k Pose<'k>,
        rng: &'k mut Pcg64Mcg,
        answers: &'k mut Answers,
    ) -> Self {
        // About the size of the asset, where that can be told.
        let sphere = answers.take(query::root_sphere(asset, pose));
        let (center, radius) = sphere.map_or(([0.0; 3], 1.0), |s| (s.center, s.radius));
        assert!(
            radius >= 0.0 && center.iter().all(|x| x.is_finite()),
            "{sphere:?}"
        );
        let size = radius.min(1e28) * [1e-3, 0.1, 0.5, 3.0][rng.random_range(0..4)];
        let reach = radius.min(1e28);
        let point = center.map(|c| (c + reach * rng.random_range(-1.0..1.0)).clamp(-1e29, 1e29));
        let mut direction = [0; 3].map(|_| rng.random_range(-1.0..1.0));
        direction[rng.random_range(0..3)] = [0.0, 1.0][rng.random_range(0..2)];
        direction[0] += 1e-3;
        Self {
            asset,
            pose,
            stack: vec![StackEntry::default(); asset.stack_len()],
            rng,
            answers,
            point,
            direction,
            size,
        }
    }

    fn visits(&self, visited: u64, queries: u64) {
        let most = queries * self.asset.node_count() as u64;
        assert!(visited <= most, "{visited} visits, {most} at most");
    }

    fn contacts(
        &mut self,
        ask: impl FnOnce(
            &mut [StackEntry],
            &mut Vec<Contact>,
        ) -> Result<query::Outcome, bdtree_runtime::QueryError>,
    ) {
        let mut found = Vec::new();
        let outcome = ask(&mut self.stack, &mut found);
        // A sound tree holds each triangle once; a broken one is walked no longer than that.
        let most = self.asset.triangle_count();
        assert!(
            found.len() <= most,
            "{} contacts of {most} triangles",
            found.len()
        );
        if let Some(outcome) = self.answers.take(outcome) {
            self.visits(outcome.nodes_visited, 1);
            assert!(outcome.nodes_updated <= outcome.nodes_visited && !outcome.truncated);
        }
    }

    /// Twice, so that the second round finds what the first one kept.
    fn everything_twice(&mut self, mut instance: Instance<'_>) {
        self.shapes(&mut instance);
        self.everything(instance);
    }

    fn everything(&mut self, mut instance: Instance<'_>) {
        self.shapes(&mut instance);
        self.nearest(&mut instance);
        self.many_rays(&mut instance);
    }

    fn shapes(&mut self, instance: &mut Instance<'_>) {
        let asset = self.asset;
        let (point, direction, size) = (self.point, self.direction, self.size);
        let end = [0, 1, 2].map(|k| point[k] + size * direction[k]);
        let turned = [0.0, 0.6, 0.0, 0.8];
        let half = [size, 0.5 * size, 2.0 * size];
        let offset = direction[0] * point[0] + direction[1] * point[1] + direction[2] * point[2];
        let offset = offset.clamp(-1e30, 1e30);
        let posed = instance.posed();
        self.contacts(|stack, found| query::ball(asset, posed, point, size, stack, found));
        let posed = instance.posed();
        self.contacts(|stack, found| query::plane(asset, posed, direction, offset, stack, found));
        let posed = instance.posed();
        self.contacts(|stack, found| query::capsule(asset, posed, point, end, size, stack, found));
        let posed = instance.posed();
        self.contacts(|stack, found| {
            query::cuboid(asset, posed, point, turned, half, stack, found)
        });
        // A sink that is full at once.
        let mut slots = [Contact::EMPTY; 2];
        let mut sink = SliceSink::new(&mut slots);
        let (posed, stack) = (instance.posed(), &mut self.stack);
        let found = query::ball(asset, posed, point, 4.0 * size, stack, &mut sink);
        self.answers.take(found);
        let mut sink = SliceSink::new(&mut []);
        let posed = Posed::from(self.pose).bounded(0, &mut sink as &mut SliceSink<'_, Proxy>);
        let mut none: Vec<Contact> = Vec::new();
        let found = query::ball(asset, posed, point, 4.0 * size, &mut self.stack, &mut none);
        self.answers.take(found);
        let [x, y, z] = direction;
        let planes = [[x, y, z, -offset], [-x, 0.5 * y, z, offset + size]];
        let planes = planes.map(|p| [p[0], p[1], p[2], p[3].clamp(-1e25, 1e25)]);
        let planes = Frustum::new(&planes).expect("planes");
        let found = query::frustum(asset, instance.posed(), &planes, &mut self.stack);
        if let Some(outcome) = self.answers.take(found) {
            assert!(outcome.nodes_visited <= 1 + asset.node_count() as u64);
        }
    }

    fn nearest(&mut self, instance: &mut Instance<'_>) {
        let (asset, point, direction) = (self.asset, self.point, self.direction);
        let limit = [f64::INFINITY, self.size, 0.0][self.rng.random_range(0..3)];
        let stack = &mut self.stack;
        let near = query::closest(asset, instance.posed(), point, limit, stack);
        let visited = self.answers.take(near).map_or(0, |near| near.nodes_visited);
        self.visits(visited, 1);
        let origin = [0, 1, 2].map(|k| point[k] - self.size * direction[k]);
        let stack = &mut self.stack;
        let hit = query::ray(asset, instance.posed(), origin, direction, limit, stack);
        let visited = self.answers.take(hit).map_or(0, |hit| hit.nodes_visited);
        self.visits(visited, 1);
        let stack = &mut self.stack;
        let any = query::ray_any(asset, instance.posed(), origin, direction, limit, stack);
        let visited = self.answers.take(any).map_or(0, |any| any.nodes_visited);
        self.visits(visited, 1);
        let mut hits: Vec<RayHit> = Vec::new();
        let stack = &mut self.stack;
        let posed = instance.posed();
        let all = query::ray_all(asset, posed, origin, direction, limit, stack, &mut hits);
        assert!(hits.len() <= asset.triangle_count());
        let visited = self.answers.take(all).map_or(0, |all| all.nodes_visited);
        self.visits(visited, 1);
    }

    fn many_rays(&mut self, instance: &mut Instance<'_>) {
        let asset = self.asset;
        let rays: Vec<query::Ray> = [-1.0, 0.5, 2.0]
            .iter()
            .map(|along| query::Ray {
                origin: [0, 1, 2].map(|k| self.point[k] + along * self.size * self.direction[k]),
                direction: self.direction.map(|c| c * along),
                max_distance: f64::INFINITY,
            })
            .collect();
        let mut hits = [None; 3];
        let found = query::rays(asset, instance.posed(), &rays, &mut self.stack, &mut hits);
        let visited = self.answers.take(found).map_or(0, |o| o.nodes_visited);
        self.visits(visited, 3);
        let mut any = [false; 3];
        let found = query::rays_any(asset, instance.posed(), &rays, &mut self.stack, &mut any);
        let visited = self.answers.take(found).map_or(0, |o| o.nodes_visited);
        self.visits(visited, 3);
        let mut all: Vec<(usize, RayHit)> = Vec::new();
        let found = query::rays_all(asset, instance.posed(), &rays, &mut self.stack, &mut all);
        assert!(all.len() <= 3 * asset.triangle_count());
        let visited = self.answers.take(found).map_or(0, |o| o.nodes_visited);
        self.visits(visited, 3);
    }

    fn budgets(&mut self) {
        let (asset, pose, point) = (self.asset, self.pose, self.point);
        let max_visits = [0, 1, 20, u64::MAX][self.rng.random_range(0..4)];
        let length = query::Budget::queue_len(max_visits).min(300);
        let mut queue = vec![SearchEntry::default(); self.rng.random_range(0..=length)];
        let mut budget = query::Budget::new(max_visits, &mut queue);
        let most = max_visits.min(asset.node_count() as u64);
        if let Some(near) = self
            .answers
            .take(budget.closest(asset, pose, point, f64::INFINITY))
        {
            assert!(near.nodes_visited <= most && !near.at_least.is_nan());
        }
        let hit = budget.ray(asset, pose, point, self.direction, f64::INFINITY);
        if let Some(hit) = self.answers.take(hit) {
            assert!(hit.nodes_visited <= most && !hit.at_least.is_nan());
        }
        let mut found: Vec<Contact> = Vec::new();
        let ball = budget.ball(asset, pose, point, self.size, &mut found);
        assert!(found.len() <= asset.triangle_count());
        if let Some(ball) = self.answers.take(ball) {
            assert!(ball.nodes_visited <= most);
            assert!(ball.found.triangles <= asset.triangle_count() as u64);
        }
    }
}
