//! A small ball against a deforming mesh: the product beside the paper's tree, plain and with care.

use bdtree_measure::MeasureError;
use bdtree_measure::paper_tree::{BallCounts, PaperTree, PlainTree, Step, Vertices};
use bdtree_measure::stats::quantile;
use bdtree_scenes::contenders::spheres::{Tested, of_ball, sum_growths};

use crate::prelude::*;

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
    /// Balls are centered up to this many radii from a vertex (half of them up to half of it)
    #[arg(long, default_value_t = 2.0)]
    spread: f64,
}

/// The paper's tree, with care or plain, with the memory that it queries in: answers into what is found.
fn paper<'a>(
    asset: &'a Asset<'_>,
    tree: &'a PaperTree,
    plain: Option<&'a PlainTree>,
) -> impl FnMut(&Case, &mut Vec<Contact>) -> Result<BallCounts, MeasureError> + 'a {
    let (mut memory, mut step) = (vec![0.0; asset.pose_len()], Step::default());
    let (mut vertices, mut stack) = (Vertices::new(asset), Vec::new());
    move |case, found| {
        let pose = asset.pose(&case.q, Transform::IDENTITY, &mut memory)?;
        step.prepare(&pose);
        vertices.begin_step();
        found.clear();
        Ok(match plain {
            Some(plain) => plain.ball(&pose, &step, case.ball, &mut stack, found),
            None => tree.ball(&pose, &step, case.ball, (&mut vertices, &mut stack), found),
        })
    }
}

fn ids(found: &[Contact]) -> Vec<u32> {
    let mut ids: Vec<u32> = found.iter().map(|c| c.triangle.0).collect();
    ids.sort_unstable();
    ids
}

pub(crate) fn run(arguments: &Arguments, rounds: usize) -> Result<Vec<Table>> {
    let model = arguments.scene.model()?;
    let asset = *model.asset();
    let tree = PaperTree::build(&asset);
    let plain_tree = PlainTree::of(&tree);
    let mut product = Ours::new(asset);
    let mut papers = [None, Some(&plain_tree)].map(|plain| paper(&asset, &tree, plain));
    // Half of the balls are within half the spread, the others within the spread.
    let asked = (arguments.balls, arguments.radius);
    let cases = cases(&asset, asked, poses::rng(arguments.scene.seed), |i, rng| {
        let share = arguments.displacement * rng.random_range(0.5..1.0);
        let spread = arguments.spread * if i % 2 == 0 { 0.5 } else { 1.0 };
        (poses::random_q(&asset, share, rng), spread)
    })?;
    let balls = cases.len() as f64;

    // Nodes, spheres and triangles of the product, then of the paper's tree.
    let mut work = [0; 6];
    let (mut touching, mut contacts) = (0, Vec::new());
    let mut memory = vec![0.0; asset.pose_len()];
    for case in &cases {
        case.ask(&mut product)?;
        let found = ids(&product.found);
        touching += usize::from(!found.is_empty());
        let mut theirs = BallCounts::default();
        for paper in &mut papers {
            theirs = paper(case, &mut contacts)?;
            assert_eq!(found, ids(&contacts), "all find the same triangles");
        }
        let pose = asset.pose(&case.q, Transform::IDENTITY, &mut memory)?;
        let mut tested = Tested::default();
        let nodes = of_ball(&pose, case.ball, &mut tested)?;
        let triangles = touched_triangles(&pose, case.ball)?;
        let (spheres, of_paper) = (theirs.spheres, theirs.triangles);
        let own = [nodes, tested.tests, triangles, spheres, spheres, of_paper];
        for (sum, own) in work.iter_mut().zip(own) {
            *sum += own;
        }
    }

    let mut entries = vec![Entry::new("product", Role::Ours, Counts::Same, |_| {
        pass(&cases, |case| case.ask(&mut product))
    })];
    let names = ["paper's tree, with care", "paper's tree, plain"];
    entries.extend(papers.into_iter().zip(names).map(|(mut paper, name)| {
        let (cases, mut found) = (&cases, Vec::new());
        Entry::new(name, Role::Baseline, Counts::Same, move |_| {
            pass(cases, |case| {
                let mut answer = Answer::default();
                answer.nodes.visited = paper(case, &mut found)?.spheres;
                answer.found = found.len() as u64;
                Ok(answer)
            })
        })
    }));
    let measured = compare(entries, 1, rounds)?;
    let mut times = rows(&[], &measured, cases.len(), "ns per ball");
    for (row, theirs) in times.iter_mut().zip(&measured) {
        let pairs = theirs.by_repeat.iter().zip(&measured[0].by_repeat);
        let ratios: Vec<f64> = pairs.map(|(theirs, ours)| theirs / ours).collect();
        let quartile = |k: usize| quantile(&ratios, 0.25 * k as f64);
        row.extend(row! {
            "ratio of rounds" => quartile(2), "lower quartile" => quartile(1), "upper quartile" => quartile(3),
        });
    }

    // The record, four leading rows, and five of a mode's six rows of 16 bits.
    let m = asset.mode_count() as f64;
    let node_bytes = [32.0 + 32.0 * 4.0 + 16.0 * 5.0 * m, tree.node_bytes() as f64];
    let growths = growths(&asset, &tree, &cases)?;
    let near_ns = near_ns(&asset, &tree, &cases[0])?;
    let depths = [asset.depth(), tree.depth];
    let bandwidths = [256 << 10, 16 << 20].map(machine::read_bandwidth);
    let of = |k: usize| {
        let [nodes, spheres, triangles] = [0, 1, 2].map(|i| work[3 * k + i] as f64 / balls);
        // Of a touched leaf's triangles half the vertices are new.
        let bytes = nodes * node_bytes[k] + triangles * (16.0 + 6.0 * (1.0 + m));
        let [near, far] = bandwidths.map(|per_second| bytes / per_second * 1e9);
        row! {
            "contender" => ["product", "paper's tree"][k],
            "nodes" => nodes, "spheres" => spheres, "triangles" => triangles,
            "tree nodes" => [asset.node_count(), tree.node_count()][k], "depth" => depths[k],
            "R'/R" => growths[k], "bytes read" => bytes,
            "ns to read from L2" => near, "ns to read from 16 MiB" => far,
            "ns per node near" => near_ns[k], "flops per node" => [80.0 * m, 8.0 * m][k],
        }
    };
    let work: Vec<Row> = (0..2).map(of).collect();
    let scene = row! {
        "vertices" => asset.vertex_count(), "triangles" => asset.triangle_count(),
        "modes" => asset.mode_count(), "balls" => cases.len(), "rounds" => rounds,
        "radius over the diagonal" => arguments.radius, "touching" => touching as f64 / balls,
        "bytes per s from 256 KiB" => bandwidths[0], "from 16 MiB" => bandwidths[1],
    };
    Ok(vec![
        table("scene", "Balls; all find the same", &[scene]),
        table("times", "Contenders in turns, per ball", &times),
        table("work", "What a ball takes, and limits", &work),
    ])
}

