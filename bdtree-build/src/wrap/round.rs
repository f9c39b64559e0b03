//! Outward rounding to what is stored (SPEC 5.1, 5.7): never a subnormal, never −0.

/// The least stored value that is not below `x`: a normal f32 or +0. Infinite when `x` is beyond
/// the range of f32, NaN for NaN.
pub fn round_up(x: f64) -> f32 {
    let nearest = x as f32;
    let up = if f64::from(nearest) < x {
        nearest.next_up()
    } else {
        nearest
    };
    if up > 0.0 && up < f32::MIN_POSITIVE {
        f32::MIN_POSITIVE
    } else {
        flush(up)
    }
}

/// The nearest stored value: subnormals become +0, and so does −0.
pub fn round_nearest(x: f64) -> f32 {
    flush(x as f32)
}

fn flush(x: f32) -> f32 {
    if x.abs() < f32::MIN_POSITIVE { 0.0 } else { x }
}

/// An upper bound of a norm from its square as computed in f64 from stored values: covers the
/// rounding of differences, squares, sums and the root.
pub fn norm_above(square: f64) -> f64 {
    // 2⁻⁴⁸ is eight times what the evaluation in f64 can lose.
    (square * (1.0 + f64::EPSILON * 16.0)).sqrt() * (1.0 + f64::EPSILON * 2.0)
}

/// [`norm_above`] as stored.
pub fn norm_up(square: f64) -> f32 {
    round_up(norm_above(square))
}

/// An upper bound of the norm of a stored vector.
pub(super) fn vector_norm_up(v: [f64; 3]) -> f32 {
    norm_up(crate::vec3::norm2(v))
}
