//! The ball query beside deforming and refitting, over modes, displacement, queries per step and
//! contacts: where refitting begins to win (P53).

use bdtree_baselines::clock::Clock;
use bdtree_baselines::deform::Deformer;
use bdtree_baselines::peers::Peer;
use bdtree_baselines::stats;
use bdtree_baselines::{Body, Place};
use bdtree_runtime::Asset;
use bdtree_scenes::workloads::bodies::blob_with;
use bdtree_scenes::workloads::{rays, sequence};
use clap::Args;
use std::error::Error;

use super::assets::baked;
use super::ours::ball::OurBall;
use super::report::short;

#[derive(Args)]
pub(crate) struct Arguments {
    /// How often every step is taken
    #[arg(long, default_value_t = 9)]
    repeat: usize,
}

/// Steps of the motion.
const STEPS: usize = 12;

/// One point of a curve.
#[derive(Debug, Clone, Copy)]
struct Setting {
    modes: usize,
    /// Largest displacement of a vertex over the diagonal of the box.
    displacement: f64,
    balls: usize,
    radius: f32,
}

const USUAL: Setting = Setting {
    modes: 10,
    displacement: 0.1,
    balls: 1,
    radius: 0.05,
};

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let repeats = arguments.repeat.max(1);
    println!("36 thousand triangles, 10 modes, displacement 10 %, one ball of radius 0.05 a step");
    let modes = [1, 2, 4, 8, 16, 32, 64].map(|modes| Setting { modes, ..USUAL });
    curve("modes", &modes, repeats, |s| s.modes as f64)?;
    let shares = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5];
    let shares = shares.map(|displacement| Setting {
        displacement,
        ..USUAL
    });
    curve("displacement", &shares, repeats, |s| s.displacement)?;
    let balls = [1, 4, 16, 64, 256, 1024].map(|balls| Setting { balls, ..USUAL });
    curve("balls per step", &balls, repeats, |s| s.balls as f64)?;
    let radii = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5].map(|radius| Setting { radius, ..USUAL });
    curve("radius", &radii, repeats, |s| f64::from(s.radius))?;
    Ok(())
}

fn curve(
    what: &str,
    settings: &[Setting],
    repeats: usize,
    key: impl Fn(&Setting) -> f64,
) -> Result<(), Box<dyn Error>> {
    println!(
        "\n{what:>14}  contacts  ours, µs  deform + refit + query, µs  times  break-even, balls"
    );
    for setting in settings {
        let point = measure(setting, repeats)?;
        let [ours, update, query] = point.seconds;
        let theirs = update + query;
        // Balls per step at which both take as long, if refitting ever wins.
        let per_ball = (ours - query) / setting.balls as f64;
        let even = if per_ball > 0.0 {
            short(update / per_ball)
        } else {
            "never".to_string()
        };
        println!(
            "{:>14}  {:>8}  {:>8}  {:>26}  {:>5}  {even:>17}",
            short(key(setting)),
            short(point.contacts),
            short(1e6 * ours),
            format!("{} + {}", short(1e6 * update), short(1e6 * query)),
            short(theirs / ours),
        );
    }
    Ok(())
}

/// Per step.
struct Point {
    contacts: f64,
    /// Ours; theirs until the tree is refitted, and their queries.
    seconds: [f64; 3],
}

fn measure(setting: &Setting, repeats: usize) -> Result<Point, Box<dyn Error>> {
    let body = blob_with("curve36k", 42, setting.modes, 3);
    let bytes = baked(&body)?;
    let asset = Asset::open(&bytes)?;
    let deformer = Deformer::new(&body);
    let mut ours = OurBall::new(asset);
    let mut peer = refitting(&body, &asset, &deformer);
    let mut steps: Vec<Vec<f32>> = sequence(STEPS, setting.modes, 0.8, 8)
        .chunks_exact(setting.modes)
        .map(<[f32]>::to_vec)
        .collect();
    let mut centres = Vec::new();
    let shots = rays::rays("curve36k", 1);
    let mut out = vec![0.0; deformer.len()];
    for (step, q) in steps.iter_mut().enumerate() {
        scale(&body, &deformer, q, setting.displacement, &mut out);
        // On the surface: vertices that rays choose.
        let points = out.as_chunks::<3>().0;
        let all = shots.of(step, setting.balls).map(|[origin, _]| {
            let far = |p: &[f32; 3]| -(0..3).map(|k| p[k] * origin[k]).sum::<f32>();
            *points
                .iter()
                .step_by(17)
                .min_by(|a, b| far(a).total_cmp(&far(b)))
                .unwrap_or(&points[0])
        });
        centres.push(all.collect::<Vec<[f32; 3]>>());
    }
    let (mut times, mut contacts) = (vec![[const { Vec::new() }; 3]; STEPS], 0);
    let (mut scratch, mut found) = (Vec::new(), Vec::new());
    for _ in 0..repeats {
        contacts = 0;
        for (step, q) in steps.iter().enumerate() {
            let mut own = (0.0, 0);
            for [x, y, z] in &centres[step] {
                let frame = ours.frame(q, [*x, *y, *z, setting.radius]);
                own = (own.0 + frame.query, own.1 + frame.found);
            }
            let update = peer.update(&deformer, q, &Place::IDENTITY, &mut scratch);
            let start = Clock::start();
            let mut theirs = 0;
            for center in &centres[step] {
                found.clear();
                peer.ball(center.map(f64::from), f64::from(setting.radius), &mut found);
                theirs += found.len() as u64;
            }
            let query = start.seconds();
            if theirs != own.1 {
                return Err(format!("step {step}: {} and {theirs} contacts", own.1).into());
            }
            contacts += theirs;
            times[step][0].push(own.0);
            times[step][1].push(update.deform + update.refit);
            times[step][2].push(query);
        }
    }
    let mean = |k: usize| {
        let medians = times.iter().map(|step| stats::median(&step[k]));
        medians.sum::<f64>() / STEPS as f64
    };
    Ok(Point {
        contacts: contacts as f64 / STEPS as f64,
        seconds: [mean(0), mean(1), mean(2)],
    })
}

/// Scales q so that the farthest vertex moves by `share` of the diagonal; leaves the deformed
/// vertices in `out`.
fn scale(body: &Body, deformer: &Deformer, q: &mut [f32], share: f64, out: &mut [f32]) {
    deformer.deform(q, out);
    let moved = out.as_chunks::<3>().0.iter().zip(&body.positions);
    let farthest = moved
        .map(|(a, b)| (0..3).map(|k| f64::from(a[k] - b[k]).powi(2)).sum::<f64>())
        .fold(f64::MIN_POSITIVE, f64::max)
        .sqrt();
    let by = share * body.mesh().diagonal() / farthest;
    for q in q.iter_mut() {
        *q *= by as f32;
    }
    deformer.deform(q, out);
}

/// The fastest of those who refit.
#[cfg(feature = "peers")]
fn refitting(body: &Body, _: &Asset<'_>, _: &Deformer) -> Box<dyn Peer> {
    Box::new(bdtree_baselines::peers::TinyBvh::new(body))
}

/// The layered hierarchy, where there are no libraries.
#[cfg(not(feature = "peers"))]
fn refitting(_: &Body, asset: &Asset<'_>, deformer: &Deformer) -> Box<dyn Peer> {
    use bdtree_baselines::{paper_tree::PaperTree, peers::LayeredPeer};
    let tree = std::rc::Rc::new(PaperTree::build(asset));
    Box::new(LayeredPeer::new(tree, deformer))
}
