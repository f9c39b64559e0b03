//! Lanes by their keys: where a walk goes first, without a branch per lane.

use bdtree_format::{LANES, Row};

/// An order of eight lanes.
pub(crate) trait Order: Copy {
    /// The lanes of `among`, that of the greatest key first; behind them any others. Keys that differ by less than 2⁻²⁰ of
    /// themselves count as equal, and then the highest lane comes first.
    fn new(keys: &Row, among: u8) -> Self;
    /// What the lanes hold, in this order.
    fn numbers(self, of: &[u32; LANES]) -> [u32; LANES];
    /// As [`Order::numbers`].
    #[inline(always)]
    fn keys(self, of: &Row) -> Row {
        self.numbers(&of.map(f32::to_bits)).map(f32::from_bits)
    }
    /// As [`Order::numbers`].
    fn bytes(self, of: &[u8; LANES]) -> [u32; LANES];
}

/// The bits of a lane's number.
pub(super) const LANE_BITS: i32 = 7;

/// The numbers of lanes, one after the other; the portable order.
#[derive(Clone, Copy)]
pub(crate) struct Listed([u8; LANES]);

impl Listed {
    #[inline(always)]
    fn of<T: Copy>(self, row: &[T; LANES]) -> [T; LANES] {
        self.0.map(|lane| row[usize::from(lane) & (LANES - 1)])
    }
}

/// A whole number that is as great as the key, but for the last bits, where the lane's number is.
#[inline(always)]
fn rank(key: f32, lane: i32) -> i32 {
    let bits = key.to_bits() as i32;
    // Of a negative number larger bits are less.
    let turned = ((bits >> 31) as u32 >> 1) as i32;
    (bits ^ turned) & !LANE_BITS | lane
}

impl Order for Listed {
    #[inline(always)]
    fn new(keys: &Row, among: u8) -> Self {
        let mut sorted = [0; LANES];
        let mut count = 0;
        let mut left = among;
        while left != 0 {
            let lane = (left.trailing_zeros() & 7) as usize;
            left &= left - 1;
            let rank = rank(keys[lane], lane as i32);
            let mut place = count;
            while place > 0 && sorted[place - 1] < rank {
                sorted[place] = sorted[place - 1];
                place -= 1;
            }
            sorted[place] = rank;
            count += 1;
        }
        Self(sorted.map(|rank| (rank & LANE_BITS) as u8))
    }

    #[inline(always)]
    fn numbers(self, of: &[u32; LANES]) -> [u32; LANES] {
        self.of(of)
    }

    #[inline(always)]
    fn bytes(self, of: &[u8; LANES]) -> [u32; LANES] {
        self.of(of).map(u32::from)
    }
}
