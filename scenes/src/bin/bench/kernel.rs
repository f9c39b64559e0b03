//! The node kernel alone: time of the eight spheres of a node, from each level of the memory, beside
//! what the machine allows.

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use bdtree_fixtures::bake::{baked, bumpy_sphere, smooth_basis};
use bdtree_fixtures::poses;
use bdtree_format::{Row, pair_count, row_count};
use bdtree_measure::{machine, stats};
use bdtree_runtime::{Asset, Kernel, Model, Pose, Transform, studies};
use clap::Args;
use rand::seq::SliceRandom;
use serde_json::{Value, json};

#[derive(Args)]
pub(crate) struct Arguments {
    /// Numbers of modes
    #[arg(long, value_delimiter = ',', default_value = "1,2,4,10,16,32,64")]
    modes: Vec<usize>,
    /// Number of modes that is measured from all levels; the others are from the nearest only
    #[arg(long, default_value_t = 10)]
    everywhere: usize,
    /// Rounds in which all contenders take turns
    #[arg(long, default_value_t = 31)]
    rounds: usize,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Rows of visited nodes, in bytes, that fit a level of the memory and not the one before.
const LEVELS: [(&str, usize); 4] = [
    ("L1", 20 << 10),
    ("L2", 512 << 10),
    ("L3", 8 << 20),
    ("DRAM", 192 << 20),
];

/// One way to go over nodes.
struct Contender {
    name: String,
    kernel: Kernel,
    /// Order of the file instead of a random one.
    in_order: bool,
    /// World units that modes left out may move.
    tolerance: f64,
    times: Vec<f64>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let mut results = Vec::new();
    for &modes in &arguments.modes {
        for (level, bytes) in LEVELS {
            if level == "L1" || modes == arguments.everywhere {
                results.push(measure(modes, level, bytes, arguments.rounds)?);
            }
        }
    }
    let machine = json!({"processor": machine::processor(), "clock_ghz": clock_ghz()});
    if arguments.json {
        println!("{:#}", json!({"machine": machine, "results": results}));
        return Ok(());
    }
    println!("{machine}");
    for result in results {
        println!("{result}");
    }
    Ok(())
}

/// ns per node of every contender over nodes of about `bytes` bytes.
fn measure(
    modes: usize,
    level: &str,
    bytes: usize,
    rounds: usize,
) -> Result<Value, Box<dyn Error>> {
    let mesh = bumpy_sphere(60, 2004);
    let model = baked(&mesh, &smooth_basis(&mesh, modes, 2004));
    let node_bytes = row_count(modes) * size_of::<Row>();
    let per_file = model.asset().node_count();
    let wanted = (bytes / node_bytes).max(8);
    // Copies of the file, so that any level of the memory is filled by real nodes.
    let copies: Vec<Model> = (0..wanted.div_ceil(per_file))
        .map(|_| Model::from_bytes(model.asset().bytes()))
        .collect::<Result<_, _>>()?;
    let first = model.asset();
    let q = poses::random_q(first, 0.1, &mut poses::rng(1));

    let in_order: Vec<(u32, u32)> = (0..wanted)
        .map(|i| ((i / per_file) as u32, (i % per_file) as u32))
        .collect();
    let mut shuffled = in_order.clone();
    shuffled.shuffle(&mut poses::rng(2));
    let mut contenders = Vec::new();
    let mut add = |name: String, kernel: Kernel, in_order: bool, tolerance: f64| {
        if kernel.is_available() {
            contenders.push(Contender {
                name,
                kernel,
                in_order,
                tolerance,
                times: Vec::new(),
            });
        }
    };
    for kernel in Kernel::ALL {
        add(format!("{kernel:?}"), kernel, false, 0.0);
    }
    add("in the file's order".into(), Kernel::best(), true, 0.0);
    // The half of the pairs that move least.
    let half = half_of_modes(first, &q) * first.unit();
    add(
        "half of the modes left out".into(),
        Kernel::best(),
        false,
        half,
    );

    let passes = (200_000 / wanted).max(1);
    for _ in 0..rounds {
        for contender in &mut contenders {
            let order = if contender.in_order {
                &in_order
            } else {
                &shuffled
            };
            let assets = copies.iter().map(Model::asset);
            let assets = assets.filter_map(|asset| asset.with_kernel(contender.kernel));
            let assets: Vec<Asset<'_>> = assets.collect();
            let mut memory = vec![0.0; assets.len() * first.pose_len()];
            let memories = memory.chunks_exact_mut(first.pose_len());
            let poses: Vec<Pose<'_>> = (assets.iter().zip(memories))
                .map(|(asset, memory)| {
                    let place = Transform::IDENTITY;
                    studies::pose_within(asset, &q, place, contender.tolerance, memory)
                })
                .collect::<Result<_, _>>()?;
            let start = Instant::now();
            let mut sum = 0.0;
            for _ in 0..passes {
                for &(copy, node) in order {
                    let pose = poses.get(copy as usize).ok_or("no such copy")?;
                    let spheres = pose.node_spheres(node)?;
                    sum += spheres.radius[0] + spheres.center[0][7];
                }
            }
            black_box(sum);
            let nodes = (passes * order.len()) as f64;
            contender
                .times
                .push(start.elapsed().as_secs_f64() * 1e9 / nodes);
        }
    }
    let times: serde_json::Map<String, Value> = contenders
        .iter()
        .map(|c| (c.name.clone(), rounded(stats::median(&c.times))))
        .collect();
    // All bytes of a node at the bandwidth of a plain read; six multiplications of pairs for two
    // modes, of which processors do two a cycle.
    let read_ns = node_bytes as f64 / machine::read_bandwidth(wanted * node_bytes) * 1e9;
    let multiply_ns = 3.0 * pair_count(modes) as f64 / clock_ghz();
    Ok(json!({
        "modes": modes, "from": level, "node_bytes": node_bytes, "ns_per_node": times,
        "limit_read_ns": rounded(read_ns), "limit_multiply_ns": rounded(multiply_ns),
    }))
}

fn rounded(x: f64) -> Value {
    json!((x * 10.0).round() / 10.0)
}

/// What half of the pairs of modes, those that move least, move together (stored units).
fn half_of_modes(asset: &Asset<'_>, q: &[f32]) -> f64 {
    let of_mode: Vec<f64> = (asset.modes().iter().zip(q))
        .map(|(mode, q)| f64::from(mode.field_norm_max.get()) * f64::from(q.abs()))
        .collect();
    let mut pairs: Vec<f64> = of_mode.chunks(2).map(|pair| pair.iter().sum()).collect();
    pairs.sort_by(f64::total_cmp);
    pairs.iter().take(pairs.len() / 2).sum::<f64>() * (1.0 + 1e-9)
}

/// The clock while it computes: a product of 64-bit numbers is ready after three cycles.
fn clock_ghz() -> f64 {
    const COUNT: u64 = 20_000_000;
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        let mut x = black_box(3_u64);
        for _ in 0..COUNT {
            x = x.wrapping_mul(x);
        }
        black_box(x);
        best = best.min(start.elapsed().as_secs_f64());
    }
    (3 * COUNT) as f64 / best * 1e-9
}
