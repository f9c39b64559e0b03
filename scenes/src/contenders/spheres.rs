//! What contenders test, counted outside the clock: one test is one sphere (or box) against the question.

use std::error::Error;

use bdtree_format::{LANES, ROW_RADIUS};
use bdtree_measure::paper_tree::{PaperTree, Spheres, Step};
use bdtree_runtime::{Ball, CacheSize, Contact, Pose, StepCache, Workspace};

/// Tests, and how much larger than at rest the tested spheres were.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Tested {
    /// Spheres tested.
    pub tests: u64,
    /// Sum of R'/R over them, R that of the same node's sphere at rest.
    pub growth: f64,
}

impl Tested {
    /// Mean R'/R; NaN of none.
    pub fn mean_growth(&self) -> f64 {
        self.growth / self.tests as f64
    }

    fn add(&mut self, growth: f64) {
        self.tests += 1;
        self.growth += growth;
    }
}

/// Spheres of a binary tree that count how often they are asked for.
#[derive(Debug)]
pub struct Counting<'s, S> {
    /// Those that are counted.
    pub spheres: &'s mut S,
    /// So far; R is the paper's wrapped sphere.
    pub tested: &'s mut Tested,
}

impl<S: Spheres> Spheres for Counting<'_, S> {
    fn sphere(&mut self, tree: &PaperTree, node: usize) -> [f32; 4] {
        let found = self.spheres.sphere(tree, node);
        let [_, _, _, rest] = tree.numbers(node)[0];
        self.tested.add(f64::from(found[3]) / f64::from(rest));
        found
    }

    fn vertex(&mut self, vertex: u32) -> [f64; 3] {
        self.spheres.vertex(vertex)
    }
}

/// Adds what the product's ball query tests, a test for every occupied lane of a visited node, R being the lane's own
/// sphere at rest; the number of these nodes.
///
/// # Errors
/// Those of the query.
pub fn of_ball(
    pose: &Pose<'_>,
    (center, radius): ([f64; 3], f64),
    tested: &mut Tested,
) -> Result<u64, Box<dyn Error>> {
    // With a slot for every node what is kept is what was visited.
    let asset = pose.asset();
    let nodes = asset.node_count();
    let mut cache = StepCache::new(CacheSize { nodes, leaves: 0 });
    cache.start(pose);
    let mut workspace = Workspace::new();
    let mut found: Vec<Contact> = Vec::new();
    let mut query = pose.query(&mut workspace).cached(&mut cache);
    query.contacts(Ball::new(center, radius), &mut found)?;
    for index in (0..nodes as u32).filter(|index| cache.keeps(*index)) {
        let node = &asset.nodes()[index as usize];
        let rest = asset.node_rows(node)?.leading[ROW_RADIUS];
        let spheres = pose.node_spheres(index)?;
        let taken = (0..LANES).filter(|k| (node.inner_mask | node.leaf_mask) >> k & 1 == 1);
        for k in taken {
            tested.add(f64::from(spheres.radius[k]) / f64::from(rest[k]));
        }
    }
    Ok(workspace.stats().nodes_visited)
}

/// Sum and number of R'/R over all spheres above a thousandth of the largest: the product's and the paper's.
///
/// # Errors
/// Records that break the format's rules.
pub fn sum_growths(tree: &PaperTree, pose: &Pose<'_>) -> Result<[[f64; 2]; 2], Box<dyn Error>> {
    let asset = pose.asset();
    let mut sums = [[0.0; 2]; 2];
    let mut step = Step::default();
    step.prepare(pose);
    let least = tree.numbers(0)[0][3] * 1e-3;
    let mut add = |who: usize, growth: f64| {
        sums[who][0] += growth;
        sums[who][1] += 1.0;
    };
    for index in 0..asset.node_count() as u32 {
        let rest = asset.node_rows(&asset.nodes()[index as usize])?.leading[ROW_RADIUS];
        let spheres = pose.node_spheres(index)?;
        for k in (0..LANES).filter(|k| rest[*k] > least) {
            add(0, f64::from(spheres.radius[k] / rest[k]));
        }
    }
    for node in 0..tree.node_count() {
        let rest = tree.numbers(node)[0][3];
        if rest > least {
            add(1, f64::from(tree.sphere(&step, node)[3] / rest));
        }
    }
    Ok(sums)
}
