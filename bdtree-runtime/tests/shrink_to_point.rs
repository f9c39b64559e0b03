//! An object that shrinks to a point (the paper's first limitation: there R + s doubles): radii of each
//! bound by level, and that the second-order bound is exact there but for rounding.
//!
//! `cargo test -p bdtree-runtime --test all -- --nocapture shrink_to_point::` prints the table of
//! docs/design/hard-cases.md.

use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_fixtures::{bake, lanes, models};
use bdtree_runtime::{Asset, Kernel, Pose, Transform, VertexId};

/// u of f32.
const U: f64 = 1.0 / (1_u32 << 24) as f64;

/// A used lane.
struct Lane {
    node: usize,
    lane: usize,
    level: usize,
    vertices: Vec<u32>,
}

fn all_lanes(asset: &Asset<'_>) -> Vec<Lane> {
    let mut all = Vec::new();
    for (node, record) in asset.nodes().iter().enumerate() {
        for lane in (0..8).filter(|k| (record.inner_mask | record.leaf_mask) >> k & 1 == 1) {
            all.push(Lane {
                node,
                lane,
                level: usize::from(record.level),
                vertices: lanes::vertices(asset, node, lane)
                    .into_iter()
                    .map(|v| v as u32)
                    .collect(),
            });
        }
    }
    all
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Radii of a lane at q, in stored units.
struct Radii {
    rest: f64,
    /// R + s, Ū the mean of the displacements.
    paper: f64,
    /// R + s, Ū the center of their smallest ball, as stored.
    ball: f64,
    /// As the runtime evaluates it, `slack` included.
    ours: f64,
    /// The least about the same center.
    wrapped: f64,
    /// What rounding may add to the square of ours.
    rounding: f64,
    slack: f64,
}

fn radii(pose: &Pose<'_>, lane: &Lane) -> Radii {
    let asset = pose.asset();
    let rows = asset.node_rows(&asset.nodes()[lane.node]).expect("rows");
    let mode = &asset.modes()[0];
    let q = f64::from(pose.q()[0]).abs();
    let share = q / f64::from(mode.q_limit.get());
    let [center, growth, cross] = rows.units.map(|unit| share * f64::from(unit));
    let rest = f64::from(rows.leading[3][lane.lane]);
    let spread = f64::from(rows.numbers(0, lane.lane)[3]) * growth;
    let field = |v: &u32| {
        asset
            .displacements(VertexId(*v))
            .expect("a vertex")
            .of(0)
            .map(f64::from)
    };
    let count = lane.vertices.len() as f64;
    let mean = [0, 1, 2].map(|k| lane.vertices.iter().map(|v| field(v)[k]).sum::<f64>() / count);
    let farthest = |f: &dyn Fn(&u32) -> f64| lane.vertices.iter().map(f).fold(0.0, f64::max);
    let spheres = pose.node_spheres(lane.node as u32).expect("node");
    let middle = spheres.center.map(|row| f64::from(row[lane.lane]));
    let place = |v: &u32| {
        pose.deformed_stored(VertexId(*v))
            .expect("a vertex")
            .map(f64::from)
    };
    // b is rounded up by at most a unit, ΔR by one, Ū to √3/2 units; γ' under the root.
    let around = rest + spread + center + growth;
    let rounding = 2.0 * (cross + 2.0 * around * (center + growth)) + 20.0 * U * around * around;
    Radii {
        rest,
        paper: rest + q * farthest(&|v| distance(field(v), mean)),
        ball: rest + spread,
        ours: f64::from(spheres.radius[lane.lane]),
        wrapped: farthest(&|v| distance(place(v), middle)),
        rounding,
        slack: pose.slack() / asset.unit(),
    }
}

/// Prints the table of a mesh that shrinks about a point and checks every lane.
fn check(name: &str, mut mesh: RawMesh, about: [f64; 3]) {
    for p in &mut mesh.positions {
        *p = [0, 1, 2].map(|k| p[k] - about[k]);
    }
    let field = mesh.positions.iter().map(|p| p.map(|x| -x)).collect();
    let model = bake::baked(&mesh, &bake::basis_of(&[field]));
    let asset = *model.asset();
    let lanes = all_lanes(&asset);
    println!(
        "{name}: {} triangles; means over lanes of R'/R",
        asset.triangle_count()
    );
    println!("| q | level | lanes | R + s, mean | R + s, ball | second order | wrapped |");
    println!("|---|---|---|---|---|---|---|");
    for q in [0.5_f32, 0.75, 0.9, 0.99, 1.0] {
        let exact = (1.0 - f64::from(q)).abs();
        let mut sums = vec![[0.0; 5]; asset.depth()];
        for kernel in Kernel::ALL {
            let Some(asset) = asset.with_kernel(kernel) else {
                continue;
            };
            let mut memory = vec![0.0; asset.pose_len()];
            let pose = asset
                .pose(&[q], Transform::IDENTITY, &mut memory)
                .expect("pose");
            for lane in &lanes {
                let r = radii(&pose, lane);
                // Nothing is outside, nothing is better than it can be.
                assert!(r.wrapped <= r.ours && r.ours <= r.ball * (1.0 + 1e-3) + r.slack);
                // Exact: R |1 − q|, and under the root what rounding adds.
                let root = (r.rest * exact).hypot(r.rounding.sqrt());
                assert!(
                    r.ours <= (root + r.slack) * (1.0 + 8.0 * U),
                    "{q}, {}",
                    lane.level
                );
                assert!(r.ours >= r.rest * exact * (1.0 - 8.0 * U));
                if kernel == Kernel::Scalar && r.rest > 0.0 {
                    let shares = [r.paper, r.ball, r.ours, r.wrapped].map(|x| x / r.rest);
                    let sum = &mut sums[lane.level];
                    for k in 0..4 {
                        sum[k] += shares[k];
                    }
                    sum[4] += 1.0;
                }
            }
        }
        for (level, [paper, ball, ours, wrapped, count]) in sums.into_iter().enumerate() {
            let [paper, ball, ours, wrapped] = [paper, ball, ours, wrapped].map(|x| x / count);
            println!(
                "| {q} | {level} | {count} | {paper:.3} | {ball:.3} | {ours:.4} | {wrapped:.4} |"
            );
            assert!(paper > 1.0 + 0.8 * f64::from(q) && ball > 1.0 + 0.8 * f64::from(q));
            assert!(ours < exact + 0.06, "{q}, {level}: {ours}");
        }
    }
}

#[test]
fn a_sphere_that_shrinks() {
    check("bumpy sphere", bake::bumpy_sphere(20, 3), [0.0; 3]);
}

#[test]
fn a_chair_that_shrinks() {
    let mesh = read_mesh(&models::path("chair")).expect("fixture");
    let count = mesh.positions.len() as f64;
    let about = [0, 1, 2].map(|k| mesh.positions.iter().map(|p| p[k]).sum::<f64>() / count);
    check("chair", mesh, about);
}
