//! What local fields cost: a face with 52 blend shapes as it is baked, the same with modes and
//! displacements everywhere, and the face with 12 dense modes; bytes and a small ball.

use bdtree_build::basis::Basis;
use bdtree_fixtures::{bake as made, sections};
use bdtree_format::SectionKind;
use bdtree_scenes::contenders::assets::baked_mesh;

use crate::prelude::*;

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
    /// Balls are centered up to this many radii from a vertex
    #[arg(long, default_value_t = 1.0)]
    spread: f64,
    /// Seed of waves, weights and positions
    #[arg(long, default_value_t = 2004)]
    seed: u64,
}

/// A displacement that is stored and moves nothing.
const SPECK: f64 = 1e-30;

/// From where to where weights of shapes lie, and of waves.
const SHAPES: [f64; 2] = [0.0, 1.0];
const WAVES: [f64; 2] = [-1.0, 1.0];

/// Mean square of how far vertices are moved by random weights.
fn mean_square(basis: &Basis, [low, high]: [f64; 2]) -> f64 {
    let (mean, variance) = (0.5 * (low + high), (high - low).powi(2) / 12.0);
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

/// The files: shapes as baked, with displacements of all modes, with all modes everywhere; waves.
fn files(arguments: &Arguments) -> Result<[Model; 4]> {
    let (mesh, shapes) = made::face_with_shapes();
    let mut everywhere = shapes.clone();
    for u in &mut everywhere.fields {
        if *u == [0.0; 3] {
            *u = [SPECK; 3];
        }
    }
    let mut waves = made::smooth_basis(&mesh, arguments.modes, arguments.seed);
    let scale = (mean_square(&shapes, SHAPES) / mean_square(&waves, WAVES)).sqrt();
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

/// Bytes of a file's parts, and how many modes act where.
fn bytes(asset: &Asset<'_>) -> Row {
    let bytes = |kinds: &[SectionKind]| {
        let sections = asset.sections().iter();
        let known = sections.filter(|s| kinds.contains(&s.kind));
        known.map(|s| s.length.get()).sum::<u64>()
    };
    let entries = bytes(&[SectionKind::DISPLACEMENTS]) / 12;
    let acting = asset.nodes().iter().map(|n| u64::from(n.mode_count));
    row! {
        "modes" => asset.mode_count(), "bytes" => asset.bytes().len(),
        "nodes and rows" => bytes(&[SectionKind::NODES, SectionKind::ROWS]),
        "displacements" => bytes(&[SectionKind::DISPLACEMENTS, SectionKind::VERTEX_MODES]),
        "lists" => bytes(&[SectionKind::MODE_LISTS]),
        "modes per vertex" => entries as f64 / asset.vertex_count() as f64,
        "modes per node" => acting.sum::<u64>() as f64 / asset.node_count() as f64,
    }
}

pub(crate) fn run(arguments: &Arguments, rounds: usize) -> Result<Vec<Table>> {
    let files = files(arguments)?;
    // The waves first: they are what the others are compared with.
    let contenders = [
        ("dense waves", &files[3], WAVES),
        ("52 shapes", &files[0], SHAPES),
        ("local nodes only", &files[1], SHAPES),
        ("all everywhere", &files[2], SHAPES),
    ];
    let wanted = (arguments.balls, arguments.radius);
    let mut asked = Vec::new();
    let mut expected: Vec<Vec<Contact>> = Vec::new();
    for (k, (_, file, weights)) in contenders.iter().enumerate() {
        let asset = file.asset();
        let [low, high] = weights.map(|weight| weight as f32);
        let cases = cases(asset, wanted, poses::rng(arguments.seed), |_, rng| {
            let weights = (0..asset.mode_count()).map(|_| rng.random_range(low..high));
            (weights.collect(), arguments.spread)
        })?;
        let mut ours = Ours::new(*file.asset());
        for (i, case) in cases.iter().enumerate().filter(|_| k > 0) {
            case.ask(&mut ours)?;
            match k {
                1 => expected.push(ours.found.to_vec()),
                _ => assert_eq!(ours.found, expected[i], "the shapes' answers are equal"),
            }
        }
        asked.push((cases, ours));
    }
    let pairs = contenders.iter().zip(&mut asked);
    let entries = pairs.map(|((name, ..), (cases, ours))| {
        let batches: Vec<&[Case]> = cases.chunks(BATCH).collect();
        Entry::new(name, Role::Ours, Counts::Other, move |batch| {
            pass(batches[batch], |case| case.ask(ours))
        })
    });
    let batches = arguments.balls.div_ceil(BATCH);
    let measured = compare(entries.collect(), batches, rounds)?;
    let mut rows = rows(&[], &measured, arguments.balls, "ns per ball");
    let base = files[3].asset().bytes().len() as f64;
    for ((row, (_, file, _)), (cases, _)) in rows.iter_mut().zip(contenders).zip(&asked) {
        let asset = file.asset();
        let mut memory = vec![0.0; asset.pose_len()];
        let pose_ns = least_ns(1, cases.len(), |i| {
            let pose = asset.pose(&cases[i].q, Transform::IDENTITY, &mut memory);
            black_box(pose.is_ok());
        });
        row.extend(row! {
            "bytes to the waves" => asset.bytes().len() as f64 / base, "pose, ns" => pose_ns,
        });
        row.extend(bytes(asset));
    }
    let asset = files[0].asset();
    let face = row! {
        "vertices" => asset.vertex_count(), "triangles" => asset.triangle_count(),
        "balls" => arguments.balls, "radius over the diagonal" => arguments.radius, "rounds" => rounds,
    };
    Ok(vec![
        table("face", "The face", &[face]),
        table("files", "Files in turns, per ball", &rows),
    ])
}
