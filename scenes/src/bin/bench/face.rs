//! What local fields cost: a face with 52 blend shapes as it is baked, the same with modes and
//! displacements everywhere, and the face with 12 dense modes; bytes and a small ball.

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use bdtree_build::basis::Basis;
use bdtree_fixtures::{bake as made, poses, sections};
use bdtree_format::SectionKind;
use bdtree_measure::ours::Ours;
use bdtree_measure::{machine, stats};
use bdtree_runtime::{Asset, Contact, Model, Transform, TriangleId};
use bdtree_scenes::contenders::assets::baked_mesh;
use clap::Args;
use rand::RngExt;
use serde_json::json;

#[derive(Args)]
pub(crate) struct Arguments {
    /// Dense modes: smooth waves that move vertices as far as the shapes do, rms
    #[arg(long, default_value_t = 12)]
    modes: usize,
    /// Balls, each with its own q: weights of shapes from 0 to 1, of waves from -1 to 1
    #[arg(long, default_value_t = 400)]
    balls: usize,
    /// Radius over the diagonal of the box
    #[arg(long, default_value_t = 0.005)]
    radius: f64,
    /// Balls are centerd up to this many radii from a vertex
    #[arg(long, default_value_t = 1.0)]
    spread: f64,
    /// Rounds; in each all contenders answer all balls, taking turns to be first
    #[arg(long, default_value_t = 51)]
    rounds: usize,
    /// Seed of waves, weights and positions
    #[arg(long, default_value_t = 2004)]
    seed: u64,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// A displacement that is stored and moves nothing.
const SPECK: f64 = 1e-30;

/// Which weights a contender is asked with.
#[derive(Clone, Copy, PartialEq)]
enum Weights {
    Shapes,
    Waves,
}

impl Weights {
    fn random(self, rng: &mut impl RngExt) -> f32 {
        match self {
            Self::Shapes => rng.random_range(0.0..1.0),
            Self::Waves => rng.random_range(-1.0..1.0),
        }
    }

    /// Mean and variance of a weight.
    fn moments(self) -> (f64, f64) {
        match self {
            Self::Shapes => (0.5, 1.0 / 12.0),
            Self::Waves => (0.0, 1.0 / 3.0),
        }
    }
}

/// Mean square of how far vertices are moved by random weights.
fn mean_square(basis: &Basis, weights: Weights) -> f64 {
    let (mean, variance) = weights.moments();
    let square = |u: [f64; 3]| u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
    let n = basis.vertex_count;
    let of_vertex = |i: usize| {
        let fields = (0..basis.mode_count()).map(|j| basis.field(j)[i]);
        let (mut sum, mut squares) = ([0.0; 3], 0.0);
        for u in fields {
            (0..3).for_each(|k| sum[k] += u[k]);
            squares += square(u);
        }
        mean * mean * square(sum) + variance * squares
    };
    (0..n).map(of_vertex).sum::<f64>() / n as f64
}

/// Balls that one reading of the clock is for.
const BATCH: usize = 20;

struct Case {
    q: Vec<f32>,
    center: [f64; 3],
}

/// A file, its memory and the balls it is asked for.
struct Contender<'a> {
    name: &'static str,
    asset: Asset<'a>,
    cases: Vec<Case>,
    radius: f64,
    ours: Ours<'a>,
    /// Nanoseconds per ball, by batch and round.
    ns: Vec<Vec<f64>>,
}

