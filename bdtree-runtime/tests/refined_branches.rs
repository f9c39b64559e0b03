//! A cache that refines the branches where a step comes often gives the answers of one that does not: whatever it is asked, in any
//! order, with every kernel and in any amount of memory.

use core::ops::ControlFlow;

use bdtree_build::basis::Basis;
use bdtree_build::input::RawMesh;
use bdtree_fixtures::compare::kernels;
use bdtree_fixtures::mutate::Damage;
use bdtree_fixtures::skin::skinned_bar_of;
use bdtree_fixtures::{bake, poses};
use bdtree_runtime::{
    Asset, Ball, BoneMatrices, CacheSize, Capsule, Contact, JointMatrix, Model, Pose, Proxy, Query,
    QueryError, Ray, RayIntersection, RefinedPose, Sink, StepCache, Transform, VertexId, Workspace,
};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// What a step is asked: near one place, so that few branches are met.
struct Asked {
    rays: Vec<Ray>,
    ball: Ball,
    distance: f64,
}

impl Asked {
    /// At the vertices about one, from outside.
    fn near(pose: &Pose<'_>, center: u32, rays: usize, rng: &mut Pcg64Mcg) -> Self {
        let size = poses::diagonal(pose.asset()) * pose.asset().unit();
        let last = pose.asset().vertex_count() as i64 - 1;
        let mut place = |spread: i64| {
            let near = i64::from(center) + rng.random_range(-spread..=spread);
            let vertex = VertexId(near.clamp(0, last) as u32);
            let at = pose.deformed(vertex).expect("a vertex");
            at.map(|x| x + 0.02 * size * rng.random_range(-1.0..1.0))
        };
        let from = place(3).map(|x| 1.5 * x);
        let rays = (0..rays).map(|_| {
            let to = place(40);
            Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k]))
        });
        let rays = rays.collect();
        Self {
            rays,
            ball: Ball::new(place(40), 0.03 * size),
            distance: size * [0.01, 0.2, f64::INFINITY][center as usize % 3],
        }
    }

    /// The answers, in the order of triangles where there is no other.
    fn of(&self, query: &mut Query<'_, '_>) -> Result<Answers, QueryError> {
        let count = self.rays.len();
        let mut answers = Answers {
            first: vec![None; count],
            any: vec![count % 7 == 1; count],
            ..Answers::default()
        };
        // The first question of a step finds nothing refined: it is another one each time.
        if !count.is_multiple_of(2) {
            query.intersects_rays(&self.rays, &mut answers.any)?;
        }
        let one = self.rays.first().expect("rays");
        answers.alone = query.cast_ray(one)?;
        query.cast_rays(&self.rays, &mut answers.first)?;
        answers.is_met = query.intersects_ray(one)?;
        query.contacts(self.ball, &mut answers.contacts)?;
        if count.is_multiple_of(2) {
            query.intersects_rays(&self.rays, &mut answers.any)?;
        }
        let near = query.project_point(self.ball.center, self.distance)?;
        answers.near = near.map(|near| (near.triangle.0, near.distance));
        // Asks spheres, of which branches have none.
        let end = self.rays.last().expect("rays").origin;
        let capsule = Capsule::new(self.ball.center, end, self.ball.radius);
        query.contacts(capsule, &mut answers.contacts)?;
        query.cast_rays_all(&self.rays, &mut answers.all)?;
        answers.contacts.sort_by_key(|contact| contact.triangle);
        (answers.all).sort_by_key(|(ray, hit)| (*ray, hit.triangle));
        Ok(answers)
    }
}

#[derive(Debug, Default, PartialEq)]
struct Answers {
    alone: Option<RayIntersection>,
    first: Vec<Option<RayIntersection>>,
    is_met: bool,
    any: Vec<bool>,
    all: Vec<(usize, RayIntersection)>,
    near: Option<(u32, f64)>,
    contacts: Vec<Contact>,
}

