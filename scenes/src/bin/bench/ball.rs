//! A small ball against a deforming mesh: the product beside the paper's tree, plain and with care.

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use bdtree_fixtures::poses;
use bdtree_measure::ours::Ours;
use bdtree_measure::paper_tree::{BallCounts, PaperTree, PlainTree, Step, Vertices};
use bdtree_measure::{machine, stats};
use bdtree_runtime::{Asset, Contact, Model, Transform, TriangleId};
use bdtree_scenes::contenders::spheres::sum_growths;
use clap::Args;
use rand::RngExt;
use serde_json::{Value, json};

use crate::scene::Scene;

#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: Scene,
    /// Balls, each with its own q
    #[arg(long, default_value_t = 400)]
    balls: usize,
    /// Radius over the diagonal of the box
    #[arg(long, default_value_t = 0.01)]
    radius: f64,
    /// Largest displacement over the diagonal of the box; each q reaches half of it or more
    #[arg(long, default_value_t = 0.1)]
    displacement: f64,
    /// Balls are centerd up to this many radii from a vertex (half of them up to half of it)
    #[arg(long, default_value_t = 2.0)]
    spread: f64,
    /// Rounds; in each all contenders answer all balls, taking turns to be first
    #[arg(long, default_value_t = 31)]
    rounds: usize,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// One frame: a pose and a ball.
struct Case {
    q: Vec<f32>,
    center: [f64; 3],
    radius: f64,
}

/// Small balls at and near the deformed surface: half are centerd within half the spread of a
/// triangle's first corner, the others within the spread.
fn cases(asset: &Asset<'_>, arguments: &Arguments) -> Result<Vec<Case>, Box<dyn Error>> {
    let mut rng = poses::rng(arguments.scene.seed);
    let mut memory = vec![0.0; asset.pose_len()];
    let radius = arguments.radius * poses::diagonal(asset) * asset.unit();
    let mut all = Vec::with_capacity(arguments.balls);
    for i in 0..arguments.balls {
        let share = arguments.displacement * rng.random_range(0.5..1.0);
        let q = poses::random_q(asset, share, &mut rng);
        let pose = asset.pose(&q, Transform::IDENTITY, &mut memory)?;
        let id = TriangleId(rng.random_range(0..asset.triangle_count() as u32));
        let mut center = pose.deformed(asset.triangle(id)?[0])?;
        let far = arguments.spread * if i % 2 == 0 { 0.5 } else { 1.0 };
        for c in &mut center {
            *c += far * radius * rng.random_range(-1.0..1.0) / 3.0_f64.sqrt();
        }
        all.push(Case { q, center, radius });
    }
    Ok(all)
}

/// Nodes that the product visits for a case.
fn ask(product: &mut Ours<'_>, case: &Case) -> u64 {
    let answer = product.balls(&case.q, [(case.center, case.radius)].into_iter());
    answer
        .expect("a sound asset at q within its limits")
        .nodes
        .visited
}

/// The paper's tree with the memory that it queries in.
struct Paper<'a> {
    asset: Asset<'a>,
    tree: PaperTree,
    plain: PlainTree,
    memory: Vec<f32>,
    step: Step,
    vertices: Vertices,
    stack: Vec<u32>,
    found: Vec<Contact>,
}

impl Paper<'_> {
    fn answer(&mut self, case: &Case) -> BallCounts {
        let pose = self
            .asset
            .pose(&case.q, Transform::IDENTITY, &mut self.memory);
        let pose = pose.expect("q within limits");
        self.step.prepare(&pose);
        self.vertices.begin_step();
        self.found.clear();
        self.tree.ball(
            &pose,
            &self.step,
            (case.center, case.radius),
            (&mut self.vertices, &mut self.stack),
            &mut self.found,
        )
    }

    fn answer_plainly(&mut self, case: &Case) -> BallCounts {
        let pose = self
            .asset
            .pose(&case.q, Transform::IDENTITY, &mut self.memory);
        let pose = pose.expect("q within limits");
        self.step.prepare(&pose);
        self.found.clear();
        self.plain.ball(
            &pose,
            &self.step,
            (case.center, case.radius),
            &mut self.stack,
            &mut self.found,
        )
    }
}

