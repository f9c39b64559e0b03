//! Eight lanes of f32: one small vocabulary, one implementation per instruction set.
//!
//! The node kernel is written once over [`Lanes`]; which implementation runs is chosen once,
//! when an asset is opened. Kernels may differ in the last bits (fused or separate multiply and
//! add): both are inside the slack, so they change visits at most, never results.

use bdtree_format::{LANES, Row};

use crate::bound::{BoundPose, Spheres, evaluate};
use crate::error::QueryError;
use crate::pose::Pose;
use crate::traverse::{StackEntry, Visitor, Walk, mask_of, walk};
use crate::view::{Asset, NodeRows};

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx4;
#[cfg(target_arch = "aarch64")]
mod neon;
mod prefetch;
pub(crate) mod quad;
mod scalar;

pub(crate) use prefetch::prefetch;
pub(crate) use quad::{Quad, Quad3, add3, cross3, dot3, scale3, select3, splat3, sub3};

/// Eight f32 side by side.
pub(crate) trait Lanes: Copy {
    /// Four f64 of the same instruction set.
    type Quad: Quad;

    fn splat(x: f32) -> Self;
    fn load(row: &Row) -> Self;
    /// The numbers of a row of 16 bits: exact.
    fn widen(row: &[i16; LANES]) -> Self;
    /// [`Lanes::widen`] for numbers that are not negative.
    fn widen_unsigned(row: &[u16; LANES]) -> Self;
    fn store(self) -> Row;
    fn add(self, other: Self) -> Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        other.mul_add(Self::splat(-1.0), self)
    }
    fn mul(self, other: Self) -> Self;
    /// self × factor + term, fused or not.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    fn sqrt(self) -> Self;
    /// The lanes in which `self > other`; none where one is NaN.
    #[inline(always)]
    fn above(self, other: Self) -> u8 {
        let (a, b) = (self.store(), other.store());
        mask_of(|k| a[k] > b[k])
    }
}

/// An instruction set that node bounds are evaluated with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kernel {
    /// Portable safe code; the reference.
    Scalar,
    /// x86-64 with AVX2 and FMA.
    Avx2,
    /// AArch64, where NEON is always there.
    Neon,
}

impl Kernel {
    /// Whether this processor has it. Without feature `std` only what the build targets counts.
    pub fn is_available(self) -> bool {
        match self {
            Self::Scalar => true,
            #[cfg(all(target_arch = "x86_64", feature = "std"))]
            Self::Avx2 => {
                std::arch::is_x86_feature_detected!("avx2")
                    && std::arch::is_x86_feature_detected!("fma")
            }
            #[cfg(all(target_arch = "x86_64", not(feature = "std")))]
            Self::Avx2 => cfg!(all(target_feature = "avx2", target_feature = "fma")),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 => false,
            Self::Neon => cfg!(target_arch = "aarch64"),
        }
    }

    /// The fastest one that is available.
    pub fn best() -> Self {
        [Self::Avx2, Self::Neon]
            .into_iter()
            .find(|k| k.is_available())
            .unwrap_or(Self::Scalar)
    }

    /// [`evaluate`] with this kernel.
    #[inline]
    pub(crate) fn evaluate(
        self,
        rows: &NodeRows<'_>,
        modes: &[u16],
        pose: &BoundPose<'_>,
    ) -> Option<Spheres> {
        match self {
            Self::Scalar => evaluate::<scalar::Array8>(rows, modes, pose).map(|s| s.store()),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => avx2::evaluate_checked(rows, modes, pose),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => evaluate::<neon::Neon8>(rows, modes, pose).map(|s| s.store()),
            #[allow(unreachable_patterns)] // the other architecture's kernels
            _ => evaluate::<scalar::Array8>(rows, modes, pose).map(|s| s.store()),
        }
    }

    /// [`walk`] with this kernel.
    #[inline]
    pub(crate) fn walk<V: Visitor, const LISTED: bool>(
        self,
        asset: &Asset<'_>,
        pose: &Pose<'_>,
        stack: &mut [StackEntry],
        visitor: &mut V,
    ) -> Result<Walk, QueryError> {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => avx2::walk_checked::<V, LISTED>(asset, pose, stack, visitor),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => walk::<neon::Neon8, V, LISTED>(asset, pose, stack, visitor),
            _ => walk::<scalar::Array8, V, LISTED>(asset, pose, stack, visitor),
        }
    }
}
