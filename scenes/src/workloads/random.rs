//! The stream of random numbers that the workloads are defined by: SplitMix64 (Steele, Lea, Flood 2014).

use std::f64::consts::TAU;

/// A stream; equal seeds give equal numbers everywhere.
#[derive(Debug, Clone)]
pub struct Stream(u64);

impl Stream {
    /// The stream of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let a = self.0;
        let b = (a ^ (a >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let c = (b ^ (b >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        c ^ (c >> 31)
    }

    /// From 0 up to but not 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// From −1 up to but not 1.
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// A unit vector, uniform on the sphere.
    pub fn direction(&mut self) -> [f64; 3] {
        loop {
            let [x, y, z] = [self.signed(), self.signed(), self.signed()];
            let length = (x * x + y * y + z * z).sqrt();
            // Long enough to divide by, short enough to leave no corner of the cube.
            if length > 0.1 && length <= 1.0 {
                return [x / length, y / length, z / length];
            }
        }
    }

    /// A unit quaternion (x, y, z, w), uniform among rotations (Shoemake 1992).
    pub fn rotation(&mut self) -> [f64; 4] {
        let share = self.unit();
        let first = TAU * self.unit();
        let second = TAU * self.unit();
        let (outer, inner) = ((1.0 - share).sqrt(), share.sqrt());
        [
            outer * first.sin(),
            outer * first.cos(),
            inner * second.sin(),
            inner * second.cos(),
        ]
    }
}