/// Asks steps of one pose each; how many triangles were refined in each, at most.
fn check<'p>(
    asset: &'p Asset<'p>,
    share: f64,
    pose: impl Fn(&'p Asset<'p>, &mut Pcg64Mcg, &mut dyn FnMut(&Pose<'_>)),
) -> Vec<usize> {
    let mut rng = poses::rng(11);
    let bytes = RefinedPose::bytes_for(asset).expect("bytes") as f64 * share;
    let mut bytes = vec![0xa5; bytes as usize];
    let memory = match share {
        0.0 => RefinedPose::new(), // grows
        _ => RefinedPose::in_bytes(&mut bytes),
    };
    let mut cache = StepCache::new(CacheSize {
        nodes: 20,
        leaves: 9,
    });
    cache = cache.refining(memory);
    let mut workspace = Workspace::new();
    let mut refined = Vec::new();
    let mut center = 0;
    for step in 0..6 {
        if step % 3 == 0 {
            center = rng.random_range(0..asset.vertex_count() as u32);
        }
        let mut seeds = poses::rng(rng.random_range(0..u64::MAX));
        pose(asset, &mut rng, &mut |pose| {
            cache.start(pose);
            let mut most = 0;
            for rays in [[201, 1, 60, 400], [1, 60, 400, 201]][step % 2] {
                let asked = Asked::near(pose, center, rays, &mut seeds);
                let alone = asked.of(&mut pose.query(&mut workspace)).expect("answers");
                let mut query = pose.query(&mut workspace).cached(&mut cache);
                assert_eq!(asked.of(&mut query).expect("answers"), alone);
                most = cache.refined_triangles().max(most);
            }
            refined.push(most);
        });
    }
    refined
}

fn check_bake(mesh: &RawMesh, basis: &Basis) {
    let model = bake::baked(mesh, basis);
    for asset in kernels(model.asset()) {
        let all = asset.triangle_count();
        let mut some = 0;
        for share in [0.0, 0.001, 0.05, 0.3, 0.7, 1.0] {
            let refined = check(&asset, share, |asset, rng, ask| {
                let q = poses::random_q(asset, 0.2, rng);
                let at = poses::random_transform(2.0, rng);
                let mut memory = vec![0.0; asset.pose_len()];
                ask(&asset.pose(&q, at, &mut memory).expect("a pose"));
            });
            // In memory for nothing nothing is refined, and in that for a part not much more than that.
            let most = refined.iter().max().copied().unwrap_or_default();
            assert!(share != 0.001 || most == 0, "{most}");
            assert!(
                share == 0.0 || most as f64 <= 1.2 * share * all as f64,
                "{share}: {most}"
            );
            some += refined.iter().filter(|n| (1..all).contains(*n)).count();
        }
        assert!(some > 8, "branches were refined in {some} steps");
    }
}

#[test]
fn branches_change_no_answer() {
    let mesh = bake::bumpy_sphere(56, 1);
    check_bake(&mesh, &bake::smooth_basis(&mesh, 6, 2));
    check_bake(&mesh, &bake::local_basis(&mesh, 12, 2));
}

#[test]
fn branches_change_no_answer_about_a_character() {
    let model = Model::from_bytes(&skinned_bar_of(250)).expect("a bar");
    let asset = model.asset();
    let mut some = 0;
    for share in [0.0, 0.3, 1.0] {
        let refined = check(asset, share, |asset, rng, ask| {
            let q = poses::random_q(asset, 0.2, rng);
            let at = poses::random_transform(2.0, rng);
            let mut memory = vec![0.0; asset.pose_len()];
            let matrices: [JointMatrix; 3] = core::array::from_fn(|_| {
                core::array::from_fn(|row| {
                    core::array::from_fn(|column| {
                        f64::from(u8::from(row == column)) + rng.random_range(-0.3..0.3)
                    })
                })
            });
            let bones = BoneMatrices::Skinning(&matrices);
            let pose = asset.pose_with_bones(&q, bones, at, &mut memory);
            ask(&pose.expect("a pose"));
        });
        let all = asset.triangle_count();
        some += refined.iter().filter(|n| (1..all).contains(*n)).count();
    }
    assert!(some > 3, "branches were refined in {some} steps");
}

/// A cache refines branches in steps that ask in one place, the whole pose in steps that ask all over, and branches alone where memory
/// is short.
#[test]
fn what_is_refined_is_what_pays() {
    let mesh = bake::bumpy_sphere(56, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 4, 2));
    let asset = model.asset();
    let all = asset.triangle_count();
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset.pose(&[0.01; 4], Transform::IDENTITY, &mut memory);
    let pose = pose.expect("a pose");
    let mut workspace = Workspace::new();
    let mut rng = poses::rng(3);
    let mut step = |cache: &mut StepCache<'_>, spread: f64, count: usize| {
        let rays: Vec<Ray> = (0..count)
            .map(|_| {
                let from =
                    [0.0, 0.0, 1.0].map(|x: f64| 4.0 * x + spread * rng.random_range(-1.0..1.0));
                let to = [0, 1, 2].map(|k| 0.04 * from[k] + 0.05 * rng.random_range(-1.0..1.0));
                Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k]))
            })
            .collect();
        let mut hits = vec![None; count];
        cache.start(&pose);
        assert_eq!(cache.refined_triangles(), 0);
        let mut query = pose.query(&mut workspace).cached(cache);
        query.cast_rays(&rays, &mut hits).expect("rays");
        let refined = cache.refined_triangles();
        assert_eq!(cache.is_refined(), refined == all);
        refined
    };
    let mut cache = StepCache::new(CacheSize::NONE).refining(RefinedPose::new());
    assert_eq!(step(&mut cache, 0.1, 3), 0);
    for _ in 0..3 {
        let refined = step(&mut cache, 0.1, 80);
        assert!((1..all / 4).contains(&refined), "{refined} of {all}");
    }
    step(&mut cache, 60.0, 4000);
    assert_eq!(step(&mut cache, 60.0, 4000), all);
    step(&mut cache, 0.1, 5);
    assert_eq!(step(&mut cache, 0.1, 5), 0);
    let mut bytes = vec![0; RefinedPose::bytes_for(asset).expect("bytes") / 3];
    let cache = StepCache::new(CacheSize::NONE);
    let mut cache = cache.refining(RefinedPose::in_bytes(&mut bytes));
    for spread in [60.0, 60.0, 60.0, 0.1, 0.1] {
        let refined = step(&mut cache, spread, 4000);
        assert!((1..all / 2).contains(&refined), "{refined} of {all}");
    }
}

