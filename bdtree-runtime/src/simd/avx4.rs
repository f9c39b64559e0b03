//! Four f64 with AVX.
#![allow(unsafe_code)] // intrinsics; every block has its proof

use core::arch::x86_64::{
    __m256d, _CMP_GE_OQ, _CMP_GT_OQ, _mm_loadu_ps, _mm_storeu_ps, _mm256_add_pd, _mm256_and_pd,
    _mm256_andnot_pd, _mm256_blend_pd, _mm256_blendv_pd, _mm256_cmp_pd, _mm256_cvtpd_ps,
    _mm256_cvtps_pd, _mm256_div_pd, _mm256_loadu_pd, _mm256_max_pd, _mm256_min_pd,
    _mm256_movemask_pd, _mm256_mul_pd, _mm256_or_pd, _mm256_permute2f128_pd, _mm256_set1_pd,
    _mm256_sqrt_pd, _mm256_storeu_pd, _mm256_sub_pd, _mm256_unpackhi_pd, _mm256_unpacklo_pd,
};

use super::Quad;

/// Methods that are one instruction on the register of each operand. For types that say where they exist.
macro_rules! instructions {
    ($($name:ident($($other:ident)?) = $intrinsic:ident;)+) => {
        $(#[inline(always)]
        fn $name(self $(, $other: Self)?) -> Self {
            // SAFETY: needs AVX or AVX2; the type exists only where the processor has both.
            Self(unsafe { $intrinsic(self.0 $(, $other.0)?) })
        })+
    };
}
pub(super) use instructions;

/// Four f64 in a register, used only inside `run_avx2` of the module beside: so wherever
/// one exists, the processor has AVX2.
#[derive(Clone, Copy)]
pub(super) struct Avx4(__m256d);

impl Quad for Avx4 {
    type Mask = __m256d;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        // SAFETY: needs AVX; see `Avx4`.
        Self(unsafe { _mm256_set1_pd(x) })
    }

    #[inline(always)]
    fn load(x: &[f64; 4]) -> Self {
        // SAFETY: needs AVX, see `Avx4`; `x` is four readable f64, any alignment will do.
        Self(unsafe { _mm256_loadu_pd(x.as_ptr()) })
    }

    #[inline(always)]
    fn widen(x: &[f32; 4]) -> Self {
        // SAFETY: SSE is part of x86-64; `x` is four readable f32, any alignment will do.
        let x = unsafe { _mm_loadu_ps(x.as_ptr()) };
        // SAFETY: needs AVX; see `Avx4`.
        Self(unsafe { _mm256_cvtps_pd(x) })
    }

    #[inline(always)]
    fn store(self) -> [f64; 4] {
        let mut out = [0.0; 4];
        // SAFETY: needs AVX, see `Avx4`; `out` is four writable f64, any alignment will do.
        unsafe { _mm256_storeu_pd(out.as_mut_ptr(), self.0) };
        out
    }

    #[inline(always)]
    fn with_last(self, x: f64) -> Self {
        // SAFETY: needs AVX; see `Avx4`.
        let x = unsafe { _mm256_set1_pd(x) };
        // SAFETY: as above.
        Self(unsafe { _mm256_blend_pd::<0b1000>(self.0, x) })
    }

    #[inline(always)]
    fn narrow(self) -> [f32; 4] {
        // SAFETY: needs AVX; see `Avx4`.
        let x = unsafe { _mm256_cvtpd_ps(self.0) };
        let mut out = [0.0; 4];
        // SAFETY: SSE is part of x86-64; `out` is four writable f32, any alignment will do.
        unsafe { _mm_storeu_ps(out.as_mut_ptr(), x) };
        out
    }

    #[inline(always)]
    fn cleared(self, mask: __m256d) -> Self {
        // SAFETY: needs AVX; see `Avx4`.
        Self(unsafe { _mm256_andnot_pd(mask, self.0) })
    }

    instructions! {
        add(other) = _mm256_add_pd;
        sub(other) = _mm256_sub_pd;
        mul(other) = _mm256_mul_pd;
        div(other) = _mm256_div_pd;
        sqrt() = _mm256_sqrt_pd;
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: needs AVX; see `Avx4`.
        let sign = unsafe { _mm256_set1_pd(-0.0) };
        // SAFETY: needs AVX; see `Avx4`.
        Self(unsafe { _mm256_andnot_pd(sign, self.0) })
    }

    #[inline(always)]
    fn above(self, other: Self) -> __m256d {
        // SAFETY: needs AVX; see `Avx4`.
        unsafe { _mm256_cmp_pd::<_CMP_GT_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn at_least(self, other: Self) -> __m256d {
        // SAFETY: needs AVX; see `Avx4`.
        unsafe { _mm256_cmp_pd::<_CMP_GE_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn both(a: __m256d, b: __m256d) -> __m256d {
        // SAFETY: needs AVX; see `Avx4`.
        unsafe { _mm256_and_pd(a, b) }
    }

    #[inline(always)]
    fn either(a: __m256d, b: __m256d) -> __m256d {
        // SAFETY: needs AVX; see `Avx4`.
        unsafe { _mm256_or_pd(a, b) }
    }

    #[inline(always)]
    fn select(mask: __m256d, yes: Self, no: Self) -> Self {
        // SAFETY: needs AVX; see `Avx4`.
        Self(unsafe { _mm256_blendv_pd(no.0, yes.0, mask) })
    }

    // Of equal numbers, and where one is NaN, the instructions give the second operand.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: needs AVX; see `Avx4`.
        Self(unsafe { _mm256_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: needs AVX; see `Avx4`.
        Self(unsafe { _mm256_min_pd(other.0, self.0) })
    }

    #[inline(always)]
    fn transposed([a, b, c, d]: [Self; 4]) -> [Self; 4] {
        // SAFETY: needs AVX; see `Avx4`.
        let even_ab = unsafe { _mm256_unpacklo_pd(a.0, b.0) };
        // SAFETY: as above.
        let odd_ab = unsafe { _mm256_unpackhi_pd(a.0, b.0) };
        // SAFETY: as above.
        let even_cd = unsafe { _mm256_unpacklo_pd(c.0, d.0) };
        // SAFETY: as above.
        let odd_cd = unsafe { _mm256_unpackhi_pd(c.0, d.0) };
        // SAFETY: as above.
        let first = unsafe { _mm256_permute2f128_pd::<0x20>(even_ab, even_cd) };
        // SAFETY: as above.
        let second = unsafe { _mm256_permute2f128_pd::<0x20>(odd_ab, odd_cd) };
        // SAFETY: as above.
        let third = unsafe { _mm256_permute2f128_pd::<0x31>(even_ab, even_cd) };
        // SAFETY: as above.
        let fourth = unsafe { _mm256_permute2f128_pd::<0x31>(odd_ab, odd_cd) };
        [Self(first), Self(second), Self(third), Self(fourth)]
    }

    #[inline(always)]
    fn bits(mask: __m256d) -> u8 {
        // SAFETY: needs AVX; see `Avx4`.
        let bits = unsafe { _mm256_movemask_pd(mask) };
        // One bit for each of the four.
        bits as u8
    }
}