impl<'a> Contender<'a> {
    fn new(
        name: &'static str,
        asset: Asset<'a>,
        weights: Weights,
        arguments: &Arguments,
    ) -> Result<Self, Box<dyn Error>> {
        let mut rng = poses::rng(arguments.seed);
        let mut memory = vec![0.0; asset.pose_len()];
        let radius = arguments.radius * poses::diagonal(&asset) * asset.unit();
        let mut cases = Vec::with_capacity(arguments.balls);
        for _ in 0..arguments.balls {
            let q: Vec<f32> = (0..asset.mode_count())
                .map(|_| weights.random(&mut rng))
                .collect();
            let pose = asset.pose(&q, Transform::IDENTITY, &mut memory)?;
            let id = TriangleId(rng.random_range(0..asset.triangle_count() as u32));
            let mut center = pose.deformed(asset.triangle(id)?[0])?;
            for c in &mut center {
                *c += arguments.spread * radius * rng.random_range(-1.0..1.0) / 3.0_f64.sqrt();
            }
            cases.push(Case { q, center });
        }
        Ok(Self {
            name,
            asset,
            cases,
            radius,
            ours: Ours::new(asset),
            ns: vec![Vec::new(); arguments.balls.div_ceil(BATCH)],
        })
    }

    /// Nodes visited for ball `i`.
    fn answer(&mut self, i: usize) -> u64 {
        let case = &self.cases[i];
        let ball = [(case.center, self.radius)].into_iter();
        let answer = self.ours.balls(&case.q, ball);
        answer
            .expect("a sound asset at q within its limits")
            .nodes
            .visited
    }

    /// One pass over all balls.
    fn time_round(&mut self) {
        for batch in 0..self.ns.len() {
            let balls = BATCH * batch..(BATCH * (batch + 1)).min(self.cases.len());
            let count = balls.len() as f64;
            let start = Instant::now();
            for i in balls {
                black_box(self.answer(black_box(i)));
            }
            self.ns[batch].push(start.elapsed().as_nanos() as f64 / count);
        }
    }

    /// Nanoseconds per ball: of each batch the median over rounds, which others on the machine
    /// interrupt now and then.
    fn ball_ns(&self) -> f64 {
        let medians = self.ns.iter().map(|rounds| stats::median(rounds));
        medians.sum::<f64>() / self.ns.len() as f64
    }

    /// Nanoseconds that preparing a pose takes.
    fn pose_ns(&self) -> f64 {
        let mut memory = vec![0.0; self.asset.pose_len()];
        let runs = (0..50).map(|_| {
            let start = Instant::now();
            for case in &self.cases {
                let pose = self.asset.pose(&case.q, Transform::IDENTITY, &mut memory);
                black_box(pose.is_ok());
            }
            start.elapsed().as_nanos() as f64 / self.cases.len() as f64
        });
        runs.fold(f64::INFINITY, f64::min)
    }

    fn section_bytes(&self, kinds: &[SectionKind]) -> u64 {
        let sections = self.asset.sections().iter();
        let known = sections.filter(|s| kinds.contains(&s.kind));
        known.map(|s| s.length.get()).sum()
    }
}

