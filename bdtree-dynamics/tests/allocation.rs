//! After warm-up a world allocates nothing on one thread.

#[path = "support.rs"]
#[allow(dead_code)] // what other tests use
mod support;

use bdtree_fixtures::allocations::{Counting, allocations};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn steps_allocate_nothing() {
    let mut world = support::falling_beams(8, 1);
    // The first pass makes room; the second is the same steps again.
    let mut start = Vec::new();
    world.save(&mut start);
    for _ in 0..500 {
        world.step().expect("a step");
    }
    world.restore(&start).expect("restored");
    for _ in 0..10 {
        world.step().expect("a step");
    }
    let (count, events) = allocations(|| {
        let mut events = 0;
        for _ in 10..500 {
            events += world.step().expect("a step").events;
            events += world.events().count() as u64 + world.contacts().count() as u64;
        }
        events
    });
    assert_eq!(count, 0);
    assert!(events > 1000, "{events}");
}
