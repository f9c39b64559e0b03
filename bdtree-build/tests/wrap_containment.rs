//! No vertex leaves any of its ancestors' spheres, for any q within the limits.

use crate::tree_support::*;
use bdtree_build::basis::Basis;
use bdtree_build::input::RawMesh;

/// Checks every lane, or about `lanes_max` of them, at `poses` random poses.
fn check(mesh: &RawMesh, basis: &Basis, lanes_max: usize, poses: usize, seed: u64) {
    let file = bake_default(mesh, basis);
    let mut rng = rng(seed);
    let lanes = file.lanes();
    let step = lanes.len().div_ceil(lanes_max).max(1);
    let sampled: Vec<_> = lanes
        .into_iter()
        .step_by(step)
        .map(|(i, k)| (i, k, file.vertices_below(i, k)))
        .collect();
    let mut zero_done = false;
    for _ in 0..poses {
        let q = if zero_done {
            file.random_q(&mut rng)
        } else {
            vec![0.0; file.mode_count()]
        };
        zero_done = true;
        check_f32(&file, &sampled, &q);
        let deformed = file.deform(&q);
        for (i, k, vertices) in &sampled {
            let (center, square, reach) = file.sphere(*i, *k, &q);
            // Exact arithmetic keeps every vertex inside. f64 loses at most (M + 8) 2⁻⁵³ of the
            // largest term, which the norms of section 5 bound; an f32 bound that is one ulp too
            // small is 2⁻²⁴ off, a thousand times more than this margin.
            let scale = reach
                + f64::from(file.header.position_norm_max.get())
                + q.iter()
                    .zip(&file.modes)
                    .map(|(q, m)| f64::from(q.abs()) * f64::from(m.field_norm_max.get()))
                    .sum::<f64>();
            let margin = (file.mode_count() + 8) as f64 * 2f64.powi(-52) * scale;
            for &v in vertices {
                let d2: f64 = (0..3).map(|a| (deformed[v][a] - center[a]).powi(2)).sum();
                let bound = square.max(0.0) + margin * (reach + margin) * 4.0;
                assert!(
                    d2 <= bound,
                    "node {i} lane {k} vertex {v}: {} outside {} at q = {q:?}",
                    d2.sqrt(),
                    bound.sqrt()
                );
            }
        }
    }
}

/// The same in the arithmetic of a query (SPEC 5.6): centers and radii in f32 with γ' under
/// the root and the slack added, vertices in the leaf arithmetic, and the test that skips a node.
fn check_f32(file: &Decoded, lanes: &[(usize, usize, Vec<usize>)], q: &[f32]) {
    let m = file.mode_count();
    let u = 2f64.powi(-24);
    let reach: f64 = q
        .iter()
        .zip(&file.modes)
        .map(|(q, mode)| f64::from(q.abs()) * f64::from(mode.field_norm_max.get()))
        .sum();
    let slack = 8.0 * u * f64::from(file.header.position_norm_max.get())
        + (2 * m + 8) as f64 * u * reach
        + 2f64.powi(-54);
    let slack = (slack as f32).next_up();
    let gamma = ((2 * m + 16) as f64 * u) as f32;
    for (i, k, vertices) in lanes {
        let node = &file.nodes[*i];
        let at = |row: usize| file.value(node, row, *k);
        let mut center = [at(0), at(1), at(2)];
        let (mut cross, mut growth) = (0.0f32, 0.0f32);
        for (a, &mode) in file.node_modes(node).iter().enumerate() {
            let q = q[usize::from(mode)];
            let row = 4 + 6 * a;
            for (axis, c) in center.iter_mut().enumerate() {
                *c += at(row + axis) * q;
            }
            growth += at(row + 3) * q.abs();
            cross += at(row + if q > 0.0 { 4 } else { 5 }) * q.abs();
        }
        let total = at(3) + growth;
        let square = at(3) * at(3) + 2.0 * cross + growth * growth + gamma * (total * total);
        let radius = square.max(0.0).sqrt() + slack;
        for &v in vertices {
            let mut moved = [0.0f32; 3];
            for (j, &q) in q.iter().enumerate() {
                for (x, u) in moved.iter_mut().zip(file.displacements[v * m + j]) {
                    *x += u * q;
                }
            }
            let d2: f64 = (0..3)
                .map(|a| f64::from(file.positions[v][a] + moved[a]) - f64::from(center[a]))
                .map(|d| d * d)
                .sum();
            let skipped = d2 * (1.0 - 2f64.powi(-20)) > f64::from(radius).powi(2);
            assert!(
                !skipped,
                "node {i} lane {k} would be skipped over vertex {v} at q = {q:?}"
            );
        }
    }
}

