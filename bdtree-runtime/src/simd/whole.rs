//! Sums of products of whole numbers, one lane after the other.

use bdtree_format::{LANES, PairRow};

use super::PairSums;

/// Eight sums: the reference of others, and all there is where nothing else is known of the processor.
#[derive(Clone, Copy)]
pub(crate) struct Whole8([i32; LANES]);

impl Whole8 {
    #[inline(always)]
    pub(super) fn store(self) -> [i32; LANES] {
        self.0
    }
}

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
