//! Islands that come to rest sleep, wake when they are pushed, and nothing changes meanwhile.

use bdtree_dynamics::{BodyId, Frame, ModelId, Phase, World};
use bdtree_runtime::Transform;

use crate::support::{at, falling_beams};

/// Steps until everything sleeps.
fn sleep(world: &mut World, count: usize) -> u64 {
    for n in 0..6000 {
        if world.asleep() == count {
            return n;
        }
        world.step().expect("a step");
    }
    panic!("{} of {count} sleep: {:?}", world.asleep(), world.energy());
}

fn bytes(world: &World) -> Vec<u8> {
    let mut out = Vec::new();
    world.save(&mut out);
    out
}

fn placements(world: &World) -> Vec<Transform> {
    (0..world.len())
        .map(|k| world.placement(BodyId(k)).expect("a placement"))
        .collect()
}

#[test]
fn a_heap_sleeps_and_wakes() {
    let mut world = falling_beams(6, 1);
    sleep(&mut world, 6);
    assert_eq!(world.energy().kinetic, 0.0);
    let lie = placements(&world);
    for _ in 0..100 {
        let report = world.step().expect("a step");
        assert_eq!([report.pairs, report.events], [0, 0]);
        assert_eq!(world.events().count(), 0);
    }
    assert_eq!(placements(&world), lie);

    // What falls on them wakes them, and all sleep again.
    let top = lie.iter().map(|t| t.translation[1]).fold(0.0, f64::max);
    let falls = world
        .add_body(ModelId(0), Frame::Free, at([-0.5, top + 0.4, 0.0]))
        .expect("a body");
    let mut least = usize::MAX;
    for _ in 0..200 {
        world.step().expect("a step");
        least = least.min(world.asleep());
    }
    assert!(least < 6, "{least}");
    sleep(&mut world, 7);
    assert_ne!(placements(&world)[..6], lie[..]);

    // So does a push.
    world
        .add_force(falls, [0.0, 5.0, 0.0], [0.0; 3])
        .expect("a force");
    world.step().expect("a step");
    assert!(world.asleep() < 7);
}

/// Pairs that fall asleep have not parted; when they wake they still touch.
#[test]
fn sleeping_pairs_stay_together() {
    let mut world = falling_beams(3, 1);
    let mut touching = std::collections::BTreeSet::new();
    let mut follow = |world: &mut World| {
        world.step().expect("a step");
        for event in world.events() {
            match event.phase {
                Phase::Began => assert!(touching.insert(event.bodies), "{event:?}"),
                Phase::Touching => assert!(touching.contains(&event.bodies), "{event:?}"),
                Phase::Ended => assert!(touching.remove(&event.bodies), "{event:?}"),
            }
        }
        touching.len()
    };
    for _ in 0..6000 {
        follow(&mut world);
        if world.asleep() == 3 {
            break;
        }
    }
    assert_eq!(world.asleep(), 3);
    let before = follow(&mut world);
    assert!(before >= 3);
    world
        .add_force(BodyId(0), [0.0; 3], [0.0, 1e-3, 0.0])
        .expect("a torque");
    for _ in 0..30 {
        assert_eq!(follow(&mut world), before);
    }
    assert_eq!(world.asleep(), 0);
}

/// Asleep or about to wake: saved, restored and with two threads it goes on with the same bytes.
#[test]
fn sleep_is_part_of_the_state() {
    let mut alone = falling_beams(4, 1);
    let steps = sleep(&mut alone, 4);
    let mut together = falling_beams(4, 2);
    for _ in 0..steps {
        together.step().expect("a step");
    }
    assert!(bytes(&alone) == bytes(&together));
    alone
        .add_force(BodyId(1), [0.0, 30.0, 0.0], [0.0; 3])
        .expect("a force");
    let saved = bytes(&alone);
    let mut again = falling_beams(4, 2);
    again.restore(&saved).expect("restored");
    assert_eq!(again.asleep(), 4);
    for _ in 0..150 {
        alone.step().expect("a step");
        again.step().expect("a step");
    }
    assert!(bytes(&alone) == bytes(&again));
}