/// The triangles of the product's leaf lanes that a ball touches, from a walk outside the clock.
fn touched_triangles(pose: &Pose<'_>, (center, radius): ([f64; 3], f64)) -> Result<u64> {
    let asset = pose.asset();
    let (origin, unit) = (asset.origin(), asset.unit());
    let center = [0, 1, 2].map(|k| ((center[k] - origin[k]) / unit) as f32);
    let reach = (radius / unit) as f32;
    let (mut triangles, mut stack) = (0, vec![0_u32]);
    while let Some(index) = stack.pop() {
        let node = &asset.nodes()[index as usize];
        let spheres = pose.node_spheres(index)?;
        let mut children = node.first_child..;
        for k in 0..bdtree_format::LANES {
            let square: f32 = (0..3)
                .map(|i| (spheres.center[i][k] - center[i]).powi(2))
                .sum();
            let touches = square.sqrt() <= spheres.radius[k] + reach;
            if node.inner_mask & (1 << k) != 0 {
                stack.extend(children.next().filter(|_| touches));
            } else if touches {
                triangles += u64::from(node.leaf_counts[k]);
            }
        }
    }
    Ok(triangles)
}

/// Mean R'/R over all spheres above a thousandth of the largest, at the first few q: the product's, the paper's.
fn growths(asset: &Asset<'_>, tree: &PaperTree, cases: &[Case]) -> Result<[f64; 2]> {
    let mut memory = vec![0.0; asset.pose_len()];
    let mut sums = [[0.0; 2]; 2];
    for case in cases.iter().take(5) {
        let pose = asset.pose(&case.q, Transform::IDENTITY, &mut memory)?;
        for (sum, own) in sums.iter_mut().zip(sum_growths(tree, &pose)?) {
            *sum = [sum[0] + own[0], sum[1] + own[1]];
        }
    }
    Ok(sums.map(|[sum, count]| sum / count))
}

/// Nanoseconds that a node's spheres take where its numbers are near: of the product's tree, of the paper's.
fn near_ns(asset: &Asset<'_>, tree: &PaperTree, case: &Case) -> Result<[f64; 2]> {
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset.pose(&case.q, Transform::IDENTITY, &mut memory)?;
    let mut step = Step::default();
    step.prepare(&pose);
    // As many nodes as fit the near caches.
    let ours = least_ns(20, asset.node_count().min(64), |i| {
        black_box(pose.node_spheres(i as u32).ok());
    });
    let theirs = least_ns(20, tree.node_count().min(64), |i| {
        black_box(tree.sphere(&step, i));
    });
    Ok([ours, theirs])
}
