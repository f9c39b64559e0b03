//! Budgeted queries on ordinary bodies; on hard cases: `hard_cases.rs`.

use bdtree_fixtures::compare::budgets::{check_budgets, rising};
use bdtree_fixtures::compare::kernels;
use bdtree_fixtures::compare::near::two;
use bdtree_fixtures::{bake, poses};
use bdtree_runtime::{PairContact, Transform, Workspace};
use rand::RngExt;

#[test]
fn bounds_are_true_and_rise_to_the_answer() {
    let mesh = bake::bumpy_sphere(16, 1);
    for basis in [
        bake::smooth_basis(&mesh, 6, 5),
        bake::local_basis(&mesh, 6, 5),
    ] {
        let model = bake::baked(&mesh, &basis);
        let asset = *model.asset();
        let mut rng = poses::rng(3);
        for asset in kernels(&asset) {
            for share in [0.0, 0.05, 0.5] {
                let q = poses::random_q(&asset, share, &mut rng);
                let place = poses::random_transform(5.0, &mut rng);
                check_budgets(&asset, &q, place, 3, 8);
            }
            for q in poses::hard_qs(&asset) {
                check_budgets(&asset, &q, Transform::IDENTITY, 4, 8);
            }
        }
    }
}

#[test]
fn distances_within_a_budget() {
    let mesh = bake::bumpy_sphere(12, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 5));
    let asset = model.asset();
    let mut rng = poses::rng(9);
    let mut workspace = Workspace::new();
    for gap in [0.3, 1.0, 4.0, 5000.0, 1e15] {
        let qa = poses::random_q(asset, 0.1, &mut rng);
        let qb = poses::random_q(asset, 0.1, &mut rng);
        let ta = poses::random_transform(1.0, &mut rng);
        let mut tb = poses::random_transform(1.0, &mut rng);
        tb.translation = ta.translation.map(|x| x + gap * rng.random_range(1.0..2.0));
        two((asset, &qa, ta), (asset, &qb, tb), |two| {
            for [a, b] in two.with_kernels() {
                for limit in [f64::INFINITY, 2.0, 0.1] {
                    if gap > 1e9 && limit > 2.0 {
                        continue; // nothing can be pruned there
                    }
                    let mut query = a.against(b, &mut workspace);
                    let exact = query.closest_points(limit).expect("distance");
                    let most = query.stats().nodes_visited;
                    let ask = |visits: u64, workspace: &mut Workspace<'_>| {
                        let query = a.against(b, workspace);
                        query.max_visits(visits).closest_points(limit)
                    };
                    let by = |hit: &PairContact| hit.distance;
                    let visits = rising(1 << 16, exact, by, limit, ask);
                    assert!(visits.expect("complete") <= most);
                    rising(20, exact, by, limit, ask);
                }
            }
        });
    }
}

#[test]
fn a_few_visits_already_tell_much() {
    // Half the distance is certified, and an answer at most twice as far found, long before the end.
    let mesh = bake::bumpy_sphere(40, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 4, 5));
    let asset = *model.asset();
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset
        .pose(&[0.5; 4], Transform::IDENTITY, &mut memory)
        .expect("pose");
    let mut workspace = Workspace::new();
    let to = [1.5, 1.0, 0.5];
    let mut query = pose.query(&mut workspace);
    let exact = query.project_point(to, f64::INFINITY).expect("closest");
    let truth = exact.expect("a point").distance;
    let mut query = query.max_visits(asset.depth() as u64);
    let answer = query.project_point(to, f64::INFINITY).expect("closest");
    assert!(answer.at_least > 0.5 * truth, "{} {truth}", answer.at_least);
    assert!(answer.found.expect("something").distance < 2.0 * truth);
}
