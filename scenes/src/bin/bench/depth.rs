//! Bounded depth: what stopping at a level costs and how far its spheres are off, for wrapped and
//! for nested spheres.

use std::error::Error;
use std::time::Instant;

use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_fixtures::poses;
use bdtree_format::LANES;
use bdtree_measure::stats::median;
use bdtree_runtime::{
    Asset, Ball, Contact, Model, PairContact, Proxy, Transform, VertexId, Workspace,
};
use clap::Args;
use rand::RngExt;

use crate::scene::Scene;

#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: Scene,
    /// Frames, each with its own q
    #[arg(long, default_value_t = 40)]
    frames: usize,
    /// Radius of the ball over the diagonal of the box
    #[arg(long, default_value_t = 0.03)]
    radius: f64,
    /// Largest displacement over the diagonal of the box
    #[arg(long, default_value_t = 0.08)]
    displacement: f64,
    /// Rounds of each measurement
    #[arg(long, default_value_t = 9)]
    rounds: usize,
}

/// A ball that reaches into the surface, and a second body that does.
struct Frame {
    q: [Vec<f32>; 2],
    center: [f64; 3],
    place: Transform,
}

fn frames(asset: &Asset<'_>, arguments: &Arguments) -> Result<Vec<Frame>, Box<dyn Error>> {
    let mut rng = poses::rng(arguments.scene.seed);
    let diagonal = poses::diagonal(asset) * asset.unit();
    let mut memory = vec![0.0; asset.pose_len()];
    let mut all = Vec::with_capacity(arguments.frames);
    for _ in 0..arguments.frames {
        let mut random_q = || {
            let share = arguments.displacement * rng.random_range(0.5..1.0);
            poses::random_q(asset, share, &mut rng)
        };
        let q = [random_q(), random_q()];
        let pose = asset.pose(&q[0], Transform::IDENTITY, &mut memory)?;
        let vertex = VertexId(rng.random_range(0..asset.vertex_count() as u32));
        let mut center = pose.deformed(vertex)?;
        for c in &mut center {
            *c += arguments.radius * diagonal * rng.random_range(-0.4..0.4);
        }
        // About as far apart as the bodies are wide, so that they graze or overlap a little.
        let turned = poses::random_transform(0.0, &mut rng);
        let direction = turned.rotation;
        let length = direction[..3].iter().map(|x| x * x).sum::<f64>().sqrt();
        let apart = diagonal * rng.random_range(0.5..0.56);
        let place = Transform {
            translation: [0, 1, 2].map(|k| apart * direction[k] / length),
            scale: 1.0,
            ..poses::random_transform(0.0, &mut rng)
        };
        all.push(Frame { q, center, place });
    }
    Ok(all)
}

/// Means over the frames.
#[derive(Default)]
struct Row {
    micros: f64,
    visits: f64,
    exact: f64,
    proxies: f64,
    /// Penetration (ball) or distance to the nearest contact point (pair) that the spheres are off, over
    /// the diagonal: mean, and the most.
    error: [f64; 2],
    /// Frames in which something is reported though nothing touches.
    false_frames: usize,
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// The ball, stopped at `level`.
fn balls(
    asset: &Asset<'_>,
    frames: &[Frame],
    level: usize,
    arguments: &Arguments,
) -> Result<Row, Box<dyn Error>> {
    let diagonal = poses::diagonal(asset) * asset.unit();
    let radius = arguments.radius * diagonal;
    let mut workspace = Workspace::new();
    let mut memory = vec![0.0; asset.pose_len()];
    let (mut contacts, mut proxies): (Vec<Contact>, Vec<Proxy>) = Default::default();
    let mut row = Row::default();
    let mut count = 0;
    for frame in frames {
        let pose = asset.pose(&frame.q[0], Transform::IDENTITY, &mut memory)?;
        let mut exact: Vec<Contact> = Vec::new();
        let ball = Ball::new(frame.center, radius);
        pose.query(&mut workspace).contacts(ball, &mut exact)?;
        let mut times = Vec::new();
        for _ in 0..arguments.rounds {
            contacts.clear();
            proxies.clear();
            let start = Instant::now();
            let mut query = pose.query(&mut workspace);
            if level != usize::MAX {
                query = query.max_level(level, &mut proxies);
            }
            query.contacts(ball, &mut contacts)?;
            times.push(start.elapsed().as_secs_f64() * 1e6);
            row.visits += workspace.stats().nodes_visited as f64 / arguments.rounds as f64;
        }
        row.micros += median(&times);
        row.exact += contacts.len() as f64;
        row.proxies += proxies.len() as f64;
        let depth = |contacts: &[Contact]| contacts.iter().map(|c| -c.distance).fold(0.0, f64::max);
        let reached = |p: &Proxy| radius + p.radius - distance(p.center, frame.center);
        let spheres = proxies.iter().map(reached).fold(0.0, f64::max);
        if exact.is_empty() {
            row.false_frames += usize::from(!proxies.is_empty());
            continue;
        }
        let error = (depth(&contacts).max(spheres) - depth(&exact)).abs() / diagonal;
        row.error[0] += error;
        row.error[1] = row.error[1].max(error);
        count += 1;
    }
    row.error[0] /= f64::from(count.max(1));
    Ok(row)
}

/// Two bodies, both stopped at `level`.
fn pairs(
    asset: &Asset<'_>,
    frames: &[Frame],
    level: usize,
    arguments: &Arguments,
) -> Result<Row, Box<dyn Error>> {
    let diagonal = poses::diagonal(asset) * asset.unit();
    let mut workspace = Workspace::new();
    let (mut memory_a, mut memory_b) = (vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]);
    let mut contacts: Vec<PairContact> = Vec::new();
    let (mut first, mut second): (Vec<Proxy>, Vec<Proxy>) = Default::default();
    let mut row = Row::default();
    let mut count = 0.0;
    for frame in frames {
        let a = asset.pose(&frame.q[0], Transform::IDENTITY, &mut memory_a)?;
        let b = asset.pose(&frame.q[1], frame.place, &mut memory_b)?;
        let mut exact: Vec<PairContact> = Vec::new();
        a.against(&b, &mut workspace).contacts(0.0, &mut exact)?;
        let mut times = Vec::new();
        for _ in 0..arguments.rounds {
            contacts.clear();
            first.clear();
            second.clear();
            let start = Instant::now();
            let mut query = a.against(&b, &mut workspace);
            if level != usize::MAX {
                query = query.max_level1(level, &mut first);
                query = query.max_level2(level, &mut second);
            }
            query.contacts(0.0, &mut contacts)?;
            times.push(start.elapsed().as_secs_f64() * 1e6);
            row.visits += workspace.stats().nodes_visited as f64 / arguments.rounds as f64;
        }
        row.micros += median(&times);
        row.exact += contacts.len() as f64;
        row.proxies += first.len() as f64;
        if exact.is_empty() {
            row.false_frames += usize::from(!first.is_empty());
            continue;
        }
        for (p, q) in first.iter().zip(&second) {
            // Where two balls in contact would be taken to touch.
            let share = p.radius / (p.radius + q.radius);
            let point = [0, 1, 2].map(|k| p.center[k] + share * (q.center[k] - p.center[k]));
            let near = exact.iter().map(|c| distance(c.point1, point));
            let error = near.fold(f64::INFINITY, f64::min) / diagonal;
            row.error[0] += error;
            row.error[1] = row.error[1].max(error);
            count += 1.0;
        }
    }
    row.error[0] /= f64::max(count, 1.0);
    Ok(row)
}

