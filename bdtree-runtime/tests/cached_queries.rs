//! What a step keeps changes no answer: every query with and without, over poses that follow each
//! other, equals brute force.

use bdtree_build::basis::Basis;
use bdtree_build::input::RawMesh;
use bdtree_fixtures::compare::cached::check_cached;
use bdtree_fixtures::compare::kernels;
use bdtree_fixtures::{bake, poses};
use bdtree_runtime::{
    Ball, CacheSize, Contact, Instance, LaneId, PairContact, Ray, RefinedPose, StepCache,
    Transform, Workspace,
};

fn check(mesh: &RawMesh, basis: &Basis, seed: u64, rounds: usize) {
    let model = bake::baked(mesh, basis);
    let asset = *model.asset();
    let mut rng = poses::rng(seed);
    let far = Transform {
        translation: [1e7, -2e6, 3.0],
        ..poses::random_transform(1.0, &mut rng)
    };
    let at = [
        (poses::random_q(&asset, 0.0, &mut rng), Transform::IDENTITY),
        (
            poses::random_q(&asset, 0.1, &mut rng),
            poses::random_transform(3.0, &mut rng),
        ),
        (poses::random_q(&asset, 0.4, &mut rng), far),
    ];
    for asset in kernels(&asset) {
        check_cached(&asset, &at, seed, rounds);
    }
}

#[test]
fn kept_nodes_and_leaves_change_no_answer() {
    let mesh = bake::bumpy_sphere(12, 1);
    check(&mesh, &bake::smooth_basis(&mesh, 10, 2), 3, 4);
    check(&mesh, &bake::local_basis(&mesh, 16, 2), 4, 3);
}

#[test]
fn triangles_without_area_are_missed_by_rays_of_every_kind() {
    let mut mesh = bake::bumpy_sphere(7, 1);
    let given = mesh.triangles.clone();
    for [a, b, c] in given {
        mesh.triangles.extend([[a, b, b], [c, c, c], [a, b, c]]);
    }
    check(&mesh, &bake::smooth_basis(&mesh, 3, 2), 5, 3);
}

/// Of a mesh that has no branches, a cache that refines by itself does so when a step has asked twice what pays, or where nothing is known once, at once in
/// the step after such a one and for many rays together, and not where memory is short.
#[test]
fn caches_refine_poses_where_it_pays() {
    let mesh = bake::bumpy_sphere(20, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 4, 2));
    let asset = model.asset();
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset.pose(&[0.01; 4], Transform::IDENTITY, &mut memory);
    let pose = pose.expect("a pose");
    let mut workspace = Workspace::new();
    let enough = (asset.triangle_count() + 2 * asset.vertex_count()) as u64 / 3;
    let ball = Ball::new([1.0, 0.0, 0.0], 0.3);
    // Balls until the pose is refined, at most so many; what they would have gained, at least.
    let mut ask = |cache: &mut StepCache<'_>, most: usize| {
        let mut gain = 0;
        for _ in 0..most {
            let mut found: Vec<Contact> = Vec::new();
            let mut query = pose.query(&mut workspace).cached(cache);
            query.contacts(ball, &mut found).expect("contacts");
            if cache.is_refined() {
                break;
            }
            gain += 4 * workspace.stats().nodes_visited + found.len() as u64;
        }
        gain
    };
    let mut cache = StepCache::new(CacheSize::NONE).refining(RefinedPose::new());
    cache.start(&pose);
    assert!(!cache.is_refined());
    let gain = ask(&mut cache, 1000);
    assert!(cache.is_refined() && gain < 2 * enough, "{gain} {enough}");
    // The step before had enough.
    cache.start(&pose);
    assert!(!cache.is_refined());
    assert_eq!(ask(&mut cache, 1), 0);
    assert!(cache.is_refined());
    // So had this one? It asked little: the next one waits, for twice as much.
    cache.start(&pose);
    let gain = ask(&mut cache, 1000);
    assert!(gain > enough / 2, "{gain} {enough}");
    // Many rays are counted before they are cast.
    let mut cache = StepCache::new(CacheSize::NONE).refining(RefinedPose::new());
    cache.start(&pose);
    let rays = vec![Ray::new([0.0, 5.0, 0.0], [0.0, -1.0, 0.0]); enough as usize];
    let mut hits = vec![None; rays.len()];
    let mut workspace = Workspace::new();
    let mut query = pose.query(&mut workspace).cached(&mut cache);
    query.cast_rays(&rays, &mut hits).expect("rays");
    assert_eq!(query.stats().nodes_updated, 0);
    assert!(cache.is_refined());
    // What ends at a level does not use it.
    let mut lanes: Vec<LaneId> = Vec::new();
    let mut query = pose.query(&mut workspace).cached(&mut cache);
    query.level_spheres(0, ball, &mut lanes).expect("lanes");
    assert!(query.stats().nodes_updated > 0);
    // No room.
    let mut bytes = [0; 100];
    let cache = StepCache::new(CacheSize::NONE);
    let mut cache = cache.refining(RefinedPose::in_bytes(&mut bytes));
    cache.start(&pose);
    let mut query = pose.query(&mut workspace).cached(&mut cache);
    query.cast_rays(&rays, &mut hits).expect("rays");
    assert!(query.stats().nodes_updated > 0 && !cache.is_refined());
    // An instance's own.
    let mut body = Instance::new(&model).expect("an instance");
    body.set_refining(true);
    let found = body.query(&mut workspace).cast_rays(&rays, &mut hits);
    found.expect("rays");
    assert!(body.is_refined());
    body.set_refining(false);
    assert!(!body.is_refined());
}

