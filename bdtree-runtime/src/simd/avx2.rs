//! AVX2 and FMA: a row is one register.
#![allow(unsafe_code)] // intrinsics; every block has its proof

use bdtree_format::{LANES, Row};
use core::arch::x86_64::{
    __m256, _CMP_GT_OQ, _mm_loadu_si128, _mm256_add_ps, _mm256_cmp_ps, _mm256_cvtepi16_epi32,
    _mm256_cvtepi32_ps, _mm256_cvtepu16_epi32, _mm256_fmadd_ps, _mm256_loadu_ps,
    _mm256_movemask_ps, _mm256_mul_ps, _mm256_set1_ps, _mm256_sqrt_ps, _mm256_storeu_ps,
    _mm256_sub_ps,
};

use super::avx4::Avx4;
use super::{Kernel, Lanes};
use crate::bound::{BoundPose, Spheres, evaluate};
use crate::error::QueryError;
use crate::pose::Pose;
use crate::traverse::{StackEntry, Visitor, Walk, walk};
use crate::view::{Asset, NodeRows};

/// Eight f32 in a register. Private to this module, which only uses it inside
/// [`evaluate_avx2`] and [`walk_avx2`]: so wherever one exists, the processor has AVX2 and FMA.
#[derive(Clone, Copy)]
struct Avx8(__m256);

impl Lanes for Avx8 {
    type Quad = Avx4;

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
    fn widen(row: &[i16; LANES]) -> Self {
        // SAFETY: SSE2 is part of x86-64; `row` is eight readable i16, any alignment will do.
        let row = unsafe { _mm_loadu_si128(row.as_ptr().cast()) };
        // SAFETY: needs AVX2; see `Avx8`.
        let wide = unsafe { _mm256_cvtepi16_epi32(row) };
        // SAFETY: needs AVX; see `Avx8`.
        Self(unsafe { _mm256_cvtepi32_ps(wide) })
    }

    #[inline(always)]
    fn widen_unsigned(row: &[u16; LANES]) -> Self {
        // SAFETY: SSE2 is part of x86-64; `row` is eight readable u16, any alignment will do.
        let row = unsafe { _mm_loadu_si128(row.as_ptr().cast()) };
        // SAFETY: needs AVX2; see `Avx8`.
        let wide = unsafe { _mm256_cvtepu16_epi32(row) };
        // SAFETY: needs AVX; see `Avx8`.
        Self(unsafe { _mm256_cvtepi32_ps(wide) })
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
        Self(unsafe { _mm256_add_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // SAFETY: needs AVX; see `Avx8`.
        Self(unsafe { _mm256_mul_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        // SAFETY: needs FMA; see `Avx8`.
        Self(unsafe { _mm256_fmadd_ps(self.0, factor.0, term.0) })
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        // SAFETY: needs AVX; see `Avx8`.
        Self(unsafe { _mm256_sub_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: needs AVX; see `Avx8`.
        Self(unsafe { _mm256_sqrt_ps(self.0) })
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
}

#[target_feature(enable = "avx2,fma")]
fn evaluate_avx2(rows: &NodeRows<'_>, modes: &[u16], pose: &BoundPose<'_>) -> Option<Spheres> {
    Some(evaluate::<Avx8>(rows, modes, pose)?.store())
}

/// [`evaluate`] with AVX2.
#[inline]
pub(super) fn evaluate_checked(
    rows: &NodeRows<'_>,
    modes: &[u16],
    pose: &BoundPose<'_>,
) -> Option<Spheres> {
    debug_assert!(Kernel::Avx2.is_available());
    // SAFETY: `Kernel::Avx2` reaches an asset only through `Kernel::best` and
    // `Asset::with_kernel`, which ask `Kernel::is_available` first.
    unsafe { evaluate_avx2(rows, modes, pose) }
}

#[target_feature(enable = "avx2,fma")]
fn walk_avx2<V: Visitor, const LISTED: bool>(
    asset: &Asset<'_>,
    pose: &Pose<'_>,
    stack: &mut [StackEntry],
    visitor: &mut V,
) -> Result<Walk, QueryError> {
    walk::<Avx8, V, LISTED>(asset, pose, stack, visitor)
}

/// [`walk`] with AVX2.
#[inline]
pub(super) fn walk_checked<V: Visitor, const LISTED: bool>(
    asset: &Asset<'_>,
    pose: &Pose<'_>,
    stack: &mut [StackEntry],
    visitor: &mut V,
) -> Result<Walk, QueryError> {
    debug_assert!(Kernel::Avx2.is_available());
    // SAFETY: as in `evaluate_checked`.
    unsafe { walk_avx2::<V, LISTED>(asset, pose, stack, visitor) }
}
