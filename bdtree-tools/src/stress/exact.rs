//! Whether a point lies in a sphere, decided without rounding.

use num_bigint::BigInt;
use num_rational::BigRational;

/// ‖v − c‖² in f64. Coordinates up to 2⁶⁰ in magnitude, as the format's limits ask for.
#[inline]
pub(super) fn squared_distance(v: [f32; 3], c: [f32; 3]) -> f64 {
    let d = [0, 1, 2].map(|k| f64::from(v[k]) - f64::from(c[k]));
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
}

/// Whether a squared distance is certainly at most r²: differences lose 2⁻⁵³ of themselves, squares
/// and sums as much again, 5 · 2⁻⁵³ together; r² is exact in f64. What is not finite is not.
#[inline]
pub(super) fn certainly_within(squared_distance: f64, r: f32) -> bool {
    const GROW: f64 = 1.0 + 8.0 / (1_u64 << 53) as f64;
    let r = f64::from(r);
    squared_distance.is_finite() && r >= 0.0 && squared_distance * GROW + f64::MIN_POSITIVE <= r * r
}

/// Whether ‖v − c‖ ≤ r, in exact arithmetic. What is not finite lies in nothing.
pub(super) fn within(v: [f32; 3], c: [f32; 3], r: f32) -> bool {
    let finite = v.iter().chain(&c).all(|x| x.is_finite()) && r.is_finite();
    if !finite || r < 0.0 {
        return r == f32::INFINITY && v.iter().chain(&c).all(|x| x.is_finite());
    }
    let exact = |x: f32| BigRational::from_float(x).unwrap_or_else(|| BigInt::ZERO.into());
    let square = |x: BigRational| &x * &x;
    let [x, y, z] = [0, 1, 2].map(|k| square(exact(v[k]) - exact(c[k])));
    x + y + z <= square(exact(r))
}

#[cfg(test)]
mod tests {
    use super::{certainly_within, squared_distance, within};

    #[test]
    fn the_surface_is_inside_and_the_next_number_is_not() {
        let next = |x: f32| f32::from_bits(x.to_bits() + 1);
        for scale in [1.0, 2.0_f32.powi(-66), 2.0_f32.powi(50), f32::MIN_POSITIVE] {
            let v = [3.0 * scale, 4.0 * scale, 0.0];
            let c = [0.0; 3];
            assert!(within(v, c, 5.0 * scale));
            assert!(!within(
                [3.0 * scale, next(4.0 * scale), 0.0],
                c,
                5.0 * scale
            ));
            assert!(!within([v[0], v[1], f32::from_bits(1)], c, 5.0 * scale));
        }
        // 1 + 2⁻¹⁴⁰ is not 1, but f64 cannot tell.
        let v = [1.0, 2.0_f32.powi(-70), 0.0];
        assert_eq!(squared_distance(v, [0.0; 3]), 1.0);
        assert!(!certainly_within(1.0, 1.0) && !within(v, [0.0; 3], 1.0));
        assert!(within([1.0, 0.0, 0.0], [0.0; 3], 1.0));
    }

    #[test]
    fn what_is_not_finite_lies_in_nothing() {
        for v in [f32::NAN, f32::INFINITY] {
            assert!(!within([v, 0.0, 0.0], [0.0; 3], 1.0));
            assert!(!within([0.0; 3], [v, 0.0, 0.0], 1.0));
            assert!(!certainly_within(
                squared_distance([v, 0.0, 0.0], [0.0; 3]),
                1.0
            ));
        }
        assert!(!within([0.0; 3], [0.0; 3], -1.0) && !certainly_within(0.0, -1.0));
        assert!(within([0.0; 3], [1.0; 3], f32::INFINITY));
        assert!(!certainly_within(f64::INFINITY, f32::INFINITY));
    }

    /// What f64 is certain of is true.
    #[test]
    fn certainty_is_never_wrong() {
        let mut certain = 0;
        for i in 0..20_000_u32 {
            let x = |k: u32| f32::from_bits(0x3f80_0000 + (i * 7919 + k * 104_729) % 0x0080_0000);
            let (v, c) = ([x(1), x(2), x(3)], [-x(4), x(5), 0.5 * x(6)]);
            let d = squared_distance(v, c);
            let nearest = d.sqrt() as f32;
            for bits in nearest.to_bits() - 1..=nearest.to_bits() + 1 {
                let r = f32::from_bits(bits);
                if certainly_within(d, r) {
                    certain += 1;
                    assert!(within(v, c, r));
                }
            }
        }
        assert!(certain > 20_000);
    }
}
