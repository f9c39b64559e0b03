//! Two bodies in contact.

use std::hint::black_box;
use std::time::Instant;

use bdtree_build::tree::Split;
use bdtree_fixtures::poses::rng;
use bdtree_runtime::narrow::triangles_intersect;
use bdtree_scenes::bounds::body::Body;
use bdtree_scenes::bounds::bound::{Bound, Wrapped};
use bdtree_scenes::bounds::contenders::{Contender, contenders};
use bdtree_scenes::bounds::overlap::{BoxTest, Relation};
use bdtree_scenes::bounds::pair::{Filter, PairCounts, Weights, near_triangles, pair};
use bdtree_scenes::bounds::posed::Posed;
use bdtree_scenes::bounds::scene::{self, Mesh};
use bdtree_scenes::bounds::sphere::Growth;
use nalgebra::{Isometry3, Vector3};

use super::table::Table;
use super::{Arguments, Costs};

/// Columns of tables of pairs.
pub(super) const COLUMNS: [&str; 12] = [
    "numbers per lane",
    "updates",
    "1 × 8 tests",
    "leaf pairs",
    "triangle pairs",
    "leaf pairs, boxed",
    "triangle pairs, boxed",
    "near pairs",
    "vertices",
    "contacts",
    "nodes µs",
    "all µs",
];

/// The bumpy sphere, twice.
pub(super) struct Bodies {
    pub(super) mesh: Mesh,
    pub(super) fields: Vec<Vec<Vector3<f64>>>,
    pub(super) body: Body,
    product: Wrapped,
    best: Wrapped,
}

/// Poses of both and the second's place in the first's frame.
pub(super) struct Frame {
    pub(super) qa: Vec<f64>,
    qb: Vec<f64>,
    place: Isometry3<f64>,
}

impl Bodies {
    pub(super) fn new(arguments: &Arguments) -> Self {
        let mesh = scene::bumpy_sphere(arguments.cuts);
        let fields = scene::smooth_fields(&mesh, 10, 2.5, &mut rng(arguments.seed));
        let body = mesh.body(&fields, Split::Cost, 4);
        Self {
            product: Wrapped::new(&body, Bound::Ball(Growth::SecondOrder)),
            best: Wrapped::new(&body, Bound::Wrapped),
            mesh,
            fields,
            body,
        }
    }

    /// Contacts of 200 to 400 touching pairs.
    pub(super) fn frames(&self, displacement: Option<f64>, arguments: &Arguments) -> Vec<Frame> {
        let mut rng = rng(arguments.seed + 1);
        let diagonal = self.mesh.diagonal();
        let mut frames = Vec::new();
        while frames.len() < arguments.poses {
            let qa = scene::pose(&self.body, diagonal, displacement, &mut rng);
            let qb = scene::pose(&self.body, diagonal, displacement, &mut rng);
            let (turn, along) = (scene::rotation(&mut rng), scene::direction(&mut rng));
            let mut frame = Frame {
                qa,
                qb,
                place: Isometry3::identity(),
            };
            let (mut near, mut far) = (0.8, 4.5);
            for _ in 0..40 {
                let middle = 0.5 * (near + far);
                frame.place = scene::placed(turn, along, middle);
                match self.contacts(&frame) {
                    0..200 => far = middle,
                    200..=400 => {
                        frames.push(frame);
                        break;
                    }
                    _ => near = middle,
                }
            }
        }
        frames
    }

    fn contacts(&self, frame: &Frame) -> u64 {
        let relation = Relation::new(BoxTest::Full, &[], &frame.place);
        let [mut a, mut b] = frame.posed(&self.body, &self.product, false);
        pair(&mut a, &mut b, &relation, Filter::Parent).contacts
    }

