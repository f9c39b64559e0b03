//! The examples of bodies of rapier that deform.

use std::sync::OnceLock;

use bdtree_fixtures::bake;
use bdtree_parry::DeformingModel;
use bdtree_runtime::Model;

#[path = "../examples/ball_on_chair.rs"]
#[allow(dead_code, unreachable_pub)]
mod ball_on_chair;
#[path = "../examples/heap.rs"]
#[allow(dead_code, unreachable_pub)]
mod heap;

/// The chair with six vibration modes; baked once.
pub(crate) fn chair() -> &'static Model {
    static CHAIR: OnceLock<Model> = OnceLock::new();
    CHAIR.get_or_init(|| bake::elastic("chair", 6, 30, &[]))
}

#[test]
fn a_chair_stops_a_ball() {
    let height = ball_on_chair::drop_on_chair(chair()).expect("a world");
    assert!((0.48..0.56).contains(&height), "{height}");
}

/// The page's program is the example, which this file runs.
#[test]
fn the_page_shows_the_example() {
    let page = include_str!("../../docs/guide/rapier.md");
    let example = include_str!("../examples/ball_on_chair.rs");
    let start = example
        .find("/// Drops a ball of 3 kg")
        .expect("the function");
    assert!(page.contains(example[start..].trim_end()));
}

/// Chairs that fell on each other sleep before ten seconds have passed, and go on doing so.
#[test]
fn a_heap_comes_to_rest() {
    let model = DeformingModel::new(chair(), 1.0).expect("a model");
    let mut heap = heap::Heap::new(&model, 12, true).expect("a heap");
    let mut bent = 0.0_f32;
    for step in 0..11 * heap::RATE {
        heap.flexible.step(&mut heap.world).expect("a step");
        if step < 10 * heap::RATE {
            for (_, collider) in &heap.chairs {
                let q = heap.flexible.mesh(*collider).expect("a mesh").q();
                bent = q.iter().fold(bent, |most, q| most.max(q.abs()));
            }
        } else {
            assert_eq!((heap.asleep(), heap.kinetic_energy()), (12, 0.0));
        }
    }
    assert!(bent > 1e-3, "{bent}");
    for (frame, _) in &heap.chairs {
        let at = heap.world.bodies[*frame].translation();
        assert!(at.y > -0.1 && at.x.abs() < 2.0 && at.z.abs() < 2.0, "{at}");
    }
}
