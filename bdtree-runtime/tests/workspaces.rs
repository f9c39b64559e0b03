//! Workspaces: at any address, of exactly the size that is asked for, whatever the bytes held before.

use bdtree_fixtures::{bake, poses};
use bdtree_runtime::{
    Asset, Ball, CacheSize, Capsule, Contact, ContactManifold, Coverage, Cuboid, Frustum,
    HalfSpace, Model, PairContact, Pose, QueryError, Ray, RayIntersection, Shape, StepCache,
    Transform, TrianglePair, Workspace,
};
use zerocopy::IntoBytes;

/// A rigid one, a deep one, and one with few modes per vertex.
fn models() -> [Model; 3] {
    let (small, large) = (bake::bumpy_sphere(5, 1), bake::bumpy_sphere(20, 2));
    [
        bake::baked(&small, &bake::rigid(&small)),
        bake::baked(&large, &bake::smooth_basis(&large, 6, 5)),
        bake::baked(&small, &bake::local_basis(&small, 9, 5)),
    ]
}

/// Everything that can be asked of one mesh.
fn ask_one(pose: &Pose<'_>, workspace: &mut Workspace<'_>) -> Result<Vec<Contact>, QueryError> {
    let mut contacts = Vec::new();
    let point = [0.7, 0.3, -0.2];
    let planes = Frustum::new(&[[1.0, 0.0, 0.0, -0.1]]).expect("planes");
    let mut query = pose.query(workspace);
    for shape in [
        Ball::new(point, 0.4).into(),
        HalfSpace::new(point, -0.5).into(),
        Capsule::new(point, [0.0; 3], 0.1).into(),
        Shape::from(Cuboid::new(point, [0.3; 3])),
    ] {
        query.contacts(shape, &mut contacts)?;
        query.intersects(shape)?;
    }
    let ray = Ray::new([3.0, 2.0, 1.0], [-3.0, -2.0, -1.0]);
    let mut hits: Vec<RayIntersection> = Vec::new();
    query.cast_ray_all(&ray, &mut hits)?;
    let mut first = [None; 2];
    query.cast_rays(&[ray; 2], &mut first)?;
    assert_eq!(first, [query.cast_ray(&ray)?; 2]);
    assert_eq!(query.intersects_ray(&ray)?, !hits.is_empty());
    query.project_point(point, f64::INFINITY)?;
    query.frustum_state(&planes)?;
    Ok(contacts)
}

/// Everything that can be asked of two but manifolds.
fn ask_two(
    [a, b]: [&Pose<'_>; 2],
    workspace: &mut Workspace<'_>,
) -> Result<(Vec<PairContact>, Option<PairContact>), QueryError> {
    let mut contacts = Vec::new();
    let mut query = a.against(b, workspace);
    query.contacts(0.01, &mut contacts)?;
    let mut ids: Vec<TrianglePair> = Vec::new();
    query.triangle_pairs(0.01, &mut ids)?;
    assert_eq!(ids.len(), contacts.len());
    query.intersects()?;
    Ok((contacts, query.closest_points(f64::INFINITY)?))
}

/// The second beside the first.
fn posed<'p>(asset: &'p Asset<'p>, k: usize, memory: &'p mut Vec<f32>) -> Pose<'p> {
    *memory = vec![0.0; asset.pose_len()];
    let q = poses::random_q(asset, 0.1, &mut poses::rng(k as u64));
    let place = Transform::from_translation([1.6 * k as f64, 0.2, 0.0]);
    asset.pose(&q, place, memory).expect("a pose")
}

#[test]
fn the_stated_bytes_suffice_at_any_address() {
    let models = models();
    let mut growing = Workspace::new();
    for first in &models {
        for second in &models {
            let (asset1, asset2) = (first.asset(), second.asset());
            let mut memory = [Vec::new(), Vec::new()];
            let [memory1, memory2] = &mut memory;
            let (a, b) = (posed(asset1, 0, memory1), posed(asset2, 1, memory2));
            let expected = (
                ask_one(&a, &mut growing).expect("answers"),
                ask_two([&a, &b], &mut growing).expect("answers"),
            );
            assert!(expected.0.len() > 3);
            let needed = Workspace::bytes_for(&[asset1, asset2]);
            assert_eq!(needed, Workspace::bytes_for(&[asset2, asset1]));
            assert!(needed >= Workspace::bytes_for(&[asset1]));
            for start in 0..9 {
                // What was there before does not matter.
                let mut bytes = vec![0xff; start + needed];
                let mut workspace = Workspace::in_bytes(&mut bytes[start..]);
                let one = ask_one(&a, &mut workspace).expect("answers");
                let two = ask_two([&a, &b], &mut workspace).expect("answers");
                assert_eq!((one, two), expected);
                ask_one(&b, &mut workspace).expect("answers");
            }
        }
    }
}

