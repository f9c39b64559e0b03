//! Three-vectors as plain arrays.

/// a + b.
pub(crate) fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a − b.
pub(crate) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// s a.
pub(crate) fn scale(a: [f64; 3], s: f64) -> [f64; 3] {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// a · b.
pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b.
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// |a|².
pub(crate) fn norm2(a: [f64; 3]) -> f64 {
    dot(a, a)
}

/// |a|.
pub(crate) fn norm(a: [f64; 3]) -> f64 {
    norm2(a).sqrt()
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
