//! Numbers in 16 bits: whole multiples of a power of two that a node shares (SPEC 6.5).

use super::units::{exponent, scale};

/// The least exponent of a grid (SPEC 6.1).
const EXPONENT_MIN: i32 = -126;

/// Bits of a number without its sign.
const BITS: i32 = 15;

/// The whole multiples of 2^exponent.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    exponent: i8,
}

impl Grid {
    /// The finest grid on which `largest` ≥ 0, rounded up, takes at most [`BITS`] bits; `largest`
    /// is below 2¹²³.
    pub(super) fn covering(largest: f64) -> Self {
        if largest == 0.0 {
            return Self { exponent: 0 };
        }
        let mut e = (exponent(largest) - (BITS - 1)).max(EXPONENT_MIN);
        // Rounding up may carry into one bit more.
        if scale(largest, -e).ceil() >= f64::from(1 << BITS) {
            e += 1;
        }
        Self { exponent: e as i8 }
    }

    /// e: the grid's unit is 2^e.
    pub(super) fn exponent(self) -> i8 {
        self.exponent
    }

    /// The number that `n` units are: exact.
    pub(super) fn value(self, n: impl Into<f64>) -> f64 {
        scale(n.into(), i32::from(self.exponent))
    }

    /// Units nearest to `x`, whose magnitude the grid covers.
    pub(super) fn nearest(self, x: f64) -> i16 {
        self.units(x).round_ties_even() as i16
    }

    /// The least units that are not below `x`, whose magnitude the grid covers.
    pub(super) fn up(self, x: f64) -> i16 {
        self.units(x).ceil() as i16
    }

    fn units(self, x: f64) -> f64 {
        scale(x, -i32::from(self.exponent))
    }
}
