//! AVX2 and FMA: a row is one register.
#![allow(unsafe_code)] // intrinsics; every block has its proof

use bdtree_format::{PairRow, Row};
use core::arch::x86_64::{
    __m256, __m256i, _CMP_GT_OQ, _mm256_abs_epi16, _mm256_add_epi32, _mm256_add_ps, _mm256_cmp_ps,
    _mm256_cvtepi32_ps, _mm256_loadu_ps, _mm256_loadu_si256, _mm256_madd_epi16, _mm256_max_epi16,
    _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_set1_epi32,
    _mm256_set1_ps, _mm256_setzero_si256, _mm256_sqrt_ps, _mm256_storeu_ps, _mm256_sub_epi16,
    _mm256_sub_ps,
};
use core::marker::PhantomData;

use super::avx4::Avx4;
use super::{Fields, Kernel, Lanes, PairSums, Work};

/// Eight f32 in a register, beside which whole numbers are summed by `S`. Only functions that
/// enable AVX2 and FMA use it, here and in [`super::avx512`]: so wherever one exists, the processor
/// has both.
#[derive(Clone, Copy)]
pub(super) struct Avx8<S>(__m256, PhantomData<S>);

impl<S> Avx8<S> {
    #[inline(always)]
    fn new(v: __m256) -> Self {
        Self(v, PhantomData)
    }
}

impl<S: AvxSums> Lanes for Avx8<S> {
    type Quad = Avx4;
    type Sums = S;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: needs AVX; see `Avx8`.
        Self::new(unsafe { _mm256_set1_ps(x) })
    }

    #[inline(always)]
    fn load(row: &Row) -> Self {
        // SAFETY: needs AVX, see `Avx8`; a `Row` is eight readable f32, any alignment will do.
        Self::new(unsafe { _mm256_loadu_ps(row.as_ptr()) })
    }

    #[inline(always)]
    fn round(sums: S) -> Self {
        // SAFETY: needs AVX; see `Avx8`.
        Self::new(unsafe { _mm256_cvtepi32_ps(sums.register()) })
    }

    #[inline(always)]
    fn store(self) -> Row {
        let mut row = [0.0; 8];
        // SAFETY: needs AVX, see `Avx8`; `row` is eight writable f32, any alignment will do.
        unsafe { _mm256_storeu_ps(row.as_mut_ptr(), self.0) };
        row
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: needs AVX; see `Avx8`.
        Self::new(unsafe { _mm256_add_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // SAFETY: needs AVX; see `Avx8`.
        Self::new(unsafe { _mm256_mul_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        // SAFETY: needs AVX; see `Avx8`.
        Self::new(unsafe { _mm256_sub_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: needs AVX; see `Avx8`.
        Self::new(unsafe { _mm256_min_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: needs AVX; see `Avx8`.
        Self::new(unsafe { _mm256_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: needs AVX; see `Avx8`.
        Self::new(unsafe { _mm256_max_ps(self.0, other.0) })
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

/// Sums that lie in one register.
pub(super) trait AvxSums: PairSums {
    fn register(self) -> __m256i;
}

/// `vpmaddwd`. As [`Avx8`], only where AVX2 is enabled.
#[derive(Clone, Copy)]
struct Whole8(__m256i);

impl AvxSums for Whole8 {
    #[inline(always)]
    fn register(self) -> __m256i {
        self.0
    }
}

impl PairSums for Whole8 {
    type Factor = AvxFactor;

    #[inline(always)]
    fn zero() -> Self {
        Self(zero())
    }

    #[inline(always)]
    fn factor(n: [i16; 2]) -> AvxFactor {
        AvxFactor::splat(n)
    }

    #[inline(always)]
    fn magnitude(n: AvxFactor) -> AvxFactor {
        n.magnitude()
    }

    #[inline(always)]
    fn positive(n: AvxFactor) -> AvxFactor {
        n.positive()
    }

    #[inline(always)]
    fn positive_of_opposite(n: AvxFactor) -> AvxFactor {
        n.positive_of_opposite()
    }

    #[inline(always)]
    fn add_products(self, row: &PairRow, n: AvxFactor) -> Self {
        // SAFETY: needs AVX2; see `Whole8`.
        let products = unsafe { _mm256_madd_epi16(load(row), n.0) };
        self.add(Self(products))
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: needs AVX2; see `Whole8`.
        Self(unsafe { _mm256_add_epi32(self.0, other.0) })
    }
}

/// Two numbers, eight times. As [`Avx8`], only where AVX2 is enabled.
#[derive(Clone, Copy)]
pub(super) struct AvxFactor(pub(super) __m256i);

impl AvxFactor {
    #[inline(always)]
    pub(super) fn splat([a, b]: [i16; 2]) -> Self {
        let both = u32::from(a as u16) | (u32::from(b as u16) << 16);
        // SAFETY: needs AVX; see `AvxFactor`.
        Self(unsafe { _mm256_set1_epi32(both as i32) })
    }

    #[inline(always)]
    pub(super) fn magnitude(self) -> Self {
        // SAFETY: needs AVX2; see `AvxFactor`.
        Self(unsafe { _mm256_abs_epi16(self.0) })
    }

    #[inline(always)]
    pub(super) fn positive(self) -> Self {
        // SAFETY: needs AVX2; see `AvxFactor`.
        Self(unsafe { _mm256_max_epi16(self.0, zero()) })
    }

    #[inline(always)]
    pub(super) fn positive_of_opposite(self) -> Self {
        // max(−n, 0) = max(n, 0) − n.
        // SAFETY: needs AVX2; see `AvxFactor`.
        Self(unsafe { _mm256_sub_epi16(self.positive().0, self.0) })
    }
}

#[inline(always)]
pub(super) fn zero() -> __m256i {
    // SAFETY: needs AVX; only types that exist where it is enabled use this.
    unsafe { _mm256_setzero_si256() }
}

#[inline(always)]
pub(super) fn load(row: &PairRow) -> __m256i {
    // SAFETY: needs AVX, as for `zero`; `row` is 32 readable bytes, any alignment will do.
    unsafe { _mm256_loadu_si256(row.as_ptr().cast()) }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn run_avx2<W: Work>(work: W) -> W::Output {
    work.run::<Avx8<Whole8>>()
}

/// [`Work::run`] with AVX2.
#[inline]
pub(super) fn run<W: Work>(work: W) -> W::Output {
    debug_assert!(Kernel::Avx2.is_available());
    // SAFETY: `Kernel::Avx2` reaches an asset only through `Kernel::best` and
    // `Asset::with_kernel`, which ask `Kernel::is_available` first.
    unsafe { run_avx2(work) }
}
