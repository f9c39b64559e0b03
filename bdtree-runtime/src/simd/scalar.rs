//! The portable kernel: arrays of eight, which the compiler may vectorise. Multiply and add are
//! rounded separately, so its bits are the same on every processor.

use bdtree_format::{LANES, Row};

use super::quad::{Array4, operators};
#[cfg(target_arch = "x86_64")]
use super::sse::Sums;
use super::{Lanes, Listed};
use crate::math::sqrt_f32;

#[cfg(not(target_arch = "x86_64"))]
type Sums = super::whole::Whole8;

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
    type Sums = Sums;
    type Order = Listed;
    const IS_COMPACT: bool = true;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    fn load(row: &Row) -> Self {
        Self(*row)
    }

    #[inline(always)]
    fn round(sums: Sums) -> Self {
        Self(sums.store().map(|sum| sum as f32))
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