#[test]
fn spheres_contain_their_vertices_on_generated_meshes() {
    let mesh = grid(40);
    check(&mesh, &waves(&mesh, 6), 400, 60, 1);
    check(&mesh, &Basis::default(), 1000, 1, 2);
    let mesh = soup(700, 3);
    check(&mesh, &waves(&mesh, 9), 200, 60, 4);
}

#[test]
fn spheres_contain_their_vertices_on_hard_meshes() {
    for (name, mesh) in hard_meshes() {
        println!("{name}");
        let largest = mesh
            .positions
            .iter()
            .flatten()
            .fold(0.0, |m: f64, x| m.max(x.abs()));
        let mut fields = waves(&mesh, 2);
        for x in fields.fields.iter_mut().flatten() {
            *x *= largest.min(1e30);
        }
        check(&mesh, &fields, 200, 10, 5);
        check(&mesh, &Basis::default(), 200, 1, 6);
    }
}

#[test]
fn spheres_contain_their_vertices_on_the_bridge() {
    if let Some((mesh, basis)) = bridge(10) {
        check(&mesh, &basis, 300, 40, 7);
    }
}

/// Fields that act on a part only: nodes leave modes out, and are right to.
#[test]
fn spheres_contain_their_vertices_under_local_fields() {
    let mesh = grid(40);
    let local = basis(&mesh, 12, |j, p| {
        let distance = (p[0] - j as f64 / 12.0).abs();
        [0.0, 0.0, (0.1 - distance).max(0.0)]
    });
    check(&mesh, &local, 400, 60, 8);
    let file = bake_default(&mesh, &local);
    assert!(
        file.nodes
            .iter()
            .any(|node| node.mode_count == 0 || node.mode_count < 12)
    );
    assert!(
        !file.vertex_modes.is_empty(),
        "vertices leave modes out too"
    );
    for (i, node) in file.nodes.iter().enumerate() {
        let modes = file.node_modes(node).to_vec();
        for k in 0..8 {
            for v in file.vertices_below(i, k) {
                for j in 0..12u16 {
                    let moved = file.displacements[v * 12 + usize::from(j)] != [0.0; 3];
                    assert!(!moved || modes.contains(&j), "node {i} lacks mode {j}");
                }
            }
        }
    }
}

fn hard_meshes() -> Vec<(&'static str, RawMesh)> {
    let mesh = |positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>| RawMesh {
        positions,
        triangles,
        ..RawMesh::default()
    };
    let scaled = |s: f64, offset: f64| {
        let mut mesh = grid(12);
        for p in &mut mesh.positions {
            *p = p.map(|x| x * s + offset);
        }
        mesh
    };
    vec![
        (
            "one triangle",
            mesh(
                vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
                vec![[0, 1, 2]],
            ),
        ),
        ("a point", mesh(vec![[1.0, 2.0, 3.0]], vec![[0, 0, 0]])),
        ("a point at 0", mesh(vec![[0.0; 3]], vec![[0, 0, 0]])),
        (
            "coincident vertices",
            mesh(
                vec![[5.0, 5.0, 5.0]; 300],
                (0..100).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            ),
        ),
        (
            "the same triangle",
            mesh(
                vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5]],
                vec![[0, 1, 2]; 10_000],
            ),
        ),
        (
            "a line",
            mesh(
                (0..900).map(|i| [f64::from(i), 0.0, 0.0]).collect(),
                (0..898).map(|i| [i, i + 1, i + 2]).collect(),
            ),
        ),
        (
            "doubling distances",
            mesh(
                (0..600).map(|i| [2f64.powi(i / 10), 0.0, 0.0]).collect(),
                (0..598).map(|i| [i, i + 1, i + 2]).collect(),
            ),
        ),
        ("tiny", scaled(1e-30, 0.0)),
        ("huge", scaled(1e30, 0.0)),
        ("far away", scaled(1.0, 1e6)),
        ("very far away", scaled(1e-3, -1e12)),
    ]
}