    /// All contenders on the same contacts.
    pub(super) fn table(&self, title: &str, frames: &[Frame], costs: &Costs) -> Table {
        let mut table = Table::new(title, &COLUMNS);
        let exact = exact_ns(&self.body, &self.product, frames);
        for contender in contenders() {
            let wrapped = Wrapped::new(&self.body, contender.bound);
            let all = measure(&self.body, &wrapped, &self.best, &contender, frames);
            table.push(
                contender.name,
                row(&all, &contender, &weights(&contender, costs, exact)),
            );
        }
        table
    }
}

impl Frame {
    fn posed<'a>(&'a self, body: &'a Body, wrapped: &'a Wrapped, hulls: bool) -> [Posed<'a>; 2] {
        [
            Posed::new(body, wrapped, &self.qa, Isometry3::identity(), hulls),
            Posed::new(body, wrapped, &self.qb, self.place, hulls),
        ]
    }
}

/// Counts of a contender in each frame; `best` is what hot nodes are refitted to.
pub(super) fn measure(
    body: &Body,
    wrapped: &Wrapped,
    best: &Wrapped,
    contender: &Contender,
    frames: &[Frame],
) -> Vec<PairCounts> {
    let one = |frame: &Frame| {
        let hulls = contender.boxes == BoxTest::Hull;
        let relation = Relation::new(contender.boxes, &wrapped.directions, &frame.place);
        let [mut a, mut b] = frame.posed(body, wrapped, hulls);
        let counts = pair(&mut a, &mut b, &relation, contender.filter);
        let Some(limit) = contender.hot else {
            return counts;
        };
        let hot = [a.hot(limit), b.hot(limit)];
        let [a, b] = frame.posed(body, wrapped, hulls);
        let [hot_a, hot_b] = hot;
        let (mut a, mut b) = (a.with_refitted(best, hot_a), b.with_refitted(best, hot_b));
        pair(&mut a, &mut b, &relation, contender.filter)
    };
    frames.iter().map(one).collect()
}

/// Means over the frames, in the order of [`COLUMNS`].
pub(super) fn row(all: &[PairCounts], contender: &Contender, weights: &Weights) -> Vec<f64> {
    let mean = |of: &dyn Fn(&PairCounts) -> f64| {
        let sum: f64 = all.iter().map(of).sum();
        sum / all.len() as f64
    };
    let count = |of: fn(&PairCounts) -> u64| mean(&|counts| of(counts) as f64).round();
    vec![
        contender.bound.numbers(10) as f64,
        count(|c| c.updates),
        count(|c| c.wide_tests),
        count(|c| c.leaf_pairs),
        count(|c| c.triangle_pairs),
        count(|c| c.boxed_leaf_pairs),
        count(|c| c.boxed_triangle_pairs),
        count(|c| c.near_triangle_pairs),
        count(|c| c.vertices),
        count(|c| c.contacts),
        mean(&|c| c.node_ns(weights)) / 1e3,
        mean(&|c| c.all_ns(weights)) / 1e3,
    ]
}

pub(super) fn weights(contender: &Contender, costs: &Costs, triangle_pair: f64) -> Weights {
    Weights {
        update: costs.update(contender.bound, 10),
        test: costs.tests.of(contender),
        leaf_pair: costs.tests.three,
        vertex: costs.vertex,
        triangle_pair,
    }
}

/// Nanoseconds of the exact test of two triangles whose boxes meet.
pub(super) fn exact_ns(body: &Body, wrapped: &Wrapped, frames: &[Frame]) -> f64 {
    let mut pairs = Vec::new();
    for frame in frames {
        let [mut a, mut b] = frame.posed(body, wrapped, false);
        let relation = Relation::new(BoxTest::Full, &[], &frame.place);
        pairs.extend(near_triangles(&mut a, &mut b, &relation));
    }
    let mut rounds = Vec::new();
    for _ in 0..15 {
        let start = Instant::now();
        let touching = pairs.iter().filter(|[a, b]| triangles_intersect(a, b));
        black_box(touching.count());
        rounds.push(start.elapsed().as_secs_f64() * 1e9 / pairs.len().max(1) as f64);
    }
    bdtree_baselines::stats::median(&rounds)
}
