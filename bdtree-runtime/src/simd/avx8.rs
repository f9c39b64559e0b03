//! Eight f32 with AVX2: a row is one register.
#![allow(unsafe_code)] // intrinsics; every block has its proof

use bdtree_format::{PairRow, Row};
use core::arch::x86_64::{
    __m256, __m256i, _CMP_GT_OQ, _mm256_abs_epi16, _mm256_add_epi32, _mm256_add_ps, _mm256_cmp_ps,
    _mm256_cvtepi32_ps, _mm256_loadu_ps, _mm256_loadu_si256, _mm256_loadu2_m128, _mm256_madd_epi16,
    _mm256_max_epi16, _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
    _mm256_set1_epi32, _mm256_set1_ps, _mm256_setzero_si256, _mm256_shuffle_ps, _mm256_sqrt_ps,
    _mm256_storeu_ps, _mm256_sub_epi16, _mm256_sub_ps, _mm256_unpackhi_ps, _mm256_unpacklo_ps,
};

use super::avx_order::AvxOrder;
use super::avx4::{Avx4, instructions};
use super::{Fields, Kernel, Lanes, PairSums, Work};

/// Eight f32 in a register. Only [`run_avx2`] uses it: so wherever one exists, the processor has AVX2 and FMA.
#[derive(Clone, Copy)]
struct Avx8(__m256);

/// Two rows of four side by side.
#[inline(always)]
fn two(low: &[f32; 4], high: &[f32; 4]) -> __m256 {
    // SAFETY: needs AVX, see `Avx8`; both rows are four readable f32, any alignment will do.
    unsafe { _mm256_loadu2_m128(high.as_ptr(), low.as_ptr()) }
}

impl Lanes for Avx8 {
    type Quad = Avx4;
    type Sums = Whole8;
    type Order = AvxOrder;

    #[inline(always)]
    fn apart<W: Work>(work: W) -> W::Output {
        run(work)
    }

    instructions! {
        add(other) = _mm256_add_ps;
        sub(other) = _mm256_sub_ps;
        mul(other) = _mm256_mul_ps;
        min(other) = _mm256_min_ps;
        max(other) = _mm256_max_ps;
        sqrt() = _mm256_sqrt_ps;
    }

    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: needs AVX; see `Avx8`.
        Self(unsafe { _mm256_set1_ps(x) })
    }

    #[inline(always)]
    fn load(row: &Row) -> Self {
        // SAFETY: needs AVX, see `Avx8`; a `Row` is eight readable f32, any alignment will do.
        Self(unsafe { _mm256_loadu_ps(row.as_ptr()) })
    }

    #[inline(always)]
    fn columns([a, b, c, d, e, f, g, h]: [&[f32; 4]; 8]) -> [Self; 4] {
        let (ae, bf, cg, dh) = (two(a, e), two(b, f), two(c, g), two(d, h));
        // SAFETY: needs AVX; see `Avx8`.
        let low_ab = unsafe { _mm256_unpacklo_ps(ae, bf) };
        // SAFETY: as above.
        let low_cd = unsafe { _mm256_unpacklo_ps(cg, dh) };
        // SAFETY: as above.
        let high_ab = unsafe { _mm256_unpackhi_ps(ae, bf) };
        // SAFETY: as above.
        let high_cd = unsafe { _mm256_unpackhi_ps(cg, dh) };
        // SAFETY: as above.
        let first = unsafe { _mm256_shuffle_ps::<0x44>(low_ab, low_cd) };
        // SAFETY: as above.
        let second = unsafe { _mm256_shuffle_ps::<0xee>(low_ab, low_cd) };
        // SAFETY: as above.
        let third = unsafe { _mm256_shuffle_ps::<0x44>(high_ab, high_cd) };
        // SAFETY: as above.
        let fourth = unsafe { _mm256_shuffle_ps::<0xee>(high_ab, high_cd) };
        [Self(first), Self(second), Self(third), Self(fourth)]
    }

    #[inline(always)]
    fn round(sums: Whole8) -> Self {
        // SAFETY: needs AVX; see `Avx8`.
        Self(unsafe { _mm256_cvtepi32_ps(sums.0) })
    }

    #[inline(always)]
    fn store(self) -> Row {
        let mut row = [0.0; 8];
        // SAFETY: needs AVX, see `Avx8`; `row` is eight writable f32, any alignment will do.
        unsafe { _mm256_storeu_ps(row.as_mut_ptr(), self.0) };
        row
    }

    #[inline(always)]
    fn above(self, other: Self) -> u8 {
        // SAFETY: needs AVX; see `Avx8`.
        let above = unsafe { _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0) };
        // SAFETY: needs AVX; see `Avx8`.
        let mask = unsafe { _mm256_movemask_ps(above) };
        // One bit per lane.
        mask as u8
    }

    #[inline(always)]
    fn moved(fields: &Fields<'_>) -> [[[f32; 4]; 3]; 3] {
        fields.moved_with_sse()
    }
}

/// Eight sums in a register. As [`Avx8`].
#[derive(Clone, Copy)]
struct Whole8(__m256i);

impl PairSums for Whole8 {
    type Factor = __m256i;

    #[inline(always)]
    fn zero() -> Self {
        // SAFETY: needs AVX; see `Avx8`.
        Self(unsafe { _mm256_setzero_si256() })
    }

    #[inline(always)]
    fn factors([a, b]: [i16; 2]) -> [__m256i; 4] {
        let both = u32::from(a as u16) | (u32::from(b as u16) << 16);
        // SAFETY: needs AVX; see `Avx8`.
        let n = unsafe { _mm256_set1_epi32(both as i32) };
        // SAFETY: needs AVX2; see `Avx8`.
        let magnitude = unsafe { _mm256_abs_epi16(n) };
        // SAFETY: as above.
        let positive = unsafe { _mm256_max_epi16(n, Self::zero().0) };
        // max(−n, 0) = max(n, 0) − n.
        // SAFETY: as above.
        let negative = unsafe { _mm256_sub_epi16(positive, n) };
        [n, magnitude, positive, negative]
    }

    #[inline(always)]
    fn add_products(self, row: &PairRow, n: __m256i) -> Self {
        // SAFETY: needs AVX, see `Avx8`; `row` is 32 readable bytes, any alignment will do.
        let row = unsafe { _mm256_loadu_si256(row.as_ptr().cast()) };
        // SAFETY: needs AVX2; see `Avx8`.
        self.add(Self(unsafe { _mm256_madd_epi16(row, n) }))
    }

    instructions! {
        add(other) = _mm256_add_epi32;
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn run_avx2<W: Work>(work: W) -> W::Output {
    work.run::<Avx8>()
}

/// [`Work::run`] with AVX2.
#[inline]
pub(super) fn run<W: Work>(work: W) -> W::Output {
    debug_assert!(Kernel::Avx2.is_available());
    // SAFETY: `Kernel::Avx2` reaches an asset only through `Kernel::best` and `Asset::with_kernel`, which ask
    // `Kernel::is_available` first.
    unsafe { run_avx2(work) }
}