#[test]
fn pairs_decide_together_whether_both_poses_are_refined() {
    let mesh = bake::bumpy_sphere(12, 3);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 3, 2));
    let asset = model.asset();
    let q = [0.01, -0.02, 0.01];
    let mut memories = [(); 2].map(|()| vec![0.0; asset.pose_len()]);
    let [memory1, memory2] = &mut memories;
    let aside = Transform {
        translation: [0.9, 0.2, 0.1],
        ..Transform::IDENTITY
    };
    let pose1 = asset
        .pose(&q, Transform::IDENTITY, memory1)
        .expect("a pose");
    let pose2 = asset.pose(&q, aside, memory2).expect("a pose");
    let [mut workspace, mut own] = [(); 2].map(|()| Workspace::new());
    let [mut cache1, mut cache2] =
        [(); 2].map(|()| StepCache::new(CacheSize::NONE).refining(RefinedPose::new()));
    let mut ask = |caches: Option<[&mut StepCache<'_>; 2]>| {
        let (mut one, mut two) = (pose1.query(&mut workspace), pose2.query(&mut own));
        if let Some([cache1, cache2]) = caches {
            (one, two) = (one.cached(cache1), two.cached(cache2));
        }
        let mut pairs: Vec<PairContact> = Vec::new();
        let mut query = one.against(two);
        query.contacts(0.0, &mut pairs).expect("contacts");
        pairs.sort_by_key(|pair| (pair.triangle1, pair.triangle2));
        (pairs, query.stats().nodes_visited)
    };
    let (expected, visits) = ask(None);
    assert!(!expected.is_empty());
    for step in 0..3 {
        cache1.start(&pose1);
        cache2.start(&pose2);
        let mut asked = 0;
        while !(cache1.is_refined() && cache2.is_refined()) {
            let (found, _) = ask(Some([&mut cache1, &mut cache2]));
            assert_eq!(found, expected, "step {step}");
            asked += 1;
            assert!(asked < 1000, "step {step}: they never are");
        }
        // From the second step on it is known.
        assert_eq!(asked == 1, step > 0, "{asked} pairs of {visits} nodes");
        for _ in 0..asked.max(20) {
            assert_eq!(ask(Some([&mut cache1, &mut cache2])).0, expected);
        }
    }
}