/// Of lanes that lead to a node, the share of which a sphere below sticks out by more than rounding,
/// how far at most over the lane's radius, and the mean radius over the diagonal.
fn sticking_out(asset: &Asset<'_>, q: &[f32]) -> Result<[f64; 3], Box<dyn Error>> {
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset.pose(q, Transform::IDENTITY, &mut memory)?;
    let (mut lanes, mut out, mut most, mut radii) = (0.0, 0.0, 0.0_f64, 0.0);
    for (i, node) in (0..).zip(asset.nodes()) {
        let outer = pose.node_spheres(i)?;
        let inner_lanes = (0..LANES).filter(|k| node.inner_mask >> k & 1 == 1);
        for (child, lane) in (node.first_child..).zip(inner_lanes) {
            let below = &asset.nodes()[child as usize];
            let inner = pose.node_spheres(child)?;
            let radius = f64::from(outer.radius[lane]);
            let mut excess = 0.0_f64;
            for k in (0..LANES).filter(|k| (below.inner_mask | below.leaf_mask) >> k & 1 == 1) {
                let at = |s: &bdtree_runtime::bound::Spheres, k: usize| {
                    s.center.map(|row| f64::from(row[k]))
                };
                let reach = distance(at(&inner, k), at(&outer, lane)) + f64::from(inner.radius[k]);
                excess = excess.max(reach / radius - 1.0);
            }
            lanes += 1.0;
            radii += radius / poses::diagonal(asset);
            out += f64::from(excess > 1e-3);
            most = most.max(excess);
        }
    }
    Ok([out / lanes, most, radii / lanes])
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let (mesh, basis) = arguments.scene.load()?;
    for nested in [false, true] {
        let settings = BakeSettings {
            nested,
            leaf_size: arguments.scene.leaf_size,
            ..BakeSettings::default()
        };
        let baked = bake_fields(&mesh, &basis, &settings, &Provenance::default(), &Silent)?;
        let model = Model::from_bytes(&baked.bytes)?;
        let asset = model.asset();
        let frames = frames(asset, arguments)?;
        let kind = if nested { "nested" } else { "wrapped" };
        println!(
            "{kind}: {} triangles, {} levels",
            asset.triangle_count(),
            asset.depth()
        );
        let rest = vec![0.0; asset.mode_count()];
        for (name, q) in [("at rest", &rest), ("under q", &frames[0].q[0])] {
            let [share, most, radius] = sticking_out(asset, q)?;
            println!("{name}: {share:.3} of the lanes, by {most:.3} R; mean radius {radius:.5}");
        }
        for name in ["ball", "pair"] {
            for level in (0..asset.depth()).chain([usize::MAX]) {
                let row = match name {
                    "ball" => balls(asset, &frames, level, arguments)?,
                    _ => pairs(asset, &frames, level, arguments)?,
                };
                let n = frames.len() as f64;
                let level = if level == usize::MAX {
                    "none".into()
                } else {
                    level.to_string()
                };
                println!(
                    "| {kind}, {name} | {level} | {:.2} | {:.1} | {:.1} | {:.1} | {:.4} | {:.4} | {} |",
                    row.micros / n,
                    row.visits / n,
                    row.exact / n,
                    row.proxies / n,
                    row.error[0],
                    row.error[1],
                    row.false_frames
                );
            }
        }
    }
    Ok(())
}
