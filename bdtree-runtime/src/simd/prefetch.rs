//! Asking for memory before it is needed.

/// Asks the processor to bring the cache line where `target` begins; elsewhere than on x86-64
/// nothing. Only time depends on it.
#[inline(always)]
#[allow(unsafe_code)] // one block, proof below
pub(crate) fn prefetch<T>(target: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: SSE is part of x86-64; a prefetch changes nothing that a program sees and
        // cannot fault, and the address is that of a live reference anyway.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(core::ptr::from_ref(target).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = target;
}
