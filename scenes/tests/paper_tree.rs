//! The baseline is what it claims to be: the paper's tree, with the product's answers.

use bdtree_build::basis::{Basis, BasisMode};
use bdtree_build::pipeline::BakeSettings;
use bdtree_build::tree::Split;
use bdtree_fixtures::{bake, oracle, poses};
use bdtree_measure::paper_tree::{PaperTree, Step, Vertices};
use bdtree_runtime::{Asset, Ball, Contact, Transform, VertexId, Workspace};
use rand::RngExt;

#[test]
fn balls_of_all_builders_equal_brute_force() {
    let mesh = bake::bumpy_sphere(24, 3);
    let basis = bake::smooth_basis(&mesh, 6, 3);
    for split in [Split::Quinlan, Split::Cost] {
        let settings = BakeSettings {
            split,
            ..BakeSettings::default()
        };
        balls_equal_brute_force(bake::baked_with(&mesh, &basis, &settings).asset());
    }
}

/// Of the product's tree and of the paper's over the same vertices.
fn balls_equal_brute_force(asset: &Asset<'_>) {
    let tree = PaperTree::build(asset);
    let mut rng = poses::rng(5);
    let mut memory = vec![0.0; asset.pose_len()];
    let mut workspace = Workspace::new();
    let (mut step, mut vertices, mut paper_stack) =
        (Step::default(), Vertices::new(asset), Vec::new());
    let diagonal = poses::diagonal(asset) * asset.unit();
    let mut hits = 0;
    let mut qs = poses::hard_qs(asset);
    qs.extend((0..40).map(|_| poses::random_q(asset, 0.3, &mut rng)));
    for q in &qs {
        let pose = asset
            .pose(q, Transform::IDENTITY, &mut memory)
            .expect("pose");
        step.prepare(&pose);
        vertices.begin_step();
        let triangles = oracle::deformed_triangles(&pose);
        for _ in 0..10 {
            let mut center = triangles[rng.random_range(0..triangles.len())][0];
            for c in &mut center {
                *c += 0.05 * diagonal * rng.random_range(-1.0..1.0);
            }
            let radius = diagonal * 10_f64.powf(rng.random_range(-3.0..-0.5));
            let expected = oracle::ball(&triangles, center, radius);
            let mut paper: Vec<Contact> = Vec::new();
            tree.ball(
                &pose,
                &step,
                (center, radius),
                (&mut vertices, &mut paper_stack),
                &mut paper,
            );
            let mut product: Vec<Contact> = Vec::new();
            let mut query = pose.query(&mut workspace);
            let ball = Ball::new(center, radius);
            query.contacts(ball, &mut product).expect("ball");
            for found in [&mut paper, &mut product] {
                found.sort_by_key(|c| c.triangle);
                let answer: Vec<(u32, f64)> =
                    found.iter().map(|c| (c.triangle.0, c.distance)).collect();
                let expected: Vec<(u32, f64)> =
                    expected.iter().map(|(id, d)| (*id, d - radius)).collect();
                assert_eq!(answer, expected, "ball at {center:?}, radius {radius}");
            }
            hits += expected.len();
        }
    }
    assert!(hits > 1000, "only {hits} contacts: the test shows nothing");
}

/// P04: exactly one leaf per triangle.
#[test]
fn one_leaf_per_triangle() {
    for rings in [3, 4, 9, 20] {
        let mesh = bake::bumpy_sphere(rings, 1);
        let model = bake::baked(&mesh, &bake::rigid(&mesh));
        let asset = model.asset();
        let tree = PaperTree::build(asset);
        let count = asset.triangle_count();
        assert_eq!(tree.node_count(), 2 * count - 1);
        let nodes = tree.nodes();
        let mut leaves: Vec<u32> = nodes
            .iter()
            .filter(|(_, below)| below.len() == 1)
            .map(|(_, below)| below[0])
            .collect();
        leaves.sort_unstable();
        assert_eq!(leaves, (0..count as u32).collect::<Vec<_>>());
        // Median splits: as shallow as a binary tree can be.
        assert_eq!(
            tree.depth,
            count.next_power_of_two().trailing_zeros() as usize + 1
        );
    }
}