fn ids(found: &[Contact]) -> Vec<u32> {
    let mut ids: Vec<u32> = found.iter().map(|c| c.triangle.0).collect();
    ids.sort_unstable();
    ids
}

/// Nanoseconds per case of one pass over all of them; one clock for the pass, since reading it
/// takes as long as a few nodes.
fn time_pass(cases: &[Case], mut answer: impl FnMut(&Case)) -> f64 {
    let start = Instant::now();
    for case in cases {
        answer(black_box(case));
    }
    start.elapsed().as_nanos() as f64 / cases.len() as f64
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let (mesh, basis) = arguments.scene.load()?;
    let model = Model::from_bytes(&arguments.scene.bake(&mesh, &basis)?.bytes)?;
    let asset = model.asset();
    let memory = vec![0.0; asset.pose_len()];
    let mut product = Ours::new(*asset);
    let tree = PaperTree::build(asset);
    let mut paper = Paper {
        asset: *asset,
        plain: PlainTree::of(&tree),
        tree,
        memory,
        step: Step::default(),
        vertices: Vertices::new(asset),
        stack: Vec::new(),
        found: Vec::new(),
    };
    let cases = cases(asset, arguments)?;

    let mut work = Work::default();
    for case in &cases {
        work.nodes += ask(&mut product, case);
        let counts = paper.answer(case);
        assert_eq!(
            ids(product.found()),
            ids(&paper.found),
            "both trees find the same triangles"
        );
        paper.answer_plainly(case);
        assert_eq!(ids(product.found()), ids(&paper.found), "as does the plain");
        work.contacts += product.found().len();
        work.touching += usize::from(!product.found().is_empty());
        work.paper.spheres += counts.spheres;
        work.paper.triangles += counts.triangles;
        work.count_lanes(asset, case)?;
    }

    // Times per round of the product, the tree with care and the plain one.
    let mut times: [Vec<f64>; 3] = Default::default();
    for round in 0..arguments.rounds {
        for turn in 0..3 {
            let which = (round + turn) % 3;
            times[which].push(match which {
                0 => time_pass(&cases, |case| {
                    black_box(ask(&mut product, case));
                }),
                1 => time_pass(&cases, |case| {
                    black_box(paper.answer(case));
                }),
                _ => time_pass(&cases, |case| {
                    black_box(paper.answer_plainly(case));
                }),
            });
        }
    }
    let figures = Figures {
        ns: times.each_ref().map(|t| stats::median(t)),
        care: Ratio::of(&times[1], &times[0]),
        plain: Ratio::of(&times[2], &times[0]),
    };
    let value = json!({
        "machine": machine::processor(),
        "mesh": {"name": mesh.name, "vertices": asset.vertex_count(),
            "triangles": asset.triangle_count(), "modes": asset.mode_count()},
        "balls": cases.len(), "rounds": arguments.rounds, "radius_rel": arguments.radius,
        "figures": {"product_ns": figures.ns[0], "paper_ns": figures.ns[1],
            "plain_ns": figures.ns[2],
            "ratio": figures.care.median, "ratio_quartiles": figures.care.quartiles,
            "ratio_plain": figures.plain.median,
            "ratio_plain_quartiles": figures.plain.quartiles,},
        "counts": work.per_ball(cases.len(), asset, &paper.tree),
        "growth": growth(asset, &paper.tree, &cases)?,
        "limits": limits(&work, &cases, asset, &paper),
    });
    if arguments.json {
        println!("{value:#}");
    } else {
        print(&value, &figures);
    }
    Ok(())
}

/// Nanoseconds per ball of the three contenders, and how many times the product's they take.
struct Figures {
    ns: [f64; 3],
    care: Ratio,
    plain: Ratio,
}

/// Of the rounds' quotients.
struct Ratio {
    median: f64,
    quartiles: [f64; 2],
}

impl Ratio {
    fn of(times: &[f64], base: &[f64]) -> Self {
        let all: Vec<f64> = times.iter().zip(base).map(|(t, b)| t / b).collect();
        Self {
            median: stats::median(&all),
            quartiles: [0.25, 0.75].map(|p| stats::quantile(&all, p)),
        }
    }
}

/// What all balls together took.
#[derive(Default)]
struct Work {
    nodes: u64,
    lanes: u64,
    triangles: u64,
    contacts: usize,
    touching: usize,
    paper: BallCounts,
}

