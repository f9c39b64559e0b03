//! What every x86-64 has, SSE2. [`Fields::moved`]: each vertex in a register of its own, of which the last number
//! is not used, so that records of three numbers are read as they lie. [`Four`]: arrays are taken apart and put together
//! again around each operation where a loop keeps several. [`Sums`]: what the compiler makes of the portable
//! ones has three times as many instructions.
#![allow(unsafe_code)] // intrinsics; every block has its proof

use bdtree_format::{LANES, PairRow};
use core::arch::x86_64::{
    __m128, __m128i, _mm_add_epi32, _mm_add_ps, _mm_loadu_ps, _mm_loadu_si128, _mm_madd_epi16,
    _mm_max_epi16, _mm_max_ps, _mm_min_ps, _mm_movehl_ps, _mm_movelh_ps, _mm_mul_ps,
    _mm_set1_epi32, _mm_set1_ps, _mm_setzero_si128, _mm_storeu_ps, _mm_storeu_si128, _mm_sub_epi16,
    _mm_unpackhi_ps, _mm_unpacklo_ps,
};

use super::{Fields, PairSums};

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
        let mut sums = [Four::splat(-0.0); 4];
        for (j, q) in self.q.iter().enumerate() {
            let q = Four::splat(*q);
            for k in 0..4 {
                // SAFETY: the record of mode j of a vertex and the next one lie in the slice: the vertex is
                // not the last one, and the slice holds m records for each.
                let u =
                    unsafe { Four::of_record(self.displacements, vertices[k] as usize * m + j) };
                sums[k] = sums[k].add(u.mul(q));
            }
        }
        for k in 0..4 {
            // SAFETY: the vertex and the next one lie in the slice.
            let rest = unsafe { Four::of_record(self.positions, vertices[k] as usize) };
            sums[k] = rest.add(sums[k]);
        }
        let [x, y, z, _] = Four::transposed(sums);
        [x.store(), y.store(), z.store()]
    }
}

/// Four f32 in a register.
#[derive(Clone, Copy)]
pub(crate) struct Four(pub(super) __m128);

impl Four {
    #[inline(always)]
    pub(crate) fn splat(x: f32) -> Self {
        // SAFETY: SSE is part of x86-64, here and below.
        Self(unsafe { _mm_set1_ps(x) })
    }

    #[inline(always)]
    pub(crate) fn load(x: &[f32; 4]) -> Self {
        // SAFETY: see above; `x` is four readable f32, any alignment will do.
        Self(unsafe { _mm_loadu_ps(x.as_ptr()) })
    }

    /// Record `i`, and the first number of the next.
    ///
    /// # Safety
    /// Both lie in `records`.
    #[inline(always)]
    unsafe fn of_record(records: &[[f32; 3]], i: usize) -> Self {
        // SAFETY: inside the slice, says the caller.
        let record = unsafe { records.as_ptr().add(i) };
        // SAFETY: see above; four f32 can be read there, says the caller.
        Self(unsafe { _mm_loadu_ps(record.cast()) })
    }

    #[inline(always)]
    pub(crate) fn store(self) -> [f32; 4] {
        let mut out = [0.0; 4];
        // SAFETY: see above; `out` is four writable f32.
        unsafe { _mm_storeu_ps(out.as_mut_ptr(), self.0) };
        out
    }

    #[inline(always)]
    pub(crate) fn add(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm_add_ps(self.0, other.0) })
    }

    #[inline(always)]
    pub(crate) fn mul(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm_mul_ps(self.0, other.0) })
    }

    /// The smaller of the two, `other` where one is NaN.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm_min_ps(self.0, other.0) })
    }

    /// The larger of the two, `other` where one is NaN.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm_max_ps(self.0, other.0) })
    }

    /// Columns as rows.
    #[inline(always)]
    pub(crate) fn transposed([a, b, c, d]: [Self; 4]) -> [Self; 4] {
        // SAFETY: see above.
        let low_ab = unsafe { _mm_unpacklo_ps(a.0, b.0) };
        // SAFETY: see above.
        let low_cd = unsafe { _mm_unpacklo_ps(c.0, d.0) };
        // SAFETY: see above.
        let high_ab = unsafe { _mm_unpackhi_ps(a.0, b.0) };
        // SAFETY: see above.
        let high_cd = unsafe { _mm_unpackhi_ps(c.0, d.0) };
        // SAFETY: see above.
        let first = unsafe { _mm_movelh_ps(low_ab, low_cd) };
        // SAFETY: see above.
        let second = unsafe { _mm_movehl_ps(low_cd, low_ab) };
        // SAFETY: see above.
        let third = unsafe { _mm_movelh_ps(high_ab, high_cd) };
        // SAFETY: see above.
        let fourth = unsafe { _mm_movehl_ps(high_cd, high_ab) };
        [Self(first), Self(second), Self(third), Self(fourth)]
    }
}

/// Eight sums in two registers.
#[derive(Clone, Copy)]
pub(crate) struct Sums([__m128i; 2]);

impl Sums {
    #[inline(always)]
    pub(super) fn store(self) -> [i32; LANES] {
        let mut out = [0; LANES];
        let start: *mut __m128i = out.as_mut_ptr().cast();
        // SAFETY: SSE2 is part of x86-64; `out` is 32 writable bytes, these are the first 16.
        unsafe { _mm_storeu_si128(start, self.0[0]) };
        // SAFETY: the other 16 of the same 32.
        unsafe { _mm_storeu_si128(start.wrapping_add(1), self.0[1]) };
        out
    }
}

impl PairSums for Sums {
    type Factor = __m128i;

    #[inline(always)]
    fn zero() -> Self {
        // SAFETY: SSE2 is part of x86-64, here and below.
        Self([unsafe { _mm_setzero_si128() }; 2])
    }

    #[inline(always)]
    fn factors([a, b]: [i16; 2]) -> [__m128i; 4] {
        let both = u32::from(a as u16) | (u32::from(b as u16) << 16);
        // SAFETY: see above.
        let n = unsafe { _mm_set1_epi32(both as i32) };
        // SAFETY: see above.
        let minus = unsafe { _mm_sub_epi16(Self::zero().0[0], n) };
        // SAFETY: see above.
        let magnitude = unsafe { _mm_max_epi16(n, minus) };
        // SAFETY: see above.
        let positive = unsafe { _mm_max_epi16(n, Self::zero().0[0]) };
        // max(−n, 0) = max(n, 0) − n.
        // SAFETY: see above.
        let negative = unsafe { _mm_sub_epi16(positive, n) };
        [n, magnitude, positive, negative]
    }

    #[inline(always)]
    fn add_products(self, row: &PairRow, n: __m128i) -> Self {
        let start: *const __m128i = row.as_ptr().cast();
        // SAFETY: SSE2 is part of x86-64; `row` is 32 readable bytes, these are the first 16.
        let low = unsafe { _mm_loadu_si128(start) };
        // SAFETY: the other 16 of the same 32.
        let high = unsafe { _mm_loadu_si128(start.wrapping_add(1)) };
        // SAFETY: see above.
        let low = unsafe { _mm_madd_epi16(low, n) };
        // SAFETY: see above.
        let high = unsafe { _mm_madd_epi16(high, n) };
        self.add(Self([low, high]))
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let ([a, b], [c, d]) = (self.0, other.0);
        // SAFETY: see above.
        let low = unsafe { _mm_add_epi32(a, c) };
        // SAFETY: see above.
        Self([low, unsafe { _mm_add_epi32(b, d) }])
    }
}
