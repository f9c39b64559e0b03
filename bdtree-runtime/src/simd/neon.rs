//! NEON: a row is two registers.
#![allow(unsafe_code)] // intrinsics; every block has its proof

use bdtree_format::{PairRow, Row};
use core::arch::aarch64::{
    float32x4_t, int16x8_t, int32x4_t, vabsq_s16, vaddq_f32, vaddq_s32, vcvtq_f32_s32, vdupq_n_f32,
    vdupq_n_s16, vdupq_n_s32, vget_low_s16, vld1q_f32, vld1q_s16, vmaxq_f32, vmaxq_s16, vminq_f32,
    vmlal_high_s16, vmlal_s16, vmulq_f32, vpaddq_s32, vreinterpretq_s16_s32, vsqrtq_f32, vst1q_f32,
    vsubq_f32, vsubq_s16,
};

use super::quad::Array4;
use super::{Lanes, Listed, PairSums};

/// Methods that are one instruction on each of the two registers of the operands.
macro_rules! instructions {
    ($($name:ident($($other:ident)?) = $intrinsic:ident;)+) => {
        $(#[inline(always)]
        fn $name(self $(, $other: Self)?) -> Self {
            // SAFETY: NEON is part of AArch64.
            let low = unsafe { $intrinsic(self.0 $(, $other.0)?) };
            // SAFETY: as above.
            let high = unsafe { $intrinsic(self.1 $(, $other.1)?) };
            Self(low, high)
        })+
    };
}

/// Eight f32 in two registers; every AArch64 target of this build has NEON.
#[derive(Clone, Copy)]
pub(super) struct Neon8(float32x4_t, float32x4_t);

impl Lanes for Neon8 {
    type Quad = Array4;
    type Sums = Whole8;
    type Order = Listed;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: NEON is part of AArch64.
        let v = unsafe { vdupq_n_f32(x) };
        Self(v, v)
    }

    #[inline(always)]
    fn load(row: &Row) -> Self {
        let ([low, high], _) = row.as_chunks::<4>() else {
            return Self::splat(0.0);
        };
        // SAFETY: NEON is part of AArch64; `low` is four readable f32.
        let a = unsafe { vld1q_f32(low.as_ptr()) };
        // SAFETY: the same for `high`.
        let b = unsafe { vld1q_f32(high.as_ptr()) };
        Self(a, b)
    }

    #[inline(always)]
    fn round(sums: Whole8) -> Self {
        let [a, b, c, d] = sums.0;
        // SAFETY: NEON is part of AArch64.
        let low = unsafe { vpaddq_s32(a, b) };
        // SAFETY: as above.
        let high = unsafe { vpaddq_s32(c, d) };
        // SAFETY: as above.
        let low = unsafe { vcvtq_f32_s32(low) };
        // SAFETY: as above.
        let high = unsafe { vcvtq_f32_s32(high) };
        Self(low, high)
    }

    #[inline(always)]
    fn store(self) -> Row {
        let mut row = [0.0; 8];
        if let ([low, high], _) = row.as_chunks_mut::<4>() {
            // SAFETY: NEON is part of AArch64; `low` is four writable f32.
            unsafe { vst1q_f32(low.as_mut_ptr(), self.0) };
            // SAFETY: the same for `high`.
            unsafe { vst1q_f32(high.as_mut_ptr(), self.1) };
        }
        row
    }

    instructions! {
        add(other) = vaddq_f32;
        sub(other) = vsubq_f32;
        mul(other) = vmulq_f32;
        min(other) = vminq_f32;
        max(other) = vmaxq_f32;
        sqrt() = vsqrtq_f32;
    }
}

/// Both sums of two lanes in each register, added at the end.
#[derive(Clone, Copy)]
pub(super) struct Whole8([int32x4_t; 4]);

impl PairSums for Whole8 {
    type Factor = int16x8_t;

    #[inline(always)]
    fn zero() -> Self {
        // SAFETY: NEON is part of AArch64.
        Self([unsafe { vdupq_n_s32(0) }; 4])
    }

    #[inline(always)]
    fn factors([a, b]: [i16; 2]) -> [int16x8_t; 4] {
        let both = u32::from(a as u16) | (u32::from(b as u16) << 16);
        // SAFETY: NEON is part of AArch64.
        let both = unsafe { vdupq_n_s32(both as i32) };
        // SAFETY: as above.
        let n = unsafe { vreinterpretq_s16_s32(both) };
        // SAFETY: as above.
        let magnitude = unsafe { vabsq_s16(n) };
        // SAFETY: as above.
        let zero = unsafe { vdupq_n_s16(0) };
        // SAFETY: as above.
        let positive = unsafe { vmaxq_s16(n, zero) };
        // max(−n, 0) = max(n, 0) − n.
        // SAFETY: as above.
        let negative = unsafe { vsubq_s16(positive, n) };
        [n, magnitude, positive, negative]
    }

    #[inline(always)]
    fn add_products(self, row: &PairRow, n: int16x8_t) -> Self {
        let ([low, high], _) = row.as_flattened().as_chunks::<8>() else {
            return self;
        };
        // SAFETY: NEON is part of AArch64; `low` is eight readable i16.
        let low = unsafe { vld1q_s16(low.as_ptr()) };
        // SAFETY: the same for `high`.
        let high = unsafe { vld1q_s16(high.as_ptr()) };
        let [a, b, c, d] = self.0;
        // SAFETY: NEON is part of AArch64.
        let factor = unsafe { vget_low_s16(n) };
        // SAFETY: as above.
        let low_half = unsafe { vget_low_s16(low) };
        // SAFETY: as above.
        let high_half = unsafe { vget_low_s16(high) };
        // SAFETY: as above.
        let a = unsafe { vmlal_s16(a, low_half, factor) };
        // SAFETY: as above.
        let b = unsafe { vmlal_high_s16(b, low, n) };
        // SAFETY: as above.
        let c = unsafe { vmlal_s16(c, high_half, factor) };
        // SAFETY: as above.
        let d = unsafe { vmlal_high_s16(d, high, n) };
        Self([a, b, c, d])
    }

    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        for k in 0..4 {
            // SAFETY: NEON is part of AArch64.
            self.0[k] = unsafe { vaddq_s32(self.0[k], other.0[k]) };
        }
        self
    }
}
