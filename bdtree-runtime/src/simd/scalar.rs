//! The portable kernel: arrays of eight, which the compiler may vectorise. Multiply and add are
//! rounded separately, so its bits are the same on every processor.

use bdtree_format::{LANES, Row};

use super::Lanes;
use super::quad::Array4;
use crate::math::sqrt_f32;

#[derive(Clone, Copy)]
pub(super) struct Array8(Row);

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

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    fn load(row: &Row) -> Self {
        Self(*row)
    }

    #[inline(always)]
    fn widen(row: &[i16; LANES]) -> Self {
        Self(row.map(f32::from))
    }

    #[inline(always)]
    fn widen_unsigned(row: &[u16; LANES]) -> Self {
        Self(row.map(f32::from))
    }

    #[inline(always)]
    fn store(self) -> Row {
        self.0
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self.mul(factor).add(term)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(sqrt_f32))
    }
}
