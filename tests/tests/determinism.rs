//! The same bytes on every run and for any number of threads; the same answers, in the same
//! order, with every kernel.

use bdtree_build::pipeline::BakeSettings;
use bdtree_fixtures::{bake, poses};
use bdtree_runtime::{
    AlignedBytes, Asset, Contact, Kernel, PairContact, PairStackEntry, Pose, StackEntry, query,
};

#[test]
fn bytes_depend_on_the_input_only() {
    let mesh = bake::bumpy_sphere(20, 3);
    for (mode_count, is_local) in [(0, false), (1, false), (9, false), (9, true)] {
        let basis = if is_local {
            bake::local_basis(&mesh, mode_count, 4)
        } else {
            bake::smooth_basis(&mesh, mode_count, 4)
        };
        let made = |threads| {
            let settings = BakeSettings {
                threads,
                ..BakeSettings::default()
            };
            bake::baked_with(&mesh, &basis, &settings)
        };
        let first = made(1);
        let asset = Asset::open(&first).expect("open");
        assert_eq!(asset.vertex_modes().is_empty(), !is_local);
        for threads in [1, 2, 3, 7] {
            assert!(
                *made(threads) == *first,
                "{mode_count} modes, {threads} threads"
            );
        }
    }
}

/// All answers of fixed queries, in the order in which they came.
fn answers(asset: &Asset<'_>, partner: &Asset<'_>) -> (Vec<Contact>, Vec<PairContact>, String) {
    let mut rng = poses::rng(5);
    let (mut contacts, mut pairs, mut nearest) = (Vec::new(), Vec::new(), String::new());
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    let mut pair_stack = vec![PairStackEntry::default(); asset.pair_stack_len(partner)];
    for share in [0.0, 0.1, 0.5] {
        let q = poses::random_q(asset, share, &mut rng);
        let place = poses::random_transform(0.5, &mut rng);
        let other = poses::random_transform(0.5, &mut rng);
        let (mut memory, mut memory2) =
            (vec![0.0; asset.pose_len()], vec![0.0; partner.pose_len()]);
        let pose = Pose::new(asset, &q, place, &mut memory).expect("pose");
        let pose2 = Pose::new(partner, &q, other, &mut memory2).expect("pose");
        let point = [0.7, 0.2, -0.4];
        query::ball(asset, &pose, point, 0.5, &mut stack, &mut contacts).expect("ball");
        query::plane(asset, &pose, point, -0.2, &mut stack, &mut contacts).expect("plane");
        let (ends, half) = ([point, [-2.0, 0.3, 1.0]], [0.5, 0.2, 0.4]);
        query::capsule(
            asset,
            &pose,
            ends[0],
            ends[1],
            0.2,
            &mut stack,
            &mut contacts,
        )
        .expect("capsule");
        query::cuboid(
            asset,
            &pose,
            point,
            place.rotation,
            half,
            &mut stack,
            &mut contacts,
        )
        .expect("box");
        let near = query::closest(asset, &pose, point, f64::INFINITY, &mut stack).expect("closest");
        let hit = query::ray(asset, &pose, [4.0; 3], [-1.0; 3], f64::INFINITY, &mut stack);
        nearest += &format!("{:?} {:?}\n", near.hit, hit.expect("ray").hit);
        for tolerance in [0.0, 0.01] {
            let (a, b) = ((asset, &pose), (partner, &pose2));
            query::pair(a, b, tolerance, &mut pair_stack, &mut pairs).expect("pair");
        }
    }
    (contacts, pairs, nearest)
}

#[test]
fn answers_and_their_order_do_not_depend_on_the_kernel() {
    let mesh = bake::bumpy_sphere(16, 3);
    let bytes = bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 4));
    let asset = Asset::open(&bytes).expect("open");
    let expected = answers(&asset, &asset);
    assert!(expected.0.len() > 100 && expected.1.len() > 10);
    // A second run, and the same bytes at another address.
    let copy = AlignedBytes::copy_of(&bytes);
    assert!(answers(&asset, &asset) == expected);
    assert!(answers(&Asset::open(&copy).expect("open"), &asset) == expected);
    for kernel in Kernel::ALL {
        let Some(asset) = asset.with_kernel(kernel) else {
            continue;
        };
        assert!(answers(&asset, &asset) == expected, "{kernel:?}");
    }
}
