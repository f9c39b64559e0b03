//! The node kernel alone: time of the eight spheres of a node, from each level of the memory, beside
//! what the machine allows.

use bdtree_fixtures::bake::{baked, bumpy_sphere, smooth_basis};
use bdtree_format::{Row as NodeRow, pair_count, row_count};
use bdtree_runtime::{Kernel, studies};
use rand::seq::SliceRandom;

use crate::prelude::*;

#[derive(Args)]
pub(crate) struct Arguments {
    /// Numbers of modes
    #[arg(long, value_delimiter = ',', default_value = "1,2,4,10,16,32,64")]
    modes: Vec<usize>,
    /// Number of modes that is measured from all levels; the others are from the nearest only
    #[arg(long, default_value_t = 10)]
    everywhere: usize,
}

/// Rows of visited nodes, in bytes, that fit a level of the memory and not the one before.
const LEVELS: [(&str, usize); 4] = [
    ("L1", 20 << 10),
    ("L2", 512 << 10),
    ("L3", 8 << 20),
    ("DRAM", 192 << 20),
];

pub(crate) fn run(arguments: &Arguments, rounds: usize) -> Result<Vec<Table>> {
    let mut results = Vec::new();
    for &modes in &arguments.modes {
        for level in LEVELS {
            if level.0 == "L1" || modes == arguments.everywhere {
                results.push(measure(modes, level, rounds)?);
            }
        }
    }
    let clock = row! {"clock, GHz" => clock_ghz()};
    let title = "ns per node in turns; what reading and multiplying alone would take";
    Ok(vec![
        table("machine", "The processor", &[clock]),
        table("nodes", title, &results),
    ])
}

/// ns per node of every contender over nodes of about so many bytes.
fn measure(modes: usize, (level, bytes): (&str, usize), rounds: usize) -> Result<Row> {
    let mesh = bumpy_sphere(60, 2004);
    let model = baked(&mesh, &smooth_basis(&mesh, modes, 2004));
    let node_bytes = row_count(modes) * size_of::<NodeRow>();
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
    let passes = (200_000 / wanted).max(1);
    // One way to go over nodes: `tolerance` are world units that modes left out may move.
    let walk = |name: &str, kernel: Kernel, is_shuffled: bool, tolerance: f64| {
        let (copies, q) = (&copies, &q);
        let order = if is_shuffled { &shuffled } else { &in_order };
        Entry::new(name, Role::Ours, Counts::Other, move |_| {
            let assets = copies.iter().map(Model::asset);
            let assets = assets.filter_map(|asset| asset.with_kernel(kernel));
            let assets: Vec<Asset<'_>> = assets.collect();
            let mut memory = vec![0.0; assets.len() * first.pose_len()];
            let memories = memory.chunks_exact_mut(first.pose_len());
            let poses: Vec<Pose<'_>> = (assets.iter().zip(memories))
                .map(|(asset, memory)| {
                    studies::pose_within(asset, q, Transform::IDENTITY, tolerance, memory)
                })
                .collect::<Result<_, _>>()
                .expect("q within limits");
            frame(|| {
                let mut sum = 0.0;
                for _ in 0..passes {
                    for &(copy, node) in order {
                        let spheres = poses[copy as usize].node_spheres(node)?;
                        sum += spheres.radius[0] + spheres.center[0][7];
                    }
                }
                black_box(sum);
                Ok(Answer::default())
            })
        })
    };
    // The half of the pairs that move least.
    let half = half_of_modes(first, &q) * first.unit();
    let kernels = Kernel::ALL
        .into_iter()
        .filter(|kernel| kernel.is_available());
    let mut entries: Vec<Entry<'_>> = kernels
        .map(|kernel| walk(&format!("{kernel:?}"), kernel, true, 0.0))
        .collect();
    let best = Kernel::best();
    entries.push(walk("in the file's order", best, false, 0.0));
    entries.push(walk("half of the modes left out", best, true, half));

    let mut row = row! {"modes" => modes, "from" => level, "bytes per node" => node_bytes};
    for contender in compare(entries, 1, rounds)? {
        let ns = contender.median[TOTAL] * 1e9 / (passes * wanted) as f64;
        row.extend(row! {contender.name => ns});
    }
    // All bytes of a node at the bandwidth of a plain read; six multiplications of pairs for two
    // modes, of which processors do two a cycle.
    row.extend(row! {
        "plain read" => node_bytes as f64 / machine::read_bandwidth(wanted * node_bytes) * 1e9,
        "multiplications" => 3.0 * pair_count(modes) as f64 / clock_ghz(),
    });
    Ok(row)
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
