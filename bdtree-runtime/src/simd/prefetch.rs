//! Asking for memory before it is needed.

/// Bytes of a cache line.
pub(crate) const LINE: usize = 64;

/// Asks the processor to bring the cache line where `target` begins; elsewhere than on x86-64
/// nothing. Only time depends on it.
#[inline(always)]
pub(crate) fn prefetch<T>(target: &T) {
    prefetch_at(core::ptr::from_ref(target).cast());
}

/// [`prefetch()`] for every 64 bytes of `len` values from `first` on, which need not be there.
#[inline(always)]
pub(crate) fn prefetch_from<T>(values: &[T], first: usize, len: usize) {
    if !cfg!(target_arch = "x86_64") {
        return; // else a loop may be left that does nothing
    }
    let start: *const u8 = values.as_ptr().wrapping_add(first).cast();
    let mut at = 0;
    while at < len * size_of::<T>() {
        prefetch_at(start.wrapping_add(at));
        at += LINE;
    }
}

/// [`prefetch()`] for so many lines from an address on, which need not be anyone's.
#[inline(always)]
pub(crate) fn prefetch_lines<const LINES: usize, T>(address: *const T) {
    for line in 0..LINES {
        prefetch_at(address.cast::<u8>().wrapping_add(LINE * line));
    }
}

#[inline(always)]
#[allow(unsafe_code)] // one block, proof below
fn prefetch_at(address: *const u8) {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: SSE is part of x86-64; a prefetch changes nothing that a program sees and
        // cannot fault, whatever the address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(address.cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = address;
}
