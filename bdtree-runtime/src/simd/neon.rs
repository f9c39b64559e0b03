//! NEON: a row is two registers.
#![allow(unsafe_code)] // intrinsics; every block has its proof

use bdtree_format::{LANES, Row};
use core::arch::aarch64::{
    float32x4_t, vaddq_f32, vcvtq_f32_s32, vcvtq_f32_u32, vdupq_n_f32, vfmaq_f32, vget_low_s16,
    vget_low_u16, vld1q_f32, vld1q_s16, vld1q_u16, vmovl_high_s16, vmovl_high_u16, vmovl_s16,
    vmovl_u16, vmulq_f32, vsqrtq_f32, vst1q_f32,
};

use super::Lanes;
use super::quad::Array4;

/// Eight f32 in two registers; every AArch64 target of this build has NEON.
#[derive(Clone, Copy)]
pub(super) struct Neon8(float32x4_t, float32x4_t);

impl Lanes for Neon8 {
    type Quad = Array4;

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
    fn widen(row: &[i16; LANES]) -> Self {
        // SAFETY: NEON is part of AArch64; `row` is eight readable i16.
        let row = unsafe { vld1q_s16(row.as_ptr()) };
        // SAFETY: NEON is part of AArch64.
        let half = unsafe { vget_low_s16(row) };
        // SAFETY: as above.
        let low = unsafe { vmovl_s16(half) };
        // SAFETY: as above.
        let high = unsafe { vmovl_high_s16(row) };
        // SAFETY: as above.
        let a = unsafe { vcvtq_f32_s32(low) };
        // SAFETY: as above.
        let b = unsafe { vcvtq_f32_s32(high) };
        Self(a, b)
    }

    #[inline(always)]
    fn widen_unsigned(row: &[u16; LANES]) -> Self {
        // SAFETY: NEON is part of AArch64; `row` is eight readable u16.
        let row = unsafe { vld1q_u16(row.as_ptr()) };
        // SAFETY: NEON is part of AArch64.
        let half = unsafe { vget_low_u16(row) };
        // SAFETY: as above.
        let low = unsafe { vmovl_u16(half) };
        // SAFETY: as above.
        let high = unsafe { vmovl_high_u16(row) };
        // SAFETY: as above.
        let a = unsafe { vcvtq_f32_u32(low) };
        // SAFETY: as above.
        let b = unsafe { vcvtq_f32_u32(high) };
        Self(a, b)
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

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: NEON is part of AArch64.
        let a = unsafe { vaddq_f32(self.0, other.0) };
        // SAFETY: as above.
        let b = unsafe { vaddq_f32(self.1, other.1) };
        Self(a, b)
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // SAFETY: NEON is part of AArch64.
        let a = unsafe { vmulq_f32(self.0, other.0) };
        // SAFETY: as above.
        let b = unsafe { vmulq_f32(self.1, other.1) };
        Self(a, b)
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        // SAFETY: NEON is part of AArch64.
        let a = unsafe { vfmaq_f32(term.0, self.0, factor.0) };
        // SAFETY: as above.
        let b = unsafe { vfmaq_f32(term.1, self.1, factor.1) };
        Self(a, b)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: NEON is part of AArch64.
        let a = unsafe { vsqrtq_f32(self.0) };
        // SAFETY: as above.
        let b = unsafe { vsqrtq_f32(self.1) };
        Self(a, b)
    }
}
