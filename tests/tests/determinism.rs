//! The same bytes on every run and for any number of threads; the same answers, in the same
//! order, with every kernel.

use bdtree_build::pipeline::BakeSettings;
use bdtree_fixtures::{bake, poses};
use bdtree_runtime::{
    Asset, Ball, Capsule, Contact, Cuboid, HalfSpace, Kernel, Model, PairContact, Ray, Shape,
    Workspace,
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
        let asset = first.asset();
        assert_eq!(asset.vertex_modes().is_empty(), !is_local);
        for threads in [1, 2, 3, 7] {
            assert!(
                made(threads).asset().bytes() == asset.bytes(),
                "{mode_count} modes, {threads} threads"
            );
        }
    }
}

/// All answers of fixed queries, in the order in which they came.
fn answers(asset: &Asset<'_>, partner: &Asset<'_>) -> (Vec<Contact>, Vec<PairContact>, String) {
    let mut rng = poses::rng(5);
    let (mut contacts, mut pairs, mut nearest) = (Vec::new(), Vec::new(), String::new());
    let mut workspace = Workspace::new();
    for share in [0.0, 0.1, 0.5] {
        let q = poses::random_q(asset, share, &mut rng);
        let place = poses::random_transform(0.5, &mut rng);
        let other = poses::random_transform(0.5, &mut rng);
        let (mut memory, mut memory2) =
            (vec![0.0; asset.pose_len()], vec![0.0; partner.pose_len()]);
        let pose = asset.pose(&q, place, &mut memory).expect("pose");
        let pose2 = partner.pose(&q, other, &mut memory2).expect("pose");
        let point = [0.7, 0.2, -0.4];
        let cuboid = Cuboid::new(point, [0.5, 0.2, 0.4]).rotated(place.rotation);
        let mut query = pose.query(&mut workspace);
        for shape in [
            Ball::new(point, 0.5).into(),
            HalfSpace::new(point, -0.2).into(),
            Capsule::new(point, [-2.0, 0.3, 1.0], 0.2).into(),
            Shape::from(cuboid),
        ] {
            query.contacts(shape, &mut contacts).expect("contacts");
        }
        let near = query.project_point(point, f64::INFINITY).expect("closest");
        let hit = query.cast_ray(&Ray::new([4.0; 3], [-1.0; 3])).expect("ray");
        nearest += &format!("{near:?} {hit:?}\n");
        for tolerance in [0.0, 0.01] {
            let mut query = pose.against(&pose2, &mut workspace);
            query.contacts(tolerance, &mut pairs).expect("pair");
        }
    }
    (contacts, pairs, nearest)
}

#[test]
fn answers_and_their_order_do_not_depend_on_the_kernel() {
    let mesh = bake::bumpy_sphere(16, 3);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 4));
    let asset = model.asset();
    let expected = answers(asset, asset);
    assert!(expected.0.len() > 100 && expected.1.len() > 10);
    // A second run, and the same bytes at another address.
    let copy = Model::from_bytes(asset.bytes()).expect("open");
    assert!(answers(asset, asset) == expected);
    assert!(answers(copy.asset(), asset) == expected);
    for kernel in Kernel::ALL {
        let Some(asset) = asset.with_kernel(kernel) else {
            continue;
        };
        assert!(answers(&asset, &asset) == expected, "{kernel:?}");
    }
}