/// The files: shapes as baked, with displacements of all modes, with all modes everywhere; waves.
fn files(arguments: &Arguments) -> Result<[Model; 4], Box<dyn Error>> {
    let (mesh, shapes) = made::face_with_shapes();
    let mut everywhere = shapes.clone();
    for u in &mut everywhere.fields {
        if *u == [0.0; 3] {
            *u = [SPECK; 3];
        }
    }
    let mut waves = made::smooth_basis(&mesh, arguments.modes, arguments.seed);
    let moved = mean_square(&shapes, Weights::Shapes);
    let scale = (moved / mean_square(&waves, Weights::Waves)).sqrt();
    for u in &mut waves.fields {
        *u = u.map(|c| c * scale);
    }
    let sparse = baked_mesh(&mesh, &shapes)?;
    let all_displacements = sections::with_all_displacements(sparse.asset());
    Ok([
        sparse,
        all_displacements,
        baked_mesh(&mesh, &everywhere)?,
        baked_mesh(&mesh, &waves)?,
    ])
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let files = files(arguments)?;
    let mut contenders = Vec::new();
    for (name, file, weights) in [
        ("52 shapes", &files[0], Weights::Shapes),
        ("local nodes only", &files[1], Weights::Shapes),
        ("all everywhere", &files[2], Weights::Shapes),
        ("dense waves", &files[3], Weights::Waves),
    ] {
        contenders.push(Contender::new(name, *file.asset(), weights, arguments)?);
    }
    let mut counts = Vec::new();
    let mut expected: Vec<Vec<Contact>> = Vec::new();
    for (which, contender) in contenders.iter_mut().enumerate() {
        let (mut nodes, mut contacts) = (0, 0);
        for i in 0..arguments.balls {
            nodes += contender.answer(i);
            contacts += contender.ours.found().len();
            if which == 0 {
                expected.push(contender.ours.found().to_vec());
            } else if which < 3 {
                assert_eq!(
                    contender.ours.found(),
                    expected[i],
                    "the shapes' answers are equal"
                );
            }
        }
        let mean = |count: f64| count / arguments.balls as f64;
        counts.push((mean(nodes as f64), mean(contacts as f64)));
    }
    for round in 0..arguments.rounds {
        for turn in 0..contenders.len() {
            let which = (round + turn) % contenders.len();
            contenders[which].time_round();
        }
    }
    let base = contenders[3].ball_ns();
    let rows: Vec<_> = contenders
        .iter_mut()
        .zip(counts)
        .map(|(c, (nodes, contacts))| {
            let entries = c.section_bytes(&[SectionKind::DISPLACEMENTS]) / 12;
            let acting: usize = c
                .asset
                .nodes()
                .iter()
                .map(|n| usize::from(n.mode_count))
                .sum();
            json!({
                "name": c.name, "modes": c.asset.mode_count(), "bytes": c.asset.bytes().len(),
                "rows_bytes": c.section_bytes(&[SectionKind::NODES, SectionKind::ROWS]),
                "displacement_bytes": c.section_bytes(
                    &[SectionKind::DISPLACEMENTS, SectionKind::VERTEX_MODES]),
                "list_bytes": c.section_bytes(&[SectionKind::MODE_LISTS]),
                "modes_per_vertex": entries as f64 / c.asset.vertex_count() as f64,
                "modes_per_node": acting as f64 / c.asset.node_count() as f64,
                "nodes": nodes, "contacts": contacts, "pose_ns": c.pose_ns(),
                "ns": c.ball_ns(), "ratio": c.ball_ns() / base,
            })
        })
        .collect();
    let value = json!({
        "machine": machine::processor(), "vertices": contenders[0].asset.vertex_count(),
        "triangles": contenders[0].asset.triangle_count(), "balls": arguments.balls,
        "radius_rel": arguments.radius, "rounds": arguments.rounds, "files": rows,
    });
    if arguments.json {
        println!("{value:#}");
    } else {
        print(&value);
    }
    Ok(())
}

fn print(value: &serde_json::Value) {
    println!("machine    {}", value["machine"].as_str().unwrap_or("?"));
    println!(
        "face       {} vertices, {} triangles; {} balls of {} of the diagonal, {} rounds",
        value["vertices"], value["triangles"], value["balls"], value["radius_rel"], value["rounds"],
    );
    println!(
        "                        MB   rows  fields  modes/node  /vertex  contacts  nodes  pose, ns  ns/ball  to the waves"
    );
    let base = value["files"][3]["bytes"].as_f64().unwrap_or(f64::NAN);
    for file in value["files"].as_array().into_iter().flatten() {
        let number = |path: &str| {
            file.pointer(path)
                .and_then(|x| x.as_f64())
                .unwrap_or(f64::NAN)
        };
        println!(
            "{:>3} {:<17} {:>5.2} {:>6.2} {:>7.2} {:>11.1} {:>8.1} {:>9.1} {:>6.1} {:>9.0} {:>8.0}  {:.2}, bytes {:.2}",
            number("/modes"),
            file["name"].as_str().unwrap_or("?"),
            number("/bytes") / 1e6,
            number("/rows_bytes") / 1e6,
            number("/displacement_bytes") / 1e6,
            number("/modes_per_node"),
            number("/modes_per_vertex"),
            number("/contacts"),
            number("/nodes"),
            number("/pose_ns"),
            number("/ns"),
            number("/ratio"),
            number("/bytes") / base,
        );
    }
}
