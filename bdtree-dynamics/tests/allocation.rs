//! After warm-up a world allocates nothing on one thread.
#![allow(unsafe_code)] // a counting allocator; every block has its proof

#[path = "support.rs"]
#[allow(dead_code)] // what other tests use
mod support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    /// Allocations of this thread.
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

fn count() {
    // A thread that ends has no counter any more.
    let _ = COUNT.try_with(|c| c.set(c.get() + 1));
}

// SAFETY: every call goes to the system's allocator unchanged; counting touches a thread-local
// number that is initialised without allocating.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promise about `layout` is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `System` with this layout, as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: `pointer` came from `System`; the rest is the caller's promise.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

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
    let mut events = 0;
    let before = COUNT.get();
    for _ in 10..500 {
        events += world.step().expect("a step").events;
        events += world.events().count() as u64 + world.contacts().count() as u64;
    }
    assert_eq!(COUNT.get() - before, 0);
    assert!(events > 1000, "{events}");
}
