//! One asset for many instances on several threads, each with a pose and a cache of its own, and
//! how many bytes that takes.

use bdtree_fixtures::{bake, poses};
use bdtree_runtime::broad::GridSlot;
use bdtree_runtime::{
    AlignedBytes, Asset, CachedPose, Contact, LeafSlot, NodeSlot, Pose, Posed, Proxy, StackEntry,
    StepCache, query,
};
use rand::RngExt;

fn crosses_threads<T: Send + Sync>() {}

#[test]
fn what_instances_share_and_own_crosses_threads() {
    crosses_threads::<Asset<'static>>();
    crosses_threads::<AlignedBytes>();
    crosses_threads::<Pose<'static>>();
    crosses_threads::<CachedPose<'static>>();
    crosses_threads::<StepCache<Vec<NodeSlot>, Vec<LeafSlot>>>();
    crosses_threads::<(StackEntry, NodeSlot, LeafSlot, GridSlot, Contact, Proxy)>();
}

/// What an instance answers over a few steps.
fn simulate(asset: &Asset<'_>, instance: u64) -> Vec<(Vec<Contact>, Vec<Proxy>)> {
    let mut rng = poses::rng(instance);
    let mut cache = StepCache::new([NodeSlot::EMPTY; 64], [LeafSlot::EMPTY; 64]);
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    let mut answers = Vec::new();
    for _ in 0..5 {
        let q = poses::random_q(asset, 0.2, &mut rng);
        let place = poses::random_transform(1.0, &mut rng);
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = Pose::new(asset, &q, place, &mut memory).expect("pose");
        let mut cached = cache.start(&pose);
        for _ in 0..5 {
            let center = [0; 3].map(|_| rng.random_range(-2.0..2.0));
            let (mut contacts, mut proxies) = (Vec::new(), Vec::new());
            query::ball(asset, &mut cached, center, 0.4, &mut stack, &mut contacts).expect("ball");
            let posed = Posed::from(&mut cached).bounded(1, &mut proxies);
            query::ball(asset, posed, center, 0.4, &mut stack, &mut Vec::new()).expect("ball");
            answers.push((contacts, proxies));
        }
    }
    answers
}

#[test]
fn one_asset_serves_instances_on_several_threads() {
    let mesh = bake::bumpy_sphere(12, 1);
    let bytes = bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 5));
    let asset = Asset::open(&bytes).expect("open");
    let alone: Vec<_> = (0..32).map(|i| simulate(&asset, i)).collect();
    let found: usize = alone
        .iter()
        .flatten()
        .map(|(c, p)| c.len().min(p.len()))
        .sum();
    assert!(found > 100, "{found}");
    let together: Vec<_> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..4)
            .map(|worker| {
                let asset = &asset;
                scope.spawn(move || {
                    let mine = (0..32).filter(|i| i % 4 == worker);
                    mine.map(|i| (i, simulate(asset, i))).collect::<Vec<_>>()
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
    let bytes = bake::baked(&mesh, &bake::smooth_basis(&mesh, 10, 5));
    let asset = Asset::open(&bytes).expect("open");
    let bytes_to = |level: usize| {
        size_of::<Pose<'_>>()
            + size_of::<f32>() * asset.pose_len()
            + size_of::<NodeSlot>() * asset.node_count_to(level)
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
    assert!(size_of::<NodeSlot>() * 256 + size_of::<LeafSlot>() * 128 < 60 * 1024);
}
