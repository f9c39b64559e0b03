//! [`Fields::moved`] with SSE, which every x86-64 has: each vertex in a register of its own, of which the last number
//! is not used, so that records of three numbers are read as they lie.
#![allow(unsafe_code)] // intrinsics; every block has its proof

use core::arch::x86_64::{
    __m128, _mm_add_ps, _mm_loadu_ps, _mm_movehl_ps, _mm_movelh_ps, _mm_mul_ps, _mm_set1_ps,
    _mm_storeu_ps, _mm_unpackhi_ps, _mm_unpacklo_ps,
};

use super::Fields;

impl Fields<'_> {
    /// [`Fields::moved`] with SSE, which every x86-64 has.
    #[inline(always)]
    pub(super) fn moved_with_sse(&self) -> [[[f32; 4]; 3]; 3] {
        let [a, b, c] = *self.vertices;
        // Spelled out: behind a closure it would not be compiled with the instruction set of the caller.
        [self.four(a), self.four(b), self.four(c)]
    }

    #[inline(always)]
    fn four(&self, vertices: [u32; 4]) -> [[f32; 4]; 3] {
        let m = self.q.len();
        let mut sums = [splat(-0.0); 4];
        for (j, q) in self.q.iter().enumerate() {
            let q = splat(*q);
            for k in 0..4 {
                // SAFETY: the record of mode j of a vertex and the next one lie in the slice: the vertex is
                // not the last one, and the slice holds m records for each.
                let u = unsafe { load(self.displacements, vertices[k] as usize * m + j) };
                sums[k] = add(sums[k], mul(u, q));
            }
        }
        for k in 0..4 {
            // SAFETY: the vertex and the next one lie in the slice.
            let rest = unsafe { load(self.positions, vertices[k] as usize) };
            sums[k] = add(rest, sums[k]);
        }
        coordinates(sums)
    }
}

/// Record `i`, and the first number of the next.
///
/// # Safety
/// Both lie in `records`.
#[inline(always)]
unsafe fn load(records: &[[f32; 3]], i: usize) -> __m128 {
    // SAFETY: inside the slice, says the caller.
    let record = unsafe { records.as_ptr().add(i) };
    // SAFETY: SSE is part of x86-64; four f32 can be read there, says the caller.
    unsafe { _mm_loadu_ps(record.cast()) }
}

/// The first three numbers of each of four registers, side by side.
#[inline(always)]
fn coordinates([a, b, c, d]: [__m128; 4]) -> [[f32; 4]; 3] {
    // SAFETY: SSE is part of x86-64, here and below.
    let low_ab = unsafe { _mm_unpacklo_ps(a, b) };
    // SAFETY: see above.
    let low_cd = unsafe { _mm_unpacklo_ps(c, d) };
    // SAFETY: see above.
    let high_ab = unsafe { _mm_unpackhi_ps(a, b) };
    // SAFETY: see above.
    let high_cd = unsafe { _mm_unpackhi_ps(c, d) };
    // SAFETY: see above.
    let x = unsafe { _mm_movelh_ps(low_ab, low_cd) };
    // SAFETY: see above.
    let y = unsafe { _mm_movehl_ps(low_cd, low_ab) };
    // SAFETY: see above.
    let z = unsafe { _mm_movelh_ps(high_ab, high_cd) };
    [store(x), store(y), store(z)]
}

#[inline(always)]
fn splat(x: f32) -> __m128 {
    // SAFETY: SSE is part of x86-64.
    unsafe { _mm_set1_ps(x) }
}

#[inline(always)]
fn add(a: __m128, b: __m128) -> __m128 {
    // SAFETY: SSE is part of x86-64.
    unsafe { _mm_add_ps(a, b) }
}

#[inline(always)]
fn mul(a: __m128, b: __m128) -> __m128 {
    // SAFETY: SSE is part of x86-64.
    unsafe { _mm_mul_ps(a, b) }
}

#[inline(always)]
fn store(x: __m128) -> [f32; 4] {
    let mut out = [0.0; 4];
    // SAFETY: SSE is part of x86-64; `out` is four writable f32.
    unsafe { _mm_storeu_ps(out.as_mut_ptr(), x) };
    out
}
