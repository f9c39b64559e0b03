//! Strain limiting: a smooth change of variable that keeps q below a limit and adds no energy.
//!
//! The oscillators move a variable s, and `q = L φ(s / L)` with `φ(x) = x / (1 + x⁴)^¼`: q is s to within
//! `(s / L)⁴ / 4` of it, and never beyond L. Since s moves linearly, its energy `½ m (ṡ² + ω² s²)` is what
//! the undamped body keeps; a force on q works on s through dq/ds, so that what it does on q is exactly what s gets.

use bdtree_runtime::format::ModeRecord;
use libm::{fabs, sqrt};

/// A limit of |q|; infinite for none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrainLimit(pub f64);

impl StrainLimit {
    /// q stays what s is.
    pub const NONE: Self = Self(f64::INFINITY);

    /// `multiples` of a mode's `q_range`, never above its `q_limit`.
    pub fn of_mode(record: &ModeRecord, multiples: f64) -> Self {
        let range = f64::from(record.q_range.get()) * multiples;
        Self(range.min(f64::from(record.q_limit.get())))
    }

    /// q, never beyond the limit.
    #[inline]
    pub fn q(&self, s: f64) -> f64 {
        let x = s / self.0;
        // (1 + x⁴)^¼ is |x| to the last bit from here on, and x⁴ does not overflow before.
        if fabs(x) > 1e5 {
            return self.0 * if s < 0.0 { -1.0 } else { 1.0 };
        }
        let x2 = x * x;
        (s / sqrt(sqrt(1.0 + x2 * x2))).clamp(-self.0, self.0)
    }

    /// dq/ds, from 1 at rest down to 0.
    #[inline]
    pub fn slope(&self, s: f64) -> f64 {
        let x = s / self.0;
        if fabs(x) > 1e5 {
            return 0.0;
        }
        let x4 = (x * x) * (x * x);
        let root = sqrt(sqrt(1.0 + x4));
        1.0 / ((1.0 + x4) * root)
    }

    /// The s that gives q; `None` where |q| is not below the limit.
    pub fn s(&self, q: f64) -> Option<f64> {
        let y = q / self.0;
        let rest = 1.0 - (y * y) * (y * y);
        (rest > 0.0).then(|| q / sqrt(sqrt(rest)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn never_passes_the_limit_and_returns() {
        for limit in [1e-3, 1.0, 40.0] {
            let law = StrainLimit(limit);
            for k in -400..=400 {
                let s = limit * libm::pow(1.07, f64::from(k)) * if k % 2 == 0 { 1.0 } else { -1.0 };
                let q = law.q(s);
                assert!(q.abs() <= limit && q * s >= 0.0 && q.abs() <= s.abs());
                if s.abs() < 2.0 * limit {
                    let again = law.s(q).expect("below the limit");
                    assert!((again - s).abs() <= 1e-12 * s.abs());
                }
                let d = 1e-4 * s.abs();
                let slope = (law.q(s + d) - law.q(s - d)) / (2.0 * d);
                assert!((slope - law.slope(s)).abs() < 1e-6, "{s} {slope}");
            }
            assert_eq!(law.s(limit), None);
            assert_eq!(law.q(f64::MAX), limit);
        }
        assert_eq!(StrainLimit::NONE.q(3.5), 3.5);
        assert_eq!(StrainLimit::NONE.slope(3.5), 1.0);
        assert_eq!(StrainLimit::NONE.s(3.5), Some(3.5));
    }
}
