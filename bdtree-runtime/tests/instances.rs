//! Instances answer what their poses answer, step after step, whatever they have kept.

use bdtree_fixtures::{bake, poses};
use bdtree_runtime::{
    Ball, CacheSize, Contact, Instance, Model, PairContact, PairFront, PoseError, Ray, Transform,
    TrianglePair, Workspace,
};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

fn model() -> Model {
    let mesh = bake::bumpy_sphere(14, 1);
    bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 5))
}

/// What a body at a q and a place should be.
struct Twin {
    q: Vec<f32>,
    place: Transform,
}

/// Changes q, the place or both.
fn step(body: &mut Instance, twin: &mut Twin, share: f64, rng: &mut Pcg64Mcg) {
    let q = poses::random_q(body.model().asset(), share, rng);
    let place = poses::random_transform(0.4, rng);
    match rng.random_range(0..3) {
        0 => {
            body.set_q(&q).expect("q");
            twin.q = q;
        }
        1 => {
            body.set_placement(place).expect("a placement");
            twin.place = place;
        }
        _ => {
            body.set_pose(&q, place).expect("a pose");
            (twin.q, twin.place) = (q, place);
        }
    }
}

#[test]
fn answers_are_those_of_the_pose() {
    let model = model();
    let asset = model.asset();
    let mut rng = poses::rng(3);
    let mut workspace = Workspace::new();
    let small = CacheSize {
        nodes: 5,
        leaves: 3,
    };
    let mut found = 0;
    for size in [CacheSize::NONE, small, CacheSize::all(asset)] {
        let mut bodies = [0, 1].map(|_| Instance::with_cache(&model, size).expect("an instance"));
        let mut twins = [0, 1].map(|_| Twin {
            q: vec![0.0; asset.mode_count()],
            place: Transform::IDENTITY,
        });
        for _ in 0..40 {
            for (body, twin) in bodies.iter_mut().zip(&mut twins) {
                step(body, twin, 0.2, &mut rng);
                assert_eq!((body.q(), body.placement()), (&twin.q[..], twin.place));
            }
            let mut memory = [0, 1].map(|_| vec![0.0; asset.pose_len()]);
            let [memory0, memory1] = &mut memory;
            let plain = [
                asset.pose(&twins[0].q, twins[0].place, memory0).expect("a"),
                asset.pose(&twins[1].q, twins[1].place, memory1).expect("b"),
            ];
            let ball = Ball::new([0; 3].map(|_| rng.random_range(-1.0_f64..1.0)), 0.5);
            let ray = Ray::new([4.0, 3.0, 2.0], ball.center.map(|c| c - 2.0));
            for (body, pose) in bodies.iter_mut().zip(&plain) {
                assert_eq!(body.bounding_sphere(), pose.bounding_sphere());
                assert_eq!(body.aabb(), pose.aabb());
                // Twice: what the first question has kept answers the second.
                for _ in 0..2 {
                    let [mut own, mut expected] = [Vec::<Contact>::new(), Vec::new()];
                    let mut query = body.query(&mut workspace);
                    query.contacts(ball, &mut own).expect("ball");
                    let (near, hit) = (
                        query.project_point(ball.center, f64::INFINITY),
                        query.cast_ray(&ray),
                    );
                    let mut query = pose.query(&mut workspace);
                    query.contacts(ball, &mut expected).expect("ball");
                    assert_eq!(own, expected);
                    assert_eq!(near, query.project_point(ball.center, f64::INFINITY));
                    assert_eq!(hit, query.cast_ray(&ray));
                    found += own.len();
                }
                // Readers beside each other, who keep nothing.
                let reader = body.pose();
                assert_eq!(reader.q(), pose.q());
                let mut query = reader.query(&mut workspace);
                assert_eq!(
                    query.cast_ray(&ray),
                    pose.query(&mut Workspace::new()).cast_ray(&ray)
                );
            }
            let [first, second] = &mut bodies;
            let [mut own, mut expected] = [Vec::<PairContact>::new(), Vec::new()];
            let mut query = first.against(second, &mut workspace);
            query.contacts(0.01, &mut own).expect("pair");
            let gap = query.closest_points(f64::INFINITY);
            let mut query = plain[0].against(&plain[1], &mut workspace);
            query.contacts(0.01, &mut expected).expect("pair");
            assert_eq!(own, expected);
            assert_eq!(gap, query.closest_points(f64::INFINITY));
            found += own.len();
        }
    }
    assert!(found > 1000, "{found}");
}