/// P13: no vertex below a node leaves its deformed sphere.
#[test]
fn spheres_hold_their_vertices() {
    let mesh = bake::bumpy_sphere(12, 8);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 5, 8));
    let asset = model.asset();
    let tree = PaperTree::build(asset);
    let nodes = tree.nodes();
    let mut memory = vec![0.0; asset.pose_len()];
    let mut step = Step::default();
    let mut qs = poses::hard_qs(asset);
    let mut rng = poses::rng(9);
    qs.extend((0..100).map(|_| poses::random_q(asset, 0.5, &mut rng)));
    for q in &qs {
        let pose = asset
            .pose(q, Transform::IDENTITY, &mut memory)
            .expect("pose");
        step.prepare(&pose);
        let vertices: Vec<[f32; 3]> = (0..asset.vertex_count() as u32)
            .map(|v| pose.deformed_stored(VertexId(v)).expect("vertex"))
            .collect();
        for (i, (_, triangles)) in nodes.iter().enumerate() {
            let [x, y, z, r] = tree.sphere(&step, i).map(f64::from);
            for v in triangles.iter().flat_map(|t| tree.corners[*t as usize]) {
                let p = vertices[v as usize].map(f64::from);
                let distance =
                    ((p[0] - x).powi(2) + (p[1] - y).powi(2) + (p[2] - z).powi(2)).sqrt();
                assert!(
                    distance <= r,
                    "vertex {v} leaves node {i}: {distance} > {r}"
                );
            }
        }
    }
}

/// P21's shape: on the lowest deformations of a body (bend, shear, twist, stretch) the mean
/// ‖ΔR‖ falls from level to level.
///
/// Not so for fields with several waves over the body: there half a body still holds the whole
/// range of the field, and the mean of half may lie farther off its middle than that of all
/// (0.37 at the root, 0.40 a level below with the waves of the other tests).
#[test]
fn growth_decays_by_level() {
    let mesh = bake::bumpy_sphere(32, 2);
    let fields: [fn([f64; 3]) -> [f64; 3]; 4] = [
        |[x, _, _]| [0.0, 0.0, 0.1 * x * x],
        |[x, _, z]| [0.1 * z, 0.05 * x, 0.0],
        |[x, y, z]| [-0.1 * z * y, 0.1 * z * x, 0.0],
        |[x, y, z]| [0.1 * x, -0.05 * y, -0.05 * z],
    ];
    let basis = Basis {
        vertex_count: mesh.positions.len(),
        fields: fields
            .iter()
            .flat_map(|field| mesh.positions.iter().map(|p| field(*p)))
            .collect(),
        modes: vec![BasisMode::default(); fields.len()],
        animation: None,
    };
    let model = bake::baked(&mesh, &basis);
    let asset = model.asset();
    let tree = PaperTree::build(asset);
    let mut levels = vec![(0.0, 0.0); tree.depth];
    for (i, (level, _)) in tree.nodes().iter().enumerate() {
        let squared: f64 = tree.numbers(i)[1..]
            .iter()
            .map(|row| f64::from(row[3]).powi(2))
            .sum();
        levels[*level].0 += squared.sqrt();
        levels[*level].1 += 1.0;
    }
    let means: Vec<f64> = levels.iter().map(|(sum, count)| sum / count).collect();
    let table: Vec<f64> = means.iter().map(|mean| mean / means[0]).collect();
    println!("{table:.3?}");
    assert!(
        table.windows(2).all(|pair| pair[1] < pair[0]),
        "{table:.3?}"
    );
    // The paper's chair has 0.030 there: within a factor of three.
    assert!((0.01..0.09).contains(&table[10]), "{table:.3?}");
}
