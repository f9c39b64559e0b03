//! The portable kernel: arrays of eight, which the compiler may vectorise. Multiply and add are
//! rounded separately, so its bits are the same on every processor.

use bdtree_format::{LANES, PairRow, Row};

use super::quad::{Array4, operators};
use super::{Lanes, PairSums};
use crate::math::sqrt_f32;

#[derive(Clone, Copy)]
pub(crate) struct Array8(Row);

impl Array8 {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut out = self.0;
        for k in 0..LANES {
            out[k] = f(out[k], other.0[k]);
        }
        Self(out)
    }
}

impl Lanes for Array8 {
    type Quad = Array4;
    type Sums = Whole8;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    fn load(row: &Row) -> Self {
        Self(*row)
    }

    #[inline(always)]
    fn round(sums: Whole8) -> Self {
        let mut out = [0.0; LANES];
        for k in 0..LANES {
            out[k] = sums.0[k] as f32;
        }
        Self(out)
    }

    #[inline(always)]
    fn store(self) -> Row {
        self.0
    }

    operators! {
        add = +;
        sub = -;
        mul = *;
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(sqrt_f32))
    }
}

#[derive(Clone, Copy)]
pub(crate) struct Whole8([i32; LANES]);

impl PairSums for Whole8 {
    type Factor = [i16; 2];

    #[inline(always)]
    fn zero() -> Self {
        Self([0; LANES])
    }

    #[inline(always)]
    fn factors(n: [i16; 2]) -> [[i16; 2]; 4] {
        let magnitude = n.map(i16::wrapping_abs);
        let positive = n.map(|n| n.max(0));
        let negative = n.map(|n| n.wrapping_neg().max(0));
        [n, magnitude, positive, negative]
    }

    #[inline(always)]
    fn add_products(mut self, row: &PairRow, [a, b]: [i16; 2]) -> Self {
        for k in 0..LANES {
            let [x, y] = row[k];
            let products = (i32::from(x) * i32::from(a)).wrapping_add(i32::from(y) * i32::from(b));
            self.0[k] = self.0[k].wrapping_add(products);
        }
        self
    }

    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        for k in 0..LANES {
            self.0[k] = self.0[k].wrapping_add(other.0[k]);
        }
        self
    }
}
