//! The ball query beside deforming and refitting, over modes, displacement, balls a step and radius: where
//! refitting begins to win (P53).

use std::error::Error;

use bdtree_baselines::Place;
use bdtree_baselines::clock::Clock;
use bdtree_baselines::deform::Deformer;
use bdtree_baselines::peers::{Obvhs, Peer};
use bdtree_baselines::stats;
use bdtree_runtime::Asset;
use serde_json::{Value, json};

use crate::contenders::assets::baked;
use crate::contenders::ours::ball::OurBall;
use crate::plot::{Axis, Chart, Curve};
use crate::report::{Table, digits};
use crate::workloads::bodies::blob_with;
use crate::workloads::{rays, scale, sequence};

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

/// What is measured at a setting, per step.
struct Point {
    /// What varies.
    x: f64,
    balls: usize,
    contacts: f64,
    nodes: f64,
    /// Ours; theirs until the tree is refitted, and their queries.
    seconds: [f64; 3],
}

/// One thing varied, the others as usual.
pub(super) struct Sweep {
    key: &'static str,
    what: &'static str,
    triangles: usize,
    points: Vec<Point>,
}

/// Modes, displacement, balls a step and radius, on a body of about this many triangles.
pub(super) fn all(triangles: u32, repeats: usize) -> Result<Vec<Sweep>, Box<dyn Error>> {
    let modes = [1, 2, 4, 8, 16, 32, 64].map(|modes| Setting { modes, ..USUAL });
    let shares = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5];
    let shares = shares.map(|displacement| Setting {
        displacement,
        ..USUAL
    });
    let radii = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5].map(|radius| Setting { radius, ..USUAL });
    let balls = [1, 4, 16, 64, 256, 1024].map(|balls| Setting { balls, ..USUAL });
    // Faces of the icosahedron are split into n² triangles.
    let n = (f64::from(triangles) / 20.0).sqrt().round() as usize;
    Ok(vec![
        sweep(n, ("modes", "modes"), &modes, repeats, |s| s.modes as f64)?,
        sweep(
            n,
            ("displacement", "farthest vertex's way over the diagonal"),
            &shares,
            repeats,
            |s| s.displacement,
        )?,
        sweep(
            n,
            ("contacts", "radius of the ball"),
            &radii,
            repeats,
            |s| f64::from(s.radius),
        )?,
        sweep(n, ("balls", "balls a step"), &balls, repeats, |s| {
            s.balls as f64
        })?,
    ])
}

fn sweep(
    n: usize,
    (key, what): (&'static str, &'static str),
    settings: &[Setting],
    repeats: usize,
    x: impl Fn(&Setting) -> f64,
) -> Result<Sweep, Box<dyn Error>> {
    let points = settings.iter().map(|s| measure(n, s, repeats, x(s)));
    Ok(Sweep {
        key,
        what,
        triangles: 20 * n * n,
        points: points.collect::<Result<_, _>>()?,
    })
}

fn measure(n: usize, setting: &Setting, repeats: usize, x: f64) -> Result<Point, Box<dyn Error>> {
    let body = blob_with("blob", n, setting.modes, 3);
    let bytes = baked(&body)?;
    let asset = Asset::open(&bytes)?;
    let deformer = Deformer::new(&body);
    let mut ours = OurBall::new(asset);
    let mut peer = Obvhs::new(&body);
    let mut steps: Vec<Vec<f32>> = sequence(STEPS, setting.modes, 0.8, 8)
        .chunks_exact(setting.modes)
        .map(<[f32]>::to_vec)
        .collect();
    let mut centres = Vec::new();
    let shots = rays::rays("shots", 1);
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
    let mut times = vec![[const { Vec::new() }; 3]; STEPS];
    let (mut contacts, mut nodes) = (0, 0);
    let (mut scratch, mut found) = (Vec::new(), Vec::new());
    for _ in 0..repeats {
        (contacts, nodes) = (0, 0);
        for (step, q) in steps.iter().enumerate() {
            let mut own = (0.0, 0);
            for [x, y, z] in &centres[step] {
                let frame = ours.frame(q, [*x, *y, *z, setting.radius]);
                own = (own.0 + frame.query, own.1 + frame.found);
                nodes += frame.nodes.visited;
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
        x,
        balls: setting.balls,
        contacts: contacts as f64 / STEPS as f64,
        nodes: nodes as f64 / STEPS as f64,
        seconds: [mean(0), mean(1), mean(2)],
    })
}

impl Point {
    /// Deforming, refitting and asking over ours.
    fn times(&self) -> f64 {
        let [ours, update, query] = self.seconds;
        (update + query) / ours
    }

    /// Balls a step at which both take as long, if refitting ever wins.
    fn break_even(&self) -> Option<f64> {
        let [ours, update, query] = self.seconds;
        let per_ball = (ours - query) / self.balls as f64;
        (per_ball > 0.0).then(|| update / per_ball)
    }
}

impl Sweep {
    pub(super) fn json(&self) -> Value {
        let row = |p: &Point| {
            json!({"x": p.x, "contacts": p.contacts, "nodes": p.nodes,
                "times": {"ours_us": 1e6 * p.seconds[0], "update_us": 1e6 * p.seconds[1],
                    "query_us": 1e6 * p.seconds[2], "speedup": p.times(),
                    "break_even_balls": p.break_even()}})
        };
        json!({"over": self.what, "triangles": self.triangles,
            "rows": self.points.iter().map(row).collect::<Vec<Value>>()})
    }

    pub(super) fn table(&self) -> Table {
        let title = format!(
            "Over {}: {} triangles, else 10 modes, displacement 10 %, one ball of radius 0.05 a step. Break-even: \
             balls a step at which both take as long.",
            self.what, self.triangles
        );
        let columns = [
            self.what,
            "contacts a step",
            "nodes visited",
            "ours, µs",
            "deform + refit, µs",
            "their queries, µs",
            "times faster",
            "break-even, balls",
        ];
        let mut table = Table::new(self.key, title, &columns);
        for p in &self.points {
            let even = p.break_even().map_or("never".to_string(), digits);
            table.rows.push(vec![
                p.x.into(),
                p.contacts.into(),
                p.nodes.into(),
                (1e6 * p.seconds[0]).into(),
                (1e6 * p.seconds[1]).into(),
                (1e6 * p.seconds[2]).into(),
                p.times().into(),
                even.into(),
            ]);
        }
        table
    }

    pub(super) fn chart(&self) -> Chart<'static> {
        let curve = |name: &str, of: &dyn Fn(&Point) -> f64| Curve {
            name: name.to_string(),
            points: self.points.iter().map(|p| (p.x, of(p))).collect(),
        };
        Chart {
            title: self.what,
            x: Axis::log(self.what),
            y: Axis::log("µs a step"),
            curves: vec![
                curve("ours", &|p| 1e6 * p.seconds[0]),
                curve("deform + refit + query", &|p| {
                    1e6 * (p.seconds[1] + p.seconds[2])
                }),
                curve("their queries alone", &|p| 1e6 * p.seconds[2]),
            ],
        }
    }
}
