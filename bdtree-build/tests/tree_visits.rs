//! How many nodes and triangles queries visit: the figures behind
//! docs/design/decisions/tree-split-and-leaf-size.md. Run by hand:
//! `cargo test --release -p bdtree-build --test all -- --ignored --nocapture tree_visits::`

use crate::tree_support::*;
use bdtree_build::basis::Basis;
use bdtree_build::input::RawMesh;
use bdtree_build::pipeline::BakeSettings;
use bdtree_build::tree::Split;
use rand::RngExt;

/// Modelled times: one node of eight lanes at ten modes, one triangle with its three vertices
/// deformed, one sphere pair of a cached node, one pair of triangles.
const NODE_NS: f64 = 40.0;
const TRIANGLE_NS: f64 = 150.0;
const SPHERE_PAIR_NS: f64 = 1.0;
const TRIANGLE_PAIR_NS: f64 = 60.0;

/// Spheres of all lanes at one pose.
struct Spheres {
    of: Vec<[([f64; 3], f64); 8]>,
}

impl Spheres {
    fn new(file: &Decoded, q: &[f32]) -> Self {
        let of = (0..file.nodes.len())
            .map(|i| {
                std::array::from_fn(|k| {
                    let (center, square, _) = file.sphere(i, k, q);
                    (center, square.max(0.0).sqrt())
                })
            })
            .collect();
        Self { of }
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Nodes and triangles that one ball query visits.
fn ball(file: &Decoded, spheres: &Spheres, point: [f64; 3], radius: f64) -> (usize, usize) {
    let (mut nodes, mut triangles) = (0, 0);
    let mut stack = vec![0usize];
    while let Some(i) = stack.pop() {
        nodes += 1;
        let node = &file.nodes[i];
        let mut child = node.first_child as usize;
        for k in 0..8 {
            let inner = node.inner_mask >> k & 1 == 1;
            let (center, r) = spheres.of[i][k];
            if distance(center, point) <= r + radius {
                if inner {
                    stack.push(child);
                }
                triangles += usize::from(node.leaf_counts[k]);
            }
            child += usize::from(inner);
        }
    }
    (nodes, triangles)
}

/// What a pair query between an object and its copy at a rigid offset visits.
#[derive(Default)]
struct PairCount {
    node_pairs: usize,
    evaluated: [Vec<bool>; 2],
    triangle_pairs: usize,
    touched: [Vec<bool>; 2],
}

#[derive(Clone, Copy)]
enum Below {
    Node(usize),
    Leaf(usize, usize),
}

fn lanes(file: &Decoded, spheres: &Spheres, i: usize) -> Vec<([f64; 3], f64, Below)> {
    let node = &file.nodes[i];
    let (mut child, mut slot) = (node.first_child as usize, node.first_slot as usize);
    let mut lanes = Vec::new();
    for k in 0..8 {
        let (center, radius) = spheres.of[i][k];
        if node.inner_mask >> k & 1 == 1 {
            lanes.push((center, radius, Below::Node(child)));
            child += 1;
        } else if node.leaf_counts[k] > 0 {
            let count = usize::from(node.leaf_counts[k]);
            lanes.push((center, radius, Below::Leaf(slot, count)));
            slot += count;
        }
    }
    lanes
}

fn pair(file: &Decoded, spheres: &Spheres, offset: [f64; 3]) -> PairCount {
    let mut count = PairCount {
        evaluated: [vec![false; file.nodes.len()], vec![false; file.nodes.len()]],
        touched: [
            vec![false; file.triangles.len()],
            vec![false; file.triangles.len()],
        ],
        ..PairCount::default()
    };
    // The copy is mirrored through the diagonal, so that nothing lies on itself.
    let place = |c: [f64; 3]| [c[1] + offset[0], c[0] + offset[1], c[2] + offset[2]];
    let whole = |i: usize| ([0.0; 3], f64::INFINITY, Below::Node(i));
    let mut stack = vec![(whole(0), whole(0))];
    while let Some((a, b)) = stack.pop() {
        let mut expand = |side: usize, lane: ([f64; 3], f64, Below)| match lane.2 {
            Below::Node(i) => {
                count.evaluated[side][i] = true;
                lanes(file, spheres, i)
            }
            Below::Leaf(..) => vec![lane],
        };
        let (left, right) = (expand(0, a), expand(1, b));
        for l in &left {
            for r in &right {
                count.node_pairs += 1;
                if distance(l.0, place(r.0)) > l.1 + r.1 {
                    continue;
                }
                match (&l.2, &r.2) {
                    (&Below::Leaf(s, n), &Below::Leaf(t, m)) => {
                        count.triangle_pairs += n * m;
                        count.touched[0][s..s + n].fill(true);
                        count.touched[1][t..t + m].fill(true);
                    }
                    _ => stack.push((*l, *r)),
                }
            }
        }
    }
    count
}

fn measure(name: &str, mesh: &RawMesh, basis: &Basis) {
    for (split, leaf_size) in [
        (Split::Quinlan, 1),
        (Split::Quinlan, 4),
        (Split::Quinlan, 8),
        (Split::Cost, 1),
        (Split::Cost, 2),
        (Split::Cost, 4),
        (Split::Cost, 6),
        (Split::Cost, 8),
        (Split::Cost, 12),
    ] {
        let settings = BakeSettings {
            split,
            leaf_size: Some(leaf_size),
            threads: 2,
            ..BakeSettings::default()
        };
        let baked = bake_with(mesh, basis, &settings);
        let file = Decoded::new(&baked.bytes);
        let lane_count = file.lanes().len() as f64;
        let leaves: u32 = file.nodes.iter().map(|n| n.leaf_mask.count_ones()).sum();
        let tree_bytes = file.nodes.len() * 32 + file.rows.len() * 32;
        print!(
            "{name:10} {split:?} {leaf_size:2}: {:6} nodes {:5.1} MB lanes {:.2} tris {:.2}",
            file.nodes.len(),
            tree_bytes as f64 / 1e6,
            lane_count / file.nodes.len() as f64,
            mesh.triangles.len() as f64 / f64::from(leaves),
        );
        for share in [0.0f32, 0.05, 0.2] {
            // q_range moves a vertex by 5 % of the diagonal; all modes act with random signs.
            let mut rng = rng(17);
            let q: Vec<f32> = file
                .modes
                .iter()
                .map(|m| m.q_range.get() * share / 0.05 * rng.random_range(-1.0f32..1.0))
                .collect();
            let spheres = Spheres::new(&file, &q);
            let deformed = file.deform(&q);
            let root = f64::from(file.header.position_norm_max.get());
            let (mut nodes, mut triangles) = (0, 0);
            let queries = 2000;
            for _ in 0..queries {
                let v = deformed[rng.random_range(0..deformed.len())];
                let direction = unit_vector(&mut rng);
                let radius = 0.02 * root;
                let away = radius * rng.random_range(0.0..2.0);
                let point = std::array::from_fn(|k| v[k] + direction[k] * away);
                let (n, t) = ball(&file, &spheres, point, radius);
                nodes += n;
                triangles += t;
            }
            let (nodes, triangles) = (
                nodes as f64 / queries as f64,
                triangles as f64 / queries as f64,
            );
            let ball_us = (nodes * NODE_NS + triangles * TRIANGLE_NS) / 1e3;
            let extent = |axis: usize| {
                let x = deformed.iter().map(|p| p[axis]);
                x.clone().fold(f64::NEG_INFINITY, f64::max) - x.fold(f64::INFINITY, f64::min)
            };
            let mut pair_ms = 0.0;
            for (x, y, z) in [(0.5, 0.0, 0.1), (0.0, 0.5, 0.3), (0.1, 0.1, 0.9)] {
                let count = pair(
                    &file,
                    &spheres,
                    [x * extent(0), y * extent(1), z * extent(2)],
                );
                let sum =
                    |flags: &[Vec<bool>; 2]| flags.iter().flatten().filter(|&&f| f).count() as f64;
                pair_ms += (sum(&count.evaluated) * NODE_NS
                    + count.node_pairs as f64 * SPHERE_PAIR_NS
                    + sum(&count.touched) * (TRIANGLE_NS / 3.0)
                    + count.triangle_pairs as f64 * TRIANGLE_PAIR_NS)
                    / 3e6;
            }
            print!(" | {nodes:6.1} {triangles:6.1} {ball_us:6.2} µs {pair_ms:7.3} ms");
        }
        println!(
            " | build {:.2} wrap {:.2} s tight {:.3}",
            baked.report.stages["tree"],
            baked.report.stages["wrap"],
            baked.report.tightness.last().map_or(0.0, |t| t.mean),
        );
    }
}

#[test]
#[ignore = "prints a table, asserts nothing"]
fn visits() {
    if let Some(mesh) = corpus_mesh("meshes/nefertiti_lowres.obj.gz") {
        let largest = mesh
            .positions
            .iter()
            .flatten()
            .fold(0.0, |m: f64, x| m.max(x.abs()));
        let fields = basis(&mesh, 10, |j, p| {
            let f = (1.0 + 0.4 * j as f64) * 3.0 / largest;
            let phase = j as f64;
            [
                (f * p[1] + phase).sin(),
                (f * p[2] - phase).cos(),
                (f * p[0] + phase).sin(),
            ]
        });
        measure("nefertiti", &mesh, &fields);
    }
    if let Some((mesh, basis)) = bridge(10) {
        let (mesh, basis) = subdivide(&mesh, &basis);
        measure("bridge", &mesh, &basis);
    }
    let mesh = grid(200);
    measure("cloth", &mesh, &waves(&mesh, 10));
}