/// What is kept serves the whole step, wherever the body is placed meanwhile, and no other step.
#[test]
fn a_step_evaluates_each_node_once() {
    let model = model();
    let mut workspace = Workspace::new();
    let all = CacheSize::all(model.asset());
    let mut body = Instance::with_cache(&model, all).expect("an instance");
    let mut ask = |body: &mut Instance| {
        let mut query = body.query(&mut workspace);
        query
            .project_point([3.0, 0.0, 0.0], f64::INFINITY)
            .expect("near");
        query.stats()
    };
    let first = ask(&mut body);
    assert!(first.nodes_updated > 0 && first.nodes_updated == first.nodes_visited);
    assert_eq!(ask(&mut body).nodes_updated, 0);
    let place = Transform::from_translation([1e-3, 0.0, 0.0]);
    body.set_placement(place).expect("a placement");
    assert!(ask(&mut body).nodes_updated < first.nodes_updated);
    body.set_q(&[0.1; 6]).expect("q");
    let next = ask(&mut body);
    assert_eq!(next.nodes_updated, next.nodes_visited);
}

#[test]
fn an_error_leaves_the_body_as_it_was() {
    let model = model();
    let mut rng = poses::rng(5);
    let mut workspace = Workspace::new();
    let mut body = Instance::new(&model).expect("an instance");
    let q = poses::random_q(model.asset(), 0.2, &mut rng);
    let place = poses::random_transform(0.4, &mut rng);
    body.set_pose(&q, place).expect("a pose");
    body.user_data = 7;
    let mut answer = |body: &mut Instance| {
        let mut contacts: Vec<Contact> = Vec::new();
        let ball = Ball::new(place.translation, 1.2);
        body.query(&mut workspace)
            .contacts(ball, &mut contacts)
            .expect("ball");
        (contacts, body.aabb().expect("box"))
    };
    let before = answer(&mut body);
    assert!(!before.0.is_empty());
    let limit = model.asset().modes()[5].q_limit.get();
    let mut over = q.clone();
    over[5] = 2.0 * limit;
    let mut nan = q.clone();
    nan[5] = f32::NAN;
    let turned = Transform {
        rotation: [0.0; 4],
        ..place
    };
    let scaled = place.with_scale(0.0);
    for refused in [
        (
            body.set_q(&q[1..]),
            PoseError::ModeCount {
                expected: 6,
                found: 5,
            },
        ),
        (body.set_q(&nan), PoseError::NotFinite { mode: 5 }),
        (
            body.set_q(&over),
            PoseError::OverLimit {
                mode: 5,
                found: 2.0 * limit,
                limit,
            },
        ),
        (body.set_placement(turned), PoseError::Rotation),
        (body.set_placement(scaled), PoseError::Scale),
        (body.set_pose(&[0.0; 6], scaled), PoseError::Scale),
        (
            body.set_pose(&nan, Transform::IDENTITY),
            PoseError::NotFinite { mode: 5 },
        ),
    ] {
        assert_eq!(refused.0, Err(refused.1));
    }
    assert_eq!((body.q(), body.placement()), (&q[..], place));
    assert_eq!(answer(&mut body), before);
    assert_eq!(body.user_data, 7);
}

#[test]
fn groups_say_who_meets() {
    let model = model();
    let mut bodies = [0, 1].map(|_| Instance::new(&model).expect("an instance"));
    assert_eq!(bodies[0].user_data, 0);
    assert!(bodies[0].may_meet(&bodies[1]), "all meet at first");
    for (group0, mask0, group1, mask1, meets) in [
        (0b01, 0b10, 0b10, 0b01, true),
        (0b01, 0b10, 0b10, 0b10, false),
        (0b01, 0b01, 0b10, 0b01, false),
        (0b11, 0b01, 0b01, 0b10, true),
        (0, u32::MAX, u32::MAX, u32::MAX, false),
        (u32::MAX, 0, u32::MAX, u32::MAX, false),
    ] {
        let [first, second] = &mut bodies;
        (first.collision_group, first.collision_mask) = (group0, mask0);
        (second.collision_group, second.collision_mask) = (group1, mask1);
        assert_eq!(first.may_meet(second), meets);
        assert_eq!(second.may_meet(first), meets);
    }
}

