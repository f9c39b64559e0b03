//! Three-vectors as plain arrays.

pub(crate) use bdtree_runtime::math::{add, cross, dot, norm, scale, sub};

/// |a|².
pub(crate) fn norm2(a: [f64; 3]) -> f64 {
    dot(a, a)
}

/// Lowest and highest corner of the box around points; infinite, and the wrong way round, without any.
pub(crate) fn bounds(points: impl IntoIterator<Item = [f64; 3]>) -> ([f64; 3], [f64; 3]) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in points {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    (low, high)
}

/// Diagonal of the box around points; 0 without any.
pub(crate) fn diagonal((low, high): ([f64; 3], [f64; 3])) -> f64 {
    let square: f64 = (0..3).map(|k| (high[k] - low[k]).max(0.0).powi(2)).sum();
    square.sqrt()
}
