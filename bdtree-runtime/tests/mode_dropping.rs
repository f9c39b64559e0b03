//! Poses that leave out the modes that matter least: answers stay, spheres grow by what is left out,
//! and no more than was allowed.

use bdtree_fixtures::compare::{check_pose_within, kernels};
use bdtree_fixtures::{bake, oracle, poses};
use bdtree_runtime::studies::pose_within;
use bdtree_runtime::{Asset, Ball, Contact, PairContact, PoseError, Transform, Workspace};

/// q whose modes move the less the later they come; the first a twentieth of the diagonal.
fn graded_q(asset: &Asset<'_>) -> Vec<f32> {
    let mut reach = 0.05 * poses::diagonal(asset);
    let mut sign = 1.0;
    (asset.modes().iter())
        .map(|mode| {
            let q = sign * reach / f64::from(mode.field_norm_max.get());
            (reach, sign) = (0.7 * reach, -sign);
            q as f32
        })
        .collect()
}

/// How far each pair of modes moves a vertex at most, the least first (stored units).
fn reaches(asset: &Asset<'_>, q: &[f32]) -> Vec<f64> {
    let of_mode: Vec<f64> = (asset.modes().iter().zip(q))
        .map(|(mode, q)| f64::from(mode.field_norm_max.get()) * f64::from(q.abs()))
        .collect();
    let mut of_pair: Vec<f64> = of_mode.chunks(2).map(|pair| pair.iter().sum()).collect();
    of_pair.sort_by(f64::total_cmp);
    of_pair
}

#[test]
fn answers_stay_and_spheres_grow_by_what_is_left_out() {
    let mesh = bake::bumpy_sphere(10, 5);
    for basis in [
        bake::smooth_basis(&mesh, 13, 2),
        bake::local_basis(&mesh, 20, 3),
    ] {
        let model = bake::baked(&mesh, &basis);
        let asset = *model.asset();
        let q = graded_q(&asset);
        let reaches = reaches(&asset, &q);
        let place = Transform {
            scale: 3.0,
            ..Transform::IDENTITY
        };
        let world = 3.0 * asset.unit();
        let size = poses::diagonal(&asset) * world;
        let mut memory = vec![0.0; asset.pose_len()];
        let all = asset.pose(&q, place, &mut memory).expect("pose");
        let (slack, modes) = (all.slack(), all.active_modes());
        let mut fewest = modes;
        for share in [0.0, 1e-4, 1e-3, 1e-2, 0.1, f64::INFINITY] {
            let tolerance = share * size;
            let mut memory = vec![0.0; asset.pose_len()];
            let pose = pose_within(&asset, &q, place, tolerance, &mut memory);
            let pose = pose.expect("pose");
            // The slow twin: the least first, while they fit.
            let (mut left_out, mut dropped) = (0.0, 0);
            while let Some(reach) = reaches.get(dropped)
                && (left_out + reach) * world <= tolerance
            {
                (left_out, dropped) = (left_out + reach, dropped + 1);
            }
            let kept = 2 * (reaches.len() - dropped);
            assert!(kept.abs_diff(pose.active_modes()) <= 1, "{share}");
            // Modes left out are not rounded, which takes a little off.
            let grown = pose.slack() - slack;
            assert!(grown <= left_out * world * (1.0 + 1e-4) + 1e-6 * slack);
            assert!(grown >= left_out * world * (1.0 - 1e-4) - slack);
            fewest = fewest.min(pose.active_modes());
            check_pose_within(kernels(&asset), &q, place, tolerance, 3, 8);
        }
        assert_eq!(fewest, 0);
    }
}

#[test]
fn pairs_stay_and_dropping_costs_visits() {
    let mesh = bake::bumpy_sphere(10, 5);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 12, 2));
    let asset = *model.asset();
    let q = graded_q(&asset);
    let size = poses::diagonal(&asset) * asset.unit();
    let place = |x: f64| Transform {
        translation: [x * size, 0.0, 0.0],
        ..Transform::IDENTITY
    };
    let mut visits = Vec::new();
    for tolerance in [0.0, 0.02 * size, f64::INFINITY] {
        let (mut first, mut second) = (vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]);
        let a = pose_within(&asset, &q, place(0.0), tolerance, &mut first).expect("pose");
        let b = pose_within(&asset, &q, place(0.3), tolerance, &mut second).expect("pose");
        let mut workspace = Workspace::new();
        let mut found: Vec<PairContact> = Vec::new();
        let mut query = a.against(&b, &mut workspace);
        query.contacts(0.0, &mut found).expect("pair");
        let mut ids: Vec<(u32, u32)> = found
            .iter()
            .map(|c| (c.triangle1.0, c.triangle2.0))
            .collect();
        ids.sort_unstable();
        let triangles = [&a, &b].map(oracle::deformed_triangles);
        assert_eq!(ids, oracle::pair(&triangles[0], &triangles[1], 0.0));
        assert!(!ids.is_empty());

        let mut found: Vec<Contact> = Vec::new();
        let ball = Ball::new(triangles[0][0][0], 0.01 * size);
        let mut query = a.query(&mut workspace);
        query.contacts(ball, &mut found).expect("ball");
        visits.push(query.stats().nodes_visited);
    }
    assert!(visits.is_sorted() && visits[0] < visits[2], "{visits:?}");
}

#[test]
fn tolerances_that_are_none_are_refused() {
    let mesh = bake::bumpy_sphere(4, 5);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 2));
    let asset = *model.asset();
    let mut memory = vec![0.0; asset.pose_len()];
    for tolerance in [f64::NAN, -1e-300, f64::NEG_INFINITY] {
        let place = Transform::IDENTITY;
        let pose = pose_within(&asset, &[0.0; 2], place, tolerance, &mut memory);
        assert_eq!(pose.err(), Some(PoseError::Tolerance));
    }
}