/// Many rays that end at a level are not split: a sink that was full for one of them was full.
#[test]
fn rays_that_end_at_a_level_are_asked_together() {
    struct Full;
    impl Sink<Proxy> for Full {
        fn push(&mut self, _: Proxy) -> ControlFlow<()> {
            ControlFlow::Break(())
        }
    }
    let mesh = bake::bumpy_sphere(56, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 4, 2));
    let asset = model.asset();
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset.pose(&[0.01; 4], Transform::IDENTITY, &mut memory);
    let pose = pose.expect("a pose");
    let mut cache = StepCache::new(CacheSize::NONE).refining(RefinedPose::new());
    cache.start(&pose);
    // The first one meets the mesh, the others pass it.
    let mut rays = vec![Ray::new([0.0, 0.0, 5.0], [0.0, 0.0, 1.0]); 400];
    rays[0].direction = [0.0, 0.0, -1.0];
    let (mut hits, mut workspace) = (vec![None; 400], Workspace::new());
    let mut full = Full;
    let query = pose.query(&mut workspace).cached(&mut cache);
    let outcome = query.max_level(1, &mut full).cast_rays(&rays, &mut hits);
    assert_eq!(outcome, Err(QueryError::Proxies));
}

/// Branches of damaged trees are refined without a panic, or not at all.
#[test]
fn branches_of_damaged_files_are_harmless() {
    let mesh = bake::bumpy_sphere(56, 1);
    let sound = bake::baked(&mesh, &bake::smooth_basis(&mesh, 3, 2));
    let (mut opened, mut answered, mut refined) = (0, 0, 0);
    // One after the other in the same memory.
    let mut bytes = vec![0xa5; RefinedPose::bytes_for(sound.asset()).expect("bytes")];
    for case in 0..150 {
        let mut rng = poses::rng(case);
        let damage = [Damage::Records, Damage::Tree, Damage::Several];
        let damaged = damage[case as usize % 3].done_to(sound.asset(), &mut rng);
        let Ok(model) = Model::from_bytes(&damaged) else {
            continue;
        };
        opened += 1;
        let asset = model.asset();
        let mut memory = vec![0.0; asset.pose_len()];
        let Ok(pose) = asset.pose(&[0.01; 3], Transform::IDENTITY, &mut memory) else {
            continue;
        };
        let share = rng.random_range(0..=bytes.len());
        let memory = match case % 4 {
            0 => RefinedPose::new(),
            1 => RefinedPose::in_bytes(&mut bytes),
            _ => RefinedPose::in_bytes(&mut bytes[share..]),
        };
        let mut cache = StepCache::new(CacheSize::NONE).refining(memory);
        let mut workspace = Workspace::new();
        for _ in 0..3 {
            cache.start(&pose);
            let center = rng.random_range(0..mesh.positions.len());
            let spread = [0.1, 1.0][rng.random_range(0..2)];
            let rays = (0..rng.random_range(1..300)).map(|_| {
                let mut any = || rng.random_range(-spread..spread);
                let to = mesh.positions[center].map(|x| x + any());
                Ray::new(to.map(|x| 2.0 * x), to.map(|x| -x))
            });
            let asked = Asked {
                rays: rays.collect(),
                ball: Ball::new(mesh.positions[center], 0.1),
                distance: 0.3,
            };
            for _ in 0..2 {
                let mut query = pose.query(&mut workspace).cached(&mut cache);
                answered += usize::from(asked.of(&mut query).is_ok());
            }
            refined += usize::from(cache.refined_triangles() > 0);
        }
    }
    assert!(
        opened > 50 && answered > 100 && refined > 50,
        "{opened} {answered} {refined}"
    );
}
