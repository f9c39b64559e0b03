//! Nested bakes: every sphere holds those below it at every q, files are sound, answers the same.

use bdtree_build::basis::Basis;
use bdtree_build::input::RawMesh;
use bdtree_build::pipeline::BakeSettings;
use bdtree_fixtures::compare::{check_pairs, check_pose, kernels};
use bdtree_fixtures::{bake, poses};
use bdtree_format::{LANES, NodeRecord};
use bdtree_runtime::{Asset, Kernel, Model, Transform};

fn nested(mesh: &RawMesh, basis: &Basis) -> Model {
    let settings = BakeSettings {
        nested: true,
        ..BakeSettings::default()
    };
    bake::baked_with(mesh, basis, &settings)
}

fn cases() -> Vec<(RawMesh, Basis)> {
    let mesh = bake::bumpy_sphere(20, 1);
    vec![
        (mesh.clone(), bake::smooth_basis(&mesh, 8, 5)),
        (mesh.clone(), bake::local_basis(&mesh, 12, 5)),
        (mesh.clone(), bake::rigid(&mesh)),
    ]
}

/// Every lane that leads to a node, with the node below it: node index, lane, child index.
fn links(asset: &Asset<'_>) -> Vec<(u32, usize, u32)> {
    let mut all = Vec::new();
    for (i, node) in (0..).zip(asset.nodes()) {
        let inner = (0..LANES).filter(|k| node.inner_mask >> k & 1 == 1);
        all.extend(
            inner
                .zip(node.first_child..)
                .map(|(lane, child)| (i, lane, child)),
        );
    }
    all
}

fn used(node: &NodeRecord) -> impl Iterator<Item = usize> {
    let mask = node.inner_mask | node.leaf_mask;
    (0..LANES).filter(move |k| mask >> k & 1 == 1)
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// How far, over the diagonal, the spheres below stick out of a lane's at q: the most, and the share
/// of lanes of which one does by more than rounding.
fn sticking_out(asset: &Asset<'_>, q: &[f32]) -> (f64, f64) {
    let asset = asset.with_kernel(Kernel::Scalar).expect("always there");
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset
        .pose(q, Transform::IDENTITY, &mut memory)
        .expect("pose");
    let (mut most, mut count) = (0.0_f64, 0);
    let links = links(&asset);
    for (node, lane, child) in &links {
        let outer = pose.node_spheres(*node).expect("node");
        let inner = pose.node_spheres(*child).expect("node");
        let mut out = f64::NEG_INFINITY;
        for k in used(&asset.nodes()[*child as usize]) {
            let apart = [0, 1, 2]
                .map(|a| f64::from(inner.center[a][k]) - f64::from(outer.center[a][*lane]));
            out =
                out.max(norm(apart) + f64::from(inner.radius[k]) - f64::from(outer.radius[*lane]));
        }
        let out = out / poses::diagonal(&asset);
        most = most.max(out);
        count += usize::from(out > 1e-5);
    }
    (most, count as f64 / links.len() as f64)
}

#[test]
fn spheres_hold_those_below_them_at_every_q() {
    let mut rng = poses::rng(1);
    for (mesh, basis) in cases() {
        let models = [nested(&mesh, &basis), bake::baked(&mesh, &basis)];
        let [asset, plain] = models.each_ref().map(Model::asset);
        assert_eq!(asset.nodes().len(), plain.nodes().len(), "the same tree");
        let mut qs: Vec<Vec<f32>> = [0.0, 0.02, 0.1, 0.5, 3.0]
            .map(|share| poses::random_q(asset, share, &mut rng))
            .into();
        qs.push(
            asset
                .modes()
                .iter()
                .map(|mode| mode.q_range.get())
                .collect(),
        );
        let mut stick_out = 0.0_f64;
        for q in &qs {
            let size = 1.0 + norm_of_motion(asset, q);
            // f32 rounding of both spheres and the slack of the inner one, well below this.
            let (most, _) = sticking_out(asset, q);
            assert!(most < 1e-5 * size, "{most:e} of the diagonal at {q:?}");
            stick_out = stick_out.max(sticking_out(plain, q).1);
        }
        // Wrapped spheres do: else this test could not fail.
        assert!(stick_out > 0.05, "{stick_out} of the plain tree's lanes");
    }
}

/// Bound of the motion over the diagonal.
fn norm_of_motion(asset: &Asset<'_>, q: &[f32]) -> f64 {
    let modes = asset.modes().iter().zip(q);
    let reach: f64 = modes
        .map(|(m, q)| f64::from(m.field_norm_max.get() * q.abs()))
        .sum();
    reach / poses::diagonal(asset)
}

/// The inequalities of the proof, on the numbers as stored; f64 loses less than the tolerance.
#[test]
fn stored_numbers_satisfy_the_proof() {
    for (mesh, basis) in cases() {
        let model = nested(&mesh, &basis);
        let asset = model.asset();
        let mut checked = 0;
        for (node, lane, child) in links(asset) {
            let (outer, inner) = (
                &asset.nodes()[node as usize],
                &asset.nodes()[child as usize],
            );
            let (rows, below) = (
                asset.node_rows(outer).unwrap(),
                asset.node_rows(inner).unwrap(),
            );
            let (modes, below_modes) = (
                asset.node_modes(outer).unwrap(),
                asset.node_modes(inner).unwrap(),
            );
            let radius = f64::from(rows.leading[3][lane]);
            for k in used(inner) {
                let apart = [0, 1, 2]
                    .map(|a| f64::from(below.leading[a][k]) - f64::from(rows.leading[a][lane]));
                let needed = norm(apart) + f64::from(below.leading[3][k]);
                assert!(radius >= needed * (1.0 - 1e-15), "R {radius} < {needed}");
                for (j, mode) in modes.iter().enumerate() {
                    let [x, y, z, growth, plus, minus] =
                        rows.pairs[j / 2].numbers(j, lane).map(f64::from);
                    let units = rows.units.map(f64::from);
                    let center = [x, y, z].map(|n| n * units[0]);
                    let growth = growth * units[1];
                    let there = below_modes.iter().position(|m| m == mode);
                    let (other, reach) = there.map_or(([0.0; 3], 0.0), |j| {
                        let [x, y, z, growth, ..] = below.pairs[j / 2].numbers(j, k).map(f64::from);
                        let units = below.units.map(f64::from);
                        ([x, y, z].map(|n| n * units[0]), growth * units[1])
                    });
                    let apart = [0, 1, 2].map(|a| other[a] - center[a]);
                    let needed = norm(apart) + reach;
                    assert!(
                        growth >= needed * (1.0 - 1e-15),
                        "delta R {growth} < {needed}"
                    );
                    assert!(plus.min(minus) * units[2] >= radius * growth);
                    checked += 1;
                }
            }
        }
        assert!(checked > 500 || asset.mode_count() == 0, "{checked}");
    }
}

#[test]
fn nested_files_are_sound_and_answer_the_same() {
    for (mesh, basis) in cases() {
        let model = nested(&mesh, &basis);
        let asset = model.asset();
        let mut errors = Vec::new();
        asset.verify(&mut |e| {
            errors.push(e);
            core::ops::ControlFlow::Continue(())
        });
        assert!(errors.is_empty(), "{}", errors[0]);
        let mut rng = poses::rng(2);
        let q = poses::random_q(asset, 0.3, &mut rng);
        check_pose(
            kernels(asset),
            &q,
            poses::random_transform(5.0, &mut rng),
            3,
            6,
        );
        check_pairs(asset, 3, 3, 0.3);
    }
}
