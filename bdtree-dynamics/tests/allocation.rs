//! After warm-up a world allocates nothing on one thread.

#[path = "support.rs"]
#[allow(dead_code)] // what other tests use
mod support;

use bdtree_dynamics::{BodyOptions, ContactShape, WorldOptions};
use bdtree_fixtures::allocations::{Counting, allocations};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn steps_allocate_nothing() {
    let regions = BodyOptions {
        contact: ContactShape::Regions,
        ..BodyOptions::default()
    };
    for (count, steps, of) in [(8, 500, BodyOptions::default()), (3, 120, regions)] {
        let mut world = support::falling(count, WorldOptions::default(), &of);
        // The first pass makes room; the second is the same steps again.
        let mut start = Vec::new();
        world.save(&mut start);
        for _ in 0..steps {
            world.step().expect("a step");
        }
        world.restore(&start).expect("restored");
        for _ in 0..10 {
            world.step().expect("a step");
        }
        let (count, events) = allocations(|| {
            let mut events = 0;
            for _ in 10..steps {
                events += world.step().expect("a step").events;
                events += world.events().count() as u64 + world.contacts().count() as u64;
            }
            events
        });
        assert_eq!(count, 0);
        assert!(events > 1000, "{events}");
    }
}