impl Work {
    /// Walks the product's tree once more, outside the clock, to count occupied lanes and the
    /// triangles of touched leaf lanes.
    fn count_lanes(&mut self, asset: &Asset<'_>, case: &Case) -> Result<(), Box<dyn Error>> {
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = asset.pose(&case.q, Transform::IDENTITY, &mut memory)?;
        let (origin, unit) = (asset.origin(), asset.unit());
        let center = [0, 1, 2].map(|k| ((case.center[k] - origin[k]) / unit) as f32);
        let reach = (case.radius / unit) as f32;
        let mut stack = vec![0_u32];
        while let Some(index) = stack.pop() {
            let node = &asset.nodes()[index as usize];
            let spheres = pose.node_spheres(index)?;
            self.lanes += u64::from((node.inner_mask | node.leaf_mask).count_ones());
            let mut child = node.first_child;
            for k in 0..bdtree_format::LANES {
                let gap = (0..3)
                    .map(|i| (spheres.center[i][k] - center[i]).powi(2))
                    .sum::<f32>()
                    .sqrt();
                let apart = gap > spheres.radius[k] + reach;
                if node.inner_mask & (1 << k) != 0 {
                    if !apart {
                        stack.push(child);
                    }
                    child += 1;
                } else if !apart {
                    self.triangles += u64::from(node.leaf_counts[k]);
                }
            }
        }
        Ok(())
    }

    fn per_ball(&self, balls: usize, asset: &Asset<'_>, tree: &PaperTree) -> Value {
        let mean = |count: u64| count as f64 / balls as f64;
        json!({
            "contacts": mean(self.contacts as u64), "touching": mean(self.touching as u64),
            "product": {"nodes": mean(self.nodes), "spheres": mean(self.lanes),
                "triangles": mean(self.triangles), "tree_nodes": asset.node_count(),
                "depth": asset.depth()},
            "paper": {"nodes": mean(self.paper.spheres), "spheres": mean(self.paper.spheres),
                "triangles": mean(self.paper.triangles), "tree_nodes": tree.node_count(),
                "depth": tree.depth()},
        })
    }
}

/// Mean R'/R over all spheres above a thousandth of the largest, at the first few q.
fn growth(asset: &Asset<'_>, tree: &PaperTree, cases: &[Case]) -> Result<Value, Box<dyn Error>> {
    let mut memory = vec![0.0; asset.pose_len()];
    let mut sums = [[0.0; 2]; 2];
    for case in cases.iter().take(5) {
        let pose = asset.pose(&case.q, Transform::IDENTITY, &mut memory)?;
        let both = sum_growths(tree, &pose)?;
        for (sum, own) in sums.iter_mut().zip(both) {
            *sum = [sum[0] + own[0], sum[1] + own[1]];
        }
    }
    let [ours, theirs] = sums.map(|[sum, count]| sum / count);
    Ok(json!({"product": ours, "paper": theirs}))
}

/// What this machine allows: bytes of visited nodes over its read bandwidth, and one node
/// evaluation from near memory.
fn limits(work: &Work, cases: &[Case], asset: &Asset<'_>, paper: &Paper<'_>) -> Value {
    let m = asset.mode_count() as f64;
    let balls = cases.len() as f64;
    // The record, four leading rows, and five of a mode's six rows of 16 bits.
    let node_bytes = 32.0 + 32.0 * 4.0 + 16.0 * 5.0 * m;
    let vertex_bytes = 12.0 * (1.0 + m);
    let bytes = |nodes: u64, node: f64, triangles: u64| {
        (nodes as f64 * node + triangles as f64 * (16.0 + 0.5 * vertex_bytes)) / balls
    };
    let ours = bytes(work.nodes, node_bytes, work.triangles);
    let theirs = bytes(
        work.paper.spheres,
        paper.tree.node_bytes() as f64,
        work.paper.triangles,
    );
    let near = machine::read_bandwidth(256 << 10);
    let far = machine::read_bandwidth(16 << 20);
    json!({
        "read_l2_bytes_per_s": near, "read_16_mib_bytes_per_s": far,
        "product": {"bytes": ours, "at_l2_ns": ours / near * 1e9, "at_16_mib_ns": ours / far * 1e9},
        "paper": {"bytes": theirs, "at_l2_ns": theirs / near * 1e9,
            "at_16_mib_ns": theirs / far * 1e9},
        "product_node_ns": product_node_ns(asset, &cases[0]),
        "product_node_flops": 80.0 * m,
        "paper_node_ns": paper_node_ns(paper, &cases[0]),
        "paper_node_flops": 8.0 * m,
    })
}

