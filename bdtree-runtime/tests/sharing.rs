//! One asset for many instances on several threads, each with a pose and a cache of its own, and
//! how many bytes that takes.

use bdtree_fixtures::{bake, poses};
use bdtree_runtime::{
    Asset, Ball, CacheSize, Contact, Instance, Model, PairFront, Pose, Proxy, StepCache, Workspace,
};
use rand::RngExt;

fn crosses_threads<T: Send + Sync>() {}

#[test]
fn what_instances_share_and_own_crosses_threads() {
    crosses_threads::<Asset<'static>>();
    crosses_threads::<Model>();
    crosses_threads::<Instance>();
    crosses_threads::<Pose<'static>>();
    crosses_threads::<StepCache<'static>>();
    crosses_threads::<PairFront<'static>>();
    crosses_threads::<Workspace<'static>>();
    crosses_threads::<(Contact, Proxy)>();
}

/// What an instance answers over a few steps.
fn simulate(model: &Model, instance: u64) -> Vec<(Vec<Contact>, Vec<Proxy>)> {
    let mut rng = poses::rng(instance);
    let size = CacheSize {
        nodes: 64,
        leaves: 64,
    };
    let mut body = Instance::with_cache(model, size).expect("an instance");
    let mut workspace = Workspace::new();
    let mut answers = Vec::new();
    for _ in 0..5 {
        let q = poses::random_q(model.asset(), 0.2, &mut rng);
        let place = poses::random_transform(1.0, &mut rng);
        body.set_pose(&q, place).expect("pose");
        for _ in 0..5 {
            let ball = Ball::new([0; 3].map(|_| rng.random_range(-2.0_f64..2.0)), 0.4);
            let (mut contacts, mut proxies) = (Vec::new(), Vec::new());
            let mut query = body.query(&mut workspace);
            query.contacts(ball, &mut contacts).expect("ball");
            let mut query = query.max_level(1, &mut proxies);
            query.contacts(ball, &mut Vec::new()).expect("ball");
            answers.push((contacts, proxies));
        }
    }
    answers
}

#[test]
fn one_model_serves_instances_on_several_threads() {
    let mesh = bake::bumpy_sphere(12, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 5));
    let alone: Vec<_> = (0..32).map(|i| simulate(&model, i)).collect();
    let found: usize = alone
        .iter()
        .flatten()
        .map(|(c, p)| c.len().min(p.len()))
        .sum();
    assert!(found > 100, "{found}");
    let together: Vec<_> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..4)
            .map(|worker| {
                let model = model.clone();
                scope.spawn(move || {
                    let mine = (0..32).filter(|i| i % 4 == worker);
                    mine.map(|i| (i, simulate(&model, i))).collect::<Vec<_>>()
                })
            })
            .collect();
        workers
            .into_iter()
            .flat_map(|w| w.join().expect("no panic"))
            .collect()
    });
    assert_eq!(together.len(), 32);
    for (i, answers) in together {
        assert_eq!(answers, alone[i as usize], "instance {i}");
    }
}

/// The size of the paper's chairs: 1000 bodies of 18 000 triangles at 10 modes.
#[test]
fn an_instance_takes_less_than_64_kilobytes() {
    let mesh = bake::bumpy_sphere(67, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 10, 5));
    let asset = *model.asset();
    let bytes_to = |level: usize| {
        size_of::<Pose<'_>>()
            + size_of::<f32>() * asset.pose_len()
            + CacheSize::to_level(&asset, level).bytes()
    };
    assert_eq!(asset.node_count_to(0), 1);
    assert!(asset.node_count_to(1) <= 9 && asset.node_count_to(2) <= 73);
    assert_eq!(asset.node_count_to(asset.depth() - 1), asset.node_count());
    let (level2, all) = (bytes_to(2), bytes_to(usize::MAX));
    assert!(level2 <= 11 * 1024, "{level2} bytes down to level 2");
    assert!(
        all > 64 * 1024,
        "{all} bytes for all of {} levels",
        asset.depth()
    );
    // Any number of slots serves; the rest is evaluated when it is asked for again.
    let some = CacheSize {
        nodes: 256,
        leaves: 128,
    };
    assert!(some.bytes() < 60 * 1024);
}
