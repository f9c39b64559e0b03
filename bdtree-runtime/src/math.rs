//! Vectors of three numbers and square roots, in plain IEEE arithmetic.
//!
//! Only `+ − × ÷ √`, each rounded once and in the order written: every processor returns the
//! same bits. Nothing here is fused.

/// Returns `a + b`.
#[inline(always)]
pub fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Returns `a − b`.
#[inline(always)]
pub fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Returns `k a`.
#[inline(always)]
pub fn scale(a: [f64; 3], k: f64) -> [f64; 3] {
    [a[0] * k, a[1] * k, a[2] * k]
}

/// Returns `a + k b`.
#[inline(always)]
pub fn add_scaled(a: [f64; 3], k: f64, b: [f64; 3]) -> [f64; 3] {
    add(a, scale(b, k))
}

/// Returns the dot product, summed from the left.
#[inline(always)]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the cross product.
#[inline(always)]
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Returns the Euclidean length; 0 for vectors shorter than about 2⁻⁵³⁷.
#[inline(always)]
pub fn norm(a: [f64; 3]) -> f64 {
    sqrt(dot(a, a))
}

/// Returns the sum of magnitudes: not below the Euclidean length and at most √3 times it, without a root.
/// For error bounds.
#[inline(always)]
pub fn length_bound(a: [f64; 3]) -> f64 {
    a[0].abs() + a[1].abs() + a[2].abs()
}

/// Returns `x` moved into `[low, high]`, and `low` for NaN: unlike `f64::clamp` it cannot panic.
#[inline(always)]
pub fn clamp(x: f64, low: f64, high: f64) -> f64 {
    if x > high {
        high
    } else if x > low {
        x
    } else {
        low
    }
}

/// Returns the correctly rounded square root.
#[cfg(feature = "std")]
#[inline(always)]
pub fn sqrt(x: f64) -> f64 {
    x.sqrt()
}

/// Returns the correctly rounded square root.
#[cfg(not(feature = "std"))]
#[inline(always)]
pub fn sqrt(x: f64) -> f64 {
    libm::sqrt(x)
}

/// Returns the correctly rounded square root.
#[cfg(feature = "std")]
#[inline(always)]
pub fn sqrt_f32(x: f32) -> f32 {
    x.sqrt()
}

/// Returns the correctly rounded square root.
#[cfg(not(feature = "std"))]
#[inline(always)]
pub fn sqrt_f32(x: f32) -> f32 {
    libm::sqrtf(x)
}

/// Returns the rows of the matrix of a unit quaternion (x, y, z, w).
pub fn rotation_matrix([x, y, z, w]: [f64; 4]) -> [[f64; 3]; 3] {
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - w * z),
            2.0 * (x * z + w * y),
        ],
        [
            2.0 * (x * y + w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - w * x),
        ],
        [
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ]
}

/// The least pivot of `t/2 · 1 − J + tolerance · t · 1`, where J is an inertia tensor (xx yy zz xy xz yz) and t its
/// trace: positive where some body has that inertia (SPEC 7.10), for t/2 · 1 − J holds the second moments of its mass.
/// LDLᵀ without exchanges, which is stable for what is positive definite; where a pivot is not positive, it or one
/// before it is returned.
pub fn second_moment_pivot(inertia: [f64; 6], tolerance: f64) -> f64 {
    let [xx, yy, zz, xy, xz, yz] = inertia;
    let trace = xx + yy + zz;
    let raised = 0.5 * trace + tolerance * trace;
    let [a, b, c] = [raised - xx, raised - yy, raised - zz];
    let [ab, ac, bc] = [-xy, -xz, -yz];
    let second = b - ab * ab / a;
    let rest = bc - ab * ac / a;
    let third = c - ac * ac / a - rest * rest / second;
    if a > 0.0 && second > 0.0 {
        third
    } else {
        a.min(second)
    }
}

#[cfg(test)]
mod tests {
    use super::second_moment_pivot;

    #[test]
    fn moments_of_bodies_pass_and_others_do_not() {
        // A ball, a thin plate, a thin rod (the other way round rounding), a turned box.
        let turned = [1.3, 1.5, 0.9, -0.2, 0.1, -0.15];
        for inertia in [
            [0.4, 0.4, 0.4, 0.0, 0.0, 0.0],
            [1.0, 1.0, 2.0, 0.0, 0.0, 0.0],
            [1e-12, 1.0, 1.0, 0.0, 0.0, 0.0],
            turned,
        ] {
            assert!(second_moment_pivot(inertia, 1e-9) > 0.0, "{inertia:?}");
        }
        for inertia in [
            [1.0, 1.0, 2.1, 0.0, 0.0, 0.0],
            [1.0, 1.0, 2.0 + 1e-7, 0.0, 0.0, 0.0],
            [0.4, 0.4, 0.4, 0.3, 0.3, 0.3],
            [1.0, 1.0, 1.0, 0.0, 0.0, 0.6],
            [1.0, -0.2, 1.0, 0.0, 0.0, 0.0],
        ] {
            let pivot = second_moment_pivot(inertia, 1e-9);
            assert!(!(pivot > 0.0), "{inertia:?}: {pivot}");
        }
    }
}