/// Bodies that move by small and by large steps, with a front: what a walk from the root answers.
#[test]
fn fronts_of_moving_bodies_change_no_answer() {
    let model = model();
    let asset = model.asset();
    let mut rng = poses::rng(11);
    let (mut workspace, mut front) = (Workspace::new(), PairFront::new());
    let mut bodies = [0, 1].map(|_| Instance::new(&model).expect("an instance"));
    let (mut touching, mut with_front, mut without) = (0, 0, 0);
    for time in 0..120 {
        let [first, second] = &mut bodies;
        // A while of small steps, then anywhere.
        let share = if time % 30 == 0 { 0.2 } else { 1e-4 };
        let change = poses::random_q(asset, share, &mut rng);
        let q: Vec<f32> = first.q().iter().zip(&change).map(|(q, c)| q + c).collect();
        let move_by = share * rng.random_range(-1.0..1.0);
        match time % 3 {
            0 => first.set_q(&q).expect("q"),
            1 => second
                .set_placement(Transform::from_translation([1.9 + move_by, 0.1, 0.0]))
                .expect("a placement"),
            _ => {
                let place = Transform::from_translation([0.0, move_by, 0.0]);
                first.set_pose(&q, place).expect("a pose");
            }
        }
        let tolerance = if time < 60 { 0.0 } else { 0.02 };
        let [mut own, mut expected] = [Vec::<TrianglePair>::new(), Vec::new()];
        let mut query = first.against(second, &mut workspace).front(&mut front);
        query.triangle_pairs(tolerance, &mut own).expect("pair");
        with_front += query.stats().nodes_visited;
        let (first, second) = (first.pose(), second.pose());
        let mut query = first.against(&second, &mut workspace);
        query
            .triangle_pairs(tolerance, &mut expected)
            .expect("pair");
        without += query.stats().nodes_visited;
        own.sort_unstable();
        expected.sort_unstable();
        assert_eq!(own, expected, "step {time}");
        touching += own.len();
    }
    assert!(touching > 100, "{touching}");
    assert!(with_front < without, "{with_front} {without}");
}

/// Instances keep no motion until a pose is asked for; then fronts of such poses serve as those of `against` do, also if one
/// of the two stands still.
#[test]
fn fronts_of_poses_serve() {
    let model = model();
    let (mut workspace, mut front) = (Workspace::new(), PairFront::new());
    let mut bodies = [0, 1].map(|_| Instance::new(&model).expect("an instance"));
    let at = |body: &mut Instance, place: [f64; 3]| {
        let place = Transform::from_translation(place);
        body.set_placement(place).expect("a placement");
    };
    // Nobody has asked for these.
    for time in 0..3 {
        at(&mut bodies[0], [0.0, 1e-2 * f64::from(time), 0.0]);
    }
    let (mut served, mut touching) = (0, 0);
    for time in 0..40 {
        at(&mut bodies[1], [1.9, 0.1 + 1e-5 * f64::from(time), 0.0]);
        let [first, second] = bodies.each_ref().map(Instance::pose);
        let [mut own, mut expected] = [Vec::<TrianglePair>::new(), Vec::new()];
        let mut query = first.against(&second, &mut workspace).front(&mut front);
        query.triangle_pairs(0.0, &mut own).expect("pair");
        served += usize::from(query.stats().nodes_visited == 0);
        let mut query = first.against(&second, &mut workspace);
        query.triangle_pairs(0.0, &mut expected).expect("pair");
        own.sort_unstable();
        expected.sort_unstable();
        assert_eq!(own, expected, "step {time}");
        touching += own.len();
    }
    assert!(touching > 40 && served > 20, "{touching} {served}");
}
