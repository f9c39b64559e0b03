//! Choices that are the same in every run.

/// A splitmix64 generator (S. Vigna) with a fixed seed.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new() -> Self {
        Self(2004)
    }

    /// Evenly distributed bits.
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Keeps at most `count` items: the first places of a Fisher–Yates shuffle.
    pub(crate) fn keep<T>(&mut self, count: usize, items: &mut Vec<T>) {
        if items.len() <= count {
            return;
        }
        for i in 0..count {
            let rest = (items.len() - i) as u64;
            items.swap(i, i + (self.bits() % rest) as usize);
        }
        items.truncate(count);
    }
}
