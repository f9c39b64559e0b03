//! The mode in which the processor flushes subnormal numbers to zero, as audio and game code sets it.
#![cfg(target_arch = "x86_64")]
#![allow(unsafe_code)] // the control register; every block has its proof

use std::arch::asm;

/// Flush results to zero (bit 15), read subnormals as zero (bit 6).
const FLUSH: u32 = 1 << 15 | 1 << 6;

fn control() -> u32 {
    let mut value = 0_u32;
    // SAFETY: stores four bytes through a pointer to a live u32; SSE is part of x86-64.
    unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut value, options(nostack)) };
    value
}

fn set_control(value: u32) {
    // SAFETY: loads four bytes through a pointer to a live u32. The value is what `stmxcsr` gave,
    // with flush bits added or taken away, so no reserved bit is set and no exception unmasked.
    // Code between two calls is compiled for the default mode; all its operands come from files
    // and generators at run time, so nothing that was computed in advance depends on the mode.
    unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const value, options(nostack)) };
}

/// Runs `f` with subnormals flushed or kept, and puts the mode back.
///
/// # Panics
/// When the mode does not take.
pub fn with_mode<T>(flush: bool, f: impl FnOnce() -> T) -> T {
    struct Restore(u32);
    impl Drop for Restore {
        fn drop(&mut self) {
            set_control(self.0);
        }
    }
    let restore = Restore(control());
    set_control(if flush {
        restore.0 | FLUSH
    } else {
        restore.0 & !FLUSH
    });
    let tiny = std::hint::black_box(f32::MIN_POSITIVE) * std::hint::black_box(0.5);
    assert_eq!(tiny == 0.0, flush, "the mode is set");
    f()
}