/// The largest query needs all of the stated bytes but those that make up for the address.
#[test]
fn one_byte_fewer_is_an_error() {
    for model in models() {
        let asset = model.asset();
        let mut memory = [Vec::new(), Vec::new()];
        let [memory1, memory2] = &mut memory;
        let (a, b) = (posed(asset, 0, memory1), posed(asset, 1, memory2));
        let most = Workspace::bytes_for(&[asset]) - 8;
        let mut bytes = vec![0_u64; most.div_ceil(8)];
        let bytes = zerocopy::IntoBytes::as_mut_bytes(&mut bytes[..]);
        let mut workspace = Workspace::in_bytes(&mut bytes[..most - 1]);
        let refused = ask_one(&a, &mut workspace)
            .err()
            .or_else(|| ask_two([&a, &b], &mut workspace).err());
        let found = most - 1;
        let needed = most;
        assert_eq!(refused, Some(QueryError::Memory { needed, found }));
    }
}

#[test]
fn the_stated_bytes_suffice_for_manifolds() {
    let models = models();
    let (asset1, asset2) = (models[1].asset(), models[2].asset());
    let mut memory = [Vec::new(), Vec::new()];
    let [memory1, memory2] = &mut memory;
    let (a, b) = (posed(asset1, 0, memory1), posed(asset2, 1, memory2));
    let mut growing = Workspace::new();
    let (mut pairs, mut expected) = (Vec::new(), Vec::new());
    let mut query = a.against(&b, &mut growing);
    query.contacts(0.0, &mut pairs).expect("pair");
    query
        .contact_manifolds(0.0, &mut expected)
        .expect("manifolds");
    assert!(pairs.len() > 10 && !expected.is_empty());
    let needed = Workspace::bytes_for_manifolds(&[asset1, asset2], pairs.len());
    for start in 0..3 {
        let mut bytes = vec![0xff; start + needed];
        let mut workspace = Workspace::in_bytes(&mut bytes[start..]);
        let mut query = a.against(&b, &mut workspace);
        let mut found: Vec<ContactManifold> = Vec::new();
        let coverage = query.contact_manifolds(0.0, &mut found);
        assert_eq!(coverage, Ok(Coverage::Complete));
        assert_eq!(found, expected);
        found.clear();
        query.condense(&mut pairs, &mut found).expect("manifolds");
        assert_eq!(found, expected);
    }
    // Room for fewer pairs than touch.
    let few = Workspace::bytes_for_manifolds(&[asset1, asset2], pairs.len() / 2);
    let mut bytes = vec![0; few];
    let mut workspace = Workspace::in_bytes(&mut bytes);
    let mut found: Vec<ContactManifold> = Vec::new();
    let mut query = a.against(&b, &mut workspace);
    let refused = query.contact_manifolds(0.0, &mut found);
    let Err(QueryError::Memory { needed, found: has }) = refused else {
        panic!("{refused:?}");
    };
    assert!(needed > has && found.is_empty());
    // The number is enough, and it is for all pairs.
    let mut words = vec![0_u64; needed.div_ceil(8)];
    let mut workspace = Workspace::in_bytes(words.as_mut_bytes());
    let mut query = a.against(&b, &mut workspace);
    let coverage = query.contact_manifolds(0.0, &mut found);
    assert_eq!(coverage, Ok(Coverage::Complete));
    assert_eq!(found, expected);
}

/// One workspace and one cache that serve small and large meshes in turn; memory of the caller's for a cache,
/// whatever it held.
#[test]
fn one_workspace_serves_all() {
    let models = models();
    let mut shared = Workspace::new();
    for round in 0..2 {
        for model in &models {
            let asset = model.asset();
            let mut memory = Vec::new();
            let pose = posed(asset, round, &mut memory);
            let expected = ask_one(&pose, &mut Workspace::new());
            assert_eq!(ask_one(&pose, &mut shared), expected);
            let size = CacheSize::all(asset);
            let mut bytes = vec![0xff; size.bytes() + 1];
            let mut cache = StepCache::in_bytes(&mut bytes[1..], size).expect("a cache");
            cache.start(&pose);
            assert!((0..asset.node_count() as u32).all(|node| !cache.keeps(node)));
            let mut contacts: Vec<Contact> = Vec::new();
            let mut query = pose.query(&mut shared).cached(&mut cache);
            for _ in 0..2 {
                contacts.clear();
                let ball = Ball::new([0.7, 0.3, -0.2], 0.4);
                query.contacts(ball, &mut contacts).expect("ball");
                assert_eq!(
                    contacts,
                    expected.as_ref().expect("answers")[..contacts.len()]
                );
            }
            assert_eq!(query.stats().nodes_updated, 0);
            assert!(cache.keeps(0));
        }
    }
}
