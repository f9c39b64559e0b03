//! Floating-point numbers as files store them.

/// How one number is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Number {
    /// float32, little-endian.
    F4Le,
    /// float32, big-endian.
    F4Be,
    /// float64, little-endian.
    F8Le,
    /// float64, big-endian.
    F8Be,
}

impl Number {
    /// Bytes of one number.
    pub fn size(self) -> usize {
        match self {
            Number::F4Le | Number::F4Be => 4,
            Number::F8Le | Number::F8Be => 8,
        }
    }

    /// True for the formats that round to float32.
    pub fn is_single(self) -> bool {
        self.size() == 4
    }

    /// Gives `take` the numbers in `bytes`, in order; an incomplete one at the end is left out.
    pub fn each(self, bytes: &[u8], mut take: impl FnMut(f64)) {
        // One loop per format, so that the format is not asked for at every number.
        match self {
            Number::F4Le => pieces(bytes, |b| take(f32::from_le_bytes(b).into())),
            Number::F4Be => pieces(bytes, |b| take(f32::from_be_bytes(b).into())),
            Number::F8Le => pieces(bytes, |b| take(f64::from_le_bytes(b))),
            Number::F8Be => pieces(bytes, |b| take(f64::from_be_bytes(b))),
        }
    }
}

fn pieces<const N: usize>(bytes: &[u8], take: impl FnMut([u8; N])) {
    bytes.as_chunks().0.iter().copied().for_each(take);
}
