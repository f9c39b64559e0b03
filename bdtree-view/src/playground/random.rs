//! Random orientations that depend on a seed and a number alone: SplitMix64 (Steele, Lea, Flood 2014).

use std::f64::consts::TAU;

/// A stream of random numbers; equal seeds and numbers give equal streams everywhere.
#[derive(Debug, Clone)]
pub(super) struct Stream(u64);

impl Stream {
    /// The stream of a body: the `number`-th of a seed.
    pub(super) fn of(seed: u64, number: u64) -> Self {
        Self(seed.wrapping_mul(0xd134_2543_de82_ef95) ^ number.wrapping_mul(0x9e37_79b9))
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let a = self.0;
        let b = (a ^ (a >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let c = (b ^ (b >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        c ^ (c >> 31)
    }

    /// From 0 up to but not 1.
    pub(super) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A unit quaternion (x, y, z, w), uniform among rotations (Shoemake 1992).
    pub(super) fn rotation(&mut self) -> [f64; 4] {
        let share = self.unit();
        let (first, second) = (TAU * self.unit(), TAU * self.unit());
        let (outer, inner) = ((1.0 - share).sqrt(), share.sqrt());
        [
            outer * first.sin(),
            outer * first.cos(),
            inner * second.sin(),
            inner * second.cos(),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::Stream;

    #[test]
    fn orientations_are_unit_and_of_seed_and_number() {
        let all: Vec<[f64; 4]> = [(1, 0), (1, 1), (2, 0), (2, 1)]
            .map(|(seed, number)| Stream::of(seed, number).rotation())
            .to_vec();
        for (k, a) in all.iter().enumerate() {
            assert!((a.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(all[..k].iter().all(|b| a != b), "{a:?}");
        }
        assert_eq!(Stream::of(1, 1).rotation(), all[1]);
    }
}
