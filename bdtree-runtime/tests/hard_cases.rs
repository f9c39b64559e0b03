//! The list of docs/design/hard-cases.md: every query equals brute force on all of them, at every q, in every
//! place, with every kernel, with subnormals kept and flushed; what is no asset is refused in words.
//!
//! `BDTREE_HARD_ROUNDS=20 cargo test -p bdtree-runtime --test all hard_cases::` asks more random questions of each
//! kind (one without), and all about pairs of large meshes.

use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_fixtures::hard::{ROUNDS, check_case, hard_cases, placements, refused_cases};
use bdtree_fixtures::oracle;
use bdtree_fixtures::oracle::exact;
use bdtree_runtime::{Asset, Ray, Transform, Workspace};

fn rounds() -> usize {
    match std::env::var("BDTREE_HARD_ROUNDS") {
        Ok(text) => text.parse().expect("BDTREE_HARD_ROUNDS: a whole number"),
        Err(_) => ROUNDS,
    }
}

/// The n-th of `shares` equal shares of the list, so that cores work side by side.
fn check_share(n: usize, shares: usize) {
    for case in hard_cases().iter().skip(n).step_by(shares) {
        let start = std::time::Instant::now();
        let asked = check_case(case, rounds());
        println!(
            "{}: {asked} poses, {:.1} s",
            case.name,
            start.elapsed().as_secs_f64()
        );
        assert!(asked >= placements().len());
    }
}

#[test]
fn queries_equal_brute_force_on_hard_cases() {
    check_share(0, 2);
}

#[test]
fn queries_equal_brute_force_on_the_other_hard_cases() {
    check_share(1, 2);
}

#[cfg(target_arch = "x86_64")]
#[test]
fn flushed_subnormals_change_nothing_on_hard_cases() {
    use bdtree_fixtures::compare::{check_pose, kernels};
    use bdtree_fixtures::flush::with_mode;
    for case in hard_cases() {
        let model = case.bake();
        let asset = *model.asset();
        for (i, q) in case.poses(&asset).iter().enumerate() {
            let places = placements();
            for n in [0, i] {
                let place = places[n % places.len()].1;
                with_mode(true, || check_pose(kernels(&asset), q, place, i as u64, 1));
            }
        }
    }
}

/// From the middle of a closed body every ray meets it, wherever it is aimed: at each corner, at edges.
#[test]
fn rays_slip_through_no_closed_body() {
    let mut rays = 0;
    for case in hard_cases().iter().filter(|case| case.is_star) {
        let model = case.bake();
        let asset = *model.asset();
        let q = vec![0.0; asset.mode_count()];
        for (name, place) in placements() {
            let mut memory = vec![0.0; asset.pose_len()];
            let pose = asset.pose(&q, place, &mut memory).expect("pose");
            let body = oracle::deformed_triangles(&pose);
            let mut workspace = Workspace::new();
            let mut query = pose.query(&mut workspace);
            let count = (3 * body.len()) as f64;
            let middle =
                [0, 1, 2].map(|k| body.iter().flatten().map(|x| x[k]).sum::<f64>() / count);
            for [a, b, c] in body.iter() {
                let between = |s: f64| [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]));
                for target in [*a, *b, *c, between(0.5), between(0.3)] {
                    let d = [0, 1, 2].map(|k| target[k] - middle[k]);
                    let hit = query.cast_ray(&Ray::new(middle, d)).expect("ray");
                    assert!(hit.is_some(), "{}, {name}: at {target:?}", case.name);
                    rays += 1;
                }
            }
        }
    }
    println!("{rays} rays");
    assert!(rays > 50_000);
}

/// What the closest point's distance is off, against exact arithmetic on the same corners, in shares of
/// the largest coordinate difference of point and triangle: below 2⁻⁴⁸, the τ of `narrow`.
#[test]
fn distances_are_exact_to_what_narrow_states() {
    for case in hard_cases() {
        let model = case.bake();
        let asset = *model.asset();
        let mut worst = 0.0_f64;
        for q in case.poses(&asset) {
            for (_, place) in placements() {
                worst = worst.max(off(&asset, &q, place));
            }
        }
        println!("{:32} {:.1e} of the largest difference", case.name, worst);
        assert!(worst <= 2_f64.powi(-48), "{}: {worst:e}", case.name);
    }
}

fn off(asset: &Asset<'_>, q: &[f32], place: Transform) -> f64 {
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset.pose(q, place, &mut memory).expect("pose");
    let body = oracle::deformed_triangles(&pose);
    let mut workspace = Workspace::new();
    let mut query = pose.query(&mut workspace);
    let (t, far) = (&body[body.len() / 3], &body[body.len() / 2]);
    let mut worst = 0.0_f64;
    for s in [0.0, 0.01, 1.5] {
        let to =
            [0, 1, 2].map(|k| t[0][k] + s * (far[2][k] - t[0][k]) + s * s * (t[1][k] - t[0][k]));
        let near = query.project_point(to, f64::INFINITY).expect("closest");
        let near = near.expect("a triangle");
        let expected = exact::distance(to, &body, near.distance);
        let corners = body[near.triangle.0 as usize];
        let reach = corners
            .iter()
            .flat_map(|x| (0..3).map(move |k| (x[k] - to[k]).abs()));
        let reach = reach.fold(f64::MIN_POSITIVE, f64::max);
        worst = worst.max((near.distance - expected).abs() / reach);
    }
    worst
}

#[test]
fn what_is_no_asset_is_refused_in_words() {
    for case in refused_cases() {
        let error = bake_fields(
            &case.mesh,
            &case.basis,
            &BakeSettings::default(),
            &Provenance::default(),
            &Silent,
        );
        let error = error.map(|_| ()).expect_err(case.name).to_string();
        // The first twenty of many, then their number.
        let lines = error.lines().filter(|line| !line.starts_with("and "));
        for (i, line) in lines.enumerate() {
            assert!(
                i < 20 && line.contains(case.message),
                "{}: {line}",
                case.name
            );
        }
    }
}
