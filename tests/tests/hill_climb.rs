//! A search for q that pushes a vertex out of a sphere above it: the violation, as a share of the
//! slack that pays for rounding, is never positive.

use bdtree_build::input::RawMesh;
use bdtree_runtime::{Asset, Kernel, Pose, Transform, VertexId};
use bdtree_tests::{bake, poses};
use rand::RngExt;

/// How far outside the sphere of (node, lane) the vertex is, over the pose's slack; below 0 inside.
fn violation(asset: &Asset<'_>, q: &[f32], node: u32, lane: usize, vertex: u32) -> f64 {
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = Pose::new(asset, q, Transform::IDENTITY, &mut memory).expect("pose");
    let spheres = asset.node_spheres(&pose, node).expect("node");
    let radius = f64::from(spheres.radius[lane]);
    if radius.is_nan() {
        return f64::NEG_INFINITY; // every test reads it as "visit"
    }
    let p = asset
        .deformed_stored(&pose, VertexId(vertex))
        .expect("vertex");
    let square: f64 = (0..3)
        .map(|k| (f64::from(p[k]) - f64::from(spheres.centre[k][lane])).powi(2))
        .sum();
    (square.sqrt() - radius) * asset.unit() / pose.slack()
}

/// Leaf lanes and the vertices they hold.
fn cases(asset: &Asset<'_>) -> Vec<(u32, usize, u32)> {
    let mut cases = Vec::new();
    for (i, node) in (0..).zip(asset.nodes()) {
        let mut slot = node.first_slot as usize;
        for lane in 0..8 {
            let count = usize::from(node.leaf_counts[lane]);
            for triangle in &asset.triangles()[slot..slot + count] {
                cases.extend(triangle.corners.map(|v| (i, lane, v)));
            }
            slot += count;
        }
    }
    cases
}

/// Climbs from `starts` random cases; returns the largest violation met.
fn climb(mesh: &RawMesh, mode_count: usize, kernel: Kernel, starts: usize, steps: usize) -> f64 {
    let bytes = bake::baked(mesh, &bake::smooth_basis(mesh, mode_count, 6));
    let asset = Asset::open(&bytes).expect("open");
    let asset = asset.with_kernel(kernel).expect("an available kernel");
    let mut rng = poses::rng(mode_count as u64);
    let cases = cases(&asset);
    let mut worst = f64::NEG_INFINITY;
    for start in 0..starts {
        let (node, lane, vertex) = cases[rng.random_range(0..cases.len())];
        let share = [1e-3, 0.05, 1.0, 20.0][start % 4];
        let mut q = poses::random_q(&asset, share, &mut rng);
        let mut best = violation(&asset, &q, node, lane, vertex);
        for step in 0..steps {
            let mut next = q.clone();
            let j = rng.random_range(0..mode_count);
            let limit = asset.modes()[j].q_limit.get();
            match step % 4 {
                0 => next[j] *= rng.random_range(-2.0..2.0_f32),
                1 => next[j] = 0.0,
                // The last bits decide how rounding falls.
                2 => next[j] = f32::from_bits(next[j].to_bits() ^ rng.random_range(1..64)),
                _ => next
                    .iter_mut()
                    .for_each(|q| *q *= rng.random_range(0.9..1.1_f32)),
            }
            next.iter_mut().for_each(|q| *q = q.clamp(-limit, limit));
            let found = violation(&asset, &next, node, lane, vertex);
            if found > best {
                (best, q) = (found, next);
            }
        }
        assert!(
            best <= 0.0,
            "vertex {vertex} leaves lane {lane} of node {node} by {best} slacks at {q:?}"
        );
        worst = worst.max(best);
    }
    worst
}

#[test]
fn no_climb_leaves_a_sphere() {
    let mesh = bake::bumpy_sphere(6, 5);
    // Far from the origin the terms of the centre matter most.
    let mut shifted = mesh.clone();
    for p in &mut shifted.positions {
        *p = [p[0] + 1.5, p[1] - 1.0, p[2]];
    }
    let kernels = Kernel::ALL;
    for kernel in kernels.into_iter().filter(|k| k.is_available()) {
        for (mesh, mode_count) in [(&mesh, 1), (&shifted, 2), (&shifted, 8), (&mesh, 48)] {
            let worst = climb(mesh, mode_count, kernel, 48, 2500);
            println!("{kernel:?}, {mode_count} modes: tightest at {worst:.4} slacks");
        }
    }
}
