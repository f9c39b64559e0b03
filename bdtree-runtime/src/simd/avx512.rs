//! AVX-512 with VNNI, in registers of 256 bits: beside AVX2, one instruction multiplies pairs and adds
//! them to a sum.
#![allow(unsafe_code)] // intrinsics; every block has its proof

use bdtree_format::PairRow;
use core::arch::x86_64::{__m256i, _mm256_add_epi32, _mm256_dpwssd_epi32};

use super::avx2::{Avx8, AvxFactor, AvxSums, load, zero};
use super::{Kernel, PairSums, Work};

/// `vpdpwssd`. Private to this module, which only uses it inside [`run_avx512`]:
/// so wherever one exists, the processor has AVX2, FMA and AVX-512 with VL and VNNI.
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
        // SAFETY: needs AVX-512 VNNI and VL; see `Whole8`.
        Self(unsafe { _mm256_dpwssd_epi32(self.0, load(row), n.0) })
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: needs AVX2; see `Whole8`.
        Self(unsafe { _mm256_add_epi32(self.0, other.0) })
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512vnni")]
#[inline(never)]
fn run_avx512<W: Work>(work: W) -> W::Output {
    work.run::<Avx8<Whole8>>()
}

/// [`Work::run`] with AVX-512.
#[inline]
pub(super) fn run<W: Work>(work: W) -> W::Output {
    debug_assert!(Kernel::Avx512.is_available());
    // SAFETY: as in [`super::avx2::run`].
    unsafe { run_avx512(work) }
}