/// Nodes whose numbers fit the near caches.
const NEAR_NODES: usize = 64;

fn product_node_ns(asset: &Asset<'_>, case: &Case) -> f64 {
    let mut memory = vec![0.0; asset.pose_len()];
    let Ok(pose) = asset.pose(&case.q, Transform::IDENTITY, &mut memory) else {
        return f64::NAN;
    };
    let count = NEAR_NODES.min(asset.node_count());
    near_ns(count, |i| {
        black_box(pose.node_spheres(i as u32).ok());
    })
}

fn paper_node_ns(paper: &Paper<'_>, case: &Case) -> f64 {
    let mut memory = vec![0.0; paper.asset.pose_len()];
    let Ok(pose) = paper.asset.pose(&case.q, Transform::IDENTITY, &mut memory) else {
        return f64::NAN;
    };
    let mut step = Step::default();
    step.prepare(&pose);
    near_ns(NEAR_NODES.min(paper.tree.node_count()), |i| {
        black_box(paper.tree.sphere(&step, i));
    })
}

/// Nanoseconds per call, best of several runs.
fn near_ns(count: usize, mut evaluate: impl FnMut(usize)) -> f64 {
    let runs = (0..50).map(|_| {
        let start = Instant::now();
        for _ in 0..20 {
            (0..count).for_each(&mut evaluate);
        }
        start.elapsed().as_nanos() as f64 / (20 * count) as f64
    });
    runs.fold(f64::INFINITY, f64::min)
}

fn print(value: &Value, figures: &Figures) {
    let number = |path: &str| {
        value
            .pointer(path)
            .and_then(Value::as_f64)
            .unwrap_or(f64::NAN)
    };
    println!("machine    {}", value["machine"].as_str().unwrap_or("?"));
    println!(
        "mesh       {}: {} triangles, {} modes; {} balls of {} % of the diagonal, {:.0} % touch, {:.1} contacts each",
        value["mesh"]["name"].as_str().unwrap_or("?"),
        number("/mesh/triangles"),
        number("/mesh/modes"),
        number("/balls"),
        100.0 * number("/radius_rel"),
        100.0 * number("/counts/touching"),
        number("/counts/contacts"),
    );
    println!(
        "           ns/ball   nodes  spheres  triangles   R'/R   kB read  ns at L2 / 16 MiB   ns/node near (flops)"
    );
    for (name, ns) in [("product", figures.ns[0]), ("paper", figures.ns[1])] {
        println!(
            "{name:<8} {ns:>9.0} {:>7.1} {:>8.1} {:>10.1} {:>6.3} {:>9.1} {:>9.0} / {:<7.0} {:>7.1} ({:.0})",
            number(&format!("/counts/{name}/nodes")),
            number(&format!("/counts/{name}/spheres")),
            number(&format!("/counts/{name}/triangles")),
            number(&format!("/growth/{name}")),
            number(&format!("/limits/{name}/bytes")) / 1e3,
            number(&format!("/limits/{name}/at_l2_ns")),
            number(&format!("/limits/{name}/at_16_mib_ns")),
            number(&format!("/limits/{name}_node_ns")),
            number(&format!("/limits/{name}_node_flops")),
        );
    }
    println!("plain    {:>9.0}", figures.ns[2]);
    for (what, ratio) in [
        ("the paper's tree, plain", &figures.plain),
        ("the paper's tree, with care", &figures.care),
    ] {
        println!(
            "ratio      {:.2} to {what}, median of rounds (quartiles {:.2} to {:.2})",
            ratio.median, ratio.quartiles[0], ratio.quartiles[1],
        );
    }
    println!(
        "reading    {:.0} GB/s from 256 KiB, {:.0} GB/s from 16 MiB; triangle sets equal",
        number("/limits/read_l2_bytes_per_s") / 1e9,
        number("/limits/read_16_mib_bytes_per_s") / 1e9,
    );
}
