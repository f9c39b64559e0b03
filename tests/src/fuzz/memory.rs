//! Memory of the own thread, by an allocator that counts: what a reader holds at most, and a stop
//! before a small file takes the machine's memory.
#![allow(unsafe_code)] // a counting allocator; every block has its proof

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::Write;

use super::Case;

thread_local! {
    /// Bytes that this thread took less those that it gave back, since [`measured`] began.
    static HELD: Cell<isize> = const { Cell::new(0) };
    /// The most of it.
    static PEAK: Cell<isize> = const { Cell::new(0) };
    /// Beyond it the process ends.
    static LIMIT: Cell<isize> = const { Cell::new(isize::MAX) };
    /// What is being read.
    static CASE: Cell<Option<Case>> = const { Cell::new(None) };
}

/// The system's allocator with counters per thread. A program that fuzzes names it as its global
/// allocator; without it nothing is counted.
pub struct Counting;

fn taken(size: usize) {
    // A thread that ends has no counters any more.
    let over = HELD.try_with(|held| {
        let now = held.get().saturating_add_unsigned(size);
        held.set(now);
        let _ = PEAK.try_with(|peak| peak.set(peak.get().max(now)));
        LIMIT.try_with(|limit| now > limit.get()).unwrap_or(false)
    });
    if over == Ok(true) {
        stop(size);
    }
}

fn given_back(size: usize) {
    let _ = HELD.try_with(|held| held.set(held.get().saturating_sub_unsigned(size)));
}

/// Ends the process: an allocator can neither fail without ending it nor unwind.
fn stop(size: usize) -> ! {
    // Writing may allocate.
    let limit = LIMIT.replace(isize::MAX);
    let mut err = std::io::stderr();
    let _ = match CASE.get() {
        Some(case) => writeln!(
            err,
            "{case}: asks for {size} bytes, {limit} in all are allowed"
        ),
        None => writeln!(err, "asks for {size} bytes, {limit} in all are allowed"),
    };
    std::process::abort()
}

// SAFETY: every call goes to the system's allocator unchanged; counting touches thread-local
// numbers that are initialised without allocating.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        taken(layout.size());
        // SAFETY: the caller's promise about `layout` is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        taken(layout.size());
        // SAFETY: the caller's promise about `layout` is passed on.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        given_back(layout.size());
        // SAFETY: `pointer` came from `System` with this layout, as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Both may be held for a moment.
        taken(size);
        given_back(layout.size());
        // SAFETY: `pointer` came from `System`; the rest is the caller's promise.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// What `f` gives, and the bytes that it held at most. Ends the process when they get beyond
/// `limit`, after a line that names the case.
pub(super) fn measured<T>(case: Case, limit: usize, f: impl FnOnce() -> T) -> (T, usize) {
    /// Sets the limit back, however `f` ends.
    struct Unlimited;
    impl Drop for Unlimited {
        fn drop(&mut self) {
            LIMIT.set(isize::MAX);
        }
    }
    CASE.set(Some(case));
    HELD.set(0);
    PEAK.set(0);
    LIMIT.set(limit.try_into().unwrap_or(isize::MAX));
    let unlimited = Unlimited;
    let result = f();
    drop(unlimited);
    (result, PEAK.get().max(0) as usize)
}
