//! How the ball query grows with the mesh while the number of contacts stays the same (P28).

use std::error::Error;

use bdtree_baselines::stats;
use bdtree_runtime::{Asset, Pose, Transform, VertexId};
use bdtree_scenes::workloads::curtain::cloth;
use bdtree_scenes::workloads::sequence;
use clap::Args;
use serde_json::{Value, json};

use super::assets::baked;
use super::ours::ball::OurBall;
use super::report::short;

#[derive(Args)]
pub(crate) struct Arguments {
    /// How often all balls are asked on every cloth
    #[arg(long, default_value_t = 41)]
    repeat: usize,
    /// Contacts per ball, on every cloth within 5 %
    #[arg(long, default_value_t = 60.0)]
    contacts: f64,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Vertices across and down of cloths of 12 thousand to 2 million triangles.
const SIZES: [(&str, usize, usize); 5] = [
    ("cloth12k", 79, 78),
    ("cloth50k", 159, 159),
    ("cloth200k", 317, 317),
    ("cloth800k", 633, 633),
    ("cloth2m", 1001, 1001),
];

/// Balls, each with its own q.
const BALLS: usize = 64;

/// A q and a place on the deformed cloth.
struct Case {
    q: Vec<f32>,
    center: [f32; 3],
}

/// One cloth's figures per ball.
struct Figures {
    triangles: usize,
    radius: f32,
    contacts: f64,
    nodes: f64,
    seconds: f64,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let mut all = Vec::new();
    for (name, across, down) in SIZES {
        let body = cloth(name, across, down);
        let bytes = baked(&body)?;
        let asset = Asset::open(&bytes)?;
        all.push(measure(asset, [across, down], arguments)?);
    }
    let logs =
        |of: &dyn Fn(&Figures) -> f64| -> Vec<f64> { all.iter().map(|f| of(f).ln()).collect() };
    let sizes = logs(&|f| f.triangles as f64);
    let by_time = slope(&sizes, &logs(&|f| f.seconds));
    let by_nodes = slope(&sizes, &logs(&|f| f.nodes));
    if arguments.json {
        let row = |f: &Figures| -> Value {
            json!({"triangles": f.triangles, "radius": f.radius, "contacts": f.contacts,
                "nodes": f.nodes, "seconds": f.seconds})
        };
        let rows: Vec<Value> = all.iter().map(row).collect();
        let value = json!({"rows": rows, "exponent_time": by_time, "exponent_nodes": by_nodes});
        println!("{value:#}");
        return Ok(());
    }
    println!("triangles     radius  contacts  nodes visited  µs per ball");
    for f in &all {
        println!(
            "{:>9}  {:>9}  {:>8}  {:>13}  {:>11}",
            f.triangles,
            short(f64::from(f.radius)),
            short(f.contacts),
            short(f.nodes),
            short(1e6 * f.seconds)
        );
    }
    println!("exponent of time {by_time:.3}, of nodes {by_nodes:.3} (must be below 0.3)");
    Ok(())
}

/// The balls of a cloth: at the same places of the sheet, whatever its vertices.
fn cases(asset: &Asset<'_>, [across, down]: [usize; 2]) -> Result<Vec<Case>, Box<dyn Error>> {
    let modes = asset.mode_count();
    let mut memory = vec![0.0; asset.pose_len()];
    let mut all = Vec::with_capacity(BALLS);
    for (i, q) in sequence(BALLS, modes, 0.8, 2)
        .chunks_exact(modes)
        .enumerate()
    {
        // Places of a lattice with irrational steps (Roberts 2018), off the cloth's border.
        let share = |step: f64| 0.1 + 0.8 * (0.5 + step * i as f64).fract();
        let column = (share(0.754_877_666) * (across - 1) as f64).round() as usize;
        let row = (share(0.569_840_291) * (down - 1) as f64).round() as usize;
        let pose = Pose::new(asset, q, Transform::IDENTITY, &mut memory)?;
        let center = asset.deformed(&pose, VertexId((row * across + column) as u32))?;
        all.push(Case {
            q: q.to_vec(),
            center: center.map(|x| x as f32),
        });
    }
    Ok(all)
}

fn measure(
    asset: Asset<'_>,
    shape: [usize; 2],
    arguments: &Arguments,
) -> Result<Figures, Box<dyn Error>> {
    let cases = cases(&asset, shape)?;
    let mut ours = OurBall::new(asset);
    // Contacts, nodes and seconds of all balls.
    let mut pass = |radius: f32| {
        let mut sums = [0.0; 3];
        for case in &cases {
            let [x, y, z] = case.center;
            let frame = ours.frame(&case.q, [x, y, z, radius]);
            sums[0] += frame.found as f64;
            sums[1] += frame.nodes.visited as f64;
            sums[2] += frame.query;
        }
        sums.map(|sum| sum / cases.len() as f64)
    };
    // Contacts grow with the radius.
    let (mut low, mut high) = (0.0_f32, 1.0);
    let mut radius = 0.5;
    let [mut contacts, mut nodes] = [0.0; 2];
    for _ in 0..40 {
        radius = 0.5 * (low + high);
        [contacts, nodes, _] = pass(radius);
        if (contacts / arguments.contacts - 1.0).abs() < 0.01 {
            break;
        }
        if contacts < arguments.contacts {
            low = radius;
        } else {
            high = radius;
        }
    }
    if (contacts / arguments.contacts - 1.0).abs() > 0.05 {
        return Err(format!("no radius gives {} contacts", arguments.contacts).into());
    }
    let times: Vec<f64> = (0..arguments.repeat.max(1))
        .map(|_| pass(radius)[2])
        .collect();
    Ok(Figures {
        triangles: asset.triangle_count(),
        radius,
        contacts,
        nodes,
        seconds: stats::median(&times),
    })
}

/// The slope of the line of least squares.
fn slope(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len() as f64;
    let (mean_x, mean_y) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let products = x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y));
    products.sum::<f64>() / x.iter().map(|x| (x - mean_x).powi(2)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::slope;

    #[test]
    fn slope_of_a_power() {
        let x: Vec<f64> = [1.0_f64, 3.0, 10.0, 40.0].iter().map(|x| x.ln()).collect();
        let y: Vec<f64> = x.iter().map(|x| 0.25 * x + 2.0).collect();
        assert!((slope(&x, &y) - 0.25).abs() < 1e-12);
    }
}
