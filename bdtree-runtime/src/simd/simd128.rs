//! WebAssembly SIMD: a row is two vectors, and so are four f64.
#![allow(unsafe_code)] // loads and stores; every block has its proof

use bdtree_format::{PairRow, Row};
use core::arch::wasm32::{
    f32x4_add, f32x4_convert_i32x4, f32x4_gt, f32x4_mul, f32x4_splat, f32x4_sqrt, f32x4_sub,
    f64x2_abs, f64x2_add, f64x2_div, f64x2_ge, f64x2_gt, f64x2_mul, f64x2_promote_low_f32x4,
    f64x2_splat, f64x2_sqrt, f64x2_sub, i16x8_abs, i16x8_max, i16x8_splat, i16x8_sub, i32x4_add,
    i32x4_bitmask, i32x4_dot_i16x8, i32x4_shuffle, i32x4_splat, i64x2_bitmask, v128, v128_and,
    v128_bitselect, v128_load, v128_or, v128_store,
};
use zerocopy::{FromBytes, IntoBytes};

use super::{Lanes, Listed, PairSums, Quad};

/// The two halves of 32 bytes.
#[inline(always)]
fn halves<T: IntoBytes, const N: usize>(numbers: &[T; N]) -> [v128; 2] {
    const { assert!(size_of::<[T; N]>() == 32) };
    let start: *const v128 = numbers.as_ptr().cast();
    // SAFETY: `numbers` is 32 readable bytes; these are the first 16, and any alignment will do.
    let low = unsafe { v128_load(start) };
    // SAFETY: the other 16 of the same 32.
    let high = unsafe { v128_load(start.wrapping_add(1)) };
    [low, high]
}

/// Writes [`halves`].
#[inline(always)]
fn join<T: FromBytes, const N: usize>([low, high]: [v128; 2], numbers: &mut [T; N]) {
    const { assert!(size_of::<[T; N]>() == 32) };
    let start: *mut v128 = numbers.as_mut_ptr().cast();
    // SAFETY: `numbers` is 32 writable bytes; these are the first 16, and any alignment will do.
    unsafe { v128_store(start, low) };
    // SAFETY: the other 16 of the same 32.
    unsafe { v128_store(start.wrapping_add(1), high) };
}

/// Methods that are one instruction on each of the two registers of the operands.
macro_rules! instructions {
    ($($name:ident($($other:ident)?) = $intrinsic:ident;)+) => {
        $(#[inline(always)]
        fn $name(self $(, $other: Self)?) -> Self {
            Self($intrinsic(self.0 $(, $other.0)?), $intrinsic(self.1 $(, $other.1)?))
        })+
    };
}

/// Eight f32.
#[derive(Clone, Copy)]
pub(super) struct Simd8(v128, v128);

impl Lanes for Simd8 {
    type Quad = Simd4;
    type Sums = Whole8;
    type Order = Listed;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(f32x4_splat(x), f32x4_splat(x))
    }

    #[inline(always)]
    fn load(row: &Row) -> Self {
        let [low, high] = halves(row);
        Self(low, high)
    }

    #[inline(always)]
    fn round(sums: Whole8) -> Self {
        Self(f32x4_convert_i32x4(sums.0), f32x4_convert_i32x4(sums.1))
    }

    #[inline(always)]
    fn store(self) -> Row {
        let mut row = [0.0_f32; 8];
        join([self.0, self.1], &mut row);
        row
    }

    instructions! {
        add(other) = f32x4_add;
        sub(other) = f32x4_sub;
        mul(other) = f32x4_mul;
        sqrt() = f32x4_sqrt;
    }

    #[inline(always)]
    fn above(self, other: Self) -> u8 {
        let low = i32x4_bitmask(f32x4_gt(self.0, other.0));
        let high = i32x4_bitmask(f32x4_gt(self.1, other.1));
        low | (high << 4)
    }
}

/// Eight sums.
#[derive(Clone, Copy)]
pub(super) struct Whole8(v128, v128);

impl PairSums for Whole8 {
    type Factor = v128;

    #[inline(always)]
    fn zero() -> Self {
        Self(i32x4_splat(0), i32x4_splat(0))
    }

    #[inline(always)]
    fn factors([a, b]: [i16; 2]) -> [v128; 4] {
        let both = u32::from(a as u16) | (u32::from(b as u16) << 16);
        let n = i32x4_splat(both as i32);
        let positive = i16x8_max(n, i16x8_splat(0));
        // max(−n, 0) = max(n, 0) − n.
        [n, i16x8_abs(n), positive, i16x8_sub(positive, n)]
    }

    #[inline(always)]
    fn add_products(self, row: &PairRow, n: v128) -> Self {
        let [low, high] = halves(row);
        self.add(Self(i32x4_dot_i16x8(low, n), i32x4_dot_i16x8(high, n)))
    }

    instructions! {
        add(other) = i32x4_add;
    }
}

/// Four f64.
#[derive(Clone, Copy)]
pub(super) struct Simd4(v128, v128);

impl Quad for Simd4 {
    type Mask = (v128, v128);

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self(f64x2_splat(x), f64x2_splat(x))
    }

    #[inline(always)]
    fn load(x: &[f64; 4]) -> Self {
        let [low, high] = halves(x);
        Self(low, high)
    }

    #[inline(always)]
    fn widen(x: &[f32; 4]) -> Self {
        // SAFETY: `x` is 16 readable bytes, any alignment will do.
        let x = unsafe { v128_load(x.as_ptr().cast()) };
        let high = i32x4_shuffle::<2, 3, 2, 3>(x, x);
        Self(f64x2_promote_low_f32x4(x), f64x2_promote_low_f32x4(high))
    }

    #[inline(always)]
    fn store(self) -> [f64; 4] {
        let mut out = [0.0_f64; 4];
        join([self.0, self.1], &mut out);
        out
    }

    instructions! {
        add(other) = f64x2_add;
        sub(other) = f64x2_sub;
        mul(other) = f64x2_mul;
        div(other) = f64x2_div;
        sqrt() = f64x2_sqrt;
        abs() = f64x2_abs;
    }

    #[inline(always)]
    fn above(self, other: Self) -> (v128, v128) {
        (f64x2_gt(self.0, other.0), f64x2_gt(self.1, other.1))
    }

    #[inline(always)]
    fn at_least(self, other: Self) -> (v128, v128) {
        (f64x2_ge(self.0, other.0), f64x2_ge(self.1, other.1))
    }

    #[inline(always)]
    fn both(a: (v128, v128), b: (v128, v128)) -> (v128, v128) {
        (v128_and(a.0, b.0), v128_and(a.1, b.1))
    }

    #[inline(always)]
    fn either(a: (v128, v128), b: (v128, v128)) -> (v128, v128) {
        (v128_or(a.0, b.0), v128_or(a.1, b.1))
    }

    #[inline(always)]
    fn select(mask: (v128, v128), yes: Self, no: Self) -> Self {
        let low = v128_bitselect(yes.0, no.0, mask.0);
        let high = v128_bitselect(yes.1, no.1, mask.1);
        Self(low, high)
    }

    #[inline(always)]
    fn bits(mask: (v128, v128)) -> u8 {
        i64x2_bitmask(mask.0) | (i64x2_bitmask(mask.1) << 2)
    }
}
