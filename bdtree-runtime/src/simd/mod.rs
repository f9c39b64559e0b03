//! Eight lanes of f32: one small vocabulary, one implementation per instruction set.
//!
//! The node kernel is written once over [`Lanes`]; which implementation runs is chosen once,
//! when an asset is opened. Kernels sum the same whole numbers over the modes, and every operation on f32 is
//! rounded once, as IEEE 754 says: there is no fused multiply and add. So node bounds and tests of them have the
//! same bits everywhere, which decides what a query reports that stops at a level.

use bdtree_format::{LANES, PairRow, Row};

#[cfg(target_arch = "x86_64")]
mod avx4;
#[cfg(target_arch = "x86_64")]
mod avx8;
#[cfg(target_arch = "x86_64")]
mod avx_order;
mod fields;
#[cfg(any(test, not(target_arch = "x86_64")))]
mod four;
#[cfg(target_arch = "aarch64")]
mod neon;
mod order;
mod prefetch;
pub(crate) mod quad;
mod scalar;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod simd128;
#[cfg(target_arch = "x86_64")]
mod sse;
#[cfg(test)]
mod tests;
#[cfg(any(test, not(target_arch = "x86_64")))]
mod whole;

pub(crate) use fields::Fields;
#[cfg(not(target_arch = "x86_64"))]
pub(crate) use four::Four;
pub(crate) use order::{Listed, Order};
pub(crate) use prefetch::{LINE, prefetch, prefetch_from, prefetch_lines};
pub(crate) use quad::{Quad, Quad3, add3, cross3, dot3, four_of, scale3, select3, splat3, sub3};
pub(crate) use scalar::Array8 as Compact;
#[cfg(target_arch = "x86_64")]
pub(crate) use sse::Four;

/// Eight f32 side by side; no operation rounds more or less than once.
pub(crate) trait Lanes: Copy {
    /// Four f64 of the same instruction set.
    type Quad: Quad;
    /// Eight whole numbers of the same instruction set.
    type Sums: PairSums;
    /// How the same instruction set puts lanes in order.
    type Order: Order;
    /// Whether all walks call one copy of the node kernel and ask their visitors through a table of functions. Compiled
    /// for each visitor rays are a ninth faster (docs/measured/capi.md), but that is most of a library's code, and without
    /// wide registers more than with.
    const IS_COMPACT: bool = false;

    /// Does a piece of work with these lanes, in a function of its own: [`Kernel::run`] where the kernel is known.
    #[inline(always)]
    fn apart<W: Work>(work: W) -> W::Output {
        run_portable::<Self, W>(work)
    }

    fn splat(x: f32) -> Self;
    fn load(row: &Row) -> Self;
    /// The four columns of eight rows.
    #[inline(always)]
    fn columns(rows: [&[f32; 4]; LANES]) -> [Self; 4] {
        let mut columns = [Self::splat(0.0); 4];
        for (k, column) in columns.iter_mut().enumerate() {
            let mut entries = [0.0; LANES];
            for (entry, row) in entries.iter_mut().zip(rows) {
                *entry = row[k];
            }
            *column = Self::load(&entries);
        }
        columns
    }
    /// Whole numbers, rounded to the nearest.
    fn round(sums: Self::Sums) -> Self;
    fn store(self) -> Row;
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn sqrt(self) -> Self;
    /// The larger of the two, either one where one is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        let (mut a, b) = (self.store(), other.store());
        for k in 0..LANES {
            a[k] = if a[k] > b[k] { a[k] } else { b[k] };
        }
        Self::load(&a)
    }
    /// The smaller of the two, either one where one is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        let (mut a, b) = (self.store(), other.store());
        for k in 0..LANES {
            a[k] = if a[k] < b[k] { a[k] } else { b[k] };
        }
        Self::load(&a)
    }
    /// The deformed places of three times four vertices, of each coordinate that of the four.
    #[inline(always)]
    fn moved(fields: &Fields<'_>) -> [[[f32; 4]; 3]; 3] {
        fields.moved()
    }
    /// The lanes in which `self > other`; none where one is NaN.
    #[inline(always)]
    fn above(self, other: Self) -> u8 {
        let (a, b) = (self.store(), other.store());
        mask_of(|k| a[k] > b[k])
    }
}

/// Eight sums of products of whole numbers, 32 bits each: exact as long as they fit, and otherwise
/// (corrupt files) any number.
pub(crate) trait PairSums: Copy {
    /// What the two numbers of each lane are multiplied by: none is −2¹⁵.
    type Factor: Copy;

    fn zero() -> Self;
    /// Of each n that, |n|, max(n, 0) and max(−n, 0).
    fn factors(n: [i16; 2]) -> [Self::Factor; 4];
    /// Adds in each lane both products.
    fn add_products(self, row: &PairRow, n: Self::Factor) -> Self;
    fn add(self, other: Self) -> Self;
}

/// A piece of work that is written over [`Lanes`].
pub(crate) trait Work {
    type Output;

    /// Inlined where the instruction set is enabled: mark it and what it calls `inline(always)`.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// A mask from one decision per lane.
#[inline(always)]
pub(crate) fn mask_of(decide: impl Fn(usize) -> bool) -> u8 {
    let mut mask = 0;
    for k in 0..LANES {
        mask |= u8::from(decide(k)) << k;
    }
    mask
}

/// Whether the processor has an instruction set. Without feature `std` only what the build targets counts.
#[cfg(all(target_arch = "x86_64", not(feature = "std")))]
macro_rules! has {
    ($feature:tt) => {
        cfg!(target_feature = $feature)
    };
}
#[cfg(all(target_arch = "x86_64", feature = "std"))]
use std::arch::is_x86_feature_detected as has;

/// An instruction set that node bounds are evaluated with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kernel {
    /// Portable safe code; the reference.
    Scalar,
    /// x86-64 with AVX2, FMA and the bit counts of the same age: BMI, LZCNT, POPCNT.
    Avx2,
    /// AArch64, where NEON is always there.
    Neon,
    /// WebAssembly, where the build enables `simd128`.
    Simd128,
}

impl Kernel {
    /// All of them, available or not.
    pub const ALL: [Self; 4] = [Self::Scalar, Self::Avx2, Self::Neon, Self::Simd128];

    /// Whether this processor has it. Without feature `std` only what the build targets counts.
    pub fn is_available(self) -> bool {
        match self {
            Self::Scalar => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => {
                has!("avx2")
                    && has!("fma")
                    && has!("bmi1")
                    && has!("bmi2")
                    && has!("lzcnt")
                    && has!("popcnt")
            }
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 => false,
            Self::Neon => cfg!(target_arch = "aarch64"),
            Self::Simd128 => cfg!(all(target_arch = "wasm32", target_feature = "simd128")),
        }
    }

    /// The fastest one that is available.
    pub fn best() -> Self {
        [Self::Avx2, Self::Neon, Self::Simd128]
            .into_iter()
            .find(|k| k.is_available())
            .unwrap_or(Self::Scalar)
    }

    /// Does a piece of work with this kernel, in a function of its own: what is large or used in several
    /// places is compiled once.
    #[inline]
    pub(crate) fn run<W: Work>(self, work: W) -> W::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => avx8::run(work),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => run_portable::<neon::Neon8, W>(work),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Self::Simd128 => run_portable::<simd128::Simd8, W>(work),
            _ => run_portable::<scalar::Array8, W>(work),
        }
    }
}

/// [`Work::run`] with what the whole program may use.
#[inline(never)]
fn run_portable<L: Lanes, W: Work>(work: W) -> W::Output {
    work.run::<L>()
}
