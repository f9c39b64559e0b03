//! Preparing in parts gives the bytes of preparing alone.

use bdtree_fixtures::{bake, poses};
use bdtree_runtime::{Asset, Pose, PreparePart, QueryError, RefinedPose, Transform};

/// What memory holds after preparing in so many parts.
fn bytes(
    pose: &Pose<'_>,
    parts: usize,
    run: impl FnMut(&mut [PreparePart<'_>]),
) -> Result<Vec<u8>, QueryError> {
    // Whole words, so that no gap comes first wherever it lies.
    let mut words = vec![u64::MAX; RefinedPose::bytes_for(pose.asset())?.div_ceil(8)];
    let memory = zerocopy::IntoBytes::as_mut_bytes(&mut words[..]);
    let mut refined = RefinedPose::in_bytes(memory);
    let outcome = refined.prepare_in_parts(pose, parts, run);
    assert_eq!(refined.serves(pose), outcome.is_ok());
    outcome?;
    Ok(memory.to_vec())
}

fn posed(check: impl Fn(&Asset<'_>, &Pose<'_>)) {
    let mesh = bake::bumpy_sphere(12, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 4, 2));
    let asset = model.asset();
    let mut memory = vec![0.0; asset.pose_len()];
    let q = poses::random_q(asset, 0.2, &mut poses::rng(5));
    let pose = asset.pose(&q, Transform::IDENTITY, &mut memory);
    check(asset, &pose.expect("a pose"));
}

#[test]
fn parts_in_any_order_and_on_threads_give_the_same_bytes() {
    posed(|_, pose| {
        let alone = bytes(pose, 1, |parts| {
            assert_eq!(parts.len(), 1);
            parts[0].run();
        });
        let alone = alone.expect("bytes");
        for count in [0, 2, 3, 7, 32, 1000] {
            let mut most = 0;
            let backwards = bytes(pose, count, |parts| {
                most = most.max(parts.len());
                parts.iter_mut().rev().for_each(PreparePart::run);
                // Once is enough.
                parts[0].run();
            });
            assert!(backwards.expect("bytes") == alone, "{count}");
            assert!(most <= 33 && most >= count.clamp(1, 2), "{count}: {most}");
        }
        let on_threads = bytes(pose, 4, |parts| {
            std::thread::scope(|scope| {
                for part in parts {
                    scope.spawn(|| part.run());
                }
            });
        });
        assert!(on_threads.expect("bytes") == alone);
    });
}

#[test]
fn a_part_that_was_not_run_is_missed() {
    posed(|_, pose| {
        for left_out in [0, 2] {
            for of in 0..2 {
                let mut call = 0;
                let outcome = bytes(pose, 3, |parts| {
                    for (k, part) in parts.iter_mut().enumerate() {
                        if call != of || k != left_out {
                            part.run();
                        }
                    }
                    call += 1;
                });
                let error = outcome.expect_err("a part was left out");
                assert!(error.to_string().contains("a part was not run"), "{error}");
            }
        }
    });
}
