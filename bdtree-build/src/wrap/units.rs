//! Powers of two, lengths that cannot overflow, and what origin and limits follow from them.
//!
//! Only additions, products and roots: the same bits on every processor.

/// A mode moves a vertex by at least this many box diagonals at its limit.
const LIMIT_DIAGONALS: f64 = 100.0;

/// Exponents of the least and the largest q_limit.
pub(super) const LIMIT_EXPONENTS: (i32, i32) = (-126, 120);

/// 2^e for e in −1022 ..= 1023.
pub(super) fn power(e: i32) -> f64 {
    f64::from_bits(((e.clamp(-1022, 1023) + 1023) as u64) << 52)
}

/// x 2^e for |e| ≤ 2044.
pub(super) fn scale(x: f64, e: i32) -> f64 {
    let half = e / 2;
    x * power(half) * power(e - half)
}

/// ⌊log₂ x⌋ for x > 0.
pub(super) fn exponent(x: f64) -> i32 {
    if x < f64::MIN_POSITIVE {
        return exponent(x * power(200)) - 200;
    }
    ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023
}

/// ⌈log₂ x⌉ for a normal x > 0.
pub(super) fn exponent_up(x: f64) -> i32 {
    exponent(x) + i32::from(power(exponent(x)) < x)
}

/// ‖v‖ without overflow or underflow on the way.
pub(super) fn length(v: [f64; 3]) -> f64 {
    let largest = v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if largest == 0.0 || !v.iter().all(|x| x.is_finite()) {
        return if largest == 0.0 { 0.0 } else { f64::INFINITY };
    }
    let e = exponent(largest);
    let square: f64 = v.iter().map(|&x| scale(x, -e)).map(|x| x * x).sum();
    scale(square.sqrt(), e)
}

/// n of the smallest q_limit = 2^n by which a field of length `norm` > 0 moves a vertex by 100
/// `diagonal`s, within the limits of the limit.
pub(super) fn limit_exponent(norm: f64, diagonal: f64) -> i32 {
    let e = exponent(diagonal);
    let (norm, diagonal) = (scale(norm, -e), scale(diagonal, -e));
    if norm == 0.0 {
        return LIMIT_EXPONENTS.1;
    }
    let wanted = LIMIT_DIAGONALS * diagonal;
    let mut n = exponent(wanted) - exponent(norm);
    // Mantissas decide between this power and the next.
    if scale(norm, n) < wanted {
        n += 1;
    }
    n.clamp(LIMIT_EXPONENTS.0, LIMIT_EXPONENTS.1)
}

/// The origin for a box: 0 when its center is within a diagonal of 0, else the center on a grid
/// of the power of two at the diagonal.
pub(super) fn origin(low: [f64; 3], high: [f64; 3], diagonal: f64) -> [f64; 3] {
    let center: [f64; 3] = std::array::from_fn(|k| low[k] * 0.5 + high[k] * 0.5);
    if length(center) <= diagonal {
        return [0.0; 3];
    }
    if diagonal == 0.0 {
        return low.map(|x| x + 0.0);
    }
    let grid = exponent(diagonal);
    center.map(|x| {
        let rounded = scale(scale(x, -grid).round_ties_even(), grid);
        // `+ 0.0` turns −0 into +0.
        if rounded.is_finite() {
            rounded + 0.0
        } else {
            x
        }
    })
}
